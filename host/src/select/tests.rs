//! The selection on motors of the examination.

use motorlens_shared::effects::Kind;
use motorlens_virtual_motor::Kind as Hidden;

use super::adequacy::Adequacy;
use super::fitted::Fitted;
use super::run::{Rivals, tied};
use super::starts::besides;
use crate::diagnose::discover::{Discovery, Options, discover, prepare, reading_noise};
use crate::exam::case::{Case, Conditions};
use crate::log::Record;
use crate::motor_file::MotorFile;

fn found(case: &Case, validation: &[Record]) -> Discovery {
    let library = vec![Kind::Coulomb, Kind::Gravity, Kind::Delay, Kind::Eccentricity, Kind::QuadraticDrag];
    let options = Options { library, ..Options::default() };
    discover(&case.records, validation, &case.motor, &options, &mut |_| ()).unwrap()
}

#[test]
fn friction_is_found_and_a_plain_motor_gets_nothing_also_under_a_disturbance() {
    for disturbed in [0.0, 1.0] {
        let conditions = Conditions { disturbed, spoilt: 0.0 };
        let case = Case::new(31, &[Hidden::Coulomb], conditions);
        assert_eq!(found(&case, &[]).effects, [Kind::Coulomb], "{}", case.conditions);
        let plain = Case::new(32, &[], conditions);
        assert_eq!(found(&plain, &[]).effects, [], "{}", plain.conditions);
    }
}

#[test]
fn validation_records_change_no_fit_and_no_choice() {
    let case = Case::new(33, &[Hidden::Gravity], Conditions { disturbed: 0.0, spoilt: 0.0 });
    let (without, with) = (found(&case, &[]), found(&case, &case.held_out));
    assert_eq!(without.effects, with.effects);
    assert_eq!(without.model.values(), with.model.values());
}

const CALM: Conditions = Conditions { disturbed: 0.0, spoilt: 0.0 };

#[test]
fn a_model_at_the_end_of_its_search_or_far_from_what_it_was_fitted_to_is_not_taken() {
    let case = Case::new(32, &[], CALM);
    let (evidence, base) = prepare(&case.records, &[], &case.motor).unwrap();
    let at = |change: fn(&mut crate::fit::layout::BaseValues)| {
        let mut values = base.values();
        change(&mut values.base);
        Fitted::new(&evidence, base.layout.clone(), &base.layout.pack(&values), 1, 0)
    };
    let (end, off) = (at(|b| b.tau_m = 1e-9), at(|b| b.gain *= 4.0));
    assert!(end.is_lost(&base) && !base.is_lost(&end) && !off.is_lost(&base));
    assert!(off.strays(&base, &evidence) && !base.strays(&off, &evidence) && !base.strays(&base, &evidence));
    let nearer = |models: [&Fitted; 3]| {
        let rivals = Rivals { models: models.map(Clone::clone).to_vec() };
        rivals.nearer(&evidence).map(|nearer| nearer.values() == base.values())
    };
    assert_eq!(nearer([&off, &base, &off]), Some(true), "a rival that runs much nearer is told");
    assert_eq!(nearer([&base, &off, &base]), None);
}

#[test]
fn a_model_that_the_usual_one_beats_is_not_explained() {
    let case = Case::new(32, &[], CALM);
    let (mut evidence, base) = prepare(&case.records, &[], &case.motor).unwrap();
    let floor = reading_noise(&evidence.whole);
    assert!(evidence.usual.is_some());
    assert!(Adequacy::of(&evidence, &base, &base, floor).is_explained());
    evidence.usual.iter_mut().for_each(|usual| usual.rmse = 1e-9);
    assert!(!Adequacy::of(&evidence, &base, &base, floor).is_explained());
}

#[test]
fn a_spring_shows_where_the_shaft_comes_back_and_on_no_way_that_is_gone_once() {
    let times: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
    let shown = |angle: fn(f64) -> f64| {
        let angle_rad = Some(times.iter().map(|t| angle(*t)).collect());
        let record = Record {
            time_s: times.clone(),
            voltage_v: times.iter().map(|t| 6.0 * t.min(1.0)).collect(),
            angle_rad,
            ..Record::default()
        };
        let (evidence, _) = prepare(&[record], &[], &MotorFile::default()).unwrap();
        [Kind::Spring, Kind::Gravity, Kind::Coulomb].map(|kind| evidence.may_show(kind))
    };
    assert_eq!(shown(|t| 5.0 * t), [false, true, true]);
    assert_eq!(shown(|t| 5.0 * (2.0 * t).sin()), [true; 3]);
}

#[test]
fn a_driver_that_floats_is_looked_for_beside_friction_that_stops_the_motor() {
    let case = Case::new(32, &[], CALM);
    let (evidence, base) = prepare(&case.records, &[], &case.motor).unwrap();
    let shares = |kind| {
        besides(&evidence.train, &base.values(), kind)
            .iter()
            .map(|v| v.base.viscous_share)
            .collect::<Vec<_>>()
    };
    let plain = shares(Kind::Coulomb);
    assert_eq!(shares(Kind::Coast).len(), plain.len() + 1);
    assert!(shares(Kind::Coast).iter().any(|share| *share > 0.3) && plain.iter().all(|share| *share < 0.3));
}

#[test]
fn readings_that_are_noise_alone_determine_nothing_of_the_motor() {
    let case = Case::new(32, &[], CALM);
    let (evidence, base) = prepare(&case.records, &[], &case.motor).unwrap();
    assert!(base.knows_the_motor(&evidence));
    let time_s: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
    let noise = Record {
        voltage_v: time_s.iter().map(|t| 6.0 * (2.0 * t).sin()).collect(),
        angle_rad: Some((0..400).map(|k| 0.01 * f64::from(k * k).sin()).collect()),
        time_s,
        ..Record::default()
    };
    let (evidence, base) = prepare(&[noise], &[], &MotorFile::default()).unwrap();
    assert!(!base.knows_the_motor(&evidence));
}

#[test]
fn of_two_effects_that_do_as_well_the_other_one_is_tied_and_one_that_does_worse_is_not() {
    let of = |case: &Case, sizes: [(Kind, f64); 2]| {
        let (evidence, base) = prepare(&case.records, &[], &case.motor).unwrap();
        let [accepted, other] =
            sizes.map(|(kind, size)| Fitted::of(&evidence, &base.values().with(kind, vec![size]), 3, 12));
        tied(&evidence, &accepted, &[accepted.clone(), other], &base).map(|rival| rival.kinds().to_vec())
    };
    let plain = Case::new(32, &[], CALM);
    let alike = of(&plain, [(Kind::Coulomb, 0.0), (Kind::ConstantLoad, 0.0)]);
    assert_eq!(alike, Some(vec![Kind::ConstantLoad]));
    let rubs = Case::new(31, &[Hidden::Coulomb], CALM);
    assert_eq!(of(&rubs, [(Kind::Coulomb, 0.3), (Kind::Delay, 1e-3)]), None);
}
