//! What the symbols of engineers may stand for where the values allow it: `n` is a speed in turns a minute in German and in IEC's letters, `x`
//! the way of a slide.

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

#[cfg(test)]
mod tests {
    use super::*;

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
