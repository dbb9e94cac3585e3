//! How a servo's loop drives its motor: from target and angle to the duty of every row.

use super::{Controller, Servo, USUAL_SUPPLY};
use crate::log::motion::{low_pass, slope, speed};
use crate::log::timing::median_interval;
use crate::log::{Hold, Record};

/// Places between two rows at which the duty is worked out: full duty is reached between them.
const BETWEEN: usize = 8;

/// How a motor is driven: its controller, what of the loop is late, and whether the target moves on straight from row to row or is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Loop {
    pub controller: Controller,
    pub late: Lateness,
    pub moves: bool,
}

/// What of a loop is late, the target or the voltage, and by how much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lateness {
    /// From the row of a target to where the controller has it, s.
    pub target_s: f64,
    /// From where target and angle ask for a voltage to where it acts, s.
    pub voltage_s: f64,
}

impl Lateness {
    pub const NONE: Self = Self { target_s: 0.0, voltage_s: 0.0 };

    /// So many times as late.
    pub fn times(self, factor: f64) -> Self {
        Self { target_s: factor * self.target_s, voltage_s: factor * self.voltage_s }
    }
}

/// A servo's record as its loop sees it.
pub(super) struct Seen<'a> {
    pub record: &'a Record,
    servo: &'a Servo,
    angle: &'a [f64],
    speed: Vec<f64>,
    /// Time from row to row, s.
    pub interval_s: f64,
}

impl<'a> Seen<'a> {
    pub fn of(record: &'a Record) -> Option<Self> {
        let (servo, angle) = (record.servo.as_ref()?, record.angle_rad.as_deref().unwrap_or_default());
        let interval_s = median_interval(&record.time_s);
        Some(Self { record, servo, angle, speed: filtered_speed(record), interval_s })
    }
}

impl Loop {
    /// Gives `record` the voltage that the loop asks for. How late that acts is the motor's to a fit, which tells a delay from a lag.
    pub fn drive(self, record: &mut Record) {
        let Some(seen) = Seen::of(record) else { return };
        let duty = if self.moves { self.duty(&seen) } else { self.mean_duty(&seen) };
        let voltage_v = volts(record, &duty);
        record.hold = if self.moves { Hold::First } else { Hold::Zero };
        record.voltage_v = voltage_v;
    }

    /// The duty that is asked for at each row.
    fn duty(self, seen: &Seen) -> Vec<f64> {
        let late = self.late.target_s / seen.interval_s;
        let motion = seen.angle.iter().zip(&seen.speed).enumerate();
        let duty = |(k, (angle, speed)): (usize, (&f64, &f64))| {
            let target = target_at(&seen.servo.target_rad, k as f64 - late, self.moves);
            self.controller.duty(target - angle, *speed)
        };
        motion.map(duty).collect()
    }

    /// The mean duty that is asked for from each row to the next: the loop runs far more often than it is logged, and the shaft turns on meanwhile.
    pub fn mean_duty(self, seen: &Seen) -> Vec<f64> {
        let late = self.late.target_s / seen.interval_s;
        let last = seen.angle.len().saturating_sub(1);
        let mean = |k: usize| {
            let next = (k + 1).min(last);
            let at = |values: &[f64], share: f64| values[k] + share * (values[next] - values[k]);
            let duty = |step: usize| {
                let share = (step as f64 + 0.5) / BETWEEN as f64;
                let target = target_at(&seen.servo.target_rad, k as f64 + share - late, self.moves);
                self.controller.duty(target - at(seen.angle, share), at(&seen.speed, share))
            };
            (0..BETWEEN).map(duty).sum::<f64>() / BETWEEN as f64
        };
        (0..seen.angle.len()).map(mean).collect()
    }
}

/// The target so many rows, and parts of one, behind the first: it moves on straight from row to row, or is held until the next.
pub(super) fn target_at(target: &[f64], rows: f64, moves: bool) -> f64 {
    let rows = rows.max(0.0);
    let last = target.len() - 1;
    let row = (rows as usize).min(last);
    let next = (row + 1).min(last);
    if moves { target[row] + (rows - row as f64) * (target[next] - target[row]) } else { target[row] }
}

/// What a `duty` of each sample of `record` is in volts.
pub(super) fn volts(record: &Record, duty: &[f64]) -> Vec<f64> {
    duty.iter().enumerate().map(|(k, duty)| duty * full_duty_v(record, k)).collect()
}

/// The volts that full duty is at sample `k`.
pub(super) fn full_duty_v(record: &Record, k: usize) -> f64 {
    record.supply_v.as_ref().map_or(USUAL_SUPPLY, |supply| supply[k])
}

/// The speed as a servo's loop sees it, and not as noisy as a difference of two samples.
pub(super) fn filtered_speed(record: &Record) -> Vec<f64> {
    match (&record.angle_rad, &record.speed_rad_s) {
        (_, Some(_)) => speed(record),
        (Some(angle), None) => {
            low_pass(&record.time_s, &slope(&record.time_s, angle), 0.5 * median_interval(&record.time_s))
        }
        (None, None) => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_is_held_or_moves_on_and_stands_before_the_first_row_and_behind_the_last() {
        let target = [1.0, 3.0, 2.0];
        for (rows, held, moving) in
            [(-2.5, 1.0, 1.0), (0.0, 1.0, 1.0), (0.75, 1.0, 2.5), (1.5, 3.0, 2.5), (7.5, 2.0, 2.0)]
        {
            assert_eq!([false, true].map(|moves| target_at(&target, rows, moves)), [held, moving], "{rows}");
        }
    }
}
