//! Why a number is taken for full duty where neither a name nor the values tell it surely, and what speaks for another one.
//!
//! A percentage and the 8 bits of `analogWrite` look alike while the motor is driven gently, and a gain found with the wrong one is off by
//! their ratio.

use super::by_numbers::VOLTS;
use super::columns::Part;
use super::preview::short;
use super::ranges::Range;
use super::{column, words};
use crate::log::sample::numbers;
use crate::log::units::Quantity;

const PERCENT: f64 = 100.0;
const EIGHT_BITS: f64 = 255.0;

/// The full duty that the bracket of a name tells: `PWM (0-255)`, `pwm [8 bits]`.
pub(super) fn told(name: &str) -> Option<u32> {
    let inside = words::bracketed(name).1?.to_lowercase();
    let number = |text: &str| text.trim().trim_start_matches('+').parse::<u32>().ok();
    if let Some((bits, _)) = inside.split_once("bit") {
        let bits = number(bits.trim().trim_end_matches('-')).filter(|bits| (1..=16).contains(bits))?;
        return Some((1 << bits) - 1);
    }
    let (first, last) = inside.rsplit_once("..").or_else(|| inside.rsplit_once(['-', ' ', '\u{2013}']))?;
    // Before it stands where the duty begins, zero or full duty back: a pulse of a servo begins at 1000, and the number of a pin behind nothing.
    let first = first.trim().trim_end_matches("to").trim().trim_end_matches(['.', '-', '\u{2013}']).trim();
    let begins = first.replace('\u{2212}', "-").parse::<f64>().is_ok_and(|begins| begins <= 0.0);
    number(last).filter(|full| begins && *full > 1)
}

/// What is asked of a duty whose highest is none that is full duty for sure, or none of what its name says that is.
pub(super) fn question(names: &[String], rows: &[Vec<f64>], part: &Part) -> Option<String> {
    let name = names.get(part.index)?;
    let range = Range::of(numbers(rows, part.index));
    let peak = range.peak();
    let taken: f64 = part.unit.parse().ok()?;
    if part.quantity != Quantity::Duty || part.rest.is_some() {
        return None;
    }
    let (peak_said, own) = (short(peak), column(names, part.index));
    if taken >= PERCENT && peak > 0.0 && peak <= 1.0 {
        return Some(format!(
            "\"{name}\" says that {taken} is full duty, and it never passes {peak_said}: where it is a share of one, write duty={own}:1, and every \
             gain is {taken} times smaller"
        ));
    }
    if !part.guessed || words::said(name).unit.is_some() || peak <= 1.0 || peak > PERCENT && peak >= taken {
        return None;
    }
    if !range.is_whole() {
        return (taken == PERCENT && peak <= VOLTS).then(|| {
            format!(
                "nothing tells the full duty of \"{name}\": it goes to {peak_said} in fractions, as percent may and as volts do; {taken} is a guess \
                 (where it is volts, write voltage={own}:V)"
            )
        });
    }
    let (why, other) = if peak == PERCENT {
        ("exactly and no further, as percent do, and as analogWrite(100) does of 255".to_owned(), EIGHT_BITS)
    } else if peak < PERCENT && taken == PERCENT {
        ("in steps of ten, as percent do, and as gentle levels of 255 may".to_owned(), EIGHT_BITS)
    } else if peak < PERCENT {
        (format!("in steps finer than ten, as {taken} allow, and as percent do"), PERCENT)
    } else if taken == EIGHT_BITS {
        (
            "and so is none of percent; 8 bits are usual, and a timer may count to 400, 1000 or 1023"
                .to_owned(),
            1023.0,
        )
    } else {
        (
            format!("and {taken} is the next usual number above"),
            if taken < 4095.0 { 4095.0 } else { 65_535.0 },
        )
    };
    let times = |a: f64, b: f64| short(a.max(b) / a.min(b));
    Some(format!(
        "nothing tells the full duty of \"{name}\": it goes to {peak_said} {why}; {taken} is a guess (duty={own}:{} would make every gain {} times \
         as {})",
        short(other),
        times(other, taken),
        if other > taken { "large" } else { "small" }
    ))
}

#[cfg(test)]
mod tests {
    use super::super::propose;

    /// What is asked of a column of that name that goes through `levels`.
    fn asked(name: &str, levels: [f64; 3]) -> Vec<String> {
        let names = ["t", name, "rpm"].map(str::to_owned);
        let rows: Vec<Vec<f64>> =
            (0..90).map(|k| vec![0.01 * k as f64, levels[k / 10 % 3], 3.0 * k as f64]).collect();
        propose(&names, &rows).unwrap().unknown_units
    }

    #[test]
    fn numbers_that_are_shares_of_one_under_a_name_of_percent_or_bits_are_asked_about() {
        let is_asked = |name: &str, levels| {
            asked(name, levels).iter().any(|text| text.contains(&format!("write duty={name}:1,")))
        };
        for name in ["PWM (%)", "PWM (0-255)"] {
            assert!(is_asked(name, [0.0, 0.05, 0.1]) && is_asked(name, [0.0, 1.0, -1.0]), "{name}");
            assert!(!is_asked(name, [0.0, 5.0, 10.0]), "{name}");
        }
        assert!(!is_asked("PWM", [0.0, 0.05, 0.1]));
    }

    #[test]
    fn a_full_duty_that_may_be_another_is_told_with_the_reason() {
        for (name, full) in [
            ("PWM (0-255)", Some(255)),
            ("pwm [8 bits]", Some(255)),
            ("inputSignal(8bits)", Some(255)),
            ("duty (0..1000)", Some(1000)),
            ("pwm (-255 to 255)", Some(255)),
            ("pwm [%]", None),
            ("pwm", None),
        ] {
            assert_eq!(super::told(name), full, "{name}");
        }
        for (levels, name, said) in [
            ([0.0, 200.0, 80.0], "pwm", Some("none of percent")),
            ([0.0, 100.0, 50.0], "pwm", Some("analogWrite(100)")),
            ([0.0, 80.0, 50.0], "pwm", Some("in steps of ten")),
            ([0.0, 96.0, 37.0], "pwm", Some("finer than ten")),
            ([0.0, 900.0, 37.0], "pwm", Some("1000 is the next")),
            ([0.0, 12.0, -7.25], "pwm", Some("voltage=pwm:V")),
            // Said by the name, or by the values: full duty itself, and a share of it.
            ([0.0, 80.0, 50.0], "pwm [%]", None),
            ([-255.0, 255.0, 0.0], "pwm", None),
            ([0.0, 1.0, 0.5], "pwm", None),
            ([0.0, 92.5, 40.25], "pwm", None),
        ] {
            let asked = asked(name, levels);
            let about = asked.iter().find(|text| text.contains("full duty of"));
            assert_eq!(about.is_some(), said.is_some(), "{name} {levels:?}: {asked:?}");
            assert!(said.is_none_or(|said| about.unwrap().contains(said)), "{said:?} {asked:?}");
        }
    }
}
