//! Columns whose numbers measure nothing: bytes that were taken for numbers of another type, or were no numbers at all.

use super::words;
use crate::log::motion::{different, ends, peak, span};
use crate::log::sample::{Sample, numbers};
use crate::log::timing::median;
use crate::log::units::Quantity;

/// Rows that tell.
const FEWEST: usize = 20;
/// Nobody measured numbers beyond this, in any unit; where they are more often than this share, they are no spikes.
const HUGE: f64 = 1e20;
const OFTEN: f64 = 0.05;
/// ... nor a column in which none is larger than this.
const TINY: f64 = 1e-30;
/// Whole numbers of 16 bits or more jump, half of the time, by this share of what they span, and so do their steps; at random it is 0.29 and
/// 0.25, as noise 0.15.
const WIDE: f64 = 32_768.0;
const JUMP: f64 = 0.2;
const FEWEST_JUMPS: usize = 50;
/// The bytes of a floating-point number of such a size, as a whole number, are at least so large, and differ so much.
const USUAL: [f64; 2] = [1e-6, 1e7];
const BITS: [f64; 2] = [268_435_456.0, 4_294_967_296.0];
const BITS_SPAN: f64 = 16_777_216.0;
const NEARLY_ALL: f64 = 0.95;
/// Steps of a clock or a counter are as even as this.
const EVEN: f64 = 0.1;
/// Columns that a message names.
const NAMED: usize = 3;

/// What is wrong with the numbers of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    /// They are larger than any measurement, up to this size.
    Huge(f64),
    /// They are smaller than any, up to this size.
    Tiny(f64),
    /// They are the bytes of floating-point numbers: one of them, and what it stands for.
    Bits(f64, f64),
    /// They jump from row to row, usually by this share of what they span.
    Jumps(f64),
}

impl Fault {
    fn of(values: &[f64]) -> Option<Fault> {
        if values.len() < FEWEST {
            return None;
        }
        let huge = || values.iter().map(|value| value.abs()).filter(|size| *size > HUGE);
        // One number again and again stands for no limit, or for nothing.
        if huge().count() as f64 > OFTEN * values.len() as f64 && different(huge()).len() > 2 {
            return Some(Fault::Huge(peak(values)));
        }
        let told = values.iter().filter(|value| **value != 0.0).count();
        if told >= FEWEST && peak(values) < TINY {
            return Some(Fault::Tiny(peak(values)));
        }
        Fault::of_bits(values)
    }

    /// Bytes of floating-point numbers.
    fn of_bits(values: &[f64]) -> Option<Fault> {
        let meant = |value: f64| f64::from(f32::from_bits(value as i64 as u32));
        let bits: Vec<f64> = values.iter().copied().filter(|value| *value != 0.0).collect();
        let is_one = |value: &f64| value.fract() == 0.0 && (BITS[0]..BITS[1]).contains(&value.abs());
        let is_usual = |value: &&f64| (USUAL[0]..USUAL[1]).contains(&meant(**value).abs());
        let usual = bits.iter().filter(is_usual).count();
        let are_bits = bits.len() >= FEWEST
            && bits.iter().all(is_one)
            && span(&bits) > BITS_SPAN
            && usual as f64 >= NEARLY_ALL * bits.len() as f64
            && !are_even(&bits);
        are_bits.then(|| Fault::Bits(bits[bits.len() / 2], meant(bits[bits.len() / 2])))
    }

    /// Jumps that no motion makes.
    fn of_jumps(values: &[f64]) -> Option<Fault> {
        let (low, high) = ends(values);
        let all = high.max(0.0) - low.min(0.0);
        let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        // An angle that begins anew at a turn jumps too, but its steps are as long as those before them, but for whole turns.
        let change = |pair: &[f64]| {
            let change = (pair[1] - pair[0]).rem_euclid(all);
            change.min(all - change)
        };
        let is_wide = values.len() >= FEWEST_JUMPS
            && values.iter().all(|value| value.fract() == 0.0)
            && all >= WIDE
            && 2 * different(values.iter().copied()).len() >= values.len();
        let is_random = is_wide && usual(steps.windows(2).map(change)) >= JUMP * all;
        let share = if is_random { usual(steps.iter().map(|step| step.abs())) / all } else { 0.0 };
        (share >= JUMP).then_some(Fault::Jumps(share))
    }

    /// What is to be seen in the column `name`.
    fn told(self, name: &str) -> String {
        match self {
            Fault::Huge(size) => format!("\"{name}\" goes to {size:.1e}"),
            Fault::Tiny(size) => format!("no number of \"{name}\" is larger than {size:.1e}"),
            Fault::Bits(number, meant) => {
                format!("\"{name}\" holds {number}, whose bytes are the floating-point number {meant:.4}")
            }
            Fault::Jumps(share) => {
                format!(
                    "\"{name}\" jumps from row to row, usually by {:.0} % of all that it spans",
                    100.0 * share
                )
            }
        }
    }
}

/// The middle one of some sizes.
fn usual(sizes: impl Iterator<Item = f64>) -> f64 {
    median(&mut sizes.collect::<Vec<_>>())
}

/// Whether nearly all steps are the same.
fn are_even(values: &[f64]) -> bool {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = median(&mut steps.clone());
    let even = steps.iter().filter(|step| (*step - usual).abs() <= EVEN * usual.abs()).count();
    even as f64 >= NEARLY_ALL * steps.len() as f64
}

/// The columns that are no measurements.
fn faults(sample: &Sample) -> Vec<(usize, Fault)> {
    let width = sample.rows.iter().map(Vec::len).max().unwrap_or(0);
    let fault = |k: usize| {
        let values: Vec<f64> = numbers(&sample.rows, k).collect();
        let of = sample.with_units.get(k).and_then(|name| words::said(name).quantity).map(|(of, _)| of);
        // A drive may be another in every row, and a counter of microseconds may stand anywhere.
        let found = Fault::of(&values)
            .filter(|fault| of != Some(Quantity::Time) || matches!(fault, Fault::Huge(_) | Fault::Tiny(_)));
        let moves = matches!(of, Some(Quantity::Angle | Quantity::Speed));
        found.or_else(|| Fault::of_jumps(&values).filter(|_| moves)).map(|fault| (k, fault))
    };
    (0..width).filter_map(fault).collect()
}

/// What is said of columns that are no measurements, and the table without them; none where all may be measurements.
pub(in crate::log) fn left_out(sample: &Sample) -> Option<(String, Sample)> {
    let faults = faults(sample);
    if faults.is_empty() {
        return None;
    }
    let mut rest = sample.clone();
    for (k, _) in &faults {
        rest.rows.iter_mut().filter_map(|row| row.get_mut(*k)).for_each(|value| *value = f64::NAN);
        for names in [&mut rest.names, &mut rest.with_units] {
            if let Some(name) = names.get_mut(*k) {
                name.clear();
            }
        }
    }
    Some((said(sample, &faults), rest))
}

/// What is asked of a table that leaves too little without the columns that are no measurements.
pub(in crate::log) fn garbled_question(sample: &Sample) -> Option<String> {
    left_out(sample).map(|(said, _)| said)
}

fn said(sample: &Sample, faults: &[(usize, Fault)]) -> String {
    let name = |k: usize| sample.names.get(k).cloned().unwrap_or_else(|| k.to_string());
    let told = faults.iter().take(NAMED).map(|(k, fault)| fault.told(&name(*k)));
    let mut all = told.collect::<Vec<_>>().join(", ");
    if faults.len() > NAMED {
        all += &format!(", and {} more columns are like them", faults.len() - NAMED);
    }
    format!(
        "{all}: those are no measurements but bytes of something else, as of a printf whose format is not that of its argument (%d of a float, %f of \
         a whole number), of a structure that is unpacked otherwise than it was packed, or of a wrong baud rate; print and unpack each \
         number as what it is, look whether single lines read right, and log again"
    )
}

#[cfg(test)]
mod tests {
    use super::super::propose_for;
    use super::*;

    /// Numbers without any order, 0 to 2^32.
    fn random(k: u32) -> u32 {
        let mixed = (k.wrapping_mul(0x9E37_79B9) ^ 0x5bd1_e995).wrapping_mul(0x85EB_CA6B);
        (mixed ^ (mixed >> 13)).wrapping_mul(0xC2B2_AE35)
    }

    fn sample(header: &str, value: impl Fn(u32) -> f64) -> Sample {
        let row = |k: u32| vec![10.0 * f64::from(k), (4.0 * (0.1 * f64::from(k)).sin()).round(), value(k)];
        Sample::of(header, (0..400).map(row).collect())
    }

    #[test]
    fn bytes_of_other_types_are_named_and_never_proposed_as_a_motion() {
        let float = |k: u32| {
            let value = f64::from(f32::from_bits(random(k)));
            if value.is_finite() { value } else { 1e30 }
        };
        let angle = |k: u32| 2.0 - 2.0 * (0.03 * f64::from(k)).cos();
        for (header, value, words) in [
            ("t_ms;volts;rpm", &float as &dyn Fn(u32) -> f64, "\"rpm\" goes to"),
            (
                "t_ms;volts;position",
                &|k: u32| f64::from(random(k) as i32),
                "\"position\" jumps from row to row",
            ),
            ("t_ms;volts;position", &|k: u32| f64::from((angle(k) as f32).to_bits()), "whose bytes are"),
            (
                "t_ms;volts;position",
                &|k: u32| f64::from(f32::from_bits((1e3 * angle(k)) as u32)),
                "no number of",
            ),
        ] {
            let sample = sample(header, value);
            assert_eq!(propose_for(&sample), None, "{words}");
            let asked = garbled_question(&sample).unwrap();
            assert!(asked.contains(words) && asked.contains("wrong baud rate"), "{asked}");
        }
        // Without a name too.
        let mut bare = sample("t_ms;volts;rpm", float);
        (bare.names, bare.with_units) = (Vec::new(), Vec::new());
        assert!(
            garbled_question(&bare).unwrap().starts_with("\"2\" goes to") && propose_for(&bare).is_none()
        );
    }

    #[test]
    fn what_is_left_beside_a_garbled_column_is_proposed_and_it_is_said() {
        let row = |k: u32| {
            let t = 0.01 * f64::from(k);
            vec![t, 4.0 * (3.0 * t).sin(), f64::from(random(k) as i32), 2.0 - 2.0 * (3.0 * t).cos()]
        };
        let sample = Sample::of("t;voltage;rpm;theta", (0..400).map(row).collect());
        let proposal = propose_for(&sample).unwrap();
        assert_eq!(proposal.map, "time=t:s,voltage=voltage:V,angle=theta:rad");
        assert!(proposal.assumptions().contains("\"rpm\" jumps"), "{}", proposal.assumptions());
    }

    #[test]
    fn what_a_motor_may_do_is_no_such_column() {
        let noise = |k: u32| f64::from(random(k)) / 2f64.powi(32) - 0.5;
        let spike = |k: u32| if k % 50 == 7 { 1e30 } else { f64::from(k) };
        for (header, value) in [
            ("t_ms;volts;rpm", &noise as &dyn Fn(u32) -> f64),
            ("t_ms;volts;rpm", &|k: u32| 4000.0 + 100.0 * noise(k)),
            ("t_ms;volts;position", &|k: u32| f64::from((100 * k) % 4096)),
            ("t_ms;volts;position", &|k: u32| f64::from((17_000 * k + 10 * k * k) % 65_536)),
            ("t_ms;volts;position", &|k: u32| 1e9 + 1e3 * f64::from(k)),
            ("t_ms;volts;position", &spike),
            ("t_ms;volts;limit", &|_: u32| f64::from(f32::MAX)),
            ("t_ms;volts;micros", &|k: u32| 1_065_353_216.0 + 100_000.0 * f64::from(k)),
            ("t_ms;volts;position", &|k: u32| 1e-40 * f64::from(k % 2) + f64::from(k)),
            ("t_ms;volts;pwm", &|k: u32| f64::from(random(k) >> 16)),
        ] {
            assert_eq!(garbled_question(&sample(header, value)), None, "{header}: {}", value(9));
        }
    }
}
