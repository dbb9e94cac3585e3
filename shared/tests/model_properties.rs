//! Properties of the model over random motors: energy, limits, agreement of number types.

use motorlens_shared::base::Base;
use motorlens_shared::effects::{Kind, Port, Rig};
use motorlens_shared::scalar::Scalar;
use motorlens_shared::simulator::Simulator;
use motorlens_shared::step::State;
use proptest::prelude::*;

const RIG: Rig = Rig {
    step_s: 1e-3,
    gear_ratio: 30.0,
    encoder_on_motor: true,
    nominal_v: 12.0,
    supply_v: 12.0,
    reference_speed: 10.0,
    count_rad: 1e-3,
};

/// Effects that can only take energy out of a motor under no voltage.
const DISSIPATIVE: [Kind; 6] = [
    Kind::Coulomb,
    Kind::CoulombAsymmetric,
    Kind::Stribeck,
    Kind::LoadFriction,
    Kind::VoltageDrop,
    Kind::SupplySag,
];

fn motors() -> impl Strategy<Value = Base<f64>> {
    (0.1..50.0, 0.01..0.5, 1e-4..2e-3, 0.0..0.5).prop_map(|(gain, tau_m, tau_e, viscous_share)| Base {
        gain,
        tau_m,
        tau_e,
        viscous_share,
    })
}

/// The rig of a motor whose name plate is right.
fn rig(base: &Base<f64>) -> Rig {
    Rig { reference_speed: base.gain * RIG.nominal_v, ..RIG }
}

fn sizes(kind: Kind, factor: f64, rig: &Rig) -> Vec<f64> {
    let spec = kind.spec();
    let probe = spec.probes[spec.probes.len() / 2];
    let scaled = spec.parameters.iter().zip(probe).map(|(p, x)| {
        let x = if p.strength { x * factor } else { *x };
        x.clamp(p.low, p.high) * p.scale.unit(rig)
    });
    scaled.collect()
}

/// Energy of the moving parts and of the winding's field, both as volts squared times seconds:
/// d/dt (k w^2 / 2 c + tau_e u^2 / 2) = u v - u^2 - k b w^2 / c.
fn energy(base: &Base<f64>, state: &State<f64>) -> f64 {
    0.5 * base.back_emf() / base.acceleration() * state.speed * state.speed
        + 0.5 * base.tau_e * state.current * state.current
}

/// The step up to which losses take no more than is there, s. Below its knee a brush drop is a resistance of drop / knee
/// times the winding's, and shortens the electrical time constant so much; in longer steps the equation takes the current to
/// fade as the winding alone would let it, and the speed may gain what the brush seems to have held back.
fn longest_step(base: &Base<f64>, kind: Option<Kind>, parameters: &[f64]) -> f64 {
    match (kind, parameters) {
        (Some(Kind::VoltageDrop), [drop, knee]) => RIG.step_s.min(base.tau_e / (1.0 + drop / knee)),
        _ => RIG.step_s,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_motor_under_no_voltage_only_loses_energy(
        base in motors(), speed in -10.0..10.0_f64, current in -12.0..12.0_f64,
        which in 0..=DISSIPATIVE.len(), factor in 0.1..2.0_f64,
    ) {
        let kind = DISSIPATIVE.get(which).copied();
        let parameters = kind.map(|k| sizes(k, factor, &rig(&base))).unwrap_or_default();
        let rig = Rig { step_s: longest_step(&base, kind, &parameters), ..rig(&base) };
        let simulator = Simulator::new(&base, kind.iter().map(|k| (*k, parameters.as_slice())), &rig);
        let mut motion = simulator.start(State::moving(current, speed, 0.0));
        let mut before = energy(&base, &motion.state);
        for cell in 0..300 {
            simulator.advance(&mut motion, &[0.0; 300], cell);
            let after = energy(&base, &motion.state);
            prop_assert!(after <= before * (1.0 + 1e-9) + 1e-15, "{kind:?}: {before} to {after} in cell {cell}");
            before = after;
        }
    }

    #[test]
    fn no_voltage_within_limits_turns_a_motor_beyond_its_no_load_speed(
        base in motors(), volts in prop::collection::vec(-12.0..12.0_f64, 20), which in 0..=DISSIPATIVE.len(),
    ) {
        // Slow windings overshoot; the others approach the no-load speed from one side.
        let base = Base { tau_e: base.tau_e.min(base.tau_m / 5.0), ..base };
        let kind = DISSIPATIVE.get(which).copied();
        let parameters = kind.map(|k| sizes(k, 1.0, &rig(&base))).unwrap_or_default();
        let simulator = Simulator::new(&base, kind.iter().map(|k| (*k, parameters.as_slice())), &rig(&base));
        let held: Vec<f64> = volts.iter().flat_map(|v| [*v; 50]).collect();
        let peak = volts.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let mut motion = simulator.start(State::rest());
        for cell in 0..held.len() {
            simulator.advance(&mut motion, &held, cell);
            prop_assert!(motion.state.speed.abs() <= base.gain * peak * (1.0 + 1e-9));
        }
    }

    #[test]
    fn single_and_double_precision_agree(base in motors(), which in 0..Kind::ALL.len(), factor in 0.3..1.5_f64) {
        let kind = Kind::ALL[which];
        let parameters = sizes(kind, factor, &rig(&base));
        let volts: Vec<f64> = (0..1500).map(|k| 8.0 * (f64::from(k) * 0.01).sin()).collect();
        let fine = run::<f64>(&base, kind, &parameters, &volts);
        let coarse = run::<f32>(&base, kind, &parameters, &volts);
        let range = fine.iter().fold(1e-3_f64, |m, x| m.max(x.abs()));
        // Torque ripple multiplies a difference of phase, so that a cog more or less may follow.
        let tolerance = if kind == Kind::Cogging || kind.spec().port == Port::Transmission { 2e-2 } else { 2e-3 };
        for (a, b) in fine.iter().zip(&coarse) {
            prop_assert!((a - b).abs() <= tolerance * range, "{kind}: {a} {b} of {range}");
        }
    }
}

fn run<S: Scalar<Element = S> + Into<f64>>(
    base: &Base<f64>,
    kind: Kind,
    p: &[f64],
    volts: &[f64],
) -> Vec<f64> {
    let rig = rig(base);
    let base = Base {
        gain: S::lit(base.gain),
        tau_m: S::lit(base.tau_m),
        tau_e: S::lit(base.tau_e),
        viscous_share: S::lit(base.viscous_share),
    };
    let p: Vec<S> = p.iter().map(|x| S::lit(*x)).collect();
    let volts: Vec<S> = volts.iter().map(|v| S::lit(*v)).collect();
    let simulator = Simulator::new(&base, [(kind, p.as_slice())], &rig);
    let mut motion = simulator.start(State::rest());
    (0..volts.len())
        .map(|cell| {
            simulator.advance(&mut motion, &volts, cell);
            simulator.read(&motion).into()
        })
        .collect()
}
