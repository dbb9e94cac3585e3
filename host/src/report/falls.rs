//! Step 5, Falls: the ladder from the base model to the noise floor.

use serde_json::json;

use super::figure::{Figure, in_words, numbers};
use crate::compare::measures::Measures;
use crate::diagnose::discover::Rung;

/// The error that counts for a rung: on unseen records where there are any.
pub fn judged(rung: &Rung) -> Measures {
    rung.validation.unwrap_or(rung.train)
}

/// What each step is called: the base model, then each effect with the sign of its coming or going.
pub fn steps(ladder: &[Rung]) -> Vec<String> {
    let mut names = Vec::with_capacity(ladder.len());
    for (k, rung) in ladder.iter().enumerate() {
        if k == 0 {
            let with: Vec<String> = rung.effects.iter().map(ToString::to_string).collect();
            names.push(if with.is_empty() { "base model".into() } else { with.join(" + ") });
            continue;
        }
        let before = &ladder[k - 1].effects;
        let came = rung.effects.iter().filter(|e| !before.contains(e)).map(|e| format!("+ {e}"));
        let went = before.iter().filter(|e| !rung.effects.contains(e)).map(|e| format!("− {e}"));
        let name = came.chain(went).collect::<Vec<_>>().join(" ");
        names.push(if name.is_empty() { "refitted".into() } else { name });
    }
    names
}

/// The waterfall.
pub fn figure(ladder: &[Rung], floor: f64, unit: &str) -> Figure {
    let names = steps(ladder);
    let values: Vec<f64> = ladder.iter().map(|rung| judged(rung).rmse).collect();
    let text = values.iter().map(|v| in_words(*v, unit));
    let unseen = ladder.iter().any(|r| r.validation.is_some());
    // Numbered, because an effect may come twice.
    let labels: Vec<String> = names.iter().enumerate().map(|(k, n)| format!("{}. {n}", k + 1)).collect();
    let bars = json!({ "type": "bar", "name": if unseen { "error on unseen records" } else { "error" },
        "x": labels, "y": numbers(values.iter().copied(), 5), "text": text.collect::<Vec<_>>(),
        "textposition": "auto", "meta": { "role": "model" }, "hovertemplate": "%{x}: %{y:.4g} ".to_owned() + unit });
    let train = json!({ "type": "scatter", "mode": "markers", "name": "on training records", "x": labels,
        "y": numbers(ladder.iter().map(|r| r.train.rmse), 5), "meta": { "role": "measured" },
        "marker": { "size": 10, "symbol": "diamond" } });
    let last = values.last().copied().unwrap_or(0.0);
    let reading = format!(
        "From {} to {}, {:.2} times the noise floor of {}{}.",
        in_words(values.first().copied().unwrap_or(0.0), unit),
        in_words(last, unit),
        last / floor.max(1e-300),
        in_words(floor, unit),
        if unseen { ", on records that no fit has seen" } else { "" }
    );
    let layout = json!({
        "xaxis": { "title": { "text": "Model" }, "type": "category" },
        "yaxis": { "title": { "text": format!("Error, rms ({unit})") }, "type": "log" },
        "shapes": [{ "type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": floor, "y1": floor, "role": "floor" }],
        "legend": { "orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0 },
        "meta": { "last_over_floor": last / floor.max(1e-300) },
    });
    let at_floor = json!({ "type": "scatter", "mode": "lines", "name": format!("noise floor, {}", in_words(floor, unit)),
        "x": labels, "y": vec![floor; labels.len()], "line": { "dash": "dash" }, "meta": { "role": "floor" } });
    let data = if unseen { vec![bars, train, at_floor] } else { vec![bars, at_floor] };
    Figure { id: "ladder".into(), title: "The error falls".into(), reading, data, layout, height: 380 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motorlens_shared::effects::Kind;

    fn rung(effects: &[Kind], rmse: f64) -> Rung {
        Rung { effects: effects.to_vec(), train: Measures { rmse, ..Measures::default() }, validation: None }
    }

    #[test]
    fn steps_say_what_came_and_what_went() {
        let ladder = [
            rung(&[], 0.1),
            rung(&[Kind::Coulomb], 0.02),
            rung(&[Kind::Stribeck, Kind::Gravity], 0.01),
            rung(&[Kind::Stribeck], 0.02),
        ];
        assert_eq!(
            steps(&ladder),
            ["base model", "+ coulomb", "+ stribeck + gravity − coulomb", "− gravity"]
        );
    }

    #[test]
    fn the_reading_compares_the_last_rung_with_the_floor() {
        let figure = figure(&[rung(&[], 0.1), rung(&[Kind::Coulomb], 0.002)], 0.001, "rad");
        assert!(figure.reading.contains("2.00 times the noise floor of 1 mrad"), "{}", figure.reading);
    }
}
