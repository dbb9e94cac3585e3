//! The guess as a dialogue shows it: what is in the file, and for every column what it would be read as.

use std::io::BufRead;
use std::path::Path;

use serde::Serialize;

use super::super::formats::{self, Shown};
use super::super::mapping::Mapping;
use super::super::preamble;
use super::super::read::Json;
use super::super::sample;
use super::super::text;
use super::super::units::Quantity;
use super::{Proposal, garbled_question, left_out, parts_of, propose_for};
use crate::error::Result;

/// Rows that are shown.
const SHOWN: usize = 1000;

/// The beginning of a table, and what its columns look like.
#[derive(Debug, Default, Serialize)]
pub struct Look {
    /// Names of the columns; their numbers where the file has no header.
    pub names: Vec<String>,
    /// The first rows as they stand in the file.
    pub rows: Vec<Vec<String>>,
    /// For every column `QUANTITY:UNIT` as `--map` writes it, `time+:UNIT` for the fraction of a second beside whole ones, `duty-:` for what
    /// is taken off a duty; empty where the column is not used.
    pub kinds: Vec<String>,
    /// The columns have their canonical names and need no mapping.
    pub canonical: bool,
    /// What the command line would propose; none where the columns are canonical or too little is recognised.
    pub proposal: Option<Proposal>,
    /// What the command line would ask of the columns: what is open in its proposal, or why there is none.
    pub asked: Vec<String>,
    /// What a file that needs no mapping tells of its content, in a sentence; it has no columns to choose from.
    pub told: Option<String>,
    /// The motors of such a file of which one has to be chosen, by `voltage=voltage-MOTOR`; empty where there is no choice.
    pub motors: Vec<String>,
}

impl Look {
    /// For every column what it is where the file is read by `map`, written as in `kinds`.
    pub fn kinds_by(&self, map: &Mapping) -> Vec<String> {
        let mut kinds = vec![String::new(); self.names.len()];
        let place = |column: &str| {
            let named = self.names.iter().position(|name| name == column);
            named.or_else(|| column.parse().ok().filter(|k| *k < self.names.len()))
        };
        for source in map.sources() {
            let quantity = source.quantity;
            // The guess knows the unit of a column that the mapping gives none.
            let unit = |k: usize| {
                let guessed =
                    self.kinds[k].strip_prefix(quantity.key()).and_then(|rest| rest.strip_prefix(':'));
                let unit = if source.written.is_empty() { guessed } else { Some(source.written.as_str()) };
                unit.unwrap_or(quantity.si()).to_owned()
            };
            if let Some(k) = place(&source.column) {
                kinds[k] = format!("{quantity}:{}", unit(k));
                continue;
            }
            let pairs = source.column.match_indices(['+', '-']).map(|(at, sign)| {
                let (one, other) = source.column.split_at(at);
                (place(one.trim()), sign, place(other[1..].trim()))
            });
            for (one, sign, other) in pairs {
                let (Some(one), Some(other)) = (one, other) else { continue };
                // The unit of a time in two columns is that of the fraction, that of a bridge both sides'.
                let (whole, second) = match quantity {
                    Quantity::Time => (quantity.si().to_owned(), unit(other)),
                    _ => (unit(one), String::new()),
                };
                kinds[one] = format!("{quantity}:{whole}");
                kinds[other] = format!("{quantity}{sign}:{second}");
                break;
            }
        }
        // Canonical columns that the mapping does not speak of are read all the same.
        let given = |quantity: Quantity| map.source(quantity).is_some();
        for quantity in Quantity::ALL.into_iter().filter(|quantity| !given(*quantity)) {
            let motion = matches!(quantity, Quantity::Angle | Quantity::Speed);
            let replaced = motion && map.names_motion()
                || quantity == Quantity::Voltage && given(Quantity::Duty)
                || quantity == Quantity::Time && given(Quantity::Interval);
            let own = self.names.iter().position(|name| quantity.canonical() == Some(name.as_str()));
            if let Some(k) = own.filter(|k| !replaced && kinds[*k].is_empty()) {
                kinds[k] = format!("{quantity}:{}", quantity.si());
            }
        }
        kinds
    }

    /// Whether the columns have names: numbers alone tell no kind of file from another.
    pub fn is_named(&self) -> bool {
        self.names.iter().any(|name| name.parse::<f64>().is_err())
    }
}

/// Looks at the file at `path`, whether it is a text or of a binary format.
///
/// # Errors
/// Bad input where the file is no table, is damaged, or is of a format that another program has to convert.
pub fn look(path: &Path) -> Result<Look> {
    match formats::look(path)? {
        None => {
            let input = text::open(path)?;
            match Json::of(input.decoded()) {
                Some(Json::Other) => table_in(path, formats::json(path, input)?.text()),
                Some(json) => {
                    let told = json.told().ok_or_else(|| json.refused(path))?;
                    Ok(Look { canonical: true, told: Some(told.into()), ..Look::default() })
                }
                None => table_in(path, input),
            }
        }
        Some(Shown::Table(table)) => table_in(path, table.text()),
        Some(Shown::Tests(entries)) => {
            let (told, motors) = (Some(entries.sentence()), entries.choices());
            Ok(Look { canonical: true, told, motors, ..Look::default() })
        }
    }
}

/// Looks at a table written as text.
fn table_in(path: &Path, mut input: impl BufRead) -> Result<Look> {
    let head = preamble::read(path, &mut input, true)?;
    let sample = sample::read(path, &mut input, &head, SHOWN)?;
    let rest = left_out(&sample).map(|(_, rest)| rest);
    let told = rest.as_ref().unwrap_or(&sample);
    let parts = parts_of(told);
    // The first row may be half of one.
    let places = parts.iter().flat_map(|part| [Some(part.index), part.rest]).flatten();
    let width = sample.texts.first().map_or(0, Vec::len).max(sample.names.len());
    let width = places.map(|place| place + 1).fold(width, usize::max);
    let mut kinds = vec![String::new(); width];
    let place =
        |quantity: Quantity| sample.names.iter().position(|name| quantity.canonical() == Some(name.as_str()));
    let is_there = |quantity| place(quantity).is_some();
    let canonical = (is_there(Quantity::Time) || sample.stamped)
        && ((is_there(Quantity::Voltage) && (is_there(Quantity::Angle) || is_there(Quantity::Speed)))
            || (is_there(Quantity::Target) && is_there(Quantity::Angle)));
    if canonical {
        for quantity in Quantity::ALL {
            if let Some(index) = place(quantity) {
                kinds[index] = format!("{quantity}:{}", quantity.si());
            }
        }
    } else {
        for part in parts {
            // The unit of a time in two columns is that of the fraction, that of a bridge both sides'.
            let (whole, second) = match part.rest {
                Some(_) if part.quantity == Quantity::Time => (Quantity::Time.si(), part.unit.as_str()),
                _ => (part.unit.as_str(), ""),
            };
            kinds[part.index] = format!("{}:{whole}", part.quantity);
            if let Some(rest) = part.rest {
                kinds[rest] = format!("{}{}:{second}", part.quantity, part.sign());
            }
        }
    }
    let proposal = if canonical { None } else { propose_for(&sample) };
    let asked = match &proposal {
        Some(proposal) => proposal.questions(),
        None if canonical => Vec::new(),
        None if sample.names.is_empty() => garbled_question(&sample).into_iter().collect(),
        None => sample::question(&sample).into_iter().collect(),
    };
    let names = (0..width).map(|k| sample.names.get(k).cloned().unwrap_or_else(|| k.to_string())).collect();
    Ok(Look { names, rows: sample.texts, kinds, canonical, proposal, asked, ..Look::default() })
}

#[cfg(test)]
mod tests {
    use super::super::super::read_tests::file;
    use super::super::super::{ReadOptions, read};
    use super::*;

    fn looked(text: &str) -> Look {
        let (_directory, path) = file(text.as_bytes());
        look(&path).unwrap()
    }

    #[test]
    fn every_column_shows_what_the_proposal_says_of_it() {
        let rows: String = (0..60).map(|k| format!("{};{};{}\n", 10 * k, k % 7 * 30, k * k)).collect();
        let look = looked(&format!("boot\nt_ms;pwm;enc\n{rows}"));
        assert_eq!(look.kinds, ["time:ms", "duty:255", "angle:counts"]);
        assert_eq!(
            (look.names.as_slice(), look.rows.len()),
            (["t_ms", "pwm", "enc"].map(String::from).as_slice(), 60)
        );
        let proposal = look.proposal.unwrap();
        assert_eq!(proposal.map, "time=t_ms:ms,duty=pwm:255,angle=enc:counts");
        assert!(proposal.supply_volts.is_some() && proposal.counts_per_rev.is_some());
    }

    #[test]
    fn what_the_command_line_asks_of_the_columns_comes_with_the_guess() {
        let table = |header: &str, row: &dyn Fn(u32) -> String| {
            looked(&format!("{header}\n{}", (0..60).map(row).collect::<String>()))
        };
        let look = table("t_ms;pwm;enc", &|k| format!("{};{};{}\n", 10 * k, k % 7 * 30, k * k));
        assert!(look.asked[0].starts_with("nothing tells the full duty of \"pwm\""), "{:?}", look.asked);
        assert!(look.asked[1].starts_with("put the number that is full duty"), "{:?}", look.asked);
        // The counts of a turn have a field of their own.
        assert_eq!(look.asked.len(), 2, "{:?}", look.asked);
        let look = table("t_ms;enc", &|k| format!("{};{}\n", 10 * k, k * k));
        assert!(look.proposal.is_none() && look.asked[0].contains("drove the motor"), "{:?}", look.asked);
        let look = table("time_s,voltage_v,angle_rad", &|k| format!("{k},{},{k}\n", k % 7));
        assert!(look.canonical && look.asked.is_empty(), "{:?}", look.asked);
    }

    #[test]
    fn a_mapping_in_use_is_shown_in_the_columns_that_it_names() {
        let rows: String = (0..60).map(|k| format!("{},{k},{},{k},0\n", 10 * k, k % 7 * 30)).collect();
        let look = looked(&format!("t_ms,in1,in2,enc,supply_v\n{rows}"));
        let kinds = |map: &str| look.kinds_by(&map.parse().unwrap());
        assert_eq!(
            kinds("time=t_ms:ms,duty=1-2:255,angle=enc:counts*-1"),
            ["time:ms", "duty:255", "duty-:", "angle:counts*-1", "supply:V"]
        );
        assert_eq!(
            kinds("time=0+3:us,voltage=in1:mV,speed=in2"),
            ["time:s", "voltage:mV", "speed:rad/s", "time+:us", "supply:V"]
        );
        assert!(look.is_named() && !looked("0,1,2\n1,2,3\n2,3,4\n").is_named());
    }

    #[test]
    fn canonical_columns_need_no_mapping_and_numbers_alone_are_shown_by_their_place() {
        let look = looked("time_s,note,voltage_v,angle_rad\n0,a,1,2\n1,b,2,3\n2,c,3,4\n");
        assert!(look.canonical && look.proposal.is_none());
        assert_eq!(look.kinds, ["time:s", "", "voltage:V", "angle:rad"]);
        assert_eq!(looked("0,1,2\n1,2,3\n2,3,4\n").names, ["0", "1", "2"]);
    }

    #[test]
    fn half_a_first_row_of_numbers_alone_hides_no_column() {
        let row = |k: u32| format!("{},{},{}\n", 10 * k, k / 50 * 40, (k * k) % 9000 + k);
        let look = looked(&format!("3,5\n{}", (0..200).map(row).collect::<String>()));
        assert_eq!((look.names.len(), look.kinds.len()), (3, 3));
        assert!(look.kinds.iter().all(|kind| !kind.is_empty()), "{:?}", look.kinds);
    }

    #[test]
    fn a_time_in_two_columns_is_shown_in_both() {
        let rows: String =
            (0..300).map(|k| format!("{},{},{},{}\n", k / 100, k % 100 * 10_000_000, k % 5, k)).collect();
        let look = looked(&format!("sec,nanosec,u,theta\n{rows}"));
        assert_eq!(look.kinds, ["time:s", "time+:ns", "voltage:V", "angle:deg"]);
    }

    #[test]
    fn a_bridge_with_a_column_for_each_side_is_shown_in_both() {
        let row = |k: i32| {
            let duty = (200.0 * (0.05 * f64::from(k)).sin()).round();
            format!("{},{},{},{}\n", 10 * k, (-duty).max(0.0), duty.max(0.0), 0.5 * duty)
        };
        let look = looked(&format!("t_ms,LPWM,RPWM,rpm\n{}", (0..300).map(row).collect::<String>()));
        assert_eq!(look.kinds, ["time:ms", "duty-:", "duty:255", "speed:rpm"]);
    }

    /// A NumPy array of `rows` with these fields, all of them doubles.
    fn npy(fields: &[&str], rows: &[Vec<f64>]) -> Vec<u8> {
        let fields: Vec<String> = fields.iter().map(|name| format!("('{name}', '<f8')")).collect();
        let header = format!(
            "{{'descr': [{}], 'fortran_order': False, 'shape': ({},), }}\n",
            fields.join(", "),
            rows.len()
        );
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(rows.iter().flatten().flat_map(|value| value.to_le_bytes()));
        bytes
    }

    #[test]
    fn a_binary_table_is_shown_and_guessed_at_like_its_csv() {
        let rows: Vec<Vec<f64>> =
            (0..60).map(|k| vec![10.0 * f64::from(k), f64::from(k % 7 * 30), f64::from(k * k)]).collect();
        let names = ["t_ms", "pwm", "enc"];
        let (_directory, path) = file(&npy(&names, &rows));
        let look = look(&path).unwrap();
        let text: String =
            rows.iter().map(|row| format!("{:?},{:?},{:?}\n", row[0], row[1], row[2])).collect();
        let csv = looked(&format!("t_ms,pwm,enc\n{text}"));
        assert_eq!((look.names, look.kinds, look.rows), (csv.names, csv.kinds, csv.rows));
        assert_eq!(look.proposal.unwrap(), csv.proposal.unwrap());
        assert!(look.told.is_none() && !look.canonical);
    }

    #[test]
    fn canonical_fields_of_a_binary_table_need_no_mapping() {
        let rows: Vec<Vec<f64>> = (0..30).map(|k| vec![0.01 * f64::from(k), 1.0, f64::from(k)]).collect();
        let (_directory, path) = file(&npy(&["time_s", "voltage_v", "angle_rad"], &rows));
        let look = look(&path).unwrap();
        assert!(look.canonical);
        assert_eq!((look.kinds[2].as_str(), look.rows[1][0].as_str()), ("angle:rad", "0.01"));
    }

    #[test]
    fn a_binary_file_that_is_cut_off_says_so_and_one_of_another_program_names_it() {
        let whole = npy(&["t", "u", "w"], &vec![vec![0.0, 1.0, 2.0]; 30]);
        let cut = &whole[..whole.len() - 9];
        for (content, told) in [(cut, "cut off or damaged"), (&b"ULog\x01\x12\x35\x00"[..], "ulog2csv")] {
            let (_directory, path) = file(content);
            let refused = look(&path).unwrap_err().to_string();
            assert!(refused.contains(told), "{refused}");
        }
    }

    /// A WPILib data log in which two mechanisms ran a test each; `unit` is what the entries say of themselves.
    fn routines(unit: &str) -> Vec<u8> {
        let mut bytes = b"WPILOG\x00\x01\x00\x00\x00\x00".to_vec();
        let mut record = |entry: u8, time_s: f64, payload: &[u8]| {
            bytes.extend([0b0100_0100, entry]);
            bytes.extend(u16::try_from(payload.len()).unwrap().to_le_bytes());
            bytes.extend(&((time_s * 1e6) as u64).to_le_bytes()[..5]);
            bytes.extend(payload);
        };
        for (of, (mechanism, motor)) in
            [("arm", "joint-arm"), ("drive", "left-drive")].into_iter().enumerate()
        {
            let first = 1 + 4 * u8::try_from(of).unwrap();
            let state = (format!("sysid-test-state-{mechanism}"), "string", "");
            let numbers =
                ["voltage", "position", "velocity"].map(|k| (format!("{k}-{motor}"), "double", unit));
            for (k, (name, kind, about)) in (0..).zip([state].into_iter().chain(numbers)) {
                let mut start = vec![0, first + k, 0, 0, 0];
                for text in [name.as_str(), kind, about] {
                    start.extend(u32::try_from(text.len()).unwrap().to_le_bytes());
                    start.extend(text.as_bytes());
                }
                record(0, 0.0, &start);
            }
            for k in 0..60 {
                let t = 10.0 * of as f64 + 0.02 * f64::from(k);
                record(first, t, b"dynamic-forward");
                for (entry, value) in (first + 1..).zip([6.0, 0.1 * t, 0.1]) {
                    record(entry, t, &f64::to_le_bytes(value));
                }
            }
            record(first, 10.0 * of as f64 + 2.0, b"none");
        }
        bytes
    }

    #[test]
    fn tests_of_sysid_need_no_columns_but_perhaps_a_motor_and_the_metres_of_a_turn() {
        let (_directory, path) = file(&routines("Meter"));
        let seen = look(&path).unwrap();
        let told = seen.told.unwrap();
        assert!(told.starts_with("2 tests of SysId") && told.contains("metres per output turn"), "{told}");
        assert!(seen.names.is_empty() && seen.canonical);
        assert_eq!(seen.motors, ["joint-arm", "left-drive"]);
        // With both of them told, the file is read.
        let map = Some("voltage=voltage-left-drive:V".parse().unwrap());
        let mut options = ReadOptions { map, ..ReadOptions::default() };
        assert!(read(&path, &options).unwrap_err().to_string().contains("--metres-per-rev"));
        options.motor.metres_per_rev = Some(0.5);
        let records = read(&path, &options).unwrap();
        assert_eq!(records.len(), 1);
        assert!((records[0].speed_rad_s.as_ref().unwrap()[9] - 0.4 * std::f64::consts::PI).abs() < 1e-12);
    }
}
