//! The library as a stranger calls it: slices in, findings out, stopped from outside.

#[path = "../src/formula/lobe.rs"]
mod lobe;

use std::ops::ControlFlow;
use std::time::Instant;

use motorlens::formula::{Library, Written, WrittenParameter, define};
use motorlens::{
    Discovered, Error, Event, Kind, Measured, Model, Options, compare, discover, discover_records, estimate,
    fit, plan, record, same,
};

/// A second-order motor with dry friction, by semi-implicit Euler at 0.1 ms: 6 s of steps at 500 Hz.
fn measured(friction: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let steps = [6.0, 0.0, -4.0, 2.0, 9.0, -7.0, 1.5, -1.2];
    let time: Vec<f64> = (0..3000).map(|k| f64::from(k) * 2e-3).collect();
    let volts: Vec<f64> = (0..3000).map(|k| steps[k / 200 % steps.len()]).collect();
    let (mut angle, mut speed) = (0.0_f64, 0.0_f64);
    let mut angles = Vec::new();
    for v in &volts {
        angles.push((angle / 1e-3).round() * 1e-3);
        for _ in 0..20 {
            let free = speed + 1e-4 * (0.9 * v - speed) / 0.05;
            speed = free.signum() * (free.abs() - 1e-4 * 0.9 * friction / 0.05).max(0.0);
            angle += 1e-4 * speed;
        }
    }
    (time, volts, angles)
}

fn found(friction: f64, observe: &mut dyn FnMut(&Event) -> ControlFlow<()>) -> Result<Discovered, Error> {
    let (time, volts, angle) = measured(friction);
    discover(&time, &volts, Measured::Angle(&angle), &Options::default(), observe)
}

#[test]
fn slices_become_findings_and_a_model_that_runs_like_the_record() {
    let found = found(0.6, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(found.findings.effects, [Kind::Coulomb], "{}", found.findings.headline);
    let (time, volts, angle) = measured(0.6);
    let simulated = found.model.simulate(&time, &volts, 0.0).unwrap();
    let far = angle.iter().zip(&simulated).fold(0.0_f64, |far, (a, b)| far.max((a - b).abs()));
    assert!(far < 0.02, "{far}");
}

/// Stopped at any of several moments, a search ends in a small part of its time and takes nobody down with it.
#[test]
fn an_observer_that_breaks_ends_the_call_soon_with_cancelled() {
    let begun = Instant::now();
    let mut events = 0_u32;
    found(0.6, &mut |_| {
        events += 1;
        ControlFlow::Continue(())
    })
    .unwrap();
    let whole = begun.elapsed();
    for at in [1, events / 3, 2 * events / 3] {
        let mut seen = 0;
        let mut asked = Instant::now();
        let stopped = found(0.6, &mut |_| {
            seen += 1;
            asked = Instant::now();
            if seen >= at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert!(matches!(stopped, Err(Error::Cancelled)), "{stopped:?}");
        let after = asked.elapsed();
        assert!(after < whole / 2, "{after:?} of {whole:?} after event {at} of {events}");
    }
}

#[test]
fn a_genetic_fit_stops_after_the_generation_in_hand() {
    let (time, volts, angle) = measured(0.6);
    let records = [record("run", &time, &volts, Measured::Angle(&angle)).unwrap()];
    for effects in [vec![], vec![Kind::Coulomb]] {
        let how = estimate::Options {
            method: estimate::Method::Ga,
            effects,
            population: 40,
            generations: 1_000_000,
            seed: 1,
        };
        let mut generations = 0;
        let stopped = fit(&records, &Options::default(), &how, &mut |event| match event {
            Event::Generation { .. } if generations == 3 => ControlFlow::Break(()),
            Event::Generation { .. } => {
                generations += 1;
                ControlFlow::Continue(())
            }
            _ => ControlFlow::Continue(()),
        });
        assert!(matches!(stopped, Err(Error::Cancelled)));
    }
}

/// Calls side by side share nothing: each finds its own motor's friction.
#[test]
fn calls_on_several_threads_do_not_disturb_each_other() {
    let alone = |friction| {
        let found = found(friction, &mut |_| ControlFlow::Continue(())).unwrap();
        (found.findings.simulations, found.model)
    };
    let together: Vec<_> = std::thread::scope(|scope| {
        let calls = [0.4, 0.9].map(|friction| scope.spawn(move || alone(friction)));
        calls.into_iter().map(|call| call.join().unwrap()).collect()
    });
    assert_eq!(together[0], alone(0.4));
    assert_ne!(together[0].1, together[1].1);
}

/// What one call is offered the next call in the process neither tries nor names.
#[test]
fn an_effect_that_one_call_is_offered_is_unknown_to_the_next() {
    const NAME: &str = "lobe_of_one_call";
    let lobe = define(&lobe::lobe(NAME, 0.3)).unwrap();
    let with_it = Library::default().with(lobe).unwrap();
    let (time, volts, angle) = measured(0.6);
    let called = |options: Options| {
        let mut tried = Vec::new();
        let found = discover(&time, &volts, Measured::Angle(&angle), &options, &mut |event| {
            if let Event::Trying { effect, .. } = event {
                tried.push(effect.name());
            }
            ControlFlow::Continue(())
        })
        .unwrap();
        (tried.contains(&NAME), serde_json::to_string(&found.findings).unwrap().contains(NAME))
    };
    let offered = called(Options { library: with_it.kinds().to_vec(), most: 1, ..Options::default() });
    assert!(offered.0, "it is tried where it is offered");
    assert_eq!(called(Options { most: 1, ..Options::default() }), (false, false));
    assert!(!motorlens::diagnose::discover::Options::default().library.contains(&lobe));
    assert_eq!(estimate::effect_by_name(NAME, &with_it).unwrap(), lobe);
    assert!(estimate::effect_by_name(NAME, &Library::default()).is_err());
}

#[test]
fn slices_that_do_not_belong_together_are_refused_with_the_place() {
    let (time, mut volts, angle) = measured(0.6);
    volts[7] = f64::NAN;
    let refused = record("bench", &time, &volts, Measured::Angle(&angle)).unwrap_err().to_string();
    assert!(
        refused.contains("bench") && refused.contains("voltage_v") && refused.contains("value 7"),
        "{refused}"
    );
    let short = record("bench", &time[1..], &angle, Measured::Angle(&angle)).unwrap_err().to_string();
    assert!(short.contains("3000 values, and 2999 times"), "{short}");
}

/// A list that came out empty, of a folder without logs for example.
#[test]
fn no_record_at_all_is_refused_and_no_panic() {
    let (options, how) = (Options::default(), estimate::Options::default());
    let go = &mut |_: &Event| ControlFlow::Continue(());
    let (time, volts, angle) = measured(0.6);
    let one = [record("run", &time, &volts, Measured::Angle(&angle)).unwrap()];
    let model = Model::from_json(include_str!("../examples/model.json")).unwrap();
    for refused in [
        discover_records(&[], &options, go).err(),
        fit(&[], &options, &how, go).err(),
        plan(&[], &options, None, 4.0, go).err(),
        compare(&model, &[], &options, go).err(),
        same(&[], &one, &options, None, go).err(),
        same(&one, &[], &options, Some(&[]), go).err(),
    ] {
        assert!(
            matches!(&refused, Some(Error::Usage { why, .. }) if why == "there is no record"),
            "{refused:?}"
        );
    }
}

#[test]
fn a_comparison_of_two_sets_is_stopped_in_its_fits_too() {
    let (time, volts, angle) = measured(0.6);
    let one = [record("run", &time, &volts, Measured::Angle(&angle)).unwrap()];
    let stopped = same(&one, &one, &Options::default(), Some(&[Kind::Coulomb, Kind::Backlash]), &mut |_| {
        ControlFlow::Break(())
    });
    assert!(matches!(stopped, Err(Error::Cancelled)), "{stopped:?}");
}

#[test]
fn a_model_is_read_from_its_own_text() {
    let text = include_str!("../examples/model.json");
    let model = Model::from_json(text).unwrap();
    assert_eq!(
        serde_json::to_value(&model).unwrap(),
        serde_json::from_str::<serde_json::Value>(text).unwrap()
    );
    assert!(Model::from_json("{}").is_err());
}
