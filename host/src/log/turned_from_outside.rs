//! A shaft that something outside turned: it begins to turn from rest while no voltage drives it.
//!
//! Nothing that a motor carries ends a rest by itself: what a weight or a spring pulls at then, friction holds. What swings stands for a
//! moment at each end of its way too; but the longer it stays there unseen, the slower it leaves. So the rest must be long, and the
//! motion fast beside what a sensor does not see of it.

use std::ops::Range;

use super::Record;
use super::labels::Labels;
use super::motion::{STANDS, angle, peak, slope, stretches};
use super::quantum::quantum;
use super::suspicion::Odd;
use super::times::{ranges_in_words, skip_of};
use super::timing::median_interval;

/// A voltage up to this share of the highest drives the shaft no faster than what counts as turning here.
const DRIVEN: f64 = 0.02;
/// The shaft turns above this share of its highest speed.
const TURNS: f64 = 0.05;
/// It rested for so many seconds and samples at least, ...
const REST_S: f64 = 0.5;
const REST_SAMPLES: f64 = 10.0;
/// ... turned for so many, ...
const TURNED_S: f64 = 0.1;
const TURNED_SAMPLES: usize = 5;
/// ... so many times as fast as it may have turned at rest, ...
const FASTER: f64 = 10.0;
/// ... and began so long before the next voltage that no late column explains it, s; that long where it is still turning then.
const BEFORE_S: f64 = 0.3;
const STILL_TURNING_S: f64 = 1.0;

/// The shaft begins to turn from rest though nothing drives it.
pub(super) fn turned_from_outside(record: &Record) -> Option<Odd> {
    // The voltage of a position loop is worked out, and does not tell when the loop was off.
    if record.is_of_position_loop() {
        return None;
    }
    let seen = Seen::of(record)?;
    let runs = undriven(&record.voltage_v);
    let found: Vec<Turned> = runs.iter().filter_map(|run| seen.turned(run)).collect();
    let first = found.first()?;
    let time = |k: usize| record.time_s[k];
    let ranges: Vec<(f64, f64)> = found.iter().map(|one| (time(one.from), time(one.to))).collect();
    Some((
        "turned_from_outside",
        if record.angle_rad.is_some() { "angle_rad" } else { "speed_rad_s" },
        format!(
            "the shaft begins to turn after {:.1} s of rest at 0 V and reaches {:.2} rad/s without a voltage, from {}: a hand or a load \
             turned it, or something drove it that the log does not tell{}",
            first.rest_s,
            first.speed,
            ranges_in_words(&ranges),
            Labels::of(record.labels.as_ref(), &ranges)
        ),
        format!(
            "no model of a motor turns without a drive: leave that out with {}; where the motor was driven then, map the column of that drive",
            skip_of(record, &ranges)
        ),
    ))
}

/// From where to where a shaft turned without a drive, after which rest, s, and its speed at the fastest.
struct Turned {
    from: usize,
    to: usize,
    rest_s: f64,
    speed: f64,
}

/// The quantisation step of what was measured; 0 where there is none.
enum Step {
    Angle(f64),
    Speed(f64),
}

/// A record as it moved.
struct Seen<'a> {
    time_s: &'a [f64],
    interval_s: f64,
    /// The slope of the angle, which no filter made late, or the mean speed of some samples.
    speed: Vec<f64>,
    fastest: f64,
    step: Step,
}

impl<'a> Seen<'a> {
    fn of(record: &'a Record) -> Option<Self> {
        let time_s = &record.time_s;
        let step = match (&record.angle_rad, &record.speed_rad_s) {
            (Some(angle), _) => Step::Angle(quantum(angle).unwrap_or(0.0)),
            (None, Some(speed)) => Step::Speed(quantum(speed).unwrap_or(0.0)),
            (None, None) => return None,
        };
        let speed = slope(time_s, &angle(record));
        let fastest = peak(&speed);
        (fastest > 0.0).then(|| Seen { time_s, interval_s: median_interval(time_s), speed, fastest, step })
    }

    fn rests(&self, k: usize) -> bool {
        self.speed[k].abs() <= STANDS * self.fastest
    }

    fn turns(&self, k: usize) -> bool {
        self.speed[k].abs() > TURNS * self.fastest
    }

    /// Where the shaft turned from outside within `run`, the samples between two drives: from the first time to the end of the last.
    fn turned(&self, run: &Range<usize>) -> Option<Turned> {
        let mut found: Option<Turned> = None;
        let mut begin = run.start;
        while let Some(turning) = (begin..run.end).find(|k| self.turns(*k)) {
            let end = (turning..run.end).find(|k| self.rests(*k)).unwrap_or(run.end);
            let mut resting = (begin..turning).filter(|k| self.rests(*k));
            let rest = resting.next().zip(resting.next_back());
            if let Some((since, from)) = rest
                && self.is_from_outside(since..from, turning..end, run.end)
            {
                let fastest = (turning..end).map(|k| self.speed[k]);
                let speed = fastest.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
                let rest_s = self.time_s[from] - self.time_s[since];
                let one = found.get_or_insert(Turned { from, to: from, rest_s, speed });
                one.to = end.min(run.end - 1);
            }
            begin = end;
        }
        found
    }

    /// Whether a motion after a rest is none that the shaft makes by itself, where the voltage is zero up to the sample `drive`.
    fn is_from_outside(&self, rest: Range<usize>, motion: Range<usize>, drive: usize) -> bool {
        let passed = |from: usize, to: usize| self.time_s[to] - self.time_s[from];
        let rest_s = passed(rest.start, rest.end);
        if rest_s < REST_S.max(REST_SAMPLES * self.interval_s) {
            return false;
        }
        let ends = motion.end < drive;
        let before_s = if ends { BEFORE_S } else { STILL_TURNING_S };
        let turning = motion.clone().filter(|k| self.turns(*k)).count();
        let is_long = turning >= TURNED_SAMPLES
            && passed(motion.start, motion.end.min(drive - 1)) >= TURNED_S
            && passed(motion.start, drive - 1) >= before_s;
        let at_rest = &self.speed[rest];
        let mean_square = at_rest.iter().map(|w| w * w).sum::<f64>() / at_rest.len() as f64;
        let unseen = mean_square.sqrt().max(self.unseen(rest_s));
        is_long && peak(&self.speed[motion]) >= FASTER * unseen
    }

    /// The speed that a shaft may have at the end of a rest of `rest_s` without being seen: that of a turning point from which it stays
    /// within one step of its angle for so long, to either side, or half a step of its speed.
    fn unseen(&self, rest_s: f64) -> f64 {
        match self.step {
            Step::Angle(step) => 4.0 * step / rest_s,
            Step::Speed(step) => 0.5 * step,
        }
    }
}

/// The ranges of samples in which no voltage drives the motor.
fn undriven(voltage_v: &[f64]) -> Vec<Range<usize>> {
    let highest = peak(voltage_v);
    stretches(voltage_v.len(), |k| voltage_v[k].abs() <= DRIVEN * highest)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A motor with a time constant and dry `friction` (V) that is driven for 8 s and then not, with a `load` (V) by angle and a torque
    /// from `outside` (V) by time; its angle, and its speed where it is read so.
    fn motor(
        [tau_s, friction]: [f64; 2],
        load: impl Fn(f64) -> f64,
        outside: impl Fn(f64) -> f64,
    ) -> (Record, Record) {
        let time_s: Vec<f64> = (0..1400).map(|k| f64::from(k) * 0.01).collect();
        let levels = [4.0, 8.0, -4.0, 0.0, 6.0];
        let command = |t: f64| if t < 8.0 { levels[t as usize % 5] } else { 0.0 };
        let voltage_v: Vec<f64> = time_s.iter().map(|t| command(*t)).collect();
        let (mut x, mut w) = (0.0, 0.0_f64);
        let (mut angles, mut speeds) = (Vec::new(), Vec::new());
        for (t, volts) in time_s.iter().zip(&voltage_v) {
            angles.push(x);
            speeds.push(w);
            for _ in 0..10 {
                let push = volts + outside(*t) - load(x);
                let held = if w == 0.0 { push.clamp(-friction, friction) } else { w.signum() * friction };
                let next = w + 0.001 / tau_s * (2.0 * (push - held) - w);
                w = if w * next < 0.0 { 0.0 } else { next };
                x += 0.001 * w;
            }
        }
        let record = Record { name: "run".into(), time_s, voltage_v, ..Record::default() };
        (Record { angle_rad: Some(angles), ..record.clone() }, Record { speed_rad_s: Some(speeds), ..record })
    }

    fn counted(record: &Record, counts: f64) -> Record {
        let step = TAU / counts;
        let angle = record.angle_rad.as_ref().unwrap();
        let angle_rad = Some(angle.iter().map(|x| (x / step).floor() * step).collect());
        Record { angle_rad, ..record.clone() }
    }

    fn by_hand(t: f64) -> f64 {
        match t {
            10.5..11.5 => 4.0,
            12.2..12.7 => -4.0,
            _ => 0.0,
        }
    }

    #[test]
    fn a_shaft_that_a_hand_turns_without_a_voltage_is_told_with_the_range_to_skip() {
        let (angle, speed) = motor([0.08, 0.5], |_| 0.0, by_hand);
        for record in [counted(&angle, 1320.0), counted(&angle, 100.0), angle, speed] {
            let (name, _, why, fix) = turned_from_outside(&record).unwrap();
            assert_eq!(name, "turned_from_outside");
            assert!(why.contains("s of rest at 0 V") && why.contains("from 10.4"), "{why}");
            assert!(fix.contains("--skip run:10.4") && fix.contains("..12.8"), "{fix}");
        }
    }

    #[test]
    fn it_is_told_at_the_end_of_a_record_too_and_not_where_a_position_loop_made_the_voltage() {
        let (mut record, _) = motor([0.08, 0.5], |_| 0.0, |t| if t > 12.5 { 2.0 } else { 0.0 });
        assert!(turned_from_outside(&record).is_some_and(|odd| odd.3.contains("..13.990")));
        record.meta.insert("kp", "32").unwrap();
        assert_eq!(turned_from_outside(&record), None);
    }

    #[test]
    fn what_a_motor_and_its_load_do_by_themselves_is_none() {
        let none = |_: f64| 0.0;
        for friction in [0.0, 0.02, 0.3] {
            for (what, (angle, speed)) in [
                ("free", motor([0.08, friction], none, none)),
                ("pendulum", motor([1.0, friction], |x| 3.0 * x.sin(), none)),
                ("slow pendulum", motor([8.0, friction], |x| 0.6 * x.sin(), none)),
                ("spring", motor([1.0, friction], |x| 0.6 * x, none)),
                ("weight", motor([0.08, friction], |_| 0.8, none)),
                ("stops", motor([0.08, friction], |x: f64| 200.0 * (x - x.clamp(-3.0, 3.0)), none)),
            ] {
                for record in [counted(&angle, 24.0), counted(&angle, 1320.0), angle, speed] {
                    assert_eq!(turned_from_outside(&record), None, "{what} with {friction} V of friction");
                }
            }
        }
    }

    #[test]
    fn a_voltage_that_is_logged_a_little_late_turns_nothing_from_outside() {
        let (mut record, _) = motor([0.08, 0.5], |_| 0.0, |_| 0.0);
        record.voltage_v.rotate_right(20);
        assert_eq!(turned_from_outside(&record), None);
    }
}
