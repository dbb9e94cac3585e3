//! The torque that would have to be added to a model to turn its run into the measurement.
//!
//! With D the difference measured - simulated, the base model's equations give, exactly but for the winding's
//! own lag, which enters to first order,
//!
//! ```text
//! f = ((tau_m - (1 - viscous_share) tau_e) D' + D) / gain          D: of the speed, rad/s; f in V
//! ```
//!
//! The voltage cancels, and so does whatever smoothing does to both runs alike. For a model with effects the
//! equation holds to first order in D, which is small where the model is good. Derivatives come from a
//! quadratic fitted to the samples around each one, by least squares on their own times.

use super::free_run::FreeRun;
use crate::fit::grid::Quantity;
use crate::fit::layout::BaseValues;

/// Half the span over which derivatives are taken, s.
const HALF_SPAN_S: f64 = 0.025;
/// Fewest samples on either side of a derivative.
const FEWEST_BESIDE: usize = 2;
/// Most samples on either side: the quadratic needs no more of a fast log, so some are left out.
const MOST_BESIDE: usize = 25;

/// Residual torque along the measured motion; all columns have one length.
#[derive(Debug, Clone, Default)]
pub struct ResidualTorque {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Residual torque as a voltage, V; positive drives forward.
    pub torque_v: Vec<f64>,
    /// Measured angle of the output shaft, rad (integrated, where only speed was measured).
    pub angle_rad: Vec<f64>,
    /// Simulated angle, alike, rad.
    pub simulated_angle_rad: Vec<f64>,
    /// Measured speed of the output shaft, rad/s, smoothed.
    pub speed_rad_s: Vec<f64>,
    /// Simulated speed, rad/s, smoothed alike.
    pub simulated_speed_rad_s: Vec<f64>,
    /// Measured acceleration, rad/s^2, smoothed.
    pub acceleration_rad_s2: Vec<f64>,
    /// Simulated acceleration, alike, rad/s^2.
    pub simulated_acceleration_rad_s2: Vec<f64>,
    /// Voltage held at each sample, V.
    pub voltage_v: Vec<f64>,
}

impl ResidualTorque {
    /// Root of the mean square, V.
    pub fn rms(&self) -> f64 {
        (self.torque_v.iter().map(|f| f * f).sum::<f64>() / self.torque_v.len().max(1) as f64).sqrt()
    }
}

/// The residual torque of `run`, whose model has the base `base`. The first and last samples, which have no
/// neighbours on one side, are left out.
pub fn residual_torque(run: &FreeRun, base: &BaseValues) -> ResidualTorque {
    let n = run.time_s.len();
    let interval = crate::log::timing::median_interval(&run.time_s).max(1e-9);
    let beside = ((HALF_SPAN_S / interval).round() as usize).max(FEWEST_BESIDE);
    let every = beside.div_ceil(MOST_BESIDE);
    let inertia = base.tau_m - (1.0 - base.viscous_share) * base.tau_e;
    let of_angle = run.quantity == Quantity::Angle;
    let mut out = ResidualTorque::default();
    let mut travelled = [0.0; 2];
    for k in beside..n.saturating_sub(beside) {
        let around = (k - beside..=k + beside).step_by(every);
        let fit = Quadratic::around(&run.time_s, k, around, |j| [run.measured[j], run.simulated[j]]);
        let Some([measured, simulated]) = fit else { continue };
        // A speed's value and slope stand one place earlier than an angle's.
        let motion = |q: &Quadratic| if of_angle { (q.slope, q.bend) } else { (q.value, q.slope) };
        let ((w, a), (ws, as_)) = (motion(&measured), motion(&simulated));
        for (way, speed) in travelled.iter_mut().zip([run.measured[k], run.simulated[k]]) {
            *way += speed * (run.time_s[k] - run.time_s[k - 1]);
        }
        let [angle, simulated_angle] = if of_angle { [measured.value, simulated.value] } else { travelled };
        out.time_s.push(run.time_s[k]);
        out.torque_v.push((inertia * (a - as_) + (w - ws)) / base.gain);
        out.angle_rad.push(angle);
        out.simulated_angle_rad.push(simulated_angle);
        out.speed_rad_s.push(w);
        out.simulated_speed_rad_s.push(ws);
        out.acceleration_rad_s2.push(a);
        out.simulated_acceleration_rad_s2.push(as_);
        out.voltage_v.push(run.voltage_v[k]);
    }
    out
}

/// Value, first and second derivative at a sample.
struct Quadratic {
    value: f64,
    slope: f64,
    bend: f64,
}

impl Quadratic {
    /// Fits value + slope t + bend t^2 / 2 to the columns that `read` gives at the samples `around` sample `k`.
    fn around<const C: usize>(
        time_s: &[f64],
        k: usize,
        around: impl Iterator<Item = usize>,
        read: impl Fn(usize) -> [f64; C],
    ) -> Option<[Self; C]> {
        let origin = read(k);
        let mut moments = [0.0; 5];
        let mut sums = [[0.0; 3]; C];
        for j in around {
            let t = time_s[j] - time_s[k];
            let powers = [1.0, t, t * t, t * t * t, t * t * t * t];
            for (m, p) in moments.iter_mut().zip(powers) {
                *m += p;
            }
            for ((sum, y), y0) in sums.iter_mut().zip(read(j)).zip(origin) {
                for (s, p) in sum.iter_mut().zip(powers) {
                    *s += (y - y0) * p;
                }
            }
        }
        let [m0, m1, m2, m3, m4] = moments;
        let rows = nalgebra::Matrix3::new(m0, m1, m2, m1, m2, m3, m2, m3, m4);
        let inverse = rows.try_inverse()?;
        Some(std::array::from_fn(|c| {
            let x = inverse * nalgebra::Vector3::from(sums[c]);
            Self { value: origin[c] + x[0], slope: x[1], bend: 2.0 * x[2] }
        }))
    }
}

#[cfg(test)]
pub(super) mod testing {
    use super::*;

    /// The base of the made data.
    pub const BASE: BaseValues = BaseValues { gain: 0.9, tau_m: 0.06, tau_e: 5e-4, viscous_share: 0.1 };

    /// A run under a slow triangle of voltage whose true motor also feels `torque(angle, speed)`, V.
    pub fn made(torque: impl Fn(f64, f64) -> f64) -> FreeRun {
        let (steps_per_sample, dt) = (20, 5e-5);
        let volts = |t: f64| 8.0 * (4.0 * (t / 4.0 - (t / 4.0 + 0.5).floor()).abs() - 1.0);
        let go = |torque: &dyn Fn(f64, f64) -> f64| {
            let b = BASE;
            let (mut u, mut w, mut x) = (0.0, 0.0, 0.0);
            let mut angles = Vec::new();
            for k in 0..12_000 * steps_per_sample {
                if k % steps_per_sample == 0 {
                    angles.push(x);
                }
                let v = volts(f64::from(k / steps_per_sample) * 1e-3);
                u += dt * (v - (1.0 - b.viscous_share) / b.gain * w - u) / b.tau_e;
                w += dt * (b.gain * (u + torque(x, w)) - b.viscous_share * w) / b.tau_m;
                x += dt * w;
            }
            angles
        };
        let time_s: Vec<f64> = (0..12_000).map(|k| f64::from(k) * 1e-3).collect();
        FreeRun {
            record: "made".into(),
            measured: go(&torque),
            simulated: go(&|_, _| 0.0),
            voltage_v: time_s.iter().map(|t| volts(*t)).collect(),
            time_s,
            quantity: Quantity::Angle,
            first_speed_rad_s: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::testing::{BASE, made};
    use super::*;

    #[test]
    fn dry_friction_shows_as_a_step_in_the_sign_of_the_speed() {
        let run = made(|_, w| -0.4 * (w / 0.02).tanh());
        let r = residual_torque(&run, &BASE);
        let mut seen = [0; 2];
        for (f, w) in r.torque_v.iter().zip(&r.speed_rad_s) {
            if w.abs() > 0.5 {
                assert!((f + 0.4 * w.signum()).abs() < 0.02, "{f} at {w}");
                seen[usize::from(*w > 0.0)] += 1;
            }
        }
        assert!(seen[0] > 1000 && seen[1] > 1000);
    }

    #[test]
    fn gravity_shows_as_a_sine_of_the_angle() {
        let run = made(|x, _| -0.3 * x.sin());
        let r = residual_torque(&run, &BASE);
        for (f, x) in r.torque_v.iter().zip(&r.angle_rad).skip(100) {
            assert!((f + 0.3 * x.sin()).abs() < 0.02, "{f} at {x}");
        }
    }

    #[test]
    fn a_right_model_leaves_none() {
        let run = made(|_, _| 0.0);
        assert!(residual_torque(&run, &BASE).rms() < 1e-9);
    }

    #[test]
    fn speed_records_and_uneven_times_give_the_same_torque() {
        let angle = made(|_, w| -0.05 * w);
        let keep = |k: &usize| !matches!(k % 7, 2 | 5);
        let pick = |v: &[f64]| (0..v.len()).filter(keep).map(|k| v[k]).collect::<Vec<f64>>();
        let slope = |v: &[f64]| {
            (0..v.len())
                .map(|k| (v[(k + 1).min(v.len() - 1)] - v[k.saturating_sub(1)]) / 2e-3)
                .collect::<Vec<f64>>()
        };
        let speed = FreeRun {
            time_s: pick(&angle.time_s),
            measured: pick(&slope(&angle.measured)),
            simulated: pick(&slope(&angle.simulated)),
            voltage_v: pick(&angle.voltage_v),
            quantity: Quantity::Speed,
            ..angle
        };
        let r = residual_torque(&speed, &BASE);
        for (f, w) in r.torque_v.iter().zip(&r.speed_rad_s).skip(100).take(8000) {
            assert!((f + 0.05 * w).abs() < 0.02, "{f} at {w}");
        }
    }
}
