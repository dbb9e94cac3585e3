//! Step 5, Falls: the ladder from the base model to the noise floor.

use super::figure::{Axis, Curve, Draw, Figure, Numbers, Panel, in_words};
use crate::compare::measures::Measures;
use crate::diagnose::ladder::Rung;

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

/// The error of the last rung in noise floors.
pub fn last_over_floor(ladder: &[Rung], floor: f64) -> f64 {
    ladder.last().map_or(0.0, |rung| judged(rung).rmse) / floor.max(1e-300)
}

/// The waterfall: each rung's error, and above it what the step from the rung before has taken away.
pub fn figure(ladder: &[Rung], floor: f64, unit: &str) -> Figure {
    let values: Vec<f64> = ladder.iter().map(|rung| judged(rung).rmse).collect();
    let unseen = ladder.iter().any(|r| r.validation.is_some());
    let reading = format!(
        "From {} to {}, {:.2} times the noise floor of {}{}.",
        in_words(values.first().copied().unwrap_or(0.0), unit),
        in_words(values.last().copied().unwrap_or(0.0), unit),
        last_over_floor(ladder, floor),
        in_words(floor, unit),
        if unseen { ", on records that no fit has seen" } else { "" }
    );
    let before = values.iter().enumerate().map(|(k, v)| if k == 0 { *v } else { values[k - 1].max(*v) });
    let bars = |role, name: &str, values: &mut dyn Iterator<Item = f64>| Curve {
        draw: Draw::Bars,
        ..Curve::line(role, name, 0, Numbers::new(values, 5))
    };
    let error = if unseen { "error on unseen records" } else { "error" };
    let mut curves = vec![
        bars("gone", "taken away by the step", &mut before.clone()),
        Curve {
            words: values.iter().map(|v| in_words(*v, unit)).collect(),
            ..bars("model", error, &mut values.iter().copied())
        },
    ];
    if unseen {
        let train = Numbers::new(ladder.iter().map(|r| r.train.rmse), 5);
        curves.push(Curve { draw: Draw::Points, ..Curve::line("measured", "on training records", 1, train) });
    }
    // Room above the highest bar for its words, and below the lowest one for seeing that it is a bar.
    let all = || before.clone().chain(values.iter().copied()).chain(ladder.iter().map(|r| r.train.rmse));
    let high = 2.0 * all().fold(floor, f64::max).max(1e-300);
    let low = 0.4 * all().filter(|v| *v > 0.0).fold(high, f64::min).min(floor.max(1e-4 * high));
    Figure {
        id: "ladder".into(),
        title: "Error of each model".into(),
        reading,
        x: Axis { names: steps(ladder), ..Axis::titled("Model (step)") },
        // The points stand beside the words over the bars.
        columns: [0.0, 0.2]
            .map(|beside| Numbers::new((0..ladder.len()).map(|k| k as f64 + beside), 5))
            .into(),
        panels: vec![Panel {
            y: Axis { log: true, range: Some([low, high]), ..Axis::titled(format!("Error, rms ({unit})")) },
            height: 300,
            curves,
            floor: Some([floor, floor]),
        }],
    }
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
