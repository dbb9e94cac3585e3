//! The sides from which effects are seen: each sorts the moments of the records along one axis.

use std::f64::consts::TAU;

use super::effect_trace::{EffectTrace, Pair, SPAN_S};
use super::residual_views::{FEWEST_IN_BIN, reach, turn, within_turn};

/// A way of looking at an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum View {
    /// Residual torque by speed and direction.
    Speed,
    /// The same, slow motion only.
    SlowSpeed,
    /// Residual torque by the angle of the output shaft within a turn.
    OutputAngle,
    /// Residual torque by the way from the record's start.
    Travel,
    /// Residual torque by the angle of the motor within a few periods of its ripple.
    Ripple,
    /// Residual torque after reversals, along the new direction.
    Reversal,
    /// Residual torque by the voltage applied.
    Voltage,
    /// Residual torque along the motion by the voltage along the motion.
    VoltageAlong,
    /// Residual torque by the voltage that drives the current.
    Current,
    /// Residual torque along the motion by the voltage that drives the current along the motion.
    CurrentAlong,
    /// Share of the winding's voltage that is missing, by time.
    Time,
    /// Error of the speed after jumps of the voltage, along the jump.
    Jump,
    /// Error of the speed by acceleration.
    Acceleration,
    /// Error of the speed by speed.
    CountedSpeed,
    /// Error of the angle by the angle of the encoder's shaft.
    EncoderAngle,
}

/// What the views need to know of the rig and the effect.
#[derive(Debug, Clone, Copy)]
pub struct Shafts {
    /// Motor turns per turn of the output shaft.
    pub gear_ratio: f64,
    /// The encoder sits on the motor's shaft.
    pub encoder_on_motor: bool,
    /// Periods of the effect per turn of the motor, where it has any.
    pub order: f64,
}

/// A moment as a view sorts it: where it belongs, how much it counts, what is seen and said there.
struct Moment {
    at: f64,
    weight: f64,
    seen: f64,
    said: f64,
}

/// What is seen and said along the axis of a view.
#[derive(Debug, Clone, Default)]
pub struct Sorted {
    /// Places that have moments enough.
    pub at: Vec<f64>,
    /// Means there.
    pub pair: Pair,
    /// Share of the square of what is seen that what is said accounts for; below zero where it makes things worse.
    pub agreement: f64,
}

/// Slow is up to this share of the reach of the speed.
const SLOW: f64 = 0.2;
/// Ripple faster than this drowns in the smoothing of the derivatives, Hz.
const QUICKEST_RIPPLE_HZ: f64 = 12.0;
/// Most periods of a ripple side by side.
const PERIODS: f64 = 4.0;
/// Without this share of the highest voltage on the winding there is no current to speak of.
const CURRENT: f64 = 0.1;

impl View {
    /// Lowest and highest place of the axis, and the number of bins between.
    fn axis(self, all: &[EffectTrace], shafts: &Shafts) -> (f64, f64, usize) {
        let widest = |pick: fn(&EffectTrace) -> &Vec<f64>| reach(all.iter().flat_map(pick)) * (1.0 + 1e-9);
        let even = |most: f64, bins| (-most, most, bins);
        match self {
            Self::Speed | Self::CountedSpeed => even(widest(|t| &t.motion.speed_rad_s), 32),
            Self::SlowSpeed => even(SLOW * widest(|t| &t.motion.speed_rad_s), 40),
            Self::OutputAngle => {
                let (low, high) =
                    turn(all.iter().flat_map(|t| t.motion.angle_rad.iter().map(|x| x.to_degrees())));
                (low, high, 45)
            }
            Self::Travel => {
                let ways = || all.iter().flat_map(|t| t.motion.angle_rad.iter().map(|x| travel(t, *x)));
                let (low, high) = (ways().fold(f64::MAX, f64::min), ways().fold(f64::MIN, f64::max));
                if low < high { (low, high + 1e-9, 40) } else { (0.0, 1.0, 40) }
            }
            Self::Ripple => (0.0, 360.0 * periods(shafts.order) / shafts.order.max(1e-9), 48),
            Self::Reversal | Self::Jump => (-SPAN_S.0, SPAN_S.1, 60),
            Self::Voltage | Self::VoltageAlong => even(widest(|t| &t.motion.voltage_v), 40),
            Self::Current | Self::CurrentAlong => even(widest(|t| &t.winding_v), 40),
            Self::Time => (0.0, all.iter().map(length).fold(1e-6, f64::max), 24),
            Self::Acceleration => even(widest(|t| &t.motion.acceleration_rad_s2), 32),
            Self::EncoderAngle => (0.0, 360.0, 45),
        }
    }

    /// The moments of a record that belong here; `low` is the lowest place of the axis.
    fn moments(self, t: &EffectTrace, shafts: &Shafts, low: f64) -> Vec<Moment> {
        let motion = &t.motion;
        let (speed, volts) = (&motion.speed_rad_s, &motion.voltage_v);
        let plain = |at: f64, pair: &Pair, k: usize, sign: f64| Moment {
            at,
            weight: 1.0,
            seen: sign * pair.seen[k],
            said: sign * pair.said[k],
        };
        let by = |pair: &Pair, at: &dyn Fn(usize) -> f64| -> Vec<Moment> {
            (0..motion.time_s.len()).map(|k| plain(at(k), pair, k, 1.0)).collect()
        };
        let along = |at: &[f64]| -> Vec<Moment> {
            let moving = 0.02 * reach(speed.iter());
            (0..at.len())
                .filter(|k| speed[*k].abs() > moving)
                .map(|k| plain(at[k] * speed[k].signum(), &t.torque, k, speed[k].signum()))
                .collect()
        };
        let after = |events: &[(usize, f64, f64)], pair: &Pair| -> Vec<Moment> {
            events.iter().map(|(k, since, sign)| plain(*since, pair, *k, *sign)).collect()
        };
        let degrees = |x: f64, turns: f64| (x * turns / TAU).rem_euclid(1.0) * 360.0;
        match self {
            Self::Speed | Self::SlowSpeed => by(&t.torque, &|k| speed[k]),
            Self::OutputAngle => by(&t.torque, &|k| within_turn(motion.angle_rad[k].to_degrees(), low)),
            Self::Travel => by(&t.torque, &|k| travel(t, motion.angle_rad[k])),
            Self::Ripple => {
                let turns = shafts.gear_ratio * shafts.order / periods(shafts.order);
                let wide = periods(shafts.order) / shafts.order.max(1e-9);
                let quickest = QUICKEST_RIPPLE_HZ * TAU / (shafts.gear_ratio * shafts.order).max(1e-9);
                let all = by(&t.torque, &|k| wide * degrees(motion.angle_rad[k], turns));
                all.into_iter().zip(speed).filter(|(_, w)| w.abs() < quickest).map(|(m, _)| m).collect()
            }
            Self::Reversal => after(&t.reversals, &t.torque),
            Self::Voltage => by(&t.torque, &|k| volts[k]),
            Self::VoltageAlong => along(volts),
            Self::Current => by(&t.torque, &|k| t.winding_v[k]),
            Self::CurrentAlong => along(&t.winding_v),
            Self::Time => {
                let least = CURRENT * reach(volts.iter());
                let share = |k: usize| -100.0 / t.winding_v[k];
                (0..t.winding_v.len())
                    .filter(|k| t.winding_v[*k].abs() > least)
                    .map(|k| Moment {
                        weight: t.winding_v[k].powi(2),
                        ..plain(motion.time_s[k] - motion.time_s[0], &t.torque, k, share(k))
                    })
                    .collect()
            }
            Self::Jump => after(&t.jumps, &t.speed),
            Self::Acceleration => by(&t.speed, &|k| motion.acceleration_rad_s2[k]),
            Self::CountedSpeed => by(&t.speed, &|k| speed[k]),
            Self::EncoderAngle => {
                let turns = if shafts.encoder_on_motor { shafts.gear_ratio } else { 1.0 };
                by(&t.angle, &|k| degrees(motion.angle_rad[k], turns))
            }
        }
    }

    /// The records seen from this side.
    pub fn sorted(self, all: &[EffectTrace], shafts: &Shafts) -> Sorted {
        let (low, high, bins) = self.axis(all, shafts);
        let mut sums = vec![(0_usize, 0.0, 0.0, 0.0); bins];
        for m in all.iter().flat_map(|t| self.moments(t, shafts, low)).filter(|m| m.at >= low && m.at < high)
        {
            let bin = (((m.at - low) / (high - low) * bins as f64) as usize).min(bins - 1);
            let sum = &mut sums[bin];
            *sum = (sum.0 + 1, sum.1 + m.weight, sum.2 + m.weight * m.seen, sum.3 + m.weight * m.said);
        }
        let mut out = Sorted::default();
        let (mut power, mut left) = (0.0, 0.0);
        for (bin, (count, weight, seen, said)) in sums.into_iter().enumerate() {
            if count < FEWEST_IN_BIN {
                continue;
            }
            let (seen, said) = (seen / weight, said / weight);
            out.at.push(low + (bin as f64 + 0.5) * (high - low) / bins as f64);
            out.pair.seen.push(seen);
            out.pair.said.push(said);
            power += weight * seen * seen;
            left += weight * (seen - said).powi(2);
        }
        out.agreement = if power > 0.0 { 1.0 - left / power } else { 0.0 };
        out
    }
}

/// Output turns from the record's start.
fn travel(t: &EffectTrace, angle: f64) -> f64 {
    (angle - t.motion.angle_rad[0]) / TAU
}

/// Length of a record, s.
fn length(t: &EffectTrace) -> f64 {
    let times = &t.motion.time_s;
    times.first().zip(times.last()).map_or(0.0, |(first, last)| last - first + 1e-9)
}

/// Periods of a ripple of `order` that are drawn side by side: a turn of the motor, or a few.
fn periods(order: f64) -> f64 {
    order.round().clamp(1.0, PERIODS)
}

#[cfg(test)]
mod tests {
    use super::super::free_run::FreeRun;
    use super::super::residual_torque::testing::{BASE, made};
    use super::*;

    const SHAFTS: Shafts = Shafts { gear_ratio: 3.0, encoder_on_motor: true, order: 2.0 };

    /// A motor that feels `truth`, and an equation `says`.
    fn traces(truth: impl Fn(f64, f64) -> f64, says: impl Fn(f64, f64) -> f64) -> [EffectTrace; 1] {
        let without = made(truth);
        let with = FreeRun { simulated: made(says).measured, ..without.clone() };
        [EffectTrace::new(&with, &without, &BASE)]
    }

    #[test]
    fn a_right_law_lies_on_what_is_seen_and_a_wrong_one_does_not() {
        let friction = |_: f64, w: f64| -0.4 * (w / 0.02).tanh();
        let right = View::Speed.sorted(&traces(friction, friction), &SHAFTS);
        assert!(right.agreement > 0.999 && right.at.len() > 20, "{}", right.agreement);
        let wrong = View::Speed.sorted(&traces(friction, |_, w| -0.05 * w), &SHAFTS);
        assert!(wrong.agreement < 0.8, "{}", wrong.agreement);
    }

    #[test]
    fn ripple_is_laid_over_whole_periods_where_the_motor_is_slow() {
        let ripple = |x: f64, _: f64| 0.1 * (2.0 * 3.0 * x).sin();
        let seen = View::Ripple.sorted(&traces(ripple, ripple), &SHAFTS);
        assert!(seen.at.last().is_some_and(|at| (354.0..360.0).contains(at)), "{:?}", seen.at.last());
        let rises = seen.pair.said.windows(2).filter(|p| p[0] < 0.0 && p[1] >= 0.0).count();
        assert!((1..=2).contains(&rises), "two periods a turn: {:?}", seen.pair.said);
    }

    #[test]
    fn a_growing_resistance_is_a_growing_share_of_the_winding_voltage() {
        let mut all = traces(|_, _| 0.0, |_, _| 0.0);
        let t = &mut all[0];
        t.torque.seen = t.winding_v.iter().zip(&t.motion.time_s).map(|(u, t)| -0.01 * t * u).collect();
        let seen = View::Time.sorted(&all, &SHAFTS);
        for (at, share) in seen.at.iter().zip(&seen.pair.seen) {
            assert!((share - at).abs() < 0.4, "{share} % at {at} s");
        }
    }
}
