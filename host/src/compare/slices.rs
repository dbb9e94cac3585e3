//! The ways in which moments are sorted into bins.

use std::f64::consts::TAU;

use motorlens_shared::effects::Rig;

use super::course::Moment;

/// Sorts a moment.
type Place = Box<dyn Fn(&Moment) -> Option<usize>>;

/// A way of sorting: its name for programs, its title for people, its bins.
pub(super) struct Sorting {
    pub name: &'static str,
    pub title: &'static str,
    pub unit: &'static str,
    pub bins: Vec<Edge>,
    /// The bin of a moment; none where the moment has no such property.
    pub place: Place,
}

/// The label of a bin and its limits, where it has any.
pub(super) struct Edge {
    pub label: String,
    pub low: Option<f64>,
    pub high: Option<f64>,
}

/// Shares of the largest value between which signed quantities are sorted.
const SHARES: [f64; 4] = [0.1, 0.3, 0.6, 1.0];
/// Bins of a turn.
const SECTORS: usize = 12;
/// Bins of a record.
const PARTS: usize = 8;
/// Limits of the time since a reversal, s.
const SINCE_S: [f64; 6] = [0.0, 0.02, 0.05, 0.1, 0.25, 0.5];
/// A turn must be passed this often before its sectors mean anything.
const TURNS: f64 = 2.0;

/// Every sorting that makes sense for these moments.
pub(super) fn all(moments: &[Moment], rig: &Rig) -> Vec<Sorting> {
    let largest = |f: fn(&Moment) -> f64| moments.iter().map(|m| f(m).abs()).fold(1e-12, f64::max);
    let mut list = vec![
        signed("speed", "speed and direction", "rad/s", largest(|m| m.speed), Box::new(|m| m.speed), true),
        since_reversal(),
        standstill(rig),
        signed("voltage", "voltage", "V", largest(|m| m.voltage), Box::new(|m| m.voltage), false),
        time(),
    ];
    let angles = || moments.iter().filter_map(|m| m.angle);
    let travel = angles().fold(f64::MIN, f64::max) - angles().fold(f64::MAX, f64::min);
    if travel > TURNS * TAU {
        list.push(sectors("output_angle", "angle of the output shaft", 1.0));
    }
    // Finer than the encoder sees, sectors would be made of rounding.
    let motor_turn = TAU / rig.gear_ratio;
    if rig.gear_ratio > 1.0 && travel > TURNS * motor_turn && rig.count_rad < motor_turn / SECTORS as f64 {
        list.push(sectors("motor_angle", "angle of the motor shaft", rig.gear_ratio));
    }
    list
}

fn signed(
    name: &'static str,
    title: &'static str,
    unit: &'static str,
    largest: f64,
    value: Box<dyn Fn(&Moment) -> f64>,
    standing_apart: bool,
) -> Sorting {
    let n = SHARES.len();
    let mut bins = Vec::new();
    for k in (0..n).rev() {
        let low = if k == 0 { 0.0 } else { SHARES[k - 1] };
        bins.push(range(-SHARES[k] * largest, -low * largest, unit));
    }
    for k in 0..n {
        let low = if k == 0 { 0.0 } else { SHARES[k - 1] };
        bins.push(range(low * largest, SHARES[k] * largest, unit));
    }
    if standing_apart {
        bins.push(Edge { label: "standing".into(), low: None, high: None });
    }
    let place = move |m: &Moment| {
        if standing_apart && m.standing {
            return Some(2 * n);
        }
        let share = value(m) / largest;
        let k = SHARES.iter().position(|s| share.abs() <= *s).unwrap_or(n - 1);
        Some(if share < 0.0 { n - 1 - k } else { n + k })
    };
    Sorting { name, title, unit, bins, place: Box::new(place) }
}

fn since_reversal() -> Sorting {
    let n = SINCE_S.len();
    let mut bins: Vec<Edge> = (0..n)
        .map(|k| match SINCE_S.get(k + 1) {
            Some(high) => Edge {
                label: format!("{:.0} to {:.0} ms", 1e3 * SINCE_S[k], 1e3 * high),
                low: Some(SINCE_S[k]),
                high: Some(*high),
            },
            None => {
                Edge { label: format!("over {:.0} ms", 1e3 * SINCE_S[k]), low: Some(SINCE_S[k]), high: None }
            }
        })
        .collect();
    bins.push(Edge { label: "before the first reversal".into(), low: None, high: None });
    let place = move |m: &Moment| {
        Some(m.since_reversal.map_or(n, |t| SINCE_S.iter().rposition(|s| t >= *s).unwrap_or(0)))
    };
    Sorting {
        name: "since_reversal",
        title: "time since the last reversal",
        unit: "s",
        bins,
        place: Box::new(place),
    }
}

fn standstill(rig: &Rig) -> Sorting {
    let quiet = 0.005 * rig.nominal_v;
    let labels = ["standing, without voltage", "standing, with voltage", "moving"];
    let bins = labels.map(|l| Edge { label: l.into(), low: None, high: None });
    let place = move |m: &Moment| {
        Some(match (m.standing, m.voltage.abs() <= quiet) {
            (true, true) => 0,
            (true, false) => 1,
            (false, _) => 2,
        })
    };
    Sorting { name: "standstill", title: "standstill", unit: "", bins: bins.into(), place: Box::new(place) }
}

fn time() -> Sorting {
    let bins = (0..PARTS)
        .map(|k| {
            let (low, high) = (k as f64 / PARTS as f64, (k + 1) as f64 / PARTS as f64);
            Edge {
                label: format!("{:.0} to {:.0} % of the record", 100.0 * low, 100.0 * high),
                low: Some(low),
                high: Some(high),
            }
        })
        .collect();
    let place = |m: &Moment| Some(((m.progress * PARTS as f64) as usize).min(PARTS - 1));
    Sorting { name: "time", title: "time within the record", unit: "1", bins, place: Box::new(place) }
}

fn sectors(name: &'static str, title: &'static str, turns_per_turn: f64) -> Sorting {
    let width = 360.0 / SECTORS as f64;
    let bins = (0..SECTORS)
        .map(|k| {
            let (low, high) = (width * k as f64, width * (k + 1) as f64);
            Edge {
                label: format!("{low:.0} to {high:.0} deg"),
                low: Some(low.to_radians()),
                high: Some(high.to_radians()),
            }
        })
        .collect();
    let place = move |m: &Moment| {
        let turn = (m.angle? * turns_per_turn / TAU).rem_euclid(1.0);
        Some(((turn * SECTORS as f64) as usize).min(SECTORS - 1))
    };
    Sorting { name, title, unit: "rad", bins, place: Box::new(place) }
}

fn range(low: f64, high: f64, unit: &str) -> Edge {
    Edge { label: format!("{low:.2} to {high:.2} {unit}"), low: Some(low), high: Some(high) }
}
