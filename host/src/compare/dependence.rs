//! Whether what a model leaves depends on anything that is measured.
//!
//! A disturbance torque cannot be told from a missing effect by its size, but by this: a missing effect depends on voltage, speed, angle or
//! time, and does so again. The means of the residual torque over short stretches are regressed on some shapes of these, by ridge
//! regression, and foretold where they were not fitted (residual analysis: L. Ljung, *System Identification*, 2nd ed., 1999, sec. 16.6; ridge
//! regression: A. Hoerl and R. Kennard, *Technometrics* 12, 1970; cross-validation: M. Stone, *J. R. Stat. Soc. B* 36, 1974). What the
//! parameters of the base model could take up does not count.
//!
//! Speed and acceleration are those of the simulation. The measured ones hold what the torque itself has done, so that every disturbance
//! would seem to depend on them (instrumental variables: Ljung, sec. 7.6).

use nalgebra::{DMatrix, DVector};

use super::residual_torque::ResidualTorque;
use crate::log::timing::median;

/// Length of a stretch, s: a few mechanical time constants of a small motor, long beside the span of the derivatives.
const STRETCH_S: f64 = 0.12;
/// Stretches that are left out of a fit together, s.
const BLOCK_S: f64 = 1.0;
/// Parts that the blocks are dealt to.
const FOLDS: usize = 5;
/// Weight of the ridge, of the number of stretches.
const RIDGE: f64 = 1e-3;
/// Beyond so many standard deviations a mean is clipped.
const MOST: f64 = 6.0;
/// Fewest stretches that tell anything.
const FEWEST: usize = 60;

/// What of the residual torque can be foretold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dependence {
    /// Share of its variance.
    pub share: f64,
    /// How much better it is foretold than by nothing, over the standard error of that. Below nothing where it depends on nothing.
    pub sure: f64,
    /// Its rms over the stretches, as a voltage, V.
    pub left_v: f64,
}

impl Dependence {
    /// Of the residual torques of all records; none where they are too short to tell.
    pub fn of(all: &[ResidualTorque]) -> Option<Self> {
        let stretches = Stretch::all(all);
        if stretches.len() < FEWEST {
            return None;
        }
        let square = stretches.iter().map(|s| s.torque_v.powi(2)).sum::<f64>();
        let torque = clipped(stretches.iter().map(|s| s.torque_v).collect());
        let shapes = shapes(&stretches);
        let base = shapes.columns(0, BASE).into_owned();
        let [without, with] = [&base, &shapes].map(|shapes| foretold(&stretches, shapes, &torque));
        let blocks = 1 + stretches.iter().map(|s| s.block).max().unwrap_or(0);
        let mut gains = vec![0.0; blocks];
        let (mut before, mut after) = (0.0, 0.0);
        for (k, stretch) in stretches.iter().enumerate() {
            let (old, new) = ((torque[k] - without[k]).powi(2), (torque[k] - with[k]).powi(2));
            gains[stretch.block] += old - new;
            (before, after) = (before + old, after + new);
        }
        let n = blocks as f64;
        let mean = gains.iter().sum::<f64>() / n;
        let variance = gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        Some(Self {
            share: 1.0 - after / before.max(1e-300),
            sure: mean / (variance / n).max(1e-300).sqrt(),
            left_v: (square / stretches.len() as f64).sqrt(),
        })
    }
}

/// Means over a stretch of a record.
#[derive(Debug, Clone, Copy, Default)]
struct Stretch {
    block: usize,
    time_s: f64,
    torque_v: f64,
    angle_rad: f64,
    speed_rad_s: f64,
    acceleration_rad_s2: f64,
    voltage_v: f64,
    /// Voltage of the stretch before.
    before_v: f64,
}

impl Stretch {
    fn all(all: &[ResidualTorque]) -> Vec<Self> {
        let mut stretches: Vec<Self> = Vec::new();
        let mut first_block = 0;
        for torque in all {
            let (Some(begin), Some(end)) = (torque.time_s.first(), torque.time_s.last()) else { continue };
            let place = |time: f64, length: f64| ((time - begin) / length) as usize;
            let mut from = 0;
            let mut before_v = torque.voltage_v[0];
            while from < torque.time_s.len() {
                let own = place(torque.time_s[from], STRETCH_S);
                let count = torque.time_s[from..].iter().take_while(|t| place(**t, STRETCH_S) == own).count();
                let mean = |column: &[f64]| column[from..from + count].iter().sum::<f64>() / count as f64;
                let stretch = Self {
                    block: first_block + place(torque.time_s[from], BLOCK_S),
                    time_s: mean(&torque.time_s),
                    torque_v: mean(&torque.torque_v),
                    angle_rad: mean(&torque.angle_rad),
                    speed_rad_s: mean(&torque.simulated_speed_rad_s),
                    acceleration_rad_s2: mean(&torque.simulated_acceleration_rad_s2),
                    voltage_v: mean(&torque.voltage_v),
                    before_v,
                };
                before_v = stretch.voltage_v;
                stretches.push(stretch);
                from += count;
            }
            first_block += 1 + place(*end, BLOCK_S);
        }
        stretches
    }
}

/// Columns that the parameters of the base model could take up.
const BASE: usize = 3;

/// The shapes, a column each, of mean square one.
fn shapes(stretches: &[Stretch]) -> DMatrix<f64> {
    let scale = |of: fn(&Stretch) -> f64| {
        (stretches.iter().map(|s| of(s).powi(2)).sum::<f64>() / stretches.len() as f64).sqrt().max(1e-12)
    };
    let (speed, volts) = (scale(|s| s.speed_rad_s), scale(|s| s.voltage_v));
    let acceleration = scale(|s| s.acceleration_rad_s2);
    let longest = stretches.iter().map(|s| s.time_s).fold(1e-12, f64::max);
    let row = |s: &Stretch| {
        let (w, u, a) = (s.speed_rad_s / speed, s.voltage_v / volts, s.acceleration_rad_s2 / acceleration);
        let (late, t) = (s.before_v / volts, s.time_s / longest);
        [
            // What the base model's parameters change.
            w,
            u,
            a,
            // Loads, friction, drags, drops.
            1.0,
            (w / 0.05).tanh(),
            (w / 0.3).tanh(),
            w * w.abs(),
            (u / 0.05).tanh(),
            u * u.abs(),
            w.abs(),
            u.abs(),
            u * u * w,
            // What comes late.
            late,
            u - late,
            // What changes with time.
            t,
            t * w,
            t * u,
            // What the shaft's angle does, by direction too.
            s.angle_rad.sin(),
            s.angle_rad.cos(),
            (w / 0.05).tanh() * s.angle_rad.sin(),
            (w / 0.05).tanh() * s.angle_rad.cos(),
            s.angle_rad,
        ]
    };
    let rows: Vec<_> = stretches.iter().map(row).collect();
    let mut shapes = DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
    for mut column in shapes.column_iter_mut() {
        let rms = column.norm() / (column.len() as f64).sqrt();
        column /= rms.max(1e-12);
    }
    shapes
}

/// Every stretch's torque as those of other blocks foretell it.
fn foretold(stretches: &[Stretch], shapes: &DMatrix<f64>, torque: &[f64]) -> Vec<f64> {
    let mut foretold = vec![0.0; stretches.len()];
    for fold in 0..FOLDS {
        let n = shapes.ncols();
        let (mut h, mut g) = (DMatrix::<f64>::zeros(n, n), DVector::<f64>::zeros(n));
        for (k, _) in stretches.iter().enumerate().filter(|(_, s)| s.block % FOLDS != fold) {
            let row = shapes.row(k).transpose();
            h.ger(1.0, &row, &row, 1.0);
            g.axpy(torque[k], &row, 1.0);
        }
        for k in 0..n {
            h[(k, k)] += RIDGE * stretches.len() as f64;
        }
        let Some(factor) = h.cholesky() else { continue };
        let weights = factor.solve(&g);
        for (k, _) in stretches.iter().enumerate().filter(|(_, s)| s.block % FOLDS == fold) {
            foretold[k] = shapes.row(k).transpose().dot(&weights);
        }
    }
    foretold
}

/// `values` bounded to `MOST` standard deviations about their median, so that a few jumps do not outweigh all else.
fn clipped(values: Vec<f64>) -> Vec<f64> {
    let middle = median(&mut values.clone());
    let scatter = 1.4826 * median(&mut values.iter().map(|v| (v - middle).abs()).collect::<Vec<_>>());
    values.into_iter().map(|v| v.clamp(middle - MOST * scatter, middle + MOST * scatter)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::residual_torque::{residual_torque, testing};
    use super::*;

    fn dependence(torque: impl Fn(f64, f64) -> f64) -> Dependence {
        Dependence::of(&[residual_torque(&testing::made(torque), &testing::BASE)]).unwrap()
    }

    #[test]
    fn a_friction_that_is_missing_is_foretold_from_the_speed() {
        let found = dependence(|_, w| -0.3 * (w / 0.05).tanh());
        assert!(found.share > 0.5 && found.sure > 3.0, "{found:?}");
    }

    #[test]
    fn a_gravity_that_is_missing_is_foretold_from_the_angle() {
        let found = dependence(|x, _| 0.3 * x.sin());
        assert!(found.share > 0.5 && found.sure > 3.0, "{found:?}");
    }

    #[test]
    fn a_torque_that_depends_on_nothing_is_not_foretold() {
        let mut all = residual_torque(&testing::made(|_, _| 0.0), &testing::BASE);
        let mut seed = 7_u32;
        let mut held = 0.0;
        for torque in &mut all.torque_v {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            held = 0.98 * held + f64::from(seed >> 8) / f64::from(1 << 24) - 0.5;
            *torque = held;
        }
        let found = Dependence::of(&[all]).unwrap();
        assert!(found.sure < 2.0 && found.share < 0.1, "{found:?}");
    }
}
