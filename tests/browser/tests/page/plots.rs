//! What is drawn, and that it can be read.

use std::collections::BTreeSet;

use motorlens_browser_tests::{Browser, Server};
use serde_json::{Value, json};

use super::{added, alone, diagnosed, opened};

/// The texts of all elements that a selector names.
fn texts(browser: &mut Browser, selector: &str) -> Vec<String> {
    let all =
        browser.value(&format!("[...document.querySelectorAll('{selector}')].map((e) => e.textContent)"));
    serde_json::from_value(all).expect("texts")
}

#[test]
fn a_record_shows_angle_speed_residual_and_voltage_and_training_is_told_from_unseen() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    let axes = "ask('/api/record/0').then((f) => f.panels.map((p) => p.y.title))";
    assert_eq!(browser.value(axes), json!(["Angle (rad)", "Speed (rad/s)", "Residual (rad)", "Voltage (V)"]));
    assert_eq!(browser.number("document.querySelectorAll('#record-plot canvas').length"), 4.0);
    let curves = "ask('/api/record/0').then((f) => f.panels[0].curves.map((c) => c.role))";
    assert_eq!(browser.value(curves), json!(["measured", "base", "model"]));
    // The band of the noise floor lies behind the residual.
    assert!(browser.number("ask('/api/record/0').then((f) => f.panels[2].floor[1])") > 0.0);
    assert!(!browser.text("#record-reading").is_empty());

    let known: Vec<bool> =
        serde_json::from_value(browser.value("state.records.map((r) => r.unseen)")).unwrap();
    assert!(known.contains(&true) && known.contains(&false), "{known:?}");
    for (k, unseen) in known.iter().enumerate() {
        let role = if *unseen { "validation" } else { "fit" };
        let offered = texts(&mut browser, "#record option").swap_remove(k);
        assert!(offered.ends_with(&format!("({role})")), "{offered}");
        browser.value(&format!(
            "$('record').value = {k}, $('record-role').textContent = '', $('record').dispatchEvent(new Event('change'))"
        ));
        browser.wait("$('record-role').textContent");
        assert_eq!(browser.text("#record-role"), role);
    }
    // A slider for every parameter; error on both kinds of records beside the noise floor.
    let parameters = browser.number("state.parameters.length");
    assert!(parameters >= 3.0);
    assert_eq!(browser.number("document.querySelectorAll('#ranges input').length"), parameters);
    assert!(browser.text("#slid").contains("validation") && browser.text("#slid-floor").contains("rad"));
}

#[test]
fn the_cursor_stands_at_the_same_time_in_all_plots_of_a_record() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.value("$('record-plot').scrollIntoView({ behavior: 'instant' })");
    let place = "(() => { const b = document.querySelectorAll('#record-plot .u-over')[1].getBoundingClientRect(); return [b.left + 0.4 * b.width, b.top + 0.5 * b.height]; })()";
    let place = browser.value(place);
    let [x, y] = [0, 1].map(|k| place[k].as_f64().unwrap());
    browser.call("Input.dispatchMouseEvent", json!({ "type": "mouseMoved", "x": x, "y": y, "buttons": 0 }));
    let stands = "[...document.querySelectorAll('#record-plot .u-cursor-x')].map((e) => e.style.transform)";
    browser.wait(&format!("new Set({stands}).size == 1 && !{stands}[0].includes('-10px')"));
    let all: Vec<String> = serde_json::from_value(browser.value(stands)).unwrap();
    assert_eq!(all.len(), 4, "{all:?}");
    // Each plot tells the values there.
    let told = texts(&mut browser, "#record-plot .u-series:not(.silent) .u-value");
    assert!(told.len() >= 9 && told.iter().all(|value| value.parse::<f64>().is_ok()), "{told:?}");
}

#[test]
fn every_side_of_the_residual_is_drawn_with_one_line_that_reads_it() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    let titles = texts(&mut browser, "#fails figure h3");
    for named in [
        "By speed and direction",
        "By angle of the output shaft",
        "By angle of the motor shaft",
        "Around reversals",
        "Autocorrelation",
        "Harmonics",
    ] {
        assert!(titles.iter().any(|title| title.contains(named)), "{named} is not among {titles:?}");
    }
    let readings = texts(&mut browser, "#fails figcaption");
    assert_eq!(readings.len(), titles.len());
    for reading in &readings {
        assert!(reading.ends_with('.') && reading.len() > 20 && !reading.contains('\n'), "{reading}");
    }
    assert_eq!(readings.iter().collect::<BTreeSet<_>>().len(), readings.len());
    for k in 0..titles.len() {
        let plot = format!("document.querySelectorAll('#fails .plot')[{k}]");
        browser.value(&format!("{plot}.scrollIntoView({{ behavior: 'instant' }})"));
        browser.wait(&format!("{plot}.querySelector('canvas')"));
    }
    let memory = browser
        .value("ask('/api/figures/fails').then((a) => a.figures.find((f) => f.id == 'autocorrelation'))");
    let bound = memory["panels"][0]["floor"][1].as_f64().expect("99 % bounds");
    assert!(bound > 0.0 && bound < 1.0, "{bound}");
    assert!(memory["reading"].as_str().is_some_and(|line| line.contains("99 % bounds")));
}

/// Texts whose contrast with what is behind them is below 4.5, the bound of WCAG 2 for normal text (1.4.3).
const TOO_FAINT: &str = r"(() => {
  const parse = (c) => { const m = c.match(/[\d.]+/g).map(Number); return c.startsWith('color(srgb') ? [m[0] * 255, m[1] * 255, m[2] * 255, m[3] ?? 1] : [m[0], m[1], m[2], m[3] ?? 1]; };
  const light = (c) => c.slice(0, 3).map((v) => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4).reduce((s, v, k) => s + v * [0.2126, 0.7152, 0.0722][k], 0);
  const behind = (e) => { for (; e; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor); if (c[3] > 0.99) return c; } return matchMedia('(prefers-color-scheme: dark)').matches ? [0, 0, 0] : [255, 255, 255]; };
  const faint = [];
  let seen = 0;
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let n = walk.nextNode(); n; n = walk.nextNode()) {
    const e = n.parentElement;
    if (!n.textContent.trim() || !e.checkVisibility() || e.closest('script, option, :disabled')) continue;
    seen++;
    const [a, b] = [light(parse(getComputedStyle(e).color)), light(behind(e))], ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < 4.5) faint.push(`${n.textContent.trim()}: ${ratio.toFixed(2)}`);
  }
  const style = getComputedStyle(document.documentElement), role = (name) => { const h = style.getPropertyValue('--' + name).trim(); return [1, 3, 5].map((k) => parseInt(h.slice(k, k + 2), 16)); };
  for (const name of ['measured', 'base', 'model', 'voltage', 'unseen', 'floor', 'p0', 'p1', 'p2', 'p3', 'p4', 'p5']) {
    const [a, b] = [light(role(name)), light(role('surface'))], ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (!(ratio >= 3)) faint.push(`curve ${name}: ${ratio.toFixed(2)}`);
  }
  return { seen, faint };
})()";

#[test]
fn every_text_and_curve_stands_out_in_light_and_in_dark() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.value("document.querySelector('#device').open = true");
    diagnosed(&mut browser);
    added(&mut browser);
    for scheme in ["light", "dark"] {
        browser.prefer(scheme);
        let found = browser.value(TOO_FAINT);
        assert!(found["seen"].as_f64().is_some_and(|count| count > 100.0), "{found}");
        assert_eq!(found["faint"], Value::Array(Vec::new()), "{scheme}");
    }
}

#[test]
fn words_beside_a_point_cover_no_other_point_and_many_names_have_room_on_a_phone() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.size(390, 844, true);
    browser.value(
        "void (() => { globalThis.said = {}; const draw = CanvasRenderingContext2D.prototype.fillText;
            CanvasRenderingContext2D.prototype.fillText = function (text, x, y) { const m = this.getTransform();
                if (this.canvas.closest('#record-plot')) said[text] = { x: m.a * x + m.c * y + m.e, y: m.b * x + m.d * y + m.f, turned: m.b !== 0, wide: this.measureText(text).width }; draw.call(this, text, x, y); }; })()",
    );
    let drawn = |browser: &mut Browser, names: &str| {
        browser.value(&format!(
            "void (() => {{ said = {{}}; const names = {names}, y = (v) => names.map(() => v);
                const panel = {{ y: {{ title: 'Error (1)', log: true, range: [1, 100] }}, height: 240, curves: [
                    {{ role: 'model', name: 'error', on: 0, draw: 'dotted', y: y(26), words: y('26 x') }}, {{ role: 'base', name: 'usual', on: 0, draw: 'points', y: y(31) }}] }};
                const figure = {{ id: 'words', title: 'Error', reading: '', x: {{ title: 'Step', log: false, names }}, columns: [names.map((_, k) => k)], panels: [panel] }};
                const root = document.querySelector('#record-plot'); Plots.show(root, figure), Plots.draw(root); }})()"
        ));
        browser.wait("said['26 x'] && said['10'] && said['100']");
    };
    drawn(&mut browser, "['base']");
    // Where the other point is, by the numbers and the name beside the axes.
    let apart = "(() => { const { x, y, wide } = said['26 x'], other = said['10'].y + (Math.log10(31) - 1) * (said['100'].y - said['10'].y); \
                 return [Math.abs(x - said.base.x) - wide / 2, Math.abs(y - other) - 6]; })()";
    let apart: Vec<f64> = serde_json::from_value(browser.value(apart)).unwrap();
    assert!(apart.iter().any(|distance| *distance > 0.0), "{apart:?}");
    assert_eq!(browser.value("said.base.turned"), false);
    drawn(&mut browser, "['base model', '+ dead_zone', '+ coulomb', '+ quadratic_drag']");
    assert_eq!(browser.value("said['+ quadratic_drag'].turned && said['+ coulomb'].turned"), true);
    // A phone that is turned has room for them.
    browser.size(1280, 844, false);
    browser.wait("!said['+ coulomb'].turned");
}

#[test]
fn an_error_without_end_or_none_at_all_is_drawn_as_far_as_lines_can_be_counted() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    for errors in ["[null, 0, 3]", "[3, 1e300]", "[null]", "[0, 0]"] {
        let drawn = format!(
            "(() => {{ for (const range of [[0, 3], [3, 1e300], [0.97, 3], [9.9e-9, 2e-4], undefined, spanOf({errors})]) {{
                const panel = {{ y: {{ title: 'Error (1)', log: true, range }}, height: 240, curves: [{{ role: 'model', name: 'error', on: 0, draw: 'dotted', y: {errors} }}] }};
                const figure = {{ id: 'endless', title: 'Error', reading: '', x: {{ title: 'Step (1)', log: false }}, columns: [{errors}.map((_, k) => k)], panels: [panel] }};
                const root = document.querySelector('#record-plot');
                Plots.show(root, figure), Plots.draw(root);
            }} return document.querySelectorAll('#record-plot canvas').length; }})()"
        );
        assert_eq!(browser.value(&drawn), json!(1), "{errors}");
    }
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}
