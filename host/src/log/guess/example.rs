//! An example of a mapping, where nothing tells what the columns are.

use super::ranges::Range;
use super::{column, quoted, words};
use crate::log::sample::{Sample, numbers};
use crate::log::samples::FEWEST_SAMPLES;
use crate::log::units::Quantity;

/// A mapping of the first columns that hold numbers, for an example where nothing tells what they are.
pub(in crate::log) fn example(names: &[String], rows: &[Vec<f64>]) -> String {
    let part = |(quantity, unit): (Quantity, &str), index: usize| {
        let told = words::told(&names[index]).filter(|(of, _)| *of == quantity).map(|(_, unit)| unit);
        format!("{quantity}={}:{}", column(names, index), told.unwrap_or(unit))
    };
    let kinds = [(Quantity::Time, "s"), (Quantity::Voltage, "V"), (Quantity::Speed, "rad/s")];
    // The one that is called so, else the next; a column without a name is none, and what somebody wanted comes last.
    let has_numbers = |k: usize| rows.is_empty() || numbers(rows, k).next().is_some();
    let mut columns: Vec<usize> =
        (0..names.len()).filter(|k| !names[*k].is_empty() && has_numbers(*k)).collect();
    columns.sort_by_key(|k| words::said(&names[*k]).wanted);
    let is_called = |k: usize, kind: Quantity| {
        let said = words::said(&names[k]);
        !said.wanted && said.quantity.is_some_and(|(of, _)| of == kind)
    };
    let named: Vec<Option<usize>> =
        kinds.iter().map(|(kind, _)| columns.iter().copied().find(|k| is_called(*k, *kind))).collect();
    columns.retain(|k| !named.contains(&Some(*k)));
    // What is constant, or one of two values, is no time.
    let tells_time = |k: usize| {
        let range = Range::of(numbers(rows, k));
        rows.len() < FEWEST_SAMPLES || numbers(rows, k).any(|value| value > range.low && value < range.high)
    };
    let parts: Vec<String> = kinds
        .into_iter()
        .zip(named)
        .filter_map(|(kind, named)| {
            let fits = |k: &usize| kind.0 != Quantity::Time || tells_time(*k);
            let other = named.is_none().then(|| columns.iter().position(fits)).flatten();
            let index = named.or(other.map(|place| columns.remove(place)))?;
            Some(part(kind, index))
        })
        .collect();
    quoted(&parts.join(","))
}

/// What is said of a table that has a time and beside it only what somebody wanted and numbers of readings: no mapping of them is a log.
pub(in crate::log) fn unmeasured(sample: &Sample) -> Option<String> {
    let said: Vec<words::Said> = sample.names.iter().map(|name| words::said(name)).collect();
    let is_time = |k: &usize| matches!(said[*k].quantity, Some((Quantity::Time | Quantity::Interval, _)));
    let (times, others): (Vec<usize>, Vec<usize>) = (0..said.len()).partition(is_time);
    let is_none = |k: &usize| said[*k].wanted || words::counts_readings(&words::of(&sample.names[*k]));
    let wanted: Vec<String> =
        others.iter().filter(|k| said[**k].wanted).map(|k| format!("\"{}\"", sample.names[*k])).collect();
    (!times.is_empty() && !wanted.is_empty() && others.iter().all(is_none)).then(|| {
        format!(
            "{} was commanded, and no column was measured: log what drove the motor (its duty or voltage) and how it moved (an angle, counts or a \
             speed) in every row",
            wanted.join(" and ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A planner's own log was met with an example in which its commands are the speed, and the number of its samples the voltage.
    #[test]
    fn what_was_commanded_and_what_numbers_the_samples_is_no_example_of_a_log() {
        let row =
            |k: u32| vec![2451.0 + f64::from(k / 7), 17.0 + f64::from(k / 14), 102.0 + f64::from(k / 7)];
        let said = |header: &str| unmeasured(&Sample::of(header, (0..60).map(row).collect()));
        let told = said("t;pos_cmd;samples_consumed").unwrap();
        assert!(told.contains("\"pos_cmd\" was commanded") && !told.contains("--map"), "{told}");
        for other in ["t;pos_cmd;foo", "t;foo;bar", "foo;pos_cmd;samples_consumed"] {
            assert_eq!(said(other), None, "{other}");
        }
    }

    #[test]
    fn an_example_keeps_the_units_that_names_tell() {
        assert_eq!(
            example(&["czas_ms", "x", "y_rpm"].map(str::to_owned), &[]),
            "time=czas_ms:ms,voltage=x:V,speed=y_rpm:rpm"
        );
    }

    #[test]
    fn an_example_maps_numbers_and_no_constant_as_the_time() {
        let row = |k: usize| vec![f64::NAN, 5.0, [0.0, 1.0][k % 2], 0.1 * k as f64];
        let names = ["foo", "bar", "baz", "qux"].map(str::to_owned);
        let rows: Vec<Vec<f64>> = (0..40).map(row).collect();
        assert_eq!(example(&names, &rows), "time=qux:s,voltage=bar:V,speed=baz:rad/s");
    }
}
