//! An encoder disc that sits off centre.

use core::f64::consts::TAU;

use super::spec::{EXPLICIT, Parameter, Port, Scale, Search, Spec, at_most, strength};
use super::{Effect, Memory, Setting};
use crate::scalar::Scalar;
use crate::step::State;

/// The reading errs by the distance of the track's centre from the shaft's over the track's radius, rad (Heidenhain, *Position Encoders for Servo
/// Drives*: 412 seconds of arc by micrometre over the diameter in millimetres). Half a millimetre on a radius of 5 mm is a tenth; half of the
/// radius is no mounting.
const LARGEST: f64 = 0.5;

/// A part of the reading error, in counts.
const fn part(name: &'static str, meaning: &'static str) -> Parameter {
    at_most(LARGEST, Scale::EncoderRadian, strength(name, "rad", meaning, Scale::Count, [-60.0, 1.5, 60.0]))
}

pub(super) const SPEC: Spec = Spec {
    name: "eccentricity",
    port: Port::Sensor,
    title: "the encoder disc sits off centre: reading error once per its revolution",
    equation: "reading = x + (d(a) - d(0)) / n,  d(a) = atan2(e sin(a + p), 1 - e cos(a + p)),  e = n sqrt(sine^2 + cosine^2), \
               tan(p) = cosine / sine;  a: angle of the encoder's shaft, n: its turns per output turn",
    source: "eccentric scale error of rotary encoders",
    signature: "residual angle repeats with every revolution of the encoder's shaft, at any speed, without inertia",
    parameters: &[
        part("sine", "sine part of the reading error"),
        part("cosine", "cosine part of the reading error"),
    ],
    probes: &[
        &[1.0, 0.0], &[0.0, 1.0], &[-1.0, 0.0], &[0.0, -1.0],
        &[5.0, 0.0], &[0.0, 5.0], &[-5.0, 0.0], &[0.0, -5.0],
    ],
    search: Search::Probes,
    laws: EXPLICIT,
    remembers: false,
    periodic: true,
    by_duty: false,
    contains: &[],
};

/// Most that a disc may be off centre, in radii of its track.
const MOST: f64 = 0.9;

/// A disc that turns about a point beside its centre.
#[derive(Debug, Clone, Copy)]
pub struct Eccentricity<S> {
    /// How far beside, in radii of its track.
    off: S,
    /// Where that shows at angle zero, in turns.
    lead: S,
    at_zero: S,
    /// Output angle of a radian of the encoder's shaft.
    per_turn: S,
    turns: S,
    on_motor: bool,
}

impl<S: Scalar> Eccentricity<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        let on_motor = setting.encoder_on_motor;
        let (turns, ratio) = if on_motor {
            (setting.motor_turns, setting.gear_ratio)
        } else {
            (setting.output_turns, S::one())
        };
        let (sine, cosine) = (parameters[0], parameters[1]);
        let disc = Self {
            off: (ratio * sine.map_with(cosine, libm::hypot)).min(S::lit(MOST)),
            lead: cosine.map_with(sine, |cosine, sine| libm::atan2(cosine, sine) / TAU),
            at_zero: S::zero(),
            per_turn: S::one() / ratio,
            turns,
            on_motor,
        };
        Self { at_zero: disc.error(S::zero()), ..disc }
    }

    /// What the disc shows too much at an angle in turns, rad of its shaft.
    #[inline(always)]
    fn error(&self, turn: S) -> S {
        let (one, at) = (S::one(), turn + self.lead);
        let (across, along) = (self.off * at.sin_turns(), one - self.off * at.cos_turns());
        let half = across / (along + along.hypot(across));
        // Twice the arc of the half angle's tangent, which stays below 0.63: a polynomial within 7e-7.
        let q = half * half;
        let mut p = S::lit(0.052_253_83);
        for c in [-0.124_695_852, 0.197_483_739, -0.333_205_903, 0.999_998_937] {
            p = p.mul_add(q, S::lit(c));
        }
        (half + half) * p
    }
}

impl<S: Scalar> Effect<S> for Eccentricity<S> {
    /// A filter behind the disc filters its error too, a held reading holds it.
    #[inline(always)]
    fn show(&self, state: &mut State<S>) {
        let shaft = if self.on_motor { &mut state.angle } else { &mut state.load_angle };
        *shaft += self.per_turn * self.error(*shaft * self.turns);
    }
    #[inline(always)]
    fn read(&self, state: &State<S>, _memory: &Memory<S>, reading: &mut S) {
        let turn = (if self.on_motor { state.angle } else { state.load_angle }) * self.turns;
        *reading += self.per_turn * (self.error(turn) - self.at_zero);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    /// The disc's marks are on a circle beside the axis: what passes the sensor is the angle about the circle's centre.
    #[test]
    fn reading_is_the_angle_about_the_discs_centre_and_motion_does_not_change() {
        for off in [0.05, 0.3, 0.9] {
            for phase in [0.0_f64, 1.2, -2.9] {
                let amplitude = off / RIG.gear_ratio;
                let parts = [amplitude * libm::cos(phase), amplitude * libm::sin(phase)];
                let (angles, motion) = run(Kind::Eccentricity, &parts, &[3.0; 700]);
                let error = |a: f64| libm::atan2(off * libm::sin(a), 1.0 - off * libm::cos(a));
                let x = motion.state.angle;
                let turned = error(x * RIG.gear_ratio + phase) - error(phase);
                close(angles[699], x + turned / RIG.gear_ratio, 2e-6 / RIG.gear_ratio);
            }
        }
    }

    /// To first order of how far it sits off centre, a wave of the stated two parts.
    #[test]
    fn a_little_off_centre_reads_wrong_by_a_sine() {
        let (angles, motion) = run(Kind::Eccentricity, &[1e-5, 2e-5], &[3.0; 700]);
        let a = motion.state.angle * RIG.gear_ratio;
        let wave = 1e-5 * libm::sin(a) + 2e-5 * (libm::cos(a) - 1.0);
        close(angles[699] - motion.state.angle, wave, 1e-7);
    }

    /// What a filter behind the disc shows trails what the disc shows by the filter's time, to first order.
    #[test]
    fn a_filter_behind_the_disc_filters_its_error_too() {
        use crate::simulator::Simulator;
        use crate::step::State;
        let (disc, lag) = ([0.3 / RIG.gear_ratio, 0.1 / RIG.gear_ratio], [0.004, 0.0]);
        let readings = |effects: &[(Kind, &[f64])]| {
            let simulator = Simulator::new(&BASE, effects.iter().copied(), &RIG);
            let mut motion = simulator.start(State::rest());
            let reading = |k: usize| {
                simulator.advance(&mut motion, &[3.0; 3000], k);
                simulator.read(&motion)
            };
            (0..3000).map(reading).collect::<std::vec::Vec<f64>>()
        };
        let shown = readings(&[(Kind::Eccentricity, &disc)]);
        let filtered = readings(&[(Kind::Eccentricity, &disc), (Kind::SensorLag, &lag)]);
        let keep = libm::exp(-0.25_f64);
        let ramp = 4.0 * (1.0 - keep);
        let mut trail = 0.0;
        for k in 1..3000 {
            trail = keep * trail + ramp * (shown[k] - shown[k - 1]);
            close(filtered[k], shown[k] - trail, 2e-5);
        }
    }
}
