//! A duty that counts the time in which the drive is off: full duty is none, as of a low-active input.
//!
//! The motor is slow where such a duty is large. It is, too, where a controller makes up for a load: that one gives much because the motor is
//! slow. So a larger duty must also take speed from the motor, at one speed, and by the line through what was logged the motor must come to
//! rest at the full duty: a controller's line goes on to its gain times its set point.

use super::Record;
use super::motion::{correlation, low_pass, mean, speed};
use super::remap::remapped;
use super::suspicion::Odd;
use super::timing::median_interval;
use super::units::Quantity;
use super::voltages::{SMOOTHING_S, goes_both_ways};

/// Correlation of the smoothed voltage with the magnitude of the speed, at most.
const SLOWER: f64 = -0.5;
/// Stretches in which a motor gains speed, s: longer than a motor's time constant and a controller's answer to a noisy reading. The gain is the
/// mean of the last of so many parts less that of the first.
const STRETCH_S: f64 = 0.3;
const PARTS: usize = 6;
/// Partial correlation of the voltage with the gain at the same speed, at most.
const BRAKES: f64 = -0.5;
/// What rounding leaves of a correlation of 1.
const ROUNDING: f64 = 1e-12;
/// The voltage at which a low-active motor stands, as a share of the supply's, at most: the scatter of the readings may add this to 1.
const FULL: f64 = 1.1;

/// The motor is the slower the larger a duty that is never negative, and goes one way: the drive is low-active, and full duty is none.
pub(super) fn inverted(record: &Record) -> Option<Odd> {
    let full: f64 = record.source(Quantity::Duty)?.written.parse().ok()?;
    let supply_v = record.mean_supply_v()?;
    let (volts, motion) = (&record.voltage_v, speed(record));
    if volts.iter().any(|v| *v < 0.0) || goes_both_ways(&motion) {
        return None;
    }
    let magnitude: Vec<f64> = motion.iter().map(|w| w.abs()).collect();
    let smooth = low_pass(&record.time_s, volts, SMOOTHING_S);
    let is_inverted = correlation(&smooth, &magnitude) < SLOWER
        && is_braked_by(&record.time_s, volts, &magnitude)
        && standstill(volts, &magnitude) <= FULL * supply_v;
    is_inverted.then(|| {
        (
            "inverted_duty",
            "voltage_v",
            format!("the motor is the slower the larger its duty, and fastest where that is least: {full} is off and 0 is full duty, as of a low-active drive"),
            format!(
                "say what is no duty and what is full: {}",
                remapped(record, &[(Quantity::Duty, Quantity::Duty, &format!("{full}..0"))])
            ),
        )
    })
}

/// Whether the motor loses speed where `volts` are larger, at the same speed: by the partial correlation over stretches of time, since from row to
/// row a noisy reading is followed by a change back and, where a controller reads it, by a voltage against it.
fn is_braked_by(time_s: &[f64], volts: &[f64], speed: &[f64]) -> bool {
    let rows = ((STRETCH_S / median_interval(time_s)).round() as usize).max(PARTS);
    let part = rows / PARTS;
    let gain = |stretch: &[f64]| mean(&stretch[rows - part..]) - mean(&stretch[..part]);
    let gained: Vec<f64> = speed.chunks_exact(rows).map(gain).collect();
    let means = |values: &[f64]| values.chunks_exact(rows).map(mean).collect::<Vec<f64>>();
    let (volts, speed) = (means(volts), means(speed));
    let (by_speed, together) = (correlation(&speed, &gained), correlation(&volts, &speed));
    let unexplained = ((1.0 - by_speed * by_speed) * (1.0 - together * together)).max(ROUNDING).sqrt();
    correlation(&volts, &gained) - by_speed * together < BRAKES * unexplained
}

/// The voltage at which the line of the voltage over the speed, by least squares, comes to no speed, V.
fn standstill(volts: &[f64], speed: &[f64]) -> f64 {
    let (volt, middle) = (mean(volts), mean(speed));
    let (across, along) = volts.iter().zip(speed).fold((0.0, 0.0), |(across, along), (v, w)| {
        (across + (v - volt) * (w - middle), along + (w - middle) * (w - middle))
    });
    volt - middle * across / along
}

#[cfg(test)]
mod tests {
    use motorlens_shared::random::Stream;

    use super::*;
    use crate::log::usable::tests::motor;

    const ROWS: usize = 2000;
    /// Scatter of a reading of the speed, rad/s.
    const NOISES: [f64; 3] = [0.0, 0.3, 1.0];

    /// A motor of 2 rad/s per volt whose voltage a `drive` gives by row and reading of the speed, beside a `load` in volts.
    fn run(
        time_constant_s: f64,
        noise: f64,
        load: impl Fn(usize) -> f64,
        mut drive: impl FnMut(usize, f64) -> f64,
    ) -> Record {
        let mut random = Stream::new(0, 0, 0);
        let (mut w, mut volts, mut readings) = (0.0, Vec::new(), Vec::new());
        for k in 0..ROWS {
            let reading = w + noise * random.gaussian();
            let given = drive(k, reading);
            w += 0.01 / time_constant_s * (2.0 * (given - load(k)) - w);
            volts.push(given);
            readings.push(reading);
        }
        let mut record = motor();
        record.map = Some("time=t:s,duty=pwm:255,speed=w:rad/s".parse().unwrap());
        record.meta.insert("voltage", "it is the duty times 12 V, whatever the supply did").unwrap();
        record.voltage_v = volts;
        (record.angle_rad, record.speed_rad_s) = (None, Some(readings));
        record
    }

    fn steps(rows: usize) -> impl Fn(usize, f64) -> f64 {
        move |k, _| [4.0, 12.0, 0.0, 8.0][k / rows % 4]
    }

    /// A controller by speed, its gains in V s/rad and V/rad, that gives 0 V to 12 V.
    fn controller(gains: (f64, f64), wanted: impl Fn(usize) -> f64) -> impl FnMut(usize, f64) -> f64 {
        let mut sum: f64 = 0.0;
        move |k, reading| {
            let error = wanted(k) - reading;
            sum = (sum + 0.01 * gains.1 * error).clamp(0.0, 12.0);
            (gains.0 * error + sum).clamp(0.0, 12.0)
        }
    }

    #[test]
    fn a_drive_that_is_off_at_the_full_number_is_told_with_how_to_say_so() {
        for (noise, rows) in NOISES.into_iter().flat_map(|noise| [20, 60, 200].map(|rows| (noise, rows))) {
            let mut record = run(0.05, noise, |_| 0.0, steps(rows));
            assert_eq!(inverted(&record), None, "{noise} rad/s, {rows} rows");
            record.voltage_v.iter_mut().for_each(|v| *v = 12.0 - *v);
            let (name, _, _, fix) = inverted(&record).unwrap();
            assert!(name == "inverted_duty" && fix.contains("duty=pwm:255..0"), "{fix}");
        }
    }

    #[test]
    fn an_encoder_that_is_turned_round_is_another_fault() {
        let mut record = run(0.05, 0.0, |_| 0.0, steps(60));
        record.speed_rad_s.as_mut().unwrap().iter_mut().for_each(|w| *w = -*w);
        assert_eq!(inverted(&record), None);
    }

    #[test]
    fn a_controller_that_gives_much_while_the_motor_is_slow_is_no_low_active_drive() {
        let set_points: [fn(usize) -> f64; 3] =
            [|k| [20.0, 6.0][k / 12 % 2], |k| [15.0, 6.0, 10.0][k / 200 % 3], |_| 12.0];
        let loads: [fn(usize) -> f64; 2] = [|_| 0.0, |k| [0.0, 4.0][k / 130 % 2]];
        for gains in [(1.2, 0.0), (1.2, 5.0), (2.0, 2.0), (0.5, 10.0)] {
            for (which, wanted) in set_points.iter().enumerate() {
                for (time_constant_s, noise) in [0.05, 0.2].into_iter().flat_map(|t| NOISES.map(|n| (t, n))) {
                    for (loaded, load) in loads.iter().enumerate() {
                        let record = run(time_constant_s, noise, load, controller(gains, wanted));
                        let told = format!(
                            "{gains:?}, set point {which}, load {loaded}, {time_constant_s} s, {noise} rad/s"
                        );
                        assert_eq!(inverted(&record), None, "{told}");
                    }
                }
            }
        }
    }
}
