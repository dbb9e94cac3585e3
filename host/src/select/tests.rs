//! The selection on motors of the examination.

use motorlens_shared::effects::Kind;
use motorlens_virtual_motor::Kind as Hidden;

use crate::diagnose::discover::{Discovery, Options, discover};
use crate::exam::case::{Case, Conditions};
use crate::log::Record;

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
