//! Models to export, a voltage, and what motorlens itself makes of them.
#![allow(dead_code)] // each test file is a crate of its own and uses what it needs

use motorlens::export::Options;
use motorlens::fit::layout::{BaseValues, Prior, Values};
use motorlens::formula::{Written, WrittenParameter, define};
use motorlens::model_file::{Model, Origin};
use motorlens_shared::effects::{Kind, Rig};
use motorlens_shared::simulator::Simulator;
use motorlens_shared::step::State;

pub const OPTIONS: Options =
    Options { step_s: Some(1e-3), torque_per_volt: None, name: None, bam_model: None };

pub fn rig() -> Rig {
    Rig {
        step_s: 1e-3,
        gear_ratio: 30.0,
        encoder_on_motor: true,
        nominal_v: 12.0,
        supply_v: 12.0,
        reference_speed: 11.0,
        count_rad: 1e-3,
    }
}

pub fn model(effects: &[(Kind, &[f64])]) -> Model {
    let base = BaseValues { gain: 0.9, tau_m: 0.05, tau_e: 6e-4, viscous_share: 0.1 };
    let effects = effects.iter().map(|(kind, p)| (*kind, p.to_vec())).collect();
    let prior = Prior { tau_e: (5e-4, 0.4), viscous_share: (0.08, 0.05) };
    Model::new(&Values { base, effects }, &rig(), &prior, Origin::default())
}

/// The same with the encoder on the output shaft, and no gear.
pub fn at_the_output(mut model: Model) -> Model {
    model.rig.encoder_on_motor = false;
    model.rig.gear_ratio = 1.0;
    model
}

/// Sets that together hold every effect of the library.
pub fn sets() -> Vec<Model> {
    let sets: Vec<Vec<(Kind, &[f64])>> = vec![
        vec![],
        vec![(Kind::DeadZone, &[0.3, 0.05]), (Kind::Coulomb, &[0.2]), (Kind::Gravity, &[0.4, -0.2])],
        vec![
            (Kind::Delay, &[0.0061]),
            (Kind::DeadZone, &[0.2, 0.0]),
            (Kind::SupplySag, &[0.3, 0.003]),
            (Kind::Stribeck, &[0.2, 0.3, 0.2, 0.4]),
            (Kind::Spring, &[0.05, -0.1]),
        ],
        vec![
            (Kind::VoltageDrop, &[0.4, 0.2]),
            (Kind::LoadFriction, &[0.1, 0.2]),
            (Kind::ConstantLoad, &[-0.3]),
        ],
        vec![
            (Kind::CoulombAsymmetric, &[0.3, 0.1]),
            (Kind::QuadraticDrag, &[0.01]),
            (Kind::Cogging, &[0.2, -0.1, 0.05, -0.02, 3.0]),
        ],
        vec![(Kind::LoadFriction, &[0.2, 0.3]), (Kind::Saturation, &[0.5])],
        vec![(Kind::Delay, &[0.0137]), (Kind::Coast, &[0.6, 500.0]), (Kind::Saturation, &[0.5])],
        vec![(Kind::Freewheel, &[0.9, 500.0]), (Kind::Coulomb, &[0.3])],
        // Not in the order in which they apply.
        vec![(Kind::Saturation, &[0.5]), (Kind::Coulomb, &[0.3]), (Kind::Gravity, &[0.4, -0.2])],
        vec![(Kind::WindingHeating, &[0.2, 20.0]), (Kind::Eccentricity, &[0.004, -0.002])],
        vec![(Kind::LostCounts, &[0.05, 3.0]), (Kind::SensorLag, &[0.012, 0.0])],
        vec![(Kind::Eccentricity, &[0.004, -0.002]), (Kind::SensorLag, &[0.012, 0.0])],
        vec![(Kind::Eccentricity, &[0.004, -0.002]), (Kind::SensorLag, &[0.0, 0.013_773_1])],
        vec![(Kind::Coulomb, &[0.3]), (Kind::SensorLag, &[0.0, 0.013_773_1])],
        // Updated several times in a step.
        vec![(Kind::Coulomb, &[0.3]), (Kind::SensorLag, &[0.0, 0.000_371_31])],
        vec![
            (Kind::Backlash, &[0.05, 0.4, 0.3, 120.0, 0.4]),
            (Kind::Gravity, &[0.2, 0.1]),
            (Kind::WindingHeating, &[0.2, 20.0]),
            (Kind::Coulomb, &[0.2]),
            (Kind::SensorLag, &[0.012, 0.0]),
            (Kind::Eccentricity, &[0.004, 0.002]),
        ],
        vec![
            (Kind::Compliance, &[8.0, 0.4, 0.05, 0.3]),
            (Kind::Spring, &[0.05, 0.1]),
            (Kind::LostCounts, &[0.05, 3.0]),
        ],
    ];
    for kind in Kind::ALL {
        assert!(sets.iter().flatten().any(|(k, _)| k == kind), "{kind} is in no set");
    }
    sets.iter().map(|set| model(set)).collect()
}

/// Two effects at their typical sizes, but for two transmissions, of which a model has one.
pub fn pairs() -> Vec<Model> {
    let typical = |kind: Kind| -> Vec<f64> {
        kind.spec().parameters.iter().map(|p| p.typical * p.scale.unit(&rig())).collect()
    };
    let all = |a: Kind| Kind::ALL.iter().map(move |b| (a, *b));
    Kind::ALL
        .iter()
        .flat_map(|a| all(*a))
        .filter(|(a, b)| a < b && !(a.is_transmission() && b.is_transmission()))
        .map(|(a, b)| model(&[(a, &typical(a)), (b, &typical(b))]))
        .collect()
}

/// 4 s of reversals and rest.
pub fn volts() -> Vec<f64> {
    (0..4000_u32)
        .map(|k| match k / 400 % 5 {
            0 => 8.0,
            1 => -5.0,
            2 => 0.0,
            3 => 0.5,
            _ => 9.0 * (f64::from(k) * 0.02).sin(),
        })
        .collect()
}

pub fn truth(model: &Model, volts: &[f64]) -> Vec<f64> {
    let values = model.values();
    let effects = values.effects.iter().map(|(kind, p)| (*kind, p.as_slice()));
    let simulator = Simulator::new(&values.base.base(), effects, &model.rig(1e-3));
    let mut motion = simulator.start(State::rest());
    // A late voltage finds none before the start.
    let volts = [&[0.0], volts].concat();
    (1..volts.len())
        .map(|cell| {
            simulator.advance(&mut motion, &volts, cell);
            simulator.read(&motion)
        })
        .collect()
}

/// An effect of the user's own, with one parameter `size` of the typical value 0.2.
pub fn own(name: &str, port: &str, formula: &str) -> Kind {
    let size = WrittenParameter {
        name: "size".into(),
        unit: "V".into(),
        meaning: String::new(),
        low: 0.0,
        typical: 0.2,
        high: 5.0,
    };
    let written = Written {
        name: name.into(),
        port: port.into(),
        formula: formula.into(),
        title: String::new(),
        signature: String::new(),
        source: String::new(),
        parameters: vec![size],
    };
    define(&written).unwrap_or_else(|wrong| panic!("{wrong:?}"))
}

/// Formulas at every port, with every function that is not the library's own.
pub fn formulas() -> Vec<Model> {
    let one = |name, port, formula, size: f64| (own(name, port, formula), [size]);
    let sets = [
        vec![
            one(
                "x_torque",
                "torque",
                "-size * tanh(speed / 2) * exp(-abs(angle)^2) - 0.1 * min(speed, 1)",
                0.4,
            ),
            one("x_friction", "friction", "size * (1 + max(0, sin(angle + 0.3)))", 0.2),
            one("x_sensor", "sensor", "size * cos(motor_angle) * sign(angle - 0.5)", 0.003),
        ],
        vec![
            one("x_voltage", "voltage", "-size * atan2(voltage, 2) + 0.01 * floor(command)", 0.3),
            one("x_drop", "drop", "size * sqrt(1 + atan(current)^2)", 0.2),
            one(
                "x_resistance",
                "resistance",
                "size * (1 - exp(-time / 2)) + ln(1 + 0.01 * motor_speed^2) / 100",
                0.3,
            ),
        ],
    ];
    sets.iter().map(|set| model(&set.iter().map(|(k, p)| (*k, p.as_slice())).collect::<Vec<_>>())).collect()
}
