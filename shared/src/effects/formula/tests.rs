//! Formulas against the library, and programs that cannot run.

use super::super::spec::{Parameter, Port, Scale, strength};
use super::super::{Kind, testing::*};
use super::Operation::*;
use super::*;
use crate::effects::{Search, Spec};
use crate::lanes::Lanes;
use crate::simulator::Simulator;

const PARAMETERS: [Parameter; 1] = [strength("size", "V", "size", Scale::Own, [0.0, 0.2, 5.0])];

const fn row(name: &'static str, entry: Entry) -> Spec {
    Spec {
        name,
        port: Port::Torque,
        title: "",
        equation: "",
        source: "",
        signature: "",
        parameters: &PARAMETERS,
        probes: &[&[0.2]],
        search: Search::Probes,
        laws: entry.laws(),
        remembers: false,
        periodic: false,
        by_duty: false,
        contains: &[],
    }
}

fn kind(name: &'static str, entry: Entry, program: &'static [Operation]) -> Kind {
    let definition = Definition::new(row(name, entry), entry, program).unwrap();
    Kind::Formula(UserDefined(std::boxed::Box::leak(definition.into())))
}

fn drive() -> std::vec::Vec<f64> {
    (0..3000).map(|k| if k / 300 % 3 == 2 { 0.1 } else { 8.0 * libm::sin(f64::from(k) * 0.01) }).collect()
}

#[test]
fn a_formula_equal_to_a_library_effect_gives_the_same_motion() {
    let volts = drive();
    const W: Operation = Read(Quantity::Speed);
    const DRAG: &[Operation] = &[Parameter(0), Negate, W, Multiply, W, Absolute, Multiply];
    // The library's drag is that at the middle of the step, the formula's that at its beginning.
    let pairs: [(Kind, &str, Entry, &'static [Operation], f64); 3] = [
        (Kind::Coulomb, "my_coulomb", Entry::Friction, &[Parameter(0)], 1e-12),
        (Kind::ConstantLoad, "my_load", Entry::Torque, &[Parameter(0), Negate], 1e-12),
        (Kind::QuadraticDrag, "my_drag", Entry::Torque, DRAG, 2e-3),
    ];
    for (library, name, entry, program, tolerance) in pairs {
        let own = kind(name, entry, program);
        let truth = run(library, &[0.3], &volts).0;
        for (a, b) in run(own, &[0.3], &volts).0.iter().zip(&truth) {
            close(*a, *b, tolerance);
        }
    }
}

#[test]
fn a_sensor_formula_changes_the_reading_and_not_the_motion() {
    const DISC: &[Operation] = &[Parameter(0), Read(Quantity::MotorAngle), Sine, Multiply];
    let own = kind("my_disc", Entry::Sensor, DISC);
    let (angles, motion) = run(own, &[0.004], &[3.0; 700]);
    let x = motion.state.angle;
    close(angles[699], x + 0.004 * libm::sin(x * RIG.gear_ratio), 1e-9);
}

#[test]
fn every_lane_has_its_own_answer() {
    const FADE: &[Operation] = &[Parameter(0), Read(Quantity::Time), Negate, EXP, Multiply];
    let own = kind("my_fade", Entry::Voltage, FADE);
    let volts = drive();
    let base = crate::base::Base {
        gain: Lanes([BASE.gain; 4]),
        tau_m: Lanes([BASE.tau_m; 4]),
        tau_e: Lanes([BASE.tau_e; 4]),
        viscous_share: Lanes([BASE.viscous_share; 4]),
    };
    let sizes = [Lanes([0.1, 0.4, 0.0, 2.0])];
    let s = Simulator::new(&base, [(own, &sizes[..])], &RIG);
    let mut motion = s.start(State::rest());
    for k in 0..volts.len() {
        s.advance(&mut motion, &volts, k);
    }
    for l in 0..4 {
        let alone = run(own, &[sizes[0].0[l]], &volts).1;
        close(motion.state.angle.0[l], alone.state.angle, 1e-12);
    }
}

const EXP: Operation = Function("exp", libm::exp);

#[test]
fn programs_that_cannot_run_are_refused() {
    let refused = |entry, program| Definition::new(row("x", entry), entry, program).err();
    assert_eq!(refused(Entry::Torque, &[Add]), Some(Unsound::Unbalanced));
    assert_eq!(refused(Entry::Torque, &[Number(1.0), Number(2.0)]), Some(Unsound::Unbalanced));
    assert_eq!(refused(Entry::Torque, &[Parameter(1)]), Some(Unsound::Parameters));
    assert_eq!(refused(Entry::Sensor, &[Read(Quantity::Time)]), Some(Unsound::Unknown));
    assert_eq!(refused(Entry::Torque, &[Number(1.0); 13]), Some(Unsound::TooDeep));
}
