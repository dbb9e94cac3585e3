//! The climb on hidden cases that each ask for one of its ways.

use super::*;
use crate::diagnose::discover::{Discovery, Options, discover, prepare};
use crate::diagnose::way::MOSTLY_THERE;
use crate::exam::case::{Case, Conditions};
use motorlens_virtual_motor::Kind as Hidden;

/// A drag leaves as little as lost counts do, with a parameter less; two runs tell that counts are lost.
#[test]
fn what_two_runs_show_by_themselves_is_believed_before_what_is_simpler() {
    let case = Case::new(12_000_319, &[Hidden::LostCounts], Conditions { disturbed: 0.25, spoilt: 0.15 });
    let options = Options { library: vec![Kind::QuadraticDrag, Kind::LostCounts], ..Options::default() };
    let found = discover(&case.records, &case.held_out, &case.motor, &options, &mut |_| ()).unwrap();
    assert!(found.evidence.loses_counts);
    assert_eq!(found.effects, [Kind::LostCounts]);
    let (mut evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
    evidence.loses_counts = false;
    let blind = run(&mut evidence, base, &options.library, 1, &mut |_, _| (), &mut |_, _| ());
    let simplest = simplest(&blind.first).expect("two were tried");
    assert_eq!(simplest.kinds(), [Kind::QuadraticDrag], "the case no longer needs a second run");
}

/// A delay fitted alone leaves teeth nothing to start from: they need more starts beside it than a stage gives them.
#[test]
fn a_second_effect_is_looked_for_deeper_where_the_first_leads_nowhere() {
    let found =
        spoilt(22_200_059, &[Hidden::Backlash, Hidden::Delay], &[Kind::Backlash, Kind::Delay, Kind::Cogging]);
    assert_eq!(found.effects, [Kind::Delay, Kind::Backlash]);
    assert!(found.climb.model().explains());
}

/// A gap of 3 ms shows after the quick changes of one record, and in the mean of all leaves them near the noise.
#[test]
fn a_second_effect_is_found_where_one_record_shows_it() {
    let found =
        spoilt(23_200_069, &[Hidden::Delay, Hidden::ConstantLoad], &[Kind::Delay, Kind::ConstantLoad]);
    let first = &found.climb.rungs[1];
    assert!(first.explains() && first.worst() > STANDS_OUT, "the case no longer needs a record of its own");
    assert_eq!(found.effects, [Kind::ConstantLoad, Kind::Delay]);
    assert!(found.climb.model().worst() < STANDS_OUT);
}

/// Where counts are lost, fast records lose more of them than the one by which the floor was measured: with that allowed for, the
/// friction beside them is all that was missing.
#[test]
fn records_that_chance_scatters_count_for_less_once_a_law_foretells_it() {
    let mut found = spoilt(
        23_200_060,
        &[Hidden::LostCounts, Hidden::CoulombAsymmetric],
        &[Kind::CoulombAsymmetric, Kind::LostCounts],
    );
    let with = found.climb.model().clone();
    assert!(with.kinds().contains(&Kind::LostCounts) && with.explains(), "{:?}", with.records);
    assert!(found.evidence.allow_for_chance(&with.values().without(Kind::LostCounts)), "nothing was allowed");
    assert!(!found.evidence.again(&with).explains());
}

/// Friction alone drifts away under a bridge that coasts, and coasting alone with that friction: together they lead to
/// the floor.
#[test]
fn two_effects_are_found_where_neither_helps_without_the_other() {
    let found = spoilt(
        16_200_060,
        &[Hidden::Stribeck, Hidden::Coast],
        &[Kind::Stribeck, Kind::Coast, Kind::LostCounts],
    );
    let base = &found.climb.rungs[0];
    assert!(!found.climb.first.iter().any(|c| worth(c, base)), "the case no longer asks for a leap");
    assert_eq!(found.effects, [Kind::Stribeck, Kind::Coast]);
    assert!(found.climb.model().excess() < MOSTLY_THERE * base.excess());
}

/// A gap bends the viscous share of a model without it to the end of its range, from where no search finds the gap.
#[test]
fn a_gap_is_found_beside_a_spring_once_the_viscous_share_stands_where_it_usually_does() {
    let conditions = Conditions { disturbed: 0.25, spoilt: 0.15 };
    let case = Case::new(26_200_062, &[Hidden::Backlash, Hidden::Spring], conditions);
    let (mut evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
    let library = [Kind::Spring, Kind::Backlash];
    let alone = evidence.fit(&base.values().with(Kind::Spring, vec![0.0164, 0.0]), TO_THE_END).values();
    assert!(alone.base.viscous_share > 0.3, "the case no longer bends it: {alone:?}");
    let climb = run(&mut evidence, base, &library, 2, &mut |_, _| (), &mut |_, _| ());
    assert_eq!(climb.model().kinds(), library);
}

/// What a coarse search of teeth leaves of the error itself hides that they are worth their parameters.
#[test]
fn teeth_that_leave_noise_in_the_increments_are_searched_to_the_end_before_they_are_refused() {
    let found = spoilt(
        26_200_048,
        &[Hidden::Cogging, Hidden::CoulombAsymmetric],
        &[Kind::CoulombAsymmetric, Kind::Cogging],
    );
    assert_eq!(found.effects, [Kind::Cogging, Kind::CoulombAsymmetric]);
    let (without, with) = (&found.climb.rungs[1], found.climb.model());
    assert!(without.explains() || without.excess() < 0.1, "the case no longer is near the noise before");
    assert!(with.drift() < 0.5 * without.drift());
}

/// Dry friction of 0.56 V under a disturbance of 4.6 % of stall: a dead zone would take away a seventh of what shows above it, and
/// is not there.
#[test]
fn what_hardly_shows_above_a_disturbance_gets_no_name() {
    let found = spoilt(33_300_000, &[Hidden::Coulomb], &[Kind::DeadZone, Kind::Delay]);
    assert!(found.effects.is_empty(), "{:?}", found.effects);
    let (first, base) = (&found.climb.first[0], &found.climb.rungs[0]);
    assert_eq!((first.kinds(), first.calm), (&[Kind::DeadZone][..], Some(false)));
    let left = (first.train.increments * first.unseen.increments
        / (base.train.increments * base.unseen.increments))
        .sqrt();
    assert!((0.8..0.93).contains(&left), "the case no longer would be named on a calm rig: {left}");
}

/// Stribeck's fall shows in the slow record alone; the mean of all is at the noise without it.
#[test]
fn a_model_that_leaves_one_record_does_not_explain_them_all() {
    let found = spoilt(33_300_021, &[Hidden::Stribeck], &[Kind::Coulomb]);
    let refused = &found.climb.first[0];
    assert_eq!(refused.kinds(), [Kind::Coulomb]);
    assert!(refused.train.increments.max(refused.unseen.increments) < 1.2, "the mean no longer hides it");
    assert!(refused.worst() > STANDS_OUT && !refused.explains_all(), "{:?}", refused.records);
    assert_eq!(found.climb.withdrawn, [Kind::Coulomb]);
}

/// A load that gravity imitates within a turn: a seventh of what was missing is left, and it is not gravity.
#[test]
fn an_effect_that_goes_part_of_the_way_is_taken_back() {
    let found = spoilt(36_300_004, &[Hidden::ConstantLoad], &[Kind::Gravity]);
    let [base, refused] = [&found.climb.rungs[0], &found.climb.first[0]];
    assert!(refused.excess() < MOSTLY_THERE * base.excess(), "the case no longer goes most of the way");
    assert_eq!((&found.climb.withdrawn[..], &found.effects[..]), (&[Kind::Gravity][..], &[][..]));
}

/// A load under a disturbance of 2.6 % of stall: two effects lower the error as one of them would have to by itself.
#[test]
fn two_effects_at_once_must_do_what_they_would_one_after_the_other() {
    let found = spoilt(36_300_024, &[Hidden::ConstantLoad], &[Kind::DeadZone, Kind::QuadraticDrag]);
    assert!(found.effects.is_empty(), "{:?}", found.effects);
}

/// Coulomb friction under a disturbance of 2.8 % of stall: a dead zone leaves a fifth above the noise on the staircase, where the friction
/// would leave nothing.
#[test]
fn where_two_runs_differ_one_record_that_stands_out_is_left_unexplained() {
    is_left_unexplained(41_300_000, Hidden::Coulomb, Kind::DeadZone);
}

/// Friction and a voltage drop leave less than a hundredth of a dead zone's drift, and a twelfth of its increments.
#[test]
fn two_laws_that_stand_for_a_third_are_taken_back_however_little_they_drift() {
    let found = spoilt(41_300_030, &[Hidden::DeadZone], &[Kind::Coulomb, Kind::VoltageDrop]);
    assert_eq!(found.climb.withdrawn, [Kind::VoltageDrop, Kind::Coulomb]);
}

/// Teeth of 0.46 V beside a drag: the slow record shows them, and what the others show of them is chance.
#[test]
fn teeth_are_found_where_one_record_shows_them() {
    let found = spoilt(
        41_200_068,
        &[Hidden::Cogging, Hidden::QuadraticDrag],
        &[Kind::QuadraticDrag, Kind::Cogging, Kind::SupplySag],
    );
    assert_eq!(found.effects, [Kind::Cogging, Kind::QuadraticDrag]);
    let (without, with) = (&found.climb.rungs[1], found.climb.model());
    assert!(without.records[0] > 2.0 && with.records[0] < 1.2, "{:?}", with.records);
    assert!(
        with.unseen.increments > 0.85 * without.unseen.increments,
        "the case no longer asks for a record"
    );
}

/// Until it is known when the pulses come, friction beside them leaves twice the drift that a model which explains may leave.
#[test]
fn two_effects_that_drift_until_the_pulses_are_timed_are_searched_on() {
    let found = spoilt(
        39_200_015,
        &[Hidden::Coast, Hidden::Stribeck],
        &[Kind::Coast, Kind::Stribeck, Kind::QuadraticDrag, Kind::LoadFriction],
    );
    assert_eq!(found.effects, [Kind::Coast, Kind::Stribeck]);
    assert!(found.climb.explains_all(), "{:?}", found.climb.model().records);
}

/// Friction takes a dead zone's place first, then saturation that of a sagging supply beside it: both are put right, one after the other.
#[test]
fn each_of_two_effects_is_chosen_anew_beside_the_other() {
    let found = spoilt(
        42_200_025,
        &[Hidden::DeadZone, Hidden::SupplySag],
        &[Kind::Coulomb, Kind::DeadZone, Kind::Saturation, Kind::SupplySag],
    );
    assert_eq!(found.climb.rungs[1].kinds(), [Kind::Coulomb], "the case no longer begins elsewhere");
    assert_eq!(found.effects, [Kind::DeadZone, Kind::SupplySag]);
    assert!(found.climb.explains_all(), "{:?}", found.climb.model().records);
}

/// Left as they were under a model without them, the first speeds leave 1.3 x the floor on every record that begins in motion.
#[test]
fn first_speeds_are_fitted_anew_once_two_effects_stand() {
    let found = spoilt(42_200_031, &[Hidden::Saturation, Hidden::Delay], &[Kind::Saturation, Kind::Delay]);
    assert_eq!(found.effects, [Kind::Saturation, Kind::Delay]);
    assert!(found.climb.explains_all(), "{:?}", found.climb.model().records);
}

/// Dry friction for a dead zone of 0.94 V, under a disturbance of 1.7 % of stall: an eighth is left on all records.
#[test]
fn where_two_runs_differ_what_is_left_above_that_is_left_unexplained() {
    is_left_unexplained(43_300_010, Hidden::DeadZone, Kind::Coulomb);
}

/// A drag that a bridge which coasts imitates but for a PRBS, and for a twentieth of the drift.
#[test]
fn an_effect_that_leaves_a_record_and_some_of_the_drift_is_taken_back() {
    let found = spoilt(43_300_002, &[Hidden::QuadraticDrag], &[Kind::Coast]);
    assert_eq!((&found.climb.withdrawn[..], &found.effects[..]), (&[Kind::Coast][..], &[][..]));
    let [base, refused] = [&found.climb.rungs[0], &found.climb.first[0]];
    assert!(refused.drift() < 0.1 * base.drift(), "the case no longer goes most of the way");
}

/// Of two lowest places of a gap's cost the search ends in the one that leaves 1.6 and 3.2 x the floor; a delay of a fourteenth of
/// a sampling interval beside it would lead to the other.
#[test]
fn a_gap_is_searched_again_before_anything_is_put_beside_it() {
    let found = spoilt(44_000_409, &[Hidden::Backlash], &[Kind::Backlash, Kind::Delay]);
    assert_eq!(found.effects, [Kind::Backlash]);
    assert!(found.climb.model().explains(), "{:?}", found.climb.model().records);
}

/// The plain motor's winding took 5 ms of a filter of 17 ms: searched from there it keeps them, and a compliant shaft would explain all.
#[test]
fn a_filter_is_searched_to_its_end_beside_a_law_that_explains() {
    let found = spoilt(43_000_120, &[Hidden::SensorLag], &[Kind::SensorLag, Kind::Compliance]);
    assert_eq!(found.effects, [Kind::SensorLag]);
    assert!(found.climb.explains_all(), "{:?}", found.climb.model().records);
}

/// A filter of 2.5 ms under a noisy voltage leaves 1.8 x the floor on the PRBS, in fine cells alone.
#[test]
fn a_reading_that_is_late_by_little_comes_first_where_nothing_else_shows() {
    let case = Case::new(42_000_320, &[Hidden::SensorLag], Conditions { disturbed: 0.25, spoilt: 0.15 });
    let (mut evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
    let climb = run(&mut evidence, base, Kind::ALL, 1, &mut |_, _| (), &mut |_, _| ());
    assert_eq!(climb.first[0].kinds(), [Kind::SensorLag]);
}

/// Teeth lose of the torque that saturated iron leaves: with its loss told from the current, 17 x the floor stayed of the drift.
#[test]
fn saturation_and_the_friction_of_teeth_explain_a_motor_that_has_both() {
    let hidden = [Hidden::LoadFriction, Hidden::Saturation];
    let found = spoilt(44_200_001, &hidden, &[Kind::LoadFriction, Kind::Saturation]);
    assert!(found.climb.explains_all() && found.effects.len() == 2, "{:?}", found.climb.model().records);
}

/// A drag by the friction of teeth leaves the increments below the floor, and a tenth of the drift; a sagging supply by two laws a record
/// and a tenth of the drift; Stribeck's fall by friction and teeth likewise.
#[test]
fn laws_that_stop_a_little_short_on_a_calm_motor_are_taken_back() {
    for (seed, hidden, library) in [
        (44_300_022, Hidden::QuadraticDrag, &[Kind::LoadFriction][..]),
        (42_300_032, Hidden::SupplySag, &[Kind::Saturation, Kind::LoadFriction]),
        (44_300_001, Hidden::Stribeck, &[Kind::Coulomb, Kind::Cogging]),
    ] {
        let found = spoilt(seed, &[hidden], library);
        let withdrawn = &found.climb.withdrawn;
        assert!(found.effects.is_empty() && withdrawn.len() == library.len(), "{seed}: {withdrawn:?}");
    }
}

/// A bridge that coasts by a drag, under a disturbance: a record keeps four fifths of what it stood out with.
#[test]
fn a_law_that_leaves_one_record_as_it_was_is_taken_back_where_two_runs_differ() {
    let found = spoilt(44_300_013, &[Hidden::Coast], &[Kind::QuadraticDrag]);
    assert_eq!((&found.climb.withdrawn[..], &found.effects[..]), (&[Kind::QuadraticDrag][..], &[][..]));
}

/// `stranger` is accepted for what is `hidden` where two runs differ, and is not said to explain it, though on a calm rig it would be.
fn is_left_unexplained(seed: u64, hidden: Hidden, stranger: Kind) {
    let found = spoilt(seed, &[hidden], &[stranger]);
    let model = found.climb.model();
    assert_eq!((model.kinds(), model.calm), (&[stranger][..], Some(false)));
    assert!(model.explains_all(), "the case no longer is near the noise: {:?}", model.records);
    assert!(!found.climb.explains_all(), "{:?}", model.records);
}

/// What is found of `library` in a case that may be disturbed and spoilt.
fn spoilt(seed: u64, hidden: &[Hidden], library: &[Kind]) -> Discovery {
    let case = Case::new(seed, hidden, Conditions { disturbed: 0.25, spoilt: 0.15 });
    let options = Options { library: library.to_vec(), ..Options::default() };
    discover(&case.records, &case.held_out, &case.motor, &options, &mut |_| ()).unwrap()
}
