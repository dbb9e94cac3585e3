//! What holds for every row of the registry, and for the template.

use super::testing::{BASE, RIG};
use super::{Active, Effect, Kind, Memory, Now, Port, Setting};
use crate::fixed::Fixed;
use crate::lanes::Lanes;
use crate::simulator::Simulator;
use crate::step::{Drive, Laws, State};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::vec::Vec;

fn typical(kind: Kind) -> Vec<f64> {
    let spec = kind.spec();
    let probe = spec.probes[spec.probes.len() / 2];
    spec.parameters.iter().zip(probe).map(|(p, x)| x * p.scale.unit(&RIG)).collect()
}

/// A drive with reversals, coasting, slow and fast parts.
fn drive(n: usize) -> Vec<f64> {
    (0..n)
        .map(|k| match (k / 400) % 5 {
            0 => 9.0,
            1 => 0.0,
            2 => -6.0,
            3 => 0.01 * (k % 400) as f64 - 2.0,
            _ => 5.0 * libm::sin(k as f64 * 0.03),
        })
        .collect()
}

fn angles(effects: &[(Kind, Vec<f64>)], volts: &[f64]) -> Vec<f64> {
    let s = Simulator::new(&BASE, effects.iter().map(|(k, p)| (*k, &p[..])), &RIG);
    let mut m = s.start(State::rest());
    (0..volts.len())
        .map(|k| {
            s.advance(&mut m, volts, k);
            s.read(&m)
        })
        .collect()
}

#[test]
fn names_are_unique_and_lead_back_to_their_row() {
    let names: BTreeSet<_> = Kind::ALL.iter().map(|k| k.name()).collect();
    assert_eq!(names.len(), Kind::ALL.len());
    for (index, kind) in Kind::ALL.iter().enumerate() {
        assert_eq!(Kind::by_name(kind.name()), Some(*kind));
        assert_eq!(kind.index(), Some(index));
    }
    assert_eq!(Kind::by_name("none"), None);
}

#[test]
fn only_a_delay_and_a_filter_are_nothing_but_late() {
    let late: Vec<&str> =
        Kind::ALL.iter().filter(|kind| kind.spec().is_late()).map(|kind| kind.name()).collect();
    assert_eq!(
        late,
        ["delay", "sensor_lag"],
        "a new effect whose only size is a time is believed on fewer blocks (select::fitted)"
    );
}

#[test]
fn every_row_is_complete_and_consistent() {
    for kind in Kind::ALL {
        let s = kind.spec();
        for text in [s.title, s.equation, s.source, s.signature] {
            assert!(!text.is_empty(), "{kind}: an empty text in its row");
        }
        assert!(s.parameters.len() <= crate::simulator::MAX_PARAMETERS);
        assert!(s.parameters.iter().any(|p| p.strength) || s.port == Port::Transmission);
        for probe in s.probes {
            assert_eq!(probe.len(), s.parameters.len(), "{kind}: a probe of another length");
            for (x, p) in probe.iter().zip(s.parameters) {
                assert!((p.low..=p.high).contains(x), "{kind}: probe {x} of {} out of bounds", p.name);
            }
        }
        for (simpler, parameter) in s.contains {
            let simpler = Kind::by_name(simpler).expect("it contains an effect of the registry").spec();
            let own =
                &s.parameters[s.place(parameter).expect("it has the parameter that is the simpler one's")];
            assert_eq!(simpler.parameters.len(), 1, "{kind}: {} has more parameters", simpler.name);
            assert_eq!(simpler.parameters[0].scale, own.scale, "{kind}: {parameter} has another scale");
        }
        assert_eq!(s.load_share().is_some(), s.port == Port::Transmission);
    }
}

#[test]
fn powers_in_units_have_a_caret() {
    for parameter in Kind::ALL.iter().flat_map(|kind| kind.spec().parameters) {
        let is_bare = |pair: &[u8]| pair[0].is_ascii_alphabetic() && pair[1].is_ascii_digit();
        let unit = parameter.unit;
        assert!(unit.is_ascii() && !unit.as_bytes().windows(2).any(is_bare), "{}: {unit}", parameter.name);
    }
}

#[test]
fn every_effect_sets_only_what_its_row_declares() {
    let plain = Drive::plain(3.0);
    for kind in Kind::ALL {
        let effect = Active::new(*kind, &typical(*kind), &Setting::new(&BASE, &RIG, 1));
        let state = State { load_speed: 2.5, load_angle: 0.8, ..State::moving(2.0, 3.0, 0.7) };
        let now = Now { command: 3.0, state, voltages: &[1.0, 3.0], index: 1 };
        let memory = Memory { store: 0.1, age: 0.0, origin: 0.2 };
        let mut drive = plain;
        effect.drive(&now, &memory, &mut drive);
        let dry = drive.friction_forward != plain.friction_forward
            || drive.friction_backward != plain.friction_backward
            || drive.meshing != plain.meshing;
        let set = Laws {
            torque: drive.torque != plain.torque || drive.load_torque != plain.load_torque,
            drop: drive.drop != plain.drop,
            series: drive.series != plain.series,
            brush: drive.brush != plain.brush,
            dry,
            meshing: drive.meshing != plain.meshing,
            turning: dry,
            // That an equation acts between rotor and load is not in what drives them.
            parts: kind.spec().laws.parts,
        };
        assert_eq!(set, kind.spec().laws, "{kind}");
    }
}

#[test]
fn effects_act_in_the_order_of_the_registry_however_they_are_given() {
    let volts = drive(2000);
    let (delay, dead) = ((Kind::Delay, typical(Kind::Delay)), (Kind::DeadZone, typical(Kind::DeadZone)));
    assert_eq!(angles(&[delay.clone(), dead.clone()], &volts), angles(&[dead, delay], &volts));
}

#[test]
fn a_sum_is_its_parts_together() {
    let volts = drive(2000);
    for kind in Kind::ALL.iter().filter(|kind| kind.spec().is_sum()) {
        let parameters = typical(*kind);
        let parts = kind.spec().contains.iter().map(|(name, parameter)| {
            let place = kind.spec().place(parameter).expect("a parameter of the sum");
            (Kind::by_name(name).expect("an effect"), std::vec![parameters[place]])
        });
        let parts: Vec<_> = parts.collect();
        for (whole, added) in angles(&[(*kind, parameters)], &volts).iter().zip(angles(&parts, &volts)) {
            assert!((whole - added).abs() < 1e-9, "{kind}: {whole} and {added} rad");
        }
    }
}

#[test]
fn every_effect_changes_the_reading_and_stays_finite() {
    let volts = drive(4000);
    let plain = angles(&[], &volts);
    for kind in Kind::ALL {
        let with = angles(&[(*kind, typical(*kind))], &volts);
        let change: f64 = with.iter().zip(&plain).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(with.iter().all(|x| x.is_finite()), "{kind} blew up");
        assert!(change > 1e-3, "{kind} changed the reading by {change} rad only");
    }
}

#[test]
fn an_effect_of_strength_zero_is_the_plain_motor() {
    let volts = drive(2000);
    let plain = angles(&[], &volts);
    for kind in Kind::ALL.iter().filter(|k| k.spec().port != Port::Transmission) {
        let zero: Vec<f64> = typical(*kind)
            .iter()
            .zip(kind.spec().parameters)
            .map(|(x, p)| if p.strength || p.low < 0.0 { 0.0 } else { *x })
            .collect();
        let with = angles(&[(*kind, zero)], &volts);
        for (a, b) in with.iter().zip(&plain) {
            assert!((a - b).abs() < 1e-9, "{kind} acts although its strength is zero");
        }
    }
}

#[test]
fn lanes_give_every_candidate_its_own_answer() {
    let volts = drive(2000);
    for kind in Kind::ALL {
        let p = typical(*kind);
        let factors = [1.0, 0.7, 1.0, 0.4];
        let base = crate::base::Base {
            gain: Lanes([BASE.gain; 4]),
            tau_m: Lanes([BASE.tau_m, BASE.tau_m, 0.08, 0.03]),
            tau_e: Lanes([BASE.tau_e; 4]),
            viscous_share: Lanes([BASE.viscous_share; 4]),
        };
        let wide: Vec<Lanes<f64, 4>> =
            p.iter().map(|x| Lanes(core::array::from_fn(|l| x * factors[l]))).collect();
        let s = Simulator::new(&base, [(*kind, &wide[..])], &RIG);
        let mut m = s.start(State::rest());
        for k in 0..volts.len() {
            s.advance(&mut m, &volts, k);
        }
        let block = s.read(&m);
        for l in 0..4 {
            let base = crate::base::Base { tau_m: base.tau_m.0[l], ..BASE };
            let narrow: Vec<f64> = p.iter().map(|x| x * factors[l]).collect();
            let s = Simulator::new(&base, [(*kind, &narrow[..])], &RIG);
            let mut m = s.start(State::rest());
            for k in 0..volts.len() {
                s.advance(&mut m, &volts, k);
            }
            assert_eq!(block.0[l], s.read(&m), "{kind}, lane {l}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Without a drive, no effect but a load or a spring may add energy to a moving shaft.
    #[test]
    fn a_coasting_shaft_never_speeds_up(speed in -9.0_f64..9.0, which in 0..Kind::ALL.len(), size in 0.1_f64..1.0) {
        let kind = Kind::ALL[which];
        let driving = [Kind::ConstantLoad, Kind::Spring, Kind::Gravity, Kind::Cogging];
        prop_assume!(!driving.contains(&kind));
        let p: Vec<f64> = typical(kind).iter().zip(kind.spec().parameters)
            .map(|(x, q)| (x * size).max(q.low * q.scale.unit(&RIG))).collect();
        let s = Simulator::new(&BASE, [(kind, &p[..])], &RIG);
        let mut m = s.start(State::moving(0.0, speed, 0.0));
        let volts = [0.0; 500];
        for k in 0..500 {
            s.advance(&mut m, &volts, k);
            prop_assert!(m.state.speed.abs() <= speed.abs() * (1.0 + 1e-9));
        }
    }
}

/// 36 s at 1 kHz in 32-bit fixed point: friction, weight and a gap beside the base model, per-unit.
#[test]
fn fixed_point_follows_double_precision_for_36_seconds() {
    type Q = Fixed<25>;
    let volts: Vec<f64> =
        (0..36_000).map(|k| 7.0 * libm::sin(core::f64::consts::TAU * 0.25 * k as f64 * 1e-3)).collect();
    let units =
        crate::base::Units { volt: 8.0, speed: BASE.gain * 8.0, angle: BASE.gain * 8.0 * 1e-3 * 1024.0 };
    let worst = crate::per_unit::compare::<Q>(&BASE, 0.4, &volts, &units);
    // Stated error: a quarter of the paper's encoder count (1.26e-3 rad).
    assert!(worst < 3e-4, "fixed point is {worst} rad off");
}
