//! Logs of servos, made for tests: a motor in a position loop that runs fifty times as often as it is logged.

use super::Servo;
use crate::log::Record;

/// Where a target is between two rows: it moves on, or stands as it was so many rows before, and before the first where the shaft is.
#[derive(Clone, Copy)]
pub(super) enum Between {
    Moves,
    Stands(usize),
}

/// A servo and its log of 100 rows a second.
#[derive(Clone, Copy)]
pub(super) struct Made {
    pub gain: f64,
    pub damping: f64,
    /// How far its target goes, rad, and as what share of that by the time.
    pub size: f64,
    pub target: fn(f64) -> f64,
    pub between: Between,
    /// What a weight takes where it hangs level, V.
    pub weight_v: f64,
    /// How much later than it is asked for its voltage acts, s.
    pub dead_s: f64,
    /// What a reading of its angle is off by at most, rad.
    pub noise: f64,
    pub rows: usize,
}

impl Default for Made {
    fn default() -> Self {
        Self {
            gain: 2.5,
            damping: 0.0,
            size: 1.3,
            target: |t: f64| (0.9 * t).sin().signum() * 0.6 + 0.4 * (2.3 * t).sin(),
            between: Between::Stands(0),
            weight_v: 0.0,
            dead_s: 0.0,
            noise: 0.0,
            rows: 1_200,
        }
    }
}

impl Made {
    pub fn record(self) -> Record {
        self.log().0
    }

    /// Its record, and the mean voltage of every row.
    pub fn log(self) -> (Record, Vec<f64>) {
        let (supply, dt, steps) = (12.0, 2e-4, 50);
        let (mut w, mut x) = (0.0_f64, 0.0_f64);
        let (mut record, mut angle) = (Record { name: "servo".into(), ..Record::default() }, Vec::new());
        let (mut targets, mut means, mut asked) = (Vec::new(), Vec::new(), Vec::new());
        let dead = (self.dead_s / dt).round() as usize;
        for k in 0..self.rows * steps {
            let (row, t) = (k / steps, k as f64 * dt);
            let mut target = self.size * (self.target)(t);
            if k % steps == 0 {
                record.time_s.push(t);
                angle.push(x + self.noise * ((row * row) as f64).sin());
                targets.push(target);
                means.push(0.0);
            }
            if let Between::Stands(late) = self.between {
                target = row.checked_sub(late).map_or(0.0, |then| targets[then]);
            }
            asked.push((self.gain * (target - x) - self.damping * w).clamp(-1.0, 1.0));
            let v = supply * k.checked_sub(dead).map_or(0.0, |then| asked[then]);
            means[row] += v / steps as f64;
            let push = v - self.weight_v * x.sin();
            let friction = if w == 0.0 { push.clamp(-0.3, 0.3) } else { 0.3 * w.signum() };
            w += dt / 0.05 * (0.5 * (push - friction) - w);
            x += dt * w;
        }
        record.angle_rad = Some(angle);
        record.supply_v = Some(vec![supply; record.len()]);
        record.servo = Some(Servo { target_rad: targets, gain: None, damping: None });
        record.voltage_v = vec![0.0; record.len()];
        (record, means)
    }
}
