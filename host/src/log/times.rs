//! Times of a record as a message has them: in words, and as the options that leave them out.

use super::Record;
use super::guess::quoted;

/// Times that are told in words; the rest is counted.
const NAMED: usize = 4;

/// These `times`, s, each from and until, as they stand behind "from".
pub(super) fn ranges_in_words(times: &[(f64, f64)]) -> String {
    let named = times.iter().take(NAMED).map(|(from, until)| format!("{from:.3} s to {until:.3} s"));
    let named = named.collect::<Vec<String>>().join(" and from ");
    match times.len().saturating_sub(NAMED) {
        0 => named,
        more => format!("{named} and {more} times more"),
    }
}

/// The options that leave all these `times` of `record` out.
pub(super) fn skip_of(record: &Record, times: &[(f64, f64)]) -> String {
    let range = |(from, until): &(f64, f64)| quoted(&format!("{}:{from:.3}..{until:.3}", record.name));
    times.iter().map(|time| format!("--skip {}", range(time))).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn some_times_are_told_and_all_are_left_out() {
        let times: Vec<(f64, f64)> = (0..6).map(|k| (f64::from(k), f64::from(k) + 0.5)).collect();
        assert_eq!(ranges_in_words(&times[..2]), "0.000 s to 0.500 s and from 1.000 s to 1.500 s");
        assert!(ranges_in_words(&times).ends_with("3.000 s to 3.500 s and 2 times more"));
        let record = Record { name: "my run".into(), ..Record::default() };
        let skip = skip_of(&record, &times);
        assert!(
            skip.matches("--skip").count() == 6 && skip.starts_with("--skip \"my run:0.000..0.500\""),
            "{skip}"
        );
    }
}
