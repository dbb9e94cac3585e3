//! The encoder: quantisation, eccentric disc, lag, lost edges.

use super::find;
use crate::effect::Effect;
use crate::motor::{EncoderShaft, Motor};
use crate::noise::between;
use crate::table::Kind;
use rand::{Rng, RngExt};
use std::f64::consts::TAU;

/// Immutable parameters of the encoder. Angles are those of the encoder's own shaft.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// The shaft that it sits on.
    pub shaft: EncoderShaft,
    per_count: f64,
    count_at_output: f64,
    off_centre: f64,
    off_centre_phase: f64,
    lost: f64,
    lost_from: f64,
    lag: Lag,
}

#[derive(Debug, Clone, PartialEq)]
enum Lag {
    None,
    Filter(f64),
    Held(f64),
}

/// What the counter has seen.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorState {
    start: f64,
    filtered: f64,
    keep: (f64, f64),
    age: f64,
    seen: i64,
    /// The counter's value.
    pub counts: i64,
}

impl Sensor {
    pub fn new(motor: &Motor, effects: &[Effect]) -> Self {
        let [counts, off_centre_phase, ..] = find(effects, Kind::Eccentricity).unwrap_or_default();
        let [lost, threshold, ..] = find(effects, Kind::LostCounts).unwrap_or_default();
        let lag = match find(effects, Kind::SensorLag) {
            Some([time, ..]) if time <= 0.0 => Lag::None,
            Some([time, held, ..]) if held >= 0.5 => Lag::Held(1e-3 * time),
            Some([time, ..]) => Lag::Filter(1e-3 * time),
            None => Lag::None,
        };
        let geared = match motor.encoder_shaft {
            EncoderShaft::Motor => motor.gear_ratio,
            EncoderShaft::Output => 1.0,
        };
        let per_count = motor.encoder_counts / TAU;
        Self {
            shaft: motor.encoder_shaft,
            per_count,
            count_at_output: motor.count_rad(),
            off_centre: (counts / per_count).min(0.9),
            off_centre_phase,
            lost: 0.01 * lost,
            lost_from: threshold * motor.no_load_speed() * geared,
            lag,
        }
    }

    /// A counter at zero; where in a count the shaft stands is random.
    pub fn rest(&self, rng: &mut impl Rng) -> SensorState {
        let start = between(rng, 0.0, 1.0);
        SensorState { start, filtered: 0.0, keep: (0.0, 1.0), age: 0.0, seen: 0, counts: 0 }
    }

    /// The reading of a shaft that stands at `angle`, without lag and counts.
    fn disc(&self, angle: f64) -> f64 {
        if self.off_centre == 0.0 {
            return angle;
        }
        let error = |a: f64| {
            let (sine, cosine) = (a + self.off_centre_phase).sin_cos();
            (self.off_centre * sine).atan2(1.0 - self.off_centre * cosine)
        };
        angle + error(angle) - error(0.0)
    }

    /// The counter sees the shaft at `angle` (rad) and `speed` (rad/s), `dt` seconds after the last look.
    #[inline]
    pub fn look(&self, state: &mut SensorState, angle: f64, speed: f64, dt: f64, rng: &mut impl Rng) {
        let read = self.disc(angle);
        let read = match self.lag {
            Lag::None => read,
            Lag::Filter(time) => {
                if state.keep.0 != dt {
                    state.keep = (dt, (-dt / time).exp());
                }
                state.filtered = read + (state.filtered - read) * state.keep.1;
                state.filtered
            }
            Lag::Held(time) => {
                state.age += dt;
                if state.age >= time - 1e-9 {
                    state.age -= time;
                    state.filtered = read;
                }
                state.filtered
            }
        };
        let seen = (read * self.per_count + state.start).floor() as i64;
        let mut edges = seen - state.seen;
        state.seen = seen;
        if self.lost > 0.0 && edges != 0 {
            // From nothing at the threshold to the full share 15 % above it.
            let above = ((speed.abs() / self.lost_from - 1.0) / 0.15).clamp(0.0, 1.0);
            let chance = self.lost * above;
            let missed =
                (0..edges.abs()).filter(|_| chance > 0.0 && rng.random::<f64>() < chance).count() as i64;
            edges -= missed * edges.signum();
        }
        state.counts += edges;
    }

    /// The reading as an angle of the output shaft, rad.
    pub fn angle(&self, state: &SensorState) -> f64 {
        state.counts as f64 * self.count_at_output
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;

    /// Turns the encoder's shaft at `speed` for `seconds` and returns (counts, start, angle).
    fn turn(text: &str, speed: f64, seconds: f64) -> (i64, f64, f64) {
        let sensor = Sensor::new(&Motor::small(), &[Effect::parse(text).unwrap()]);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut state = sensor.rest(&mut rng);
        let steps = (seconds / 25e-6) as i32;
        for k in 1..=steps {
            sensor.look(&mut state, speed * 25e-6 * f64::from(k), speed, 25e-6, &mut rng);
        }
        (state.counts, state.start, speed * 25e-6 * f64::from(steps))
    }

    #[test]
    fn counts_are_the_floor_of_the_angle() {
        for speed in [3.0, -77.0, 900.0] {
            let (counts, start, angle) = turn("coulomb", speed, 0.7);
            assert_eq!(counts, (angle * 48.0 / TAU + start).floor() as i64);
        }
    }

    #[test]
    fn an_eccentric_disc_errs_by_its_size_and_returns_each_turn() {
        let sensor = Sensor::new(&Motor::small(), &[Effect::parse("eccentricity=2,phase=0").unwrap()]);
        let worst = (0..1000).map(|k| TAU * f64::from(k) / 1000.0).map(|a| (sensor.disc(a) - a).abs());
        let worst = worst.fold(0.0, f64::max) * 48.0 / TAU;
        assert!((worst - 2.0).abs() < 0.1, "{worst}");
        assert!((sensor.disc(TAU + 0.4) - sensor.disc(0.4) - TAU).abs() < 1e-12);
    }

    #[test]
    fn a_filter_trails_by_its_time_constant_and_held_readings_by_up_to_their_age() {
        let trail = |text| {
            let (counts, start, angle) = turn(text, 500.0, 0.999_975);
            (angle * 48.0 / TAU + start - counts as f64) / 48.0 * TAU / 500.0
        };
        assert!((trail("sensor_lag=10") - 0.010).abs() < 0.0005);
        let held = trail("sensor_lag=10,held=1");
        assert!((0.0..0.0105).contains(&held) && held > 0.0090, "{held}");
    }

    #[test]
    fn edges_are_lost_above_the_threshold_only_and_in_both_directions() {
        let threshold = 0.3 * Motor::small().no_load_speed() * 30.0;
        let count = |speed: f64| {
            let (counts, _, angle) = turn("lost_counts=10,threshold=0.3", speed, 4.0);
            counts as f64 / (angle * 48.0 / TAU)
        };
        assert!((count(0.9 * threshold) - 1.0).abs() < 1e-3);
        for speed in [2.0 * threshold, -2.0 * threshold] {
            assert!((count(speed) - 0.9).abs() < 0.015, "{}", count(speed));
        }
    }
}
