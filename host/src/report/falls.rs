//! Step 5, Error: the models from the base model to the accepted one, in multiples of the noise where that is known.

use serde::Serialize;

use super::figure::{Axis, Curve, Draw, Figure, Numbers, Panel, in_words};
use crate::compare::measures::Measures;
use crate::compare::rise::Rise;
use crate::diagnose::ladder::Rung;
use crate::findings::Yardstick;
use crate::sentence::listed;

/// The error that counts for a model: on validation records where there are any.
pub fn judged(rung: &Rung) -> Measures {
    rung.validation.unwrap_or(rung.train)
}

/// The records that it is of.
pub(crate) fn judged_on(rung: &Rung) -> &'static str {
    if rung.validation.is_some() { "validation records" } else { "the records fitted" }
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

/// The models from the base model to the accepted one, and what to judge them by.
#[derive(Debug, Clone, Copy)]
pub struct Ladder<'a> {
    /// Their errors.
    pub rungs: &'a [Rung],
    /// Where each step raised the error most, if it did.
    pub rises: &'a [Option<Rise>],
    /// Errors of kS-kV-kA on the same records.
    pub baseline: Option<&'a Rung>,
    /// Noise level, in the measured unit.
    pub noise: f64,
    /// The measured unit.
    pub unit: &'static str,
}

/// A step as the table tells it.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// What came or went.
    pub step: String,
    /// Error on the records fitted.
    pub fit: String,
    /// Error on the validation records.
    pub validation: Option<String>,
    /// The error that counts, in multiples of the noise; none where that is too small to be known.
    pub multiple: Option<String>,
    /// Where the error rose most.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rise: Option<String>,
}

impl Ladder<'_> {
    fn yardstick(&self) -> Yardstick {
        let measures = self.rungs.first().map_or_else(Measures::default, judged);
        Yardstick::new(self.noise, &measures, self.unit)
    }

    fn on_axis(&self, of: impl Fn(&Rung) -> f64) -> Vec<f64> {
        let yardstick = self.yardstick();
        self.rungs.iter().map(|rung| yardstick.on_axis(of(rung))).collect()
    }

    /// The error of the last model in multiples of the noise; none where that is not known.
    pub fn last_over_noise(&self) -> Option<f64> {
        self.yardstick().over_noise(judged(self.rungs.last()?).rmse)
    }

    /// Steps whose error is higher than that of the step before.
    fn rising(&self) -> impl Iterator<Item = usize> + '_ {
        let error = |k: usize| judged(&self.rungs[k]).rmse;
        (1..self.rungs.len()).filter(move |k| error(*k) > error(k - 1) * (1.0 + 1e-6))
    }

    /// Where step `k` raised the error most, in words.
    fn place(&self, k: usize) -> Option<String> {
        let rise = self.rises.get(k)?.as_ref()?;
        Some(format!("rises on {} around {:.1} s", rise.record, rise.at_s))
    }

    /// The rising steps, those with the same place together.
    fn rising_by_place(&self) -> Vec<(Option<String>, Vec<usize>)> {
        let mut all: Vec<(Option<String>, Vec<usize>)> = Vec::new();
        for k in self.rising() {
            let place = self.place(k);
            match all.iter().position(|(known, _)| *known == place) {
                Some(at) => all[at].1.push(k),
                None => all.push((place, vec![k])),
            }
        }
        all
    }

    /// The steps as a table; kS-kV-kA stands first.
    pub fn rows(&self) -> Vec<Row> {
        let (yardstick, unit) = (self.yardstick(), self.unit);
        let rising: Vec<usize> = self.rising().collect();
        let row = |step: String, rung: &Rung, rise: Option<String>| Row {
            step,
            fit: in_words(rung.train.rmse, unit),
            validation: rung.validation.map(|m| in_words(m.rmse, unit)),
            multiple: yardstick.multiple(judged(rung).rmse),
            rise,
        };
        let usual = self.baseline.map(|rung| row("kS-kV-kA".into(), rung, None));
        let own = steps(self.rungs).into_iter().zip(self.rungs).enumerate().map(|(k, (step, rung))| {
            let rise =
                rising.contains(&k).then(|| self.place(k).unwrap_or_else(|| "the error rises".to_owned()));
            row(step, rung, rise)
        });
        usual.into_iter().chain(own).collect()
    }

    fn reading(&self) -> String {
        let yardstick = self.yardstick();
        let on = if self.validated() { " on validation records" } else { " on the records fitted" };
        let told = |rung: Option<&Rung>| yardstick.words(rung.map_or(0.0, |rung| judged(rung).rmse));
        let [first, last] = [self.rungs.first(), self.rungs.last()].map(told);
        let mut text = match self.rungs.len() {
            0 | 1 => format!("The base model's error is {first}{on}."),
            _ => format!("The error goes from {first} to {last}{on}."),
        };
        let names = steps(self.rungs);
        for (place, rising) in self.rising_by_place() {
            let which: Vec<&str> = rising.iter().map(|k| names[*k].as_str()).collect();
            let step = if which.len() > 1 { "Steps" } else { "Step" };
            let place = place.map_or(String::new(), |p| format!(": it {p}"));
            text += &format!(" {step} {} raised it{place}.", listed(&which));
        }
        if let Some(usual) = self.baseline {
            let left = yardstick.words(judged(usual).rmse);
            text += &format!(" kS-kV-kA, the usual model, leaves {left}.");
        }
        text
    }

    fn validated(&self) -> bool {
        self.rungs.iter().any(|r| r.validation.is_some())
    }

    /// The models in order, each a dot at its error; a rise is a red line.
    pub fn figure(&self) -> Figure {
        let yardstick = self.yardstick();
        let values = self.on_axis(|rung| judged(rung).rmse);
        let name = if self.validated() { "on validation records" } else { "on the records fitted" };
        let mut columns = vec![Numbers::new((0..values.len()).map(|k| k as f64), 5)];
        let mut curves = vec![Curve {
            draw: Draw::Dotted,
            words: self.rungs.iter().map(|rung| yardstick.label(judged(rung).rmse)).collect(),
            ..Curve::line("model", name, 0, Numbers::new(values.iter().copied(), 5))
        }];
        let mut all = values.clone();
        if self.validated() {
            let train = self.on_axis(|rung| rung.train.rmse);
            all.extend(&train);
            let train = Numbers::new(train, 5);
            curves.push(Curve {
                draw: Draw::Points,
                ..Curve::line("measured", "on the records fitted", 0, train)
            });
        }
        let names = steps(self.rungs);
        for k in self.rising() {
            columns.push(Numbers::new([(k - 1) as f64, k as f64], 5));
            let rise = Numbers::new([values[k - 1], values[k]], 5);
            // Two steps may raise it at one place: no two curves have one name.
            let place = self.place(k).unwrap_or_else(|| "the error rises".into());
            let name = format!("{}: {place}", names[k]);
            curves.push(Curve { draw: Draw::Dotted, ..Curve::line("fault", name, columns.len() - 1, rise) });
        }
        if let Some(usual) = self.baseline {
            let usual = yardstick.on_axis(judged(usual).rmse);
            all.push(usual);
            let level = Numbers::new(values.iter().map(|_| usual), 5);
            curves.push(Curve { draw: Draw::Points, ..Curve::line("base", "kS-kV-kA", 0, level) });
        }
        all.extend(yardstick.noise());
        let some = || all.iter().copied().filter(|v| *v > 0.0 && v.is_finite());
        let (low, high) = (some().fold(f64::MAX, f64::min), some().fold(0.0, f64::max));
        let range = if high > 0.0 { [0.6 * low, 2.0 * high] } else { [0.5, 2.0] };
        Figure {
            x: Axis { names, ..Axis::titled("Model (step)") },
            columns,
            panels: vec![Panel {
                y: Axis { log: true, range: Some(range), ..Axis::titled(yardstick.axis()) },
                height: 300,
                curves,
                floor: yardstick.noise().map(|noise| [noise, noise]),
            }],
            ..Figure::titled("ladder", "Error of each model", self.reading())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motorlens_shared::effects::Kind;

    fn rung(effects: &[Kind], rmse: f64) -> Rung {
        Rung::leaving(effects, rmse, None)
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
    fn a_rise_is_red_and_names_record_and_time() {
        let rungs = [rung(&[], 0.1), rung(&[Kind::Delay], 0.2), rung(&[Kind::Delay, Kind::Coulomb], 0.002)];
        let rise = Rise { record: "stairs".into(), at_s: 3.25, times: 2.0 };
        let ladder = Ladder {
            rungs: &rungs,
            rises: &[None, Some(rise), None],
            baseline: None,
            noise: 0.001,
            unit: "rad",
        };
        let figure = ladder.figure();
        assert!(figure.reading.contains("from 100 x the noise to 2.0 x"), "{}", figure.reading);
        assert!(
            figure.reading.contains("+ delay raised it: it rises on stairs around 3.2 s"),
            "{}",
            figure.reading
        );
        let red: Vec<_> = figure.panels[0].curves.iter().filter(|c| c.role == "fault").collect();
        assert_eq!(red.len(), 1);
        let rows = ladder.rows();
        assert!(rows[0].rise.is_none() && rows[1].rise.is_some() && rows[2].rise.is_none());
    }

    #[test]
    fn steps_that_raise_the_error_at_one_place_are_named_together() {
        let rungs = [rung(&[], 0.1), rung(&[Kind::Delay], 0.2), rung(&[Kind::Delay, Kind::Coulomb], 0.3)];
        let rise = Some(Rise { record: "stairs".into(), at_s: 3.25, times: 2.0 });
        let rises = [None, rise.clone(), rise];
        let ladder = Ladder { rungs: &rungs, rises: &rises, baseline: None, noise: 0.001, unit: "rad" };
        let figure = ladder.figure();
        let told = "Steps + delay and + coulomb raised it: it rises on stairs around 3.2 s.";
        assert!(figure.reading.ends_with(told), "{}", figure.reading);
        let red = figure.panels[0].curves.iter().filter(|c| c.role == "fault");
        let names: Vec<&str> = red.map(|c| c.name.as_str()).collect();
        assert_eq!(
            names,
            ["+ delay: rises on stairs around 3.2 s", "+ coulomb: rises on stairs around 3.2 s"]
        );
    }

    #[test]
    fn the_usual_model_stands_beside_the_others() {
        let (rungs, usual) = ([rung(&[], 0.1)], rung(&[Kind::Coulomb], 0.05));
        let ladder =
            Ladder { rungs: &rungs, rises: &[None], baseline: Some(&usual), noise: 0.01, unit: "rad" };
        assert!(ladder.figure().reading.ends_with("kS-kV-kA, the usual model, leaves 5.0 x the noise."));
        assert_eq!(ladder.rows()[0].step, "kS-kV-kA");
    }
}
