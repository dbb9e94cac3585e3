//! What the motor was doing at every sample of an open-loop simulation, as far as the measurement shows it.

use super::free_run::FreeRun;
use crate::fit::grid::Quantity;
use motorlens_shared::effects::Rig;

/// Speeds are taken over this time either way, s; the error's growth too.
const HALF_WINDOW_S: f64 = 0.025;
/// Slower than this share of the no-load speed counts as standing.
const STANDING: f64 = 0.01;

/// One sample with its circumstances.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    /// Share of the record that has passed, 0 ..= 1.
    pub progress: f64,
    /// Speed of the output shaft, rad/s.
    pub speed: f64,
    /// Whether the shaft stands.
    pub standing: bool,
    /// Angle of the output shaft, rad; none in records of speed.
    pub angle: Option<f64>,
    /// Voltage, V.
    pub voltage: f64,
    /// Since the speed last changed its sign, s; none before the first time.
    pub since_reversal: Option<f64>,
    /// Measured minus simulated, in the measured unit.
    pub error: f64,
    /// Change of the error over 50 ms; of records of speed, the error itself.
    pub growth: f64,
}

/// The moments of a run.
pub(super) fn moments(run: &FreeRun, rig: &Rig) -> Vec<Moment> {
    let n = run.time_s.len();
    let error: Vec<f64> = run.measured.iter().zip(&run.simulated).map(|(y, p)| y - p).collect();
    let span = run.time_s[n - 1] - run.time_s[0];
    let angle = run.quantity == Quantity::Angle;
    let standing_below = STANDING * rig.reference_speed;
    let (mut a, mut b) = (0, 0);
    let mut direction = 0.0;
    let mut reversed: Option<f64> = None;
    (0..n)
        .map(|k| {
            let now = run.time_s[k];
            while run.time_s[a] < now - HALF_WINDOW_S {
                a += 1;
            }
            while b + 1 < n && run.time_s[b + 1] <= now + HALF_WINDOW_S {
                b += 1;
            }
            // Slow logs have no neighbour within the window.
            let (from, to) = if b > a { (a, b) } else { (k.saturating_sub(1), (k + 1).min(n - 1)) };
            let elapsed = (run.time_s[to] - run.time_s[from]).max(1e-9);
            let speed =
                if angle { (run.measured[to] - run.measured[from]) / elapsed } else { run.measured[k] };
            let standing = speed.abs() < standing_below;
            if !standing {
                if direction * speed < 0.0 {
                    reversed = Some(now);
                }
                direction = speed.signum();
            }
            Moment {
                progress: (now - run.time_s[0]) / span.max(1e-9),
                speed,
                standing,
                angle: angle.then(|| run.measured[k]),
                voltage: run.voltage_v[k],
                since_reversal: reversed.map(|at| now - at),
                error: error[k],
                growth: if angle { error[to] - error[from] } else { error[k] },
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reversal_starts_a_clock_and_a_stop_does_not() {
        let time_s: Vec<f64> = (0..4000).map(|k| f64::from(k) * 1e-3).collect();
        // Forward for 1 s, still for 1 s, forward for 1 s, backward for 1 s.
        let angle: Vec<f64> =
            time_s.iter().map(|t| t.min(1.0) + (t - 2.0).clamp(0.0, 1.0) - (t - 3.0).max(0.0)).collect();
        let run = FreeRun {
            record: "r".into(),
            simulated: angle.iter().map(|a| a * 0.9).collect(),
            measured: angle,
            voltage_v: vec![0.0; 4000],
            time_s,
            quantity: Quantity::Angle,
            first_speed_rad_s: 0.0,
        };
        let rig = Rig {
            step_s: 1e-3,
            gear_ratio: 1.0,
            encoder_on_motor: true,
            nominal_v: 12.0,
            supply_v: 12.0,
            reference_speed: 1.0,
            count_rad: 1e-3,
        };
        let m = moments(&run, &rig);
        assert!(m[1500].standing && m[2500].since_reversal.is_none());
        assert!((m[500].speed - 1.0).abs() < 1e-9);
        assert!((m[3500].since_reversal.unwrap() - 0.5).abs() < 0.03);
        assert!((m[500].growth - 0.005).abs() < 1e-6, "{}", m[500].growth);
    }
}
