//! What the symbols of engineers may stand for where the values allow it: `n` is a speed in turns a minute in German and in IEC's letters, `x`
//! the way of a slide; a V with an index is a voltage or a velocity, and a W an angular speed.

use super::ranges::Range;
use super::words;
use crate::log::sample::numbers;

/// The fastest turns a minute, of either direction, that a geared motor's log reaches at least and at most.
const RPM: (f64, f64) = (5.0, 40_000.0);
/// How far a slide goes, m.
const WAY_M: (f64, f64) = (2e-3, 5.0);

/// What a column that is called by such a symbol alone may be: as a header would say it, and in which case.
pub(super) fn readings(name: &str, rows: &[Vec<f64>], column: usize) -> Vec<(&'static str, &'static str)> {
    let range = Range::of(numbers(rows, column));
    let is_within = |(least, most): (f64, f64), value: f64| value >= least && value <= most;
    let mut found = Vec::new();
    match words::of(name).as_slice() {
        [symbol] if symbol == "n" && is_within(RPM, range.peak()) => {
            found.push(("speed [rpm]", "where it is turns a minute"));
        }
        [symbol] if symbol == "x" => {
            let way = range.high - range.low;
            if is_within(WAY_M, way) {
                found.push(("position [m]", "where it is the way of a slide in metres"));
            }
            if is_within(WAY_M, 1e-3 * way) {
                found.push(("position [mm]", "where it is that in millimetres"));
            }
        }
        _ => {}
    }
    found
}

/// Whether a name is the letter of a voltage, a velocity or an angular speed, with an index or without: `Vr`, `w_m`. None is a time.
pub(super) fn is_no_time(name: &str) -> bool {
    letter(name).is_some()
}

/// Whether a name is the letter of an angular speed: it drives nothing.
pub(super) fn is_of_speed(name: &str) -> bool {
    letter(name).is_some_and(|letter| letter != 'v')
}

/// The letter of a voltage or a speed that a name is, with one letter of an index or with numbers behind it.
fn letter(name: &str) -> Option<char> {
    let (bare, _) = words::bracketed(name);
    let word = words::of(&bare).concat();
    let mut letters = word.chars();
    let first = letters.next().filter(|letter| ['v', 'w', 'ω'].contains(letter))?;
    (letters.count() <= 1).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_voltage_or_a_speed_by_its_letter_is_no_time_and_a_speed_drives_nothing() {
        for (name, no_time, speed) in [
            ("Vr", true, false),
            ("v_2", true, false),
            ("Wr [rad/s]", true, true),
            ("ω1", true, true),
            ("time_r", false, false),
            ("value", false, false),
            ("", false, false),
        ] {
            assert_eq!((is_no_time(name), is_of_speed(name)), (no_time, speed), "{name}");
        }
    }

    #[test]
    fn symbols_are_what_their_values_allow() {
        let of = |name: &str, peak: f64| {
            let rows: Vec<Vec<f64>> = (0..50).map(|k| vec![peak * f64::from(k) / 49.0]).collect();
            readings(name, &rows, 0).into_iter().map(|(as_if, _)| as_if).collect::<Vec<_>>()
        };
        assert_eq!(of("n", 480.0), ["speed [rpm]"]);
        assert_eq!(of("n", 1.0), [""; 0]);
        assert_eq!(of("x", 0.4), ["position [m]"]);
        assert_eq!(of("x", 4.0), ["position [m]", "position [mm]"]);
        assert_eq!(of("x", 300.0), ["position [mm]"]);
        assert_eq!(of("y", 300.0), [""; 0]);
    }
}
