//! Faults of the data that only a fit shows.

use motorlens_shared::effects::Kind;

use crate::diagnose::evidence::Evidence;
use crate::diagnose::ladder::Rung;
use crate::fit::layout::{Layout, Values};
use crate::fit::search::Problem;
use crate::fit::uncertainty::Estimate;
use crate::log::Warning;
use crate::report::falls::judged;
use crate::report::figure::in_words;
use crate::select::run::Rivals;

/// All that a fitted model shows: its `parameters`, its accepted `effects`, and values of its `layout` at `x` where the search for them
/// ends. Terminal, report and page ask for the same, so that none sends to data problems that another one does not know.
pub fn of_model(parameters: &[Estimate], effects: &[Kind], (layout, x): (&Layout, &[f64])) -> Vec<Warning> {
    faults(parameters, effects).into_iter().chain(at_the_end(layout, x)).collect()
}

/// Those that the `parameters` and the accepted `effects` of a model show.
fn faults(parameters: &[Estimate], effects: &[Kind]) -> Vec<Warning> {
    too_little_excitation(parameters)
        .into_iter()
        .chain(effects.iter().filter_map(|kind| of_the_sensor(*kind, parameters)))
        .collect()
}

/// Records from which even the plain motor cannot be had.
pub fn too_little_excitation(parameters: &[Estimate]) -> Option<Warning> {
    let open: Vec<&str> = parameters
        .iter()
        .filter(|p| matches!(p.name.as_str(), "gain" | "tau_m") && !p.identifiable)
        .map(|p| p.name.as_str())
        .collect();
    (!open.is_empty()).then(|| Warning {
        place: "all records together".into(),
        what: format!("too_little_excitation: these records do not determine {}", open.join(" and ")),
        fix:
            "record a programme that accelerates, brakes and holds several speeds (motorlens plan writes one)"
                .into(),
    })
}

/// What a headline goes on with where parameters of `layout` stand at `x` where the search for them ends: a size that rests on that is none.
/// Empty where none does.
pub fn ended(layout: &Layout, x: &[f64]) -> String {
    where_ended(layout, x).map_or_else(String::new, |them| format!("; {them}, and no motor is like that"))
}

/// The same of `values` as `problem` lays them out.
pub fn ended_of(problem: &Problem, values: &Values) -> String {
    let layout = problem.layout(&values.kinds());
    ended(&layout, &layout.pack(values))
}

/// The parameters of `layout` that stand at `x` where the search for them ends: no motor has such values, so that something else made them.
fn at_the_end(layout: &Layout, x: &[f64]) -> Option<Warning> {
    where_ended(layout, x).map(|them| Warning {
        place: "all records together".into(),
        what: format!("at_the_end: {them}: no motor is like that"),
        fix: "look at the plots (motorlens serve LOG...) for readings that are garbled or late, a unit or a clock that is wrong, or a motor \
              that hardly moves; leave such times out (--skip FROM..TO)"
            .into(),
    })
}

/// The same in words: which, at which values.
fn where_ended(layout: &Layout, x: &[f64]) -> Option<String> {
    let value = |k: usize| {
        let axis = &layout.axes[k];
        format!("{} = {}", axis.name, in_words(layout.plain(k, x[k]), axis.unit))
    };
    let standing: Vec<String> = layout.at_the_end(x).into_iter().map(value).collect();
    let them = if standing.len() == 1 {
        "is where the search for it ends"
    } else {
        "are where the searches for them end"
    };
    (!standing.is_empty()).then(|| format!("{} {them}", standing.join(" and ")))
}

/// How many times nearer than the last model of `ladder` a smaller one, or the `usual` one, comes to the records that judge; 1 where none
/// comes much nearer, over whole records and within a second alike: how far a whole record drifts a disturbance decides, by chance.
pub fn beaten(ladder: &[Rung], usual: Option<&Rung>) -> f64 {
    let Some(last) = ladder.last() else { return 1.0 };
    let keeps_nearer = |rung: &Rung| judged(last).strayed > MUCH_WORSE * judged(rung).strayed;
    let smaller = nearest(ladder, |rung| rung.effects.len() < last.effects.len() && keeps_nearer(rung));
    let usual = usual_is_nearer(ladder, usual.filter(|rung| keeps_nearer(rung)));
    smaller.map(|(_, times)| times).into_iter().chain(usual.map(|(_, times)| times)).fold(1.0, f64::max)
}

/// The model of `ladder` among those asked for that comes nearest to the records kept out, and how many times nearer than the last one; none
/// where not by much.
fn nearest(ladder: &[Rung], among: impl Fn(&Rung) -> bool) -> Option<(&Rung, f64)> {
    let error = |rung: &Rung| rung.validation.map(|m| m.rmse);
    let last = ladder.last().and_then(error)?;
    let known = ladder.iter().filter(|rung| among(rung)).filter_map(|rung| Some((rung, error(rung)?)));
    let (best, least) = known.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (last > MUCH_WORSE * least).then(|| (best, last / least))
}

/// The last model of `ladder`, and how many times nearer the `usual` one comes to the records that judge; none where not by much.
fn usual_is_nearer<'a>(ladder: &'a [Rung], usual: Option<&Rung>) -> Option<(&'a Rung, f64)> {
    let last = ladder.last()?;
    let (own, least) = (judged(last).rmse, judged(usual?).rmse);
    (own > MUCH_WORSE * least).then(|| (last, own / least))
}

/// The last model of `ladder`, where a smaller one does much better on the records that judged it.
pub fn doubted_by_validation(ladder: &[Rung]) -> Option<Warning> {
    nearest(ladder, |_| true).map(|(best, times)| Warning {
        place: "validation records".into(),
        what: format!(
            "not_confirmed: the model with {} meets the validation records {:.1} times better than with the effects that came after it",
            names(&best.effects, " and ", "no effects"),
            times
        ),
        fix: format!(
            "use that model (fit --effects {}), or record more like the validation records to fit to: they choose nothing by themselves",
            names(&best.effects, ",", "none")
        ),
    })
}

/// The last model of `ladder`, to which nothing is to be added, where the `usual` one does much better on the records that judge.
pub fn worse_than_usual(ladder: &[Rung], usual: Option<&Rung>) -> Option<Warning> {
    usual_is_nearer(ladder, usual).map(|(last, times)| Warning {
        place: if last.validation.is_some() { "validation records" } else { "all records together" }.into(),
        what: format!(
            "usual_is_better: kS-kV-kA, the usual model, meets them {:.1} times better than the model with {}",
            times,
            names(&last.effects, " and ", "no effects")
        ),
        fix: "simulate such moves with that one (fit --method feedforward), and do not rely on what is named here: something acts that is \
              not in the library, or that the log does not hold"
            .into(),
    })
}

/// The first accepted effect of which a rival runs much nearer to the records of the fit.
pub fn nearer_rival(rivals: &[Rivals], data: &Evidence) -> Option<Warning> {
    rivals.iter().find_map(|set| {
        let (accepted, nearer) = (set.models.first()?, set.nearer(data)?);
        Some(Warning {
            place: "all records together".into(),
            what: format!(
                "nearer_rival: fitted to these records, the model with {} runs {:.1} times nearer to them than the one with {}, but fits to a part \
                 of them do not foresee the rest better",
                names(nearer.kinds(), " and ", "no effects"),
                accepted.error(data) / nearer.error(data),
                names(accepted.kinds(), " and ", "no effects"),
            ),
            fix: format!(
                "record once more what only one of these records shows, and give both; to have the other model: motorlens fit LOG... -e {}",
                names(nearer.kinds(), ",", "")
            ),
        })
    })
}

/// An error so many times that of a smaller model on the records that judge is told.
const MUCH_WORSE: f64 = 1.25;

/// The names of `effects`, or what `nothing` is called.
fn names(effects: &[Kind], between: &str, nothing: &str) -> String {
    if effects.is_empty() {
        return nothing.to_owned();
    }
    effects.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(between)
}

/// What is late by less than this may as well be a winding that is slower than those of small motors, s.
const SLOW_WINDING_S: f64 = 8e-3;

/// What to know where `kind` is late by so little that a winding could be it.
fn or_a_winding(kind: Kind, parameters: &[Estimate]) -> &'static str {
    let own = |p: &&Estimate| p.unit == "s" && p.name.strip_prefix(kind.name()) == Some(".time");
    // A reading that is held has no such time.
    if parameters.iter().find(own).is_some_and(|time| time.value > 0.0 && time.value < SLOW_WINDING_S) {
        "; a winding whose L/R is longer than 2.7 ms answers alike: give inductance_h and resistance_ohm in motor.toml if yours is"
    } else {
        ""
    }
}

/// Effects that are faults of the measurement, and how to end them instead of modelling them.
fn of_the_sensor(kind: Kind, parameters: &[Estimate]) -> Option<Warning> {
    let (what, fix) = match kind {
        Kind::LostCounts => (
            "lost_counts: the angle falls behind at speed as if edges were missed",
            "read the encoder by hardware or faster, check its cable and filter, and log again",
        ),
        Kind::SensorLag => (
            "stale_samples: the reading trails the motion as if it were filtered or old",
            "log the raw reading at the instant of the voltage; else keep the effect",
        ),
        Kind::Delay => (
            "shifted_samples: the motion follows the logged voltage late",
            "check that the columns of a row belong to one instant; if the drive is that slow, keep the effect",
        ),
        _ => return None,
    };
    let fix = format!("{fix}{}", if kind.spec().is_late() { or_a_winding(kind, parameters) } else { "" });
    Some(Warning { place: "all records together".into(), what: what.into(), fix })
}

#[cfg(test)]
mod tests {
    use motorlens_shared::effects::Rig;

    use super::*;
    use crate::compare::measures::Measures;
    use crate::fit::layout::Prior;

    #[test]
    fn a_usual_model_that_is_much_better_on_the_records_that_judge_is_told() {
        let rung = |train, unseen| Rung::leaving(&[Kind::Stribeck], train, unseen);
        let told = |last: Rung, usual: Rung| worse_than_usual(&[last], Some(&usual));
        let better = told(rung(0.1, Some(1.0)), rung(0.4, Some(0.5))).unwrap();
        assert_eq!(better.place, "validation records");
        assert!(better.what.contains("2.0 times better than the model with stribeck"), "{}", better.what);
        let better = told(rung(1.0, None), rung(0.5, None)).unwrap();
        assert_eq!(better.place, "all records together");
        assert_eq!(told(rung(1.0, Some(0.5)), rung(0.1, Some(0.45))), None);
    }

    #[test]
    fn a_value_where_its_search_ends_is_told_alike_in_a_headline_and_as_a_data_problem() {
        let rig = Rig {
            step_s: 1e-3,
            gear_ratio: 50.0,
            encoder_on_motor: true,
            nominal_v: 12.0,
            supply_v: 12.0,
            reference_speed: 10.0,
            count_rad: 1e-3,
        };
        let prior = Prior { tau_e: (5e-4, 0.4), viscous_share: (0.08, 0.05) };
        let layout = Layout::new(&[Kind::Coulomb], &rig, &prior);
        let mut x: Vec<f64> = layout.axes.iter().map(|axis| 0.5 * (axis.low + axis.high)).collect();
        assert_eq!((ended(&layout, &x), at_the_end(&layout, &x)), (String::new(), None));
        let level = layout.axes.iter().position(|axis| axis.name == "coulomb.level").unwrap();
        x[level] = layout.axes[level].high;
        let (headline, fault) = (ended(&layout, &x), at_the_end(&layout, &x).unwrap());
        assert!(
            headline.starts_with("; coulomb.level = ") && headline.contains("where the search for it ends")
        );
        let told = headline.trim_start_matches("; ").split(", and no").next().unwrap();
        assert!(fault.what.contains(told), "{} beside {headline}", fault.what);
    }

    #[test]
    fn a_filter_as_fast_as_a_slow_winding_is_told_to_be_perhaps_one() {
        let lag = |value| Estimate {
            name: "sensor_lag.time".into(),
            value,
            unit: "s".into(),
            low: value,
            high: value,
            identifiable: true,
        };
        let fix = |value| of_the_sensor(Kind::SensorLag, &[lag(value)]).unwrap().fix;
        assert!(fix(4e-3).contains("inductance_h"));
        assert!(!fix(4e-2).contains("inductance_h"));
        assert!(!fix(0.0).contains("inductance_h"), "it is held");
    }

    #[test]
    fn a_smaller_model_that_meets_the_validation_records_much_better_is_named() {
        let rung = |effects: &[Kind], rmse| {
            let plain = Rung::leaving(effects, 0.0, Some(rmse));
            Rung { validation: plain.validation.map(|m| Measures { strayed: rmse, ..m }), ..plain }
        };
        let ladder =
            [rung(&[], 1.2), rung(&[Kind::Coulomb, Kind::Delay], 0.04), rung(&[Kind::Stribeck], 0.12)];
        let told = doubted_by_validation(&ladder).unwrap();
        assert!(
            told.what
                .contains("the model with coulomb and delay meets the validation records 3.0 times better"),
            "{}",
            told.what
        );
        assert!(told.fix.contains("fit --effects coulomb,delay"), "{}", told.fix);
        assert_eq!(doubted_by_validation(&ladder[..2]), None);
        assert_eq!(beaten(&ladder, None), 1.0, "by a larger one");
        let [base, both, one] = ladder.clone();
        assert!(
            (beaten(&[base, one, Rung { validation: ladder[0].validation, ..both }], None) - 10.0).abs()
                < 1e-9
        );
        // What a disturbance drives a whole record off by is no beating: within a second both miss as much.
        let drifts = ladder
            .clone()
            .map(|rung| Rung { validation: rung.validation.map(|m| Measures { strayed: 0.1, ..m }), ..rung });
        let [base, both, one] = drifts;
        assert_eq!(beaten(&[base.clone(), one, Rung { validation: base.validation, ..both }], None), 1.0);
        let alone = ladder.map(|rung| Rung { validation: None, ..rung });
        assert_eq!(doubted_by_validation(&alone), None);
    }
}
