//! What a loop is to follow.

use crate::fit::layout::BaseValues;

/// A set point: place, rad, speed, rad/s, acceleration, rad/s^2.
pub(super) type Point = [f64; 3];

/// Part of the no-load speed at the controller's largest voltage that a profile reaches.
const FASTEST: f64 = 0.3;
/// A move takes so many mechanical time constants ...
const LONG: f64 = 12.0;
/// ... of this many seconds at least.
const SHORTEST_S: f64 = 0.05;
/// A step of the place is this part of a move.
const PLACE: f64 = 0.1;
/// So many times as long it is held to see whether what swings dies away.
const HELD: f64 = 10.0;

/// A course of set points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Profile {
    /// A minimum-jerk move of `way_rad` there and back in `length_s` each, with rests between.
    Move { way_rad: f64, length_s: f64 },
    /// The place is another at once; what comes of that shows within `length_s`, and it is held for longer.
    Place { height_rad: f64, length_s: f64 },
    /// The speed is another at once.
    Speed { height_rad_s: f64, length_s: f64 },
}

impl Profile {
    /// A move, a step of the place, and a step of the speed, for a motor with a controller of at most `limit_v`.
    pub fn of(base: &BaseValues, limit_v: f64) -> [Self; 3] {
        let length_s = LONG * base.tau_m.max(SHORTEST_S);
        let fastest = FASTEST * base.gain * limit_v;
        // A minimum-jerk move of D in T is fastest at 15/8 D/T.
        let way_rad = fastest * length_s * 8.0 / 15.0;
        let height_rad = PLACE * way_rad;
        [
            Self::Move { way_rad, length_s },
            Self::Place { height_rad, length_s },
            Self::Speed { height_rad_s: fastest, length_s },
        ]
    }

    /// How long it is, s.
    pub fn seconds(&self) -> f64 {
        match self {
            Self::Move { length_s, .. } => 3.5 * length_s,
            Self::Place { length_s, .. } => HELD * length_s,
            Self::Speed { length_s, .. } => *length_s,
        }
    }

    /// The part of it, s, from which rise, overshoot and settling are read: the rest shows whether what swings dies away.
    pub fn answered_s(&self) -> f64 {
        match self {
            Self::Place { length_s, .. } => *length_s,
            Self::Move { .. } | Self::Speed { .. } => self.seconds(),
        }
    }

    /// What is wanted at `time_s`.
    pub fn at(&self, time_s: f64) -> Point {
        match *self {
            Self::Move { way_rad, length_s } => there_and_back(way_rad, length_s, time_s),
            Self::Place { height_rad, .. } => [height_rad, 0.0, 0.0],
            Self::Speed { height_rad_s, .. } => [height_rad_s * time_s, height_rad_s, 0.0],
        }
    }
}

fn there_and_back(way: f64, length: f64, time_s: f64) -> Point {
    let move_at = |s: f64| -> Point {
        let s = s.clamp(0.0, 1.0);
        [
            way * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s),
            way / length * 30.0 * s * s * (1.0 - s).powi(2),
            way / (length * length) * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
        ]
    };
    let phase = time_s / length - 0.25;
    if phase < 1.5 {
        return move_at(phase);
    }
    let back = move_at(phase - 1.5);
    [way - back[0], -back[1], -back[2]]
}
