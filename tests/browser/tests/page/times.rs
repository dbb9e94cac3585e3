//! How long one waits. Each time is measured in the page, up to the frame that shows the result.

use motorlens_browser_tests::{Browser, Server, run};

use super::{FRESH, PAINTED, alone, opened};

/// Other work on the machine slows some tries; it cannot make one faster than the page is.
fn fastest(times: &[f64]) -> f64 {
    times.iter().copied().fold(f64::MAX, f64::min)
}

#[test]
fn ten_records_of_100_000_samples_are_on_the_screen_soon() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let mut logs = Vec::new();
    for seed in 0..5 {
        let out = directory.path().join(seed.to_string());
        let (seed, to) = (seed.to_string(), out.to_str().unwrap());
        run(&[
            "simulate",
            "--quiet",
            "--seconds",
            "100",
            "--excitation",
            "multisine",
            "--seed",
            &seed,
            "--out",
            to,
        ]);
        let mut found: Vec<_> = std::fs::read_dir(&out).unwrap().map(|e| e.unwrap().path()).collect();
        found.retain(|p| p.extension().is_some_and(|e| e == "csv"));
        logs.extend(found);
    }
    logs.truncate(10);
    let server = Server::start(&logs);
    let (mut paints, mut zooms) = (Vec::new(), Vec::new());
    for _ in 0..5 {
        // A new browser each time: nothing is in its cache.
        let mut browser = Browser::start(1280, 900);
        browser.open(&server.url);
        browser.wait(PAINTED);
        paints.push(browser.number("document.body.dataset.painted"));
        browser.wait(FRESH);
        assert!(browser.number("state.records[9].samples") >= 100_000.0);
        // From the wish to see two seconds until they are drawn from all of their own samples.
        let zoom = "(async () => { const begun = performance.now(), plot = $('record-plot'); Plots.look(plot, [40, 42]); \
             while (!plot.dataset.detail) await Plots.frame(); return performance.now() - begun; })()";
        zooms.push(browser.number(zoom.trim()));
    }
    println!("ten records of 100,000 samples: first paint {paints:.0?} ms, zoom {zooms:.0?} ms");
    assert!(fastest(&paints) < 1500.0, "{paints:?}");
    assert!(fastest(&zooms) < 100.0, "{zooms:?}");
}

#[test]
fn a_slider_moves_the_curve_and_the_error_at_once() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    assert!(
        browser.number("state.records.filter((r) => !r.unseen).reduce((s, r) => s + r.seconds, 0)") >= 47.9
    );
    let mut times = Vec::new();
    for k in 0..9 {
        let before = browser.text("#slid");
        browser.value(&format!(
            "(() => {{ const s = document.querySelector('#slider-0'); delete document.querySelector('#record-plot').dataset.slideMs; s.value = {}; s.dispatchEvent(new Event('input')); }})()",
            0.3 + 0.05 * f64::from(k)
        ));
        browser.wait("document.querySelector('#record-plot').dataset.slideMs");
        assert_ne!(browser.text("#slid"), before);
        times.push(browser.number("document.querySelector('#record-plot').dataset.slideMs"));
    }
    let asked = browser.number(
        "performance.getEntriesByType('resource').filter((e) => e.name.endsWith('/api/slide')).at(-1).duration",
    );
    times.sort_by(f64::total_cmp);
    println!(
        "a slider's move on 48 s at 1 kHz: {:.0} ms (fastest), {:.0} ms (median), {:.0} ms (slowest), the server's part {asked:.0} ms",
        times[0], times[4], times[8]
    );
    assert!(fastest(&times) < 50.0, "{times:?}");
}
