//! Texts that stand on their side: a line for each signal, with or without its name before the numbers, as `numpy.savetxt` writes a list of
//! them.
//!
//! They have fewer lines than a log has rows, so that nothing which is read otherwise is taken for one.

use std::io::{BufRead, Read};

use super::Fault;
use super::table::{Column, Table, Values};
use crate::log::numbers::number;
use crate::log::preamble::{is_nothing, remark_in};
use crate::log::samples::FEWEST_SAMPLES;
use crate::log::text::TextReader;

/// What stands between the numbers of a line.
const SEPARATORS: [&[char]; 4] = [&[';'], &['\t'], &[','], &[' ']];

/// A line of such a text.
struct Signal {
    /// Its name; empty where none stands there.
    name: String,
    numbers: Vec<f64>,
}

impl Signal {
    /// What a line holds; none where it is no long list of numbers.
    fn of(line: &str) -> Option<Signal> {
        SEPARATORS.into_iter().find_map(|between| Self::parted(line.trim(), between))
    }

    fn parted(line: &str, between: &[char]) -> Option<Signal> {
        let blanks = between == [' '];
        let fields = line.trim_end_matches(between).split(between).map(str::trim);
        let mut fields = fields.filter(|field| !blanks || !field.is_empty()).peekable();
        let is_name = |field: &&str| number(field).is_none() && field.contains(char::is_alphabetic);
        let name = fields.next_if(is_name).unwrap_or_default().trim_matches(['"', ':', '=']).to_owned();
        let numbers = fields.map(number).collect::<Option<Vec<f64>>>()?;
        (numbers.len() >= FEWEST_SAMPLES).then_some(Signal { name, numbers })
    }
}

/// Whether a line is neither blank nor a remark.
fn is_told(line: &str) -> bool {
    !is_nothing(line) && remark_in(line).is_none()
}

/// Whether the first line of a text that begins so may be a signal.
pub fn may_be(start: &[u8]) -> bool {
    // Of UTF-16 the digits remain when its zeros go.
    let text = String::from_utf8_lossy(start).replace('\0', "");
    let Some(first) = text.split_inclusive('\n').find(|line| is_told(line.trim())) else { return false };
    // The last number is perhaps cut off.
    let whole = if first.ends_with('\n') {
        Some(first)
    } else {
        first.rsplit_once([';', '\t', ' ', ',']).map(|(whole, _)| whole)
    };
    whole.and_then(Signal::of).is_some()
}

/// The table of a text whose lines are signals; none where they are not.
///
/// # Errors
/// A fault where its signals have different numbers of values.
pub fn read(input: impl Read) -> Result<Option<Table>, Fault> {
    let Some(signals) = TextReader::new(input).ok().and_then(signals) else { return Ok(None) };
    let lengths = || signals.iter().map(|signal| signal.numbers.len());
    let (fewest, most) = (lengths().min().unwrap_or(0), lengths().max().unwrap_or(0));
    if fewest < most {
        return Err(Fault::new(
            format!("each line is a signal, and they have different numbers of values, {fewest} to {most}"),
            "write as many values of each, at the same instants; better a row for each instant and a column for each signal (np.column_stack)",
        ));
    }
    let column = |(k, signal): (usize, Signal)| {
        let name = if signal.name.is_empty() { format!("line{}", k + 1) } else { signal.name };
        Column { name, values: Values::Numbers(signal.numbers) }
    };
    let columns = signals.into_iter().enumerate().map(column).collect();
    Table::of(columns, Vec::new()).map(|table| Some(table.turned_round()))
}

/// The signals that the lines of a text are; none where one is none, or where there are as many lines as a log has rows.
fn signals(mut lines: impl BufRead) -> Option<Vec<Signal>> {
    let (mut signals, mut line) = (Vec::<Signal>::new(), String::new());
    while lines.read_line(&mut line).ok()? > 0 {
        if is_told(line.trim()) {
            signals.push(Signal::of(&line)?);
        }
        if signals.len() >= FEWEST_SAMPLES {
            return None;
        }
        line.clear();
    }
    // Numbers below names that are numbers too, `time,1,2,3`, are rows.
    let named = signals.iter().filter(|signal| !signal.name.is_empty()).count();
    (!signals.is_empty() && [0, signals.len()].contains(&named)).then_some(signals)
}

#[cfg(test)]
mod tests {
    use crate::log::read_tests::{assert_bad, file};
    use crate::log::{ReadOptions, Record, read};

    /// Time, voltage and speed of 200 rows, a line each.
    fn lines() -> [String; 3] {
        let levels = [0.0, 5.0, 3.0, 5.0, 0.0, 4.0, 2.0];
        let volts: Vec<f64> = (0..200).map(|k| levels[k / 25 % 7]).collect();
        let speed = volts.iter().scan(0.0_f64, |speed, volts| {
            let before = *speed;
            *speed += 0.15 * (10.0 * *volts - before);
            Some(before)
        });
        let line = |numbers: Vec<String>| numbers.join(",");
        [
            line((0..200).map(|k| format!("{:.2}", 0.01 * f64::from(k))).collect()),
            line(volts.iter().map(f64::to_string).collect()),
            line(speed.map(|speed| format!("{speed:.3}")).collect()),
        ]
    }

    fn taken(text: &str, map: Option<&str>) -> crate::error::Result<Record> {
        let (_directory, path) = file(text.as_bytes());
        let options = ReadOptions { map: map.map(|map| map.parse().unwrap()), ..ReadOptions::default() };
        read(&path, &options).map(|mut records| records.remove(0))
    }

    #[test]
    fn a_line_for_each_signal_is_turned_round_and_said() {
        let [time, volts, speed] = lines();
        let plain = format!("{time}\n{volts}\n{speed}\n");
        let map = "time=line1:s,voltage=line2:V,speed=line3:rad/s";
        let named = format!("# of May\ntime_s,{time}\nvoltage_v,{volts}\nspeed_rad_s,{speed}\n");
        for (text, map) in [
            (plain.clone(), Some(map)),
            (plain.clone(), Some("time=0:s,voltage=1:V,speed=2:rad/s")),
            (plain.replace(',', " "), Some(map)),
            (plain.replace(',', ", "), Some(map)),
            (plain.replace(',', ";").replace('.', ","), Some(map)),
            (plain.replace('\n', ",\n"), Some(map)),
            (named.clone(), None),
            (named.replace(',', "\t"), None),
        ] {
            let record = taken(&text, map).unwrap();
            assert_eq!((record.len(), record.voltage_v[30]), (200, 5.0), "{text}");
            assert!((record.time_s[199] - 1.99).abs() < 1e-9, "{text}");
            let said =
                |warning: &crate::log::Warning| warning.what.contains("each line of the file is a signal");
            assert!(record.warnings.iter().any(said), "{:?}", record.warnings);
        }
    }

    #[test]
    fn its_columns_are_guessed_by_their_numbers() {
        let [time, volts, speed] = lines();
        let error = taken(&format!("{time}\n{volts}\n{speed}\n"), None).unwrap_err();
        let remedy = "--map time=line1:s,voltage=line2:V,speed=line3:rad/s";
        assert_bad(&error, "column time_s", "the columns are line1, line2, line3", remedy);
        assert!(error.to_string().contains("each line of the file is a signal"), "{error}");
        assert!(!error.to_string().contains("line1-line2"), "{error}");
        let alone = taken(&speed, None).unwrap_err();
        assert_bad(&alone, "", "the columns are line1", "only \"line1\" holds numbers");
    }

    #[test]
    fn signals_of_different_lengths_are_refused_with_the_way_to_turn_them() {
        let [time, volts, _] = lines();
        let shorter = volts.rsplit_once(',').unwrap().0;
        let error = taken(&format!("{time}\n{shorter}\n"), None).unwrap_err();
        assert_bad(&error, "", "different numbers of values, 199 to 200", "a row for each instant");
    }

    #[test]
    fn a_wide_table_stands_upright() {
        let row = |k: u32| (0..40).map(|column| format!("{}.5", k * column)).collect::<Vec<_>>().join(",");
        let text: String = (0..30).map(|k| row(k) + "\n").collect();
        let map = "time=1:s,voltage=2:V,angle=3:rad";
        assert_eq!(taken(&text, Some(map)).unwrap().len(), 30);
        let names = (0..40).map(|k| format!("c{k}")).collect::<Vec<_>>().join(",");
        let error = taken(&format!("{names}\n{}\n{}\n", row(1), row(2)), Some(map)).unwrap_err();
        assert_bad(&error, "", "2 samples are too few", "at least 20");
        let channels = (1..40).map(|k| k.to_string()).collect::<Vec<_>>().join(",");
        let error = taken(&format!("time,{channels}\n{}\n{}\n", row(1), row(2)), Some(map)).unwrap_err();
        assert_bad(&error, "", "2 samples are too few", "at least 20");
    }
}
