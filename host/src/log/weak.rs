//! The motor's equation in a form that needs neither a simulation nor a derivative.
//!
//! `v = w / gain + (tau_m / gain) w' + friction sign(w) + load`, multiplied by a smooth bump and integrated by parts,
//! is linear in its coefficients. It is rough (no electrical lag, no other effect), but a shift of the columns, a
//! clipped voltage or a record in another unit shows in it at once.

use nalgebra::{SMatrix, SVector};

use super::Record;
use super::motion::{peak, speed};
use super::timing::median_interval;

/// Width of a bump, s, and in samples where these are slow.
const WIDTH_S: f64 = 0.1;
const WIDTH_SAMPLES: f64 = 20.0;
/// Windows looked at.
const MOST_WINDOWS: usize = 160;
const FEWEST_WINDOWS: usize = 20;
/// Latencies that are tried, s.
const LATE_S: [f64; 9] = [0.0, 0.005, 0.01, 0.015, 0.02, 0.03, 0.04, 0.07, 0.1];
/// What leaves less than this multiple of the voltage that the best leaves explains it as well: the equation is rough.
const HARDLY_MORE: f64 = 2.0;
/// Below this share of the highest speed the direction of friction is unclear.
const STILL: f64 = 0.03;

/// A record prepared for the regression.
pub struct Weak<'a> {
    windows: Vec<Window>,
    time_s: &'a [f64],
    voltage: &'a [f64],
    half_s: f64,
    interval_s: f64,
    /// How long before its row a voltage acts by the record's own word, s.
    lead_s: f64,
}

#[derive(Clone)]
struct Window {
    centre: f64,
    /// Speed, acceleration, direction and one under the bump.
    motion: [f64; 4],
    /// Sine and cosine of the angle there, where it is known.
    gravity: [f64; 2],
    area: f64,
}

/// What a regression found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regression {
    /// Output speed per volt, rad/s/V.
    pub gain: f64,
    /// Time constant, s; what delays the answer is part of it.
    pub tau_s: f64,
    /// Voltage of no motion, V: what a constant load takes.
    pub load_v: f64,
    /// Voltage that a pendulum takes where its angle's sine is one, and its cosine, V; none where it was not looked for.
    gravity_v: [f64; 2],
    /// Share of the voltage's variation that is left, 0 ..= 1.
    pub left: f64,
    /// Sum of the squares of what is left, V^2.
    left_v2: f64,
}

impl Regression {
    /// Voltage that load and pendulum take at an `angle`, rad.
    pub fn load_at(&self, angle: f64) -> f64 {
        let (sine, cosine) = angle.sin_cos();
        self.load_v + self.gravity_v[0] * sine + self.gravity_v[1] * cosine
    }
}

impl<'a> Weak<'a> {
    /// Prepares `record`; none where it is too short or does not move.
    pub fn new(record: &'a Record) -> Option<Self> {
        let interval_s = median_interval(&record.time_s);
        let half_s = 0.5 * WIDTH_S.max(WIDTH_SAMPLES * interval_s);
        let time_s = record.time_s.as_slice();
        let (first, last) = (*time_s.first()?, *time_s.last()?);
        let shape = Shape { half_s };
        let w = speed(record);
        let still = STILL * peak(&w);
        let span = last - first - 2.0 * half_s;
        let count = ((span / (0.5 * half_s)) as usize).min(MOST_WINDOWS);
        if count < FEWEST_WINDOWS || still == 0.0 {
            return None;
        }
        let windows = (0..count)
            .map(|k| {
                let centre = first + half_s + span * k as f64 / (count - 1) as f64;
                let mut motion = [0.0; 4];
                let mut gravity = [0.0; 2];
                let inside = around(time_s, centre, half_s);
                // Sums over samples are integrals but for rounding, which a large angle would multiply.
                let origin =
                    record.angle_rad.as_ref().and_then(|x| x.get(inside.start)).copied().unwrap_or(0.0);
                for i in inside {
                    let t = time_s[i] - centre;
                    let dt = step(time_s, i);
                    let (bump, slope, curve) = (shape.at(t), shape.slope(t), shape.curve(t));
                    match (&record.angle_rad, &record.speed_rad_s) {
                        (Some(x), _) => {
                            motion[0] -= (x[i] - origin) * slope * dt;
                            motion[1] += (x[i] - origin) * curve * dt;
                            gravity[0] += x[i].sin() * bump * dt;
                            gravity[1] += x[i].cos() * bump * dt;
                        }
                        (None, Some(w)) => {
                            motion[0] += w[i] * bump * dt;
                            motion[1] -= w[i] * slope * dt;
                        }
                        (None, None) => {}
                    }
                    if w[i].abs() > still {
                        motion[2] += w[i].signum() * bump * dt;
                    }
                    motion[3] += bump * dt;
                }
                Window { centre, motion, gravity, area: motion[3] }
            })
            .filter(|w| w.area > 0.3 * half_s)
            .collect::<Vec<_>>();
        if windows.len() < FEWEST_WINDOWS {
            return None;
        }
        let lead_s = record.meta.voltage_lead_s().unwrap_or(0.0);
        Some(Self { windows, time_s, voltage: &record.voltage_v, half_s, interval_s, lead_s })
    }

    /// The same motion under another voltage.
    pub fn under<'b>(&self, voltage: &'b [f64]) -> Weak<'b>
    where
        'a: 'b,
    {
        let windows = self.windows.clone();
        let Self { time_s, half_s, interval_s, lead_s, .. } = *self;
        Weak { windows, time_s, voltage, half_s, interval_s, lead_s }
    }

    /// Median time between samples, s.
    pub fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// Speed, acceleration, direction and one, each averaged under a bump, and the voltage there, `late_s` later than logged and
    /// changed by `law`.
    fn rows_of(&self, late_s: f64, law: impl Fn(f64) -> f64) -> Vec<([f64; 4], f64)> {
        let shape = Shape { half_s: self.half_s };
        let late_s = late_s - self.lead_s;
        let row = |window: &Window| {
            let mut v = 0.0;
            for i in around(self.time_s, window.centre - late_s, self.half_s + self.interval_s) {
                // Held until the next sample: its middle counts.
                let held = self.time_s.get(i + 1).map_or(self.interval_s, |next| next - self.time_s[i]);
                let t = self.time_s[i] + 0.5 * held + late_s - window.centre;
                v += law(self.voltage[i]) * shape.at(t) * held;
            }
            (window.motion.map(|m| m / window.area), v / window.area)
        };
        self.windows.iter().map(row).collect()
    }

    /// The output speed per volt, rad/s/V, that explains the voltage best beside friction, a constant load and a pendulum, of a latency
    /// up to a tenth of a second; none where that explains hardly anything. Negative where the motor turns against its voltage.
    pub fn gain_under_load(&self) -> Option<f64> {
        // A motor that turns against its voltage may seem to follow it at one latency of many.
        const FEW_S: [f64; 5] = [0.0, 0.02, 0.04, 0.07, 0.1];
        const HARDLY: f64 = 0.7;
        let fitted = FEW_S.into_iter().filter_map(|late_s| self.under_load(late_s));
        let best = fitted.min_by(|a, b| a.left.total_cmp(&b.left))?;
        (best.left < HARDLY).then_some(best.gain)
    }

    /// [`Self::regress`] with the torque of a pendulum beside friction and load.
    pub fn under_load(&self, late_s: f64) -> Option<Regression> {
        self.loaded(&self.rows_of(late_s, |v| v))
    }

    /// What the voltage, `late_s` seconds later than logged, tells without the torque of a pendulum and with it.
    pub fn without_and_under_load(&self, late_s: f64) -> [Option<Regression>; 2] {
        let rows = self.rows_of(late_s, |v| v);
        [solved(&rows), self.loaded(&rows)]
    }

    fn loaded(&self, rows: &[([f64; 4], f64)]) -> Option<Regression> {
        let full = rows.iter().zip(&self.windows).map(|((row, v), window)| {
            let gravity = window.gravity.map(|g| g / window.area);
            ([row[0], row[1], row[2], row[3], gravity[0], gravity[1]], *v)
        });
        solved(&full.collect::<Vec<_>>())
    }

    /// The gains, rad/s/V, that the record may have: with a pendulum or none, at each latency, of what leaves hardly more than the best.
    pub fn gains(&self) -> Vec<f64> {
        let all = LATE_S.into_iter().flat_map(|late| [self.regress(late, |v| v), self.under_load(late)]);
        let all: Vec<Regression> = all.flatten().collect();
        let best = all.iter().map(|x| x.left).fold(f64::MAX, f64::min);
        all.iter().filter(|x| x.left < HARDLY_MORE * best).map(|x| x.gain).collect()
    }

    /// [`Self::regress`] at the latency, up to a tenth of a second, that leaves least.
    pub fn under_any_latency(&self) -> Option<Regression> {
        let all = LATE_S.into_iter().filter_map(|late_s| self.regress(late_s, |v| v));
        all.min_by(|a, b| a.left.total_cmp(&b.left))
    }

    /// The time, s, at which the record falls into the two parts that explain their voltages best, each by itself, and what they are
    /// explained by. Each part has [`FEWEST_WINDOWS`] or more.
    pub fn best_parts(&self) -> Option<(f64, [Regression; 2])> {
        let rows = self.rows_of(0.0, |v| v);
        let last = rows.len().checked_sub(FEWEST_WINDOWS)?;
        let parted = (FEWEST_WINDOWS..=last).filter_map(|k| {
            let parts = [solved(&rows[..k])?, solved(&rows[k..])?];
            let left = parts[0].left_v2 + parts[1].left_v2;
            Some((left, self.windows[k].centre, parts))
        });
        let (_, at_s, parts) = parted.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((at_s, parts))
    }

    /// Regresses the voltage, `late_s` seconds later than logged and changed by `law`, on the motion.
    pub fn regress(&self, late_s: f64, law: impl Fn(f64) -> f64) -> Option<Regression> {
        solved(&self.rows_of(late_s, law))
    }
}

/// Least squares of the voltages of `rows` on what stands before them, of which the first is the speed.
fn solved<const N: usize>(rows: &[([f64; N], f64)]) -> Option<Regression> {
    let mut h = SMatrix::<f64, N, N>::zeros();
    let mut g = SVector::<f64, N>::zeros();
    let (mut vv, mut v1) = (0.0, 0.0);
    for (row, v) in rows {
        let row = SVector::<f64, N>::from(*row);
        h += row * row.transpose();
        g += row * *v;
        (vv, v1) = (vv + v * v, v1 + v);
    }
    for k in 0..N {
        h[(k, k)] *= 1.0 + 1e-9;
        h[(k, k)] += 1e-12;
    }
    let x = h.cholesky()?.solve(&g);
    let left: f64 = rows.iter().map(|(row, v)| (v - SVector::<f64, N>::from(*row).dot(&x)).powi(2)).sum();
    let variation = vv - v1 * v1 / rows.len() as f64;
    (variation > 0.0 && x[0] != 0.0).then(|| Regression {
        gain: 1.0 / x[0],
        tau_s: x[1] / x[0],
        load_v: x.get(3).copied().unwrap_or(0.0),
        gravity_v: [4, 5].map(|k| x.get(k).copied().unwrap_or(0.0)),
        left: (left / variation).sqrt(),
        left_v2: left,
    })
}

/// Time that sample `i` stands for, s.
fn step(time_s: &[f64], i: usize) -> f64 {
    let (from, to) = (i.saturating_sub(1), (i + 1).min(time_s.len() - 1));
    (time_s[to] - time_s[from]) / (to - from).max(1) as f64
}

/// Samples within `reach` of `centre`.
fn around(time_s: &[f64], centre: f64, reach: f64) -> std::ops::Range<usize> {
    time_s.partition_point(|t| *t < centre - reach)..time_s.partition_point(|t| *t <= centre + reach)
}

/// The bump (1 - s^2)^4 over `half_s` either way, with its derivatives in time.
struct Shape {
    half_s: f64,
}

impl Shape {
    fn inside(&self, t: f64) -> Option<f64> {
        let s = t / self.half_s;
        (s.abs() < 1.0).then_some(s)
    }
    fn at(&self, t: f64) -> f64 {
        self.inside(t).map_or(0.0, |s| (1.0 - s * s).powi(4))
    }
    fn slope(&self, t: f64) -> f64 {
        self.inside(t).map_or(0.0, |s| -8.0 * s * (1.0 - s * s).powi(3) / self.half_s)
    }
    fn curve(&self, t: f64) -> f64 {
        let at = |s: f64| (1.0 - s * s).powi(2) * (56.0 * s * s - 8.0) / (self.half_s * self.half_s);
        self.inside(t).map_or(0.0, at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::usable::tests::motor;

    #[test]
    fn the_gain_of_a_first_order_motor_is_found_and_little_is_left() {
        let record = motor();
        let weak = Weak::new(&record).unwrap();
        let found = weak.regress(0.0, |v| v).unwrap();
        assert!((found.gain - 0.6).abs() < 0.03, "{found:?}");
        let later = weak.regress(0.1, |v| v).unwrap();
        assert!(later.left > 2.0 * found.left, "{found:?} {later:?}");
    }
}
