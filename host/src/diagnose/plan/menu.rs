//! The programmes that are tried, and their course on a model's grid.

use motorlens_shared::excitation::{Player, Programme, Segment, Shape};

use super::Limits;
use crate::fit::grid::Grid;
use crate::fit::search::Problem;
use crate::log::Record;

/// Rate at which programmes are tried, Hz.
pub(super) const RATE_HZ: u32 = 500;
/// A longer programme would show nothing new, s.
const LONGEST_S: f64 = 24.0;

/// Programmes within the limits.
pub(super) fn menu(limits: Limits) -> Vec<Programme> {
    let volts = limits.volts as f32;
    let seconds = limits.seconds.min(LONGEST_S) as f32;
    let share = |part: f32| part * volts;
    let triangle =
        |part: f32| Shape::Triangle { amplitude_v: share(part), period_s: (seconds / 2.0).min(4.0) };
    let slow = [triangle(0.1), triangle(0.2)].map(|shape| Segment { shape, seconds: seconds / 2.0 });
    let mut menu: Vec<Programme> = Programme::sequence("slow-triangles", slow).into_iter().collect();
    let multisine = |part: f32| Shape::Multisine {
        amplitude_v: share(part),
        low_hz: 0.2,
        high_hz: 8.0,
        tones: 14,
        seed: 7,
    };
    let single = [
        ("pulse-and-coast", Shape::PulseAndCoast { amplitude_v: share(0.9) }),
        ("multisine", multisine(0.7)),
        ("small-multisine", multisine(0.25)),
        ("prbs", Shape::Prbs { amplitude_v: share(0.8), chip_s: 0.06, seed: 7 }),
        ("staircase", Shape::Staircase { amplitude_v: share(0.9), hold_s: 0.6, seed: 7 }),
        ("one-way-sine", Shape::Sine { amplitude_v: share(0.3), frequency_hz: 1.0, offset_v: share(0.5) }),
        ("sine", Shape::Sine { amplitude_v: share(0.6), frequency_hz: 0.5, offset_v: 0.0 }),
    ];
    menu.extend(single.map(|(name, shape)| Programme::single(name, shape, seconds)));
    menu.retain(|p| p.validate(volts).is_ok());
    menu
}

/// The programme laid on the model's grid, from rest; nothing is measured yet.
pub(super) fn played(programme: &Programme, problem: &Problem) -> Option<Grid> {
    let voltage_v: Vec<f64> = Player::new(programme, RATE_HZ).ok()?.map(f64::from).collect();
    let n = voltage_v.len();
    let record = Record {
        name: programme.name.as_str().into(),
        time_s: (0..n).map(|k| k as f64 / f64::from(RATE_HZ)).collect(),
        angle_rad: Some(vec![0.0; n]),
        voltage_v,
        ..Record::default()
    };
    Some(Grid::new(&record, problem.rig.count_rad))
}
