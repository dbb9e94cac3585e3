//! Units that other people's logs come in, and their factors to SI.

use std::f64::consts::TAU;
use std::fmt;

use super::unsigned;

/// A duty of 8 bits that was printed without its sign; the number that is full duty follows: `int8/255`.
pub(in crate::log) const INT8: &str = "int8";

/// What a column measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Time of the sample, s.
    Time,
    /// Time since the sample before, s, where no column gives the time itself.
    Interval,
    /// Voltage at the driver's output, V.
    Voltage,
    /// Fraction of the supply that the driver puts out, -1 to 1.
    Duty,
    /// Sign of the voltage, the duty or the target, where it stands in a column of its own.
    Direction,
    /// Angle that a position servo was told to go to, rad.
    Target,
    /// Angle of the output shaft, rad.
    Angle,
    /// Speed of the output shaft, rad/s.
    Speed,
    /// Motor current, A.
    Current,
    /// Supply of the driver, V.
    Supply,
}

impl Quantity {
    /// All quantities, in the order in which a log lists them.
    pub const ALL: [Quantity; 10] = [
        Quantity::Time,
        Quantity::Interval,
        Quantity::Voltage,
        Quantity::Duty,
        Quantity::Direction,
        Quantity::Target,
        Quantity::Angle,
        Quantity::Speed,
        Quantity::Current,
        Quantity::Supply,
    ];

    /// The word for it in `--map`.
    pub fn key(self) -> &'static str {
        match self {
            Quantity::Time => "time",
            Quantity::Interval => "interval",
            Quantity::Voltage => "voltage",
            Quantity::Duty => "duty",
            Quantity::Direction => "direction",
            Quantity::Target => "target",
            Quantity::Angle => "angle",
            Quantity::Speed => "speed",
            Quantity::Current => "current",
            Quantity::Supply => "supply",
        }
    }

    /// The name of its column in a canonical log; interval, duty and direction have none.
    pub fn canonical(self) -> Option<&'static str> {
        match self {
            Quantity::Time => Some("time_s"),
            Quantity::Voltage => Some("voltage_v"),
            Quantity::Interval | Quantity::Duty | Quantity::Direction => None,
            Quantity::Target => Some("target_rad"),
            Quantity::Angle => Some("angle_rad"),
            Quantity::Speed => Some("speed_rad_s"),
            Quantity::Current => Some("current_a"),
            Quantity::Supply => Some("supply_v"),
        }
    }

    /// Its SI unit.
    pub fn si(self) -> &'static str {
        self.units()[0].0
    }

    /// Units it may come in, with the factor to SI; the first is the SI unit.
    fn units(self) -> &'static [(&'static str, f64)] {
        const VOLT: &[(&str, f64)] = &[("V", 1.0), ("mV", 1e-3)];
        const RPM: f64 = TAU / 60.0;
        const DEGREE: f64 = TAU / 360.0;
        match self {
            Quantity::Time | Quantity::Interval => &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)],
            Quantity::Voltage | Quantity::Supply => VOLT,
            Quantity::Duty => &[("fraction", 1.0), ("%", 1e-2), (INT8, 1.0)],
            Quantity::Direction => &[("sign", 1.0)],
            Quantity::Angle | Quantity::Target => {
                const ANGLE: &[(&str, f64)] = &[
                    ("rad", 1.0),
                    ("deg", DEGREE),
                    ("rev", TAU),
                    ("counts", TAU),
                    ("m", TAU),
                    ("cm", 1e-2 * TAU),
                    ("mm", 1e-3 * TAU),
                ];
                ANGLE
            }
            Quantity::Speed => {
                const SPEED: &[(&str, f64)] = &[
                    ("rad/s", 1.0),
                    ("deg/s", DEGREE),
                    ("rev/s", TAU),
                    ("counts/s", TAU),
                    ("rpm", RPM),
                    ("m/s", TAU),
                    ("cm/s", 1e-2 * TAU),
                    ("mm/s", 1e-3 * TAU),
                ];
                SPEED
            }
            Quantity::Current => &[("A", 1.0), ("mA", 1e-3)],
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.key())
    }
}

/// How to turn a number of a file into SI: take away the zero, multiply, and divide by the counts per turn if it counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// The number that means nothing: 1500 of the pulses of a servo or an ESC, 0 nearly everywhere else.
    pub zero: f64,
    /// Factor to SI; where the number is not one of turns, the factor after division by what one turn of the output shaft is of it.
    pub factor: f64,
    /// What the number has to be divided by.
    pub per_turn: Option<PerTurn>,
    /// The number was printed as a byte without a sign: 246 is -10.
    pub signed_byte: bool,
}

/// What one turn of the output shaft is, where a log does not measure turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PerTurn {
    /// So many encoder counts.
    Counts,
    /// So many metres of a linear axis: the lead of a screw, the circumference of a wheel.
    Metres,
}

impl PerTurn {
    /// Why a column in such a unit cannot be read where nobody told what one turn is, and what to do.
    pub fn unknown(self, quantity: Quantity, column: &str) -> (&'static str, String) {
        match self {
            PerTurn::Counts => (
                "encoder counts need the counts of one turn of the output shaft",
                format!(
                    "say --counts-per-rev 1400, put counts_per_rev into motor.toml, or write --map {quantity}={column}:rev/1400"
                ),
            ),
            PerTurn::Metres => (
                "the way of a linear axis needs the metres of one turn of the output shaft",
                "say --metres-per-rev 0.008 (the lead of the screw, or the circumference of the wheel), or put metres_per_rev into \
                 motor.toml"
                    .into(),
            ),
        }
    }
}

impl Unit {
    /// The number is in SI already.
    pub const SI: Unit = Unit { zero: 0.0, factor: 1.0, per_turn: None, signed_byte: false };

    /// Understands `deg/s`, `mV`, `rev/1400`, `V*-1`, `*0.031` (SI times 0.031) and, for duty, the number that is full duty (`255`), or
    /// those that are none and full (`1500..2000`), or the one of a duty whose negative numbers lost their sign (`int8/255`).
    ///
    /// # Errors
    /// Names the units that the quantity may come in.
    pub fn parse(quantity: Quantity, text: &str) -> Result<Unit, String> {
        let begin = text.find(['*', '/']).unwrap_or(text.len());
        let by_numbers = (quantity == Quantity::Duty).then(|| none_and_full(&text[..begin])).flatten();
        let known = quantity.units();
        let (name, zero, mut factor) = match by_numbers {
            Some((none, full)) => ("", none, 1.0 / (full - none)),
            None => known
                .iter()
                .filter(|(name, _)| {
                    text.strip_prefix(name)
                        .is_some_and(|rest| rest.is_empty() || rest.starts_with(['*', '/']))
                })
                .max_by_key(|(name, _)| name.len())
                .map(|&(name, factor)| (name, 0.0, factor))
                .or_else(|| text.starts_with(['*', '/']).then_some(("", 0.0, 1.0)))
                .ok_or_else(|| unknown(quantity, text))?,
        };
        let begin = if by_numbers.is_some() { begin } else { name.len() };
        let mut scales = &text[begin..];
        while let Some(operator) = scales.chars().next() {
            let tail = &scales[1..];
            let end = tail.find(['*', '/']).unwrap_or(tail.len());
            let number: f64 = tail[..end].trim().parse().map_err(|_| unknown(quantity, text))?;
            factor = if operator == '*' { factor * number } else { factor / number };
            scales = &tail[end..];
        }
        if !factor.is_finite() || factor == 0.0 {
            return Err(format!("the scale in \"{text}\" leaves nothing of the {quantity}"));
        }
        let per_turn = match name {
            "counts" | "counts/s" => Some(PerTurn::Counts),
            "m" | "cm" | "mm" | "m/s" | "cm/s" | "mm/s" => Some(PerTurn::Metres),
            _ => None,
        };
        Ok(Unit { zero, factor, per_turn, signed_byte: name == INT8 })
    }

    /// The number `value` of a file in SI, but for what it has to be divided by where it is none of turns.
    pub fn to_si(self, value: f64) -> f64 {
        let value = if self.signed_byte { unsigned::signed(value, unsigned::BYTE) } else { value };
        (value - self.zero) * self.factor
    }
}

/// The numbers that are no duty and full duty: `255` is `0..255`.
fn none_and_full(text: &str) -> Option<(f64, f64)> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let (none, full) = match text.split_once("..") {
        Some((none, full)) => (number(none)?, number(full)?),
        None => (0.0, number(text)?),
    };
    (full != none).then_some((none, full))
}

fn unknown(quantity: Quantity, text: &str) -> String {
    let names: Vec<&str> = quantity.units().iter().map(|&(name, _)| name).collect();
    let full_scale = if quantity == Quantity::Duty {
        ", or the number that means full duty, for example 255, or those that mean none and full, for example 1500..2000"
    } else {
        ""
    };
    format!(
        "\"{text}\" is no unit of {quantity}: use {}{full_scale}; a scale may follow, for example {}*0.5 or {}/-1",
        names.join(", "),
        names[0],
        names[0]
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_that_lost_its_sign_is_read_with_it() {
        let unit = Unit::parse(Quantity::Duty, "int8/255").unwrap();
        assert_eq!([246.0, 10.0, 0.0].map(|value| (255.0 * unit.to_si(value)).round()), [-10.0, 10.0, 0.0]);
        assert!(Unit::parse(Quantity::Angle, "int8/255").is_err());
    }

    fn factor(quantity: Quantity, text: &str) -> f64 {
        Unit::parse(quantity, text).unwrap().factor
    }

    #[test]
    fn every_unit_of_the_contract_has_its_factor() {
        let pi = std::f64::consts::PI;
        for (quantity, text, expected) in [
            (Quantity::Time, "s", 1.0),
            (Quantity::Time, "ms", 1e-3),
            (Quantity::Time, "us", 1e-6),
            (Quantity::Voltage, "mV", 1e-3),
            (Quantity::Angle, "deg", pi / 180.0),
            (Quantity::Angle, "rev", 2.0 * pi),
            (Quantity::Speed, "rad/s", 1.0),
            (Quantity::Speed, "deg/s", pi / 180.0),
            (Quantity::Speed, "rpm", pi / 30.0),
            (Quantity::Current, "mA", 1e-3),
        ] {
            let relative = factor(quantity, text) / expected;
            assert!((relative - 1.0).abs() < 1e-15, "{quantity} {text}");
        }
        assert!(Unit::parse(Quantity::Angle, "counts").unwrap().per_turn == Some(PerTurn::Counts));
        for (quantity, text) in [(Quantity::Angle, "mm"), (Quantity::Speed, "mm/s")] {
            let unit = Unit::parse(quantity, text).unwrap();
            assert_eq!(unit.per_turn, Some(PerTurn::Metres), "{text}");
            assert!((unit.factor - 1e-3 * std::f64::consts::TAU).abs() < 1e-15);
        }
    }

    #[test]
    fn scales_multiply_and_divide_after_any_unit() {
        assert!((factor(Quantity::Voltage, "V/255*7.9") - 7.9 / 255.0).abs() < 1e-15);
        assert_eq!(factor(Quantity::Voltage, "*0.031"), 0.031);
        assert_eq!(factor(Quantity::Speed, "rad/s*-1"), -1.0);
        assert_eq!(factor(Quantity::Speed, "rad/s/2"), 0.5);
        assert_eq!(factor(Quantity::Duty, "255"), 1.0 / 255.0);
    }

    #[test]
    fn a_wrong_unit_is_answered_with_the_right_ones() {
        let answer = Unit::parse(Quantity::Speed, "km/h").unwrap_err();
        assert!(answer.contains("km/h") && answer.contains("rpm"), "{answer}");
        for text in ["V*", "V*zero", "V*0", "V/0", "Vx", "radians"] {
            assert!(Unit::parse(Quantity::Voltage, text).is_err(), "{text}");
        }
    }
}
