//! A channel as Tektronix's oscilloscopes (TDS 1000 and 2000) save it, a file each: what they tell of it stands in the first two columns of
//! the first rows, and beside that, behind a blank one, the times and the readings of all.

use super::fields::Separator;
use super::layout::{Layout, fields, is_number, new};

/// How the first line begins.
const FIRST: &str = "Record Length,";
/// Columns before that of the times.
const BEFORE: usize = 3;
/// Rows beside which something is told, at most.
const TOLD: usize = 30;

/// The layout of such a file, whose columns go by `Time` and the name of the channel; none of another.
pub(super) fn layout(lines: &[&str]) -> Option<Layout> {
    lines.first().filter(|line| line.starts_with(FIRST))?;
    let separator = Separator::Byte(b',');
    let rows: Vec<Vec<String>> = lines.iter().take(TOLD).map(|line| fields(line, &separator)).collect();
    let is_row = |row: &Vec<String>| {
        let (channel, beside) = row.split_at(row.len().min(BEFORE + 2));
        channel.get(BEFORE..).is_some_and(|pair| pair.len() == 2 && pair.iter().all(|text| is_number(text)))
            && beside.iter().all(String::is_empty)
    };
    if !rows.iter().all(is_row) {
        return None;
    }
    let told =
        |key: &str| rows.iter().find(|row| row[0] == key).map_or_else(String::new, |row| row[1].clone());
    let names = vec!["Time".to_owned(), told("Source")];
    let units = vec![told("Horizontal Units"), told("Vertical Units")];
    Some(Layout { first: BEFORE, names, units, ..new(separator) })
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::file;
    use super::super::{ReadOptions, read};

    /// The file of a channel with this unit and these readings, 100 a second.
    fn channel(source: &str, unit: &str, reading: impl Fn(usize) -> f64) -> String {
        let told = format!(
            "Record Length,2.5e+03\nSample Interval,1e-02\nTrigger Point,4.9e+02\n,\n,\n,\nSource,{source}\nVertical Units,{unit}\n\
             Vertical Scale,2e+01\nVertical Offset,-6.24e+01\nHorizontal Units,s\nHorizontal Scale,5e-02\nPt Fmt,Y\nYzero,0.0\n\
             Probe Atten,1e+02\nModel Number,TDS2012B\nSerial Number,C065331\nFirmware Version,FV:v22.16"
        );
        let told = told.lines().chain(std::iter::repeat(","));
        let row = |(k, told): (usize, &str)| {
            format!("{told},,  {:.12},  {:.5},\n", 0.01 * k as f64 - 0.98, reading(k))
        };
        (0..400).zip(told).map(row).collect()
    }

    fn voltage(k: usize) -> f64 {
        [6.0, -3.0, 0.0, 4.5][k / 50 % 4]
    }

    #[test]
    fn one_channel_is_a_time_and_its_readings_and_the_other_is_asked_for() {
        let (_directory, path) = file(channel("CH1", "A", voltage).as_bytes());
        let said = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        for words in ["the columns are Time, CH1", "only \"CH1\"", "as CH1.CSV+CH2.CSV"] {
            assert!(said.contains(words), "{said}");
        }
    }

    #[test]
    fn the_files_of_two_channels_are_one_record() {
        let (_one, drive) = file(channel("CH1", "V", voltage).as_bytes());
        let (_other, motion) = file(channel("CH2", "V", |k| (0.05 * k as f64).sin()).as_bytes());
        let both = format!("{}+{}", drive.display(), motion.display());
        let map = "time=Time:s,voltage=CH1:V,speed=CH2:rad/s*104.7";
        let said = read(both.as_ref(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(said.contains("--map time=Time:s,voltage=CH1:V,speed=CH2:"), "{said}");
        let options = ReadOptions { map: Some(map.parse().unwrap()), ..ReadOptions::default() };
        let record = read(both.as_ref(), &options).unwrap().remove(0);
        assert_eq!(record.len(), 400);
        assert!((record.time_s[0] + 0.98).abs() < 1e-9);
        assert_eq!(record.voltage_v[60], -3.0);
        assert!((record.speed_rad_s.unwrap()[10] - 104.7 * 0.5_f64.sin()).abs() < 0.01);
    }

    #[test]
    fn a_table_with_more_than_one_channel_is_no_such_file() {
        let table = channel("CH1", "V", voltage).replace(",\n", ",1.5\n");
        let (_directory, path) = file(table.as_bytes());
        let said = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(!said.contains("CH1.CSV+CH2.CSV"), "{said}");
    }

    #[test]
    fn amperes_are_never_proposed_as_a_voltage() {
        let (_one, drive) = file(channel("CH1", "A", voltage).as_bytes());
        let (_other, motion) = file(channel("CH2", "V", |k| (0.05 * k as f64).sin()).as_bytes());
        let both = format!("{}+{}", drive.display(), motion.display());
        let said = read(both.as_ref(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(!said.contains("voltage=CH1"), "{said}");
    }
}
