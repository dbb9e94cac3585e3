//! A motor that does not answer to more than a certain voltage: the driver has a limit of which the log knows nothing.

use super::Record;
use super::motion::{peak, speed};
use super::suspicion::{Odd, Seen};
use super::timing::quantile;

/// Share of the highest voltage below which a clip would be told, and how much better it must fit.
const CLIP_SHARES: [f64; 8] = [0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2];
const CLIP_BETTER: f64 = 0.6;
/// Powers of the voltage that bend where a limit has an edge: a driver that floats loses more the higher the duty. A limit must fit so much better.
const BENT: [f64; 3] = [0.7, 0.5, 0.3];
const EDGED: f64 = 0.85;
/// Shares beside the best of those, and what of the voltage beyond a limit comes through where it is none: the motor still turns faster there.
const NEARER: [f64; 5] = [-0.04, -0.02, 0.0, 0.02, 0.04];
const COMES_THROUGH: f64 = 0.2;
/// Beyond a limit it turns no faster than this at it, where so many samples tell: voltages of down to this share of the limit.
const FASTER: f64 = 1.15;
const ENOUGH: usize = 20;
const AT_THE_LIMIT: f64 = 0.9;
/// Most speeds of a voltage stay below this share of them; the fastest are garbled at times.
const MOST: f64 = 0.9;
/// A limit that the voltage passes for more than this share of the time leaves one level, which friction explains as well.
const ALWAYS_CLIPPED: f64 = 0.8;

/// The motor does not answer to more than a certain voltage.
pub(super) fn clipped(Seen { record, weak }: &Seen) -> Option<Odd> {
    let weak = weak.as_ref()?;
    let plain = weak.regress(0.0, |v| v)?;
    let highest = peak(&record.voltage_v);
    let at = |share: f64| {
        Some((share * highest, weak.regress(0.0, |v| v.clamp(-share * highest, share * highest))?))
    };
    let above =
        |limit: f64| record.voltage_v.iter().filter(|v| v.abs() > limit).count() as f64 / record.len() as f64;
    let best_of = |shares: &[f64]| {
        let tried = shares.iter().filter(|share| above(**share * highest) < ALWAYS_CLIPPED);
        tried.filter_map(|s| at(*s)).min_by(|a, b| a.1.left.total_cmp(&b.1.left))
    };
    let (roughly, _) = best_of(&CLIP_SHARES)?;
    let (limit, best) = best_of(&NEARER.map(|more| roughly / highest + more))?;
    let bent = |power: f64| Some(weak.regress(0.0, |v: f64| v.signum() * v.abs().powf(power))?.left);
    let has_edge = || best.left < EDGED * BENT.into_iter().filter_map(bent).fold(f64::INFINITY, f64::min);
    let softened = |v: f64| {
        let below = v.clamp(-limit, limit);
        below + COMES_THROUGH * (v - below)
    };
    let is_flat = || weak.regress(0.0, softened).is_some_and(|soft| best.left < soft.left);
    let better = best.left < CLIP_BETTER * plain.left && plain.left > 0.05;
    (better && above(limit) > 0.03 && has_edge() && is_flat() && !is_faster_beyond(record, limit)).then(|| {
        (
            "clipped_voltage",
            "voltage_v",
            format!(
                "the motor answers as if no more than {limit:.2} V reached it, and the log goes up to {highest:.2} V"
            ),
            "log the voltage behind the driver's limit, or command less than the supply can give".into(),
        )
    })
}

/// Whether the motor turns clearly faster above a voltage than at it.
fn is_faster_beyond(record: &Record, limit: f64) -> bool {
    let speeds = speed(record);
    let fast = |volts: std::ops::Range<f64>| {
        let of_these = speeds.iter().zip(&record.voltage_v).filter(|(_, v)| volts.contains(&v.abs()));
        let mut sizes: Vec<f64> = of_these.map(|(w, _)| w.abs()).collect();
        (sizes.len() >= ENOUGH).then(|| quantile(&mut sizes, MOST))
    };
    let just_above = limit * (1.0 + 1e-9);
    let (at, beyond) = (fast(AT_THE_LIMIT * limit..just_above), fast(just_above..f64::INFINITY));
    at.zip(beyond).is_some_and(|(at, beyond)| beyond > FASTER * at)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor to which `law` of the voltage comes through.
    fn run(law: impl Fn(f64) -> f64) -> Record {
        let time_s: Vec<f64> = (0..2000).map(|k| 0.01 * f64::from(k)).collect();
        let levels = [2.0, 9.0, -5.0, 12.0, -12.0, 4.0, -8.0, 10.0, -3.0, 7.0];
        let voltage_v: Vec<f64> = (0..2000).map(|k| levels[k / 100 % 10]).collect();
        let mut speed = 0.0;
        let course = voltage_v.iter().map(|v| {
            let now = speed;
            speed += 0.1 * (1.5 * law(*v) - speed);
            now
        });
        let speed_rad_s = Some(course.collect());
        Record { time_s, voltage_v, speed_rad_s, ..Record::default() }
    }

    #[test]
    fn a_voltage_that_is_cut_off_is_clipped_and_one_that_bends_is_not() {
        let cut = clipped(&Seen::of(&run(|v| v.clamp(-4.8, 4.8)))).unwrap();
        assert!(cut.0 == "clipped_voltage" && cut.2.contains("no more than 4.80 V"), "{}", cut.2);
        // Speed over duty of a driver that floats.
        let bends = run(|v| v.signum() * 12.0 * (1.0 - 0.137 / (0.137 + v.abs() / 12.0)));
        assert_eq!(clipped(&Seen::of(&bends)), None);
        // It turns a little faster beyond: no limit, whatever else it is.
        let knee = |v: f64| v.signum() * if v.abs() < 4.8 { v.abs() } else { 4.8 + 0.25 * (v.abs() - 4.8) };
        assert_eq!(clipped(&Seen::of(&run(knee))), None);
        // Two levels alone, of which the motor has hardly reached the speed of the second.
        let mut short = run(|v| v.clamp(-4.8, 4.8));
        short.voltage_v.iter_mut().enumerate().for_each(|(k, v)| *v = if k < 1700 { 2.4 } else { 4.8 });
        let course =
            |k: usize| 60.0 + if k < 1700 { 0.0 } else { 18.0 * (1.0 - (-(k as f64 - 1700.0) / 60.0).exp()) };
        short.speed_rad_s = Some((0..2000).map(course).collect());
        assert!(is_faster_beyond(&short, 2.4) && !is_faster_beyond(&run(|v| v.clamp(-5.0, 5.0)), 5.0));
        // A limit between the shares that are tried is one.
        assert!(clipped(&Seen::of(&run(|v| v.clamp(-7.7, 7.7)))).is_some());
    }
}
