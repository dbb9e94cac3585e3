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
/// Most motors of logs have no more volts than this, and none turns at as little of 8 bits.
const FEW_VOLTS: f64 = 24.0;

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

/// A code is so many times as large as any duty at least.
const BEYOND: f64 = 1.5;

/// The level that is a code of the program and no duty, as what it sends for a brake: it stands on one side alone, far beyond all others, which go
/// as far to either side.
pub(super) fn code(values: &[f64]) -> Option<f64> {
    let range = Range::of(values.iter().copied());
    let code = if range.high >= -range.low { range.high } else { range.low };
    let duties = Range::of(values.iter().copied().filter(|value| *value != code));
    let is_code = range.is_whole() && duties.high > 1.0 && code.abs() > BEYOND * duties.high;
    (is_code && duties.high == -duties.low).then_some(code)
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
    if let Some(code) = code(&numbers(rows, part.index).collect::<Vec<_>>()).filter(|_| peak > taken) {
        return Some(format!(
            "\"{name}\" is {} in some rows and goes to {taken} both ways in all others: that is a code of the program, as for a brake, and no duty; \
             write in its rows what the driver gave, 0 where it braked or let the motor run out",
            short(code)
        ));
    }
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
    // A command of so few steps may be volts: full duty of 8 bits would hardly have turned the motor.
    let volts = if taken == EIGHT_BITS && peak <= FEW_VOLTS {
        format!("; where it is volts, write voltage={own}:V")
    } else {
        String::new()
    };
    Some(format!(
        "nothing tells the full duty of \"{name}\": it goes to {peak_said} {why}; {taken} is a guess (duty={own}:{} would make every gain {} times \
         as {}{volts})",
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

    /// The program of an inverse pendulum sends 1000 for a brake: that was full duty, and a dead zone "explained" the motor.
    #[test]
    fn a_code_beyond_full_duty_both_ways_is_no_duty_and_is_told() {
        let proposed = |levels: [f64; 4]| {
            let names = ["t", "PWM", "rpm"].map(str::to_owned);
            let row = |k: u32| vec![0.01 * f64::from(k), levels[k as usize / 10 % 4], 3.0 * f64::from(k)];
            propose(&names, &(0..120).map(row).collect::<Vec<_>>()).unwrap()
        };
        for (levels, code) in [([0.0, 255.0, 1000.0, -255.0], "1000"), ([0.0, 100.0, -100.0, -999.0], "-999")]
        {
            let proposal = proposed(levels);
            let told = format!("\"PWM\" is {code} in some rows");
            let asked = proposal.unknown_units.iter().any(|text| text.contains(&told));
            assert!(asked, "{:?}", proposal.unknown_units);
            assert!(proposal.map.contains(&format!("duty=PWM:{}", levels[1])), "{}", proposal.map);
        }
        // A duty of one direction that was gentle at first, and one that was harder one way.
        for levels in [[0.0, 50.0, 200.0, 100.0], [-100.0, 100.0, 140.0, 0.0]] {
            assert_eq!(super::code(&levels), None, "{levels:?}");
        }
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
            ([0.0, 12.0, -6.0], "pwm", Some("where it is volts, write voltage=pwm:V)")),
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
