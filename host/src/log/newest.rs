//! Rows that stand from the newest to the oldest, as historians and data bases export them: their stamps fall from row to row.

use super::choice::TimeSource;
use super::clock::Clock;
use super::fields::trimmed;
use super::numbers::OfFile;
use super::preamble::Preamble;

/// Rows from which their order is told.
const FEWEST: usize = 20;
/// Numbers from here on count from an epoch: smaller ones may be the time that is left.
const EPOCH: f64 = 1e8;

/// Whether a time that is written as a number counts from an epoch, and so tells when its row was.
pub(super) fn is_stamp(number: f64) -> bool {
    number.abs() >= EPOCH
}

/// Whether times fall from row to row, but for those that stand still.
pub(super) fn falls(times: &[f64]) -> bool {
    let steps = || times.windows(2).map(|pair| pair[1] - pair[0]);
    times.len() >= FEWEST && steps().all(|step| step <= 0.0) && steps().any(|step| step < 0.0)
}

/// Whether the first rows of a table begin with the newest, by the dates or the clock times of the column that tells the time.
pub(super) fn is_first(time: &TimeSource, head: &Preamble) -> bool {
    let TimeSource::Column(column) = time else { return false };
    let (mut splitter, mut clock) = (head.splitter(), Clock::default());
    let mut written = OfFile::with_thousands(head.thousands);
    let mut stamp = |line: &str| {
        let text = splitter.split(trimmed(line)).then(|| splitter.get(column.index))??;
        let number = written.read(0, text);
        clock.read(text, 1.0, number).filter(|_| number.is_none_or(is_stamp))
    };
    let stamps: Option<Vec<f64>> = head.rows.iter().map(|(_, line)| stamp(line)).collect();
    stamps.is_some_and(|stamps| falls(&stamps))
}

#[cfg(test)]
mod tests {
    use super::super::guess::look;
    use super::super::read_tests::file;
    use super::super::{ReadOptions, read};
    use super::*;

    #[test]
    fn times_that_fall_are_told_from_those_that_go_back_once() {
        let of = |time: &dyn Fn(usize) -> f64| falls(&(0..100).map(time).collect::<Vec<_>>());
        assert!(of(&|k| -0.01 * k as f64) && of(&|k| -0.01 * (k / 2) as f64));
        assert!(!of(&|k| 0.01 * k as f64) && !of(&|k| -((k % 50) as f64)) && !of(&|_| 5.0));
    }

    #[test]
    fn rows_from_the_newest_to_the_oldest_are_turned_round_where_they_are_dated() {
        let row =
            |k: usize, time: String| format!("{time},{},{}\n", [6.0, -3.0, 0.0][k / 50 % 3], k as f64 * 0.1);
        let table = |time: &dyn Fn(usize) -> String| {
            (0..300).rev().map(|k| row(k, time(k))).fold("stamp,u,x\n".to_owned(), |text, row| text + &row)
        };
        let map = |unit: &str| ReadOptions {
            map: Some(format!("time=stamp{unit},voltage=u:V,angle=x:rad").parse().unwrap()),
            ..ReadOptions::default()
        };
        let dated = |k: usize| format!("2024-05-01T12:00:{:06.3}Z", 0.01 * k as f64);
        let epoch = |k: usize| (1_700_000_000_000_u64 + 10 * k as u64).to_string();
        for (time, unit) in [(&dated as &dyn Fn(usize) -> String, ""), (&epoch, ":ms")] {
            let (_directory, path) = file(table(time).as_bytes());
            let record = &read(&path, &map(unit)).unwrap()[0];
            assert!(record.time_s.is_sorted() && record.angle_rad.as_ref().unwrap().is_sorted());
            assert!(record.warnings.iter().any(|w| w.what.contains("from the newest to the oldest")));
        }
        // Seconds that are left are not.
        let left = |k: usize| format!("{:.2}", 0.01 * k as f64);
        let (_directory, path) = file(table(&left).as_bytes());
        assert!(read(&path, &map(":s")).unwrap_err().to_string().contains("time goes backwards"));
    }

    #[test]
    fn a_proposal_shows_rows_that_count_from_an_epoch_turned_round_as_they_are_read() {
        let table = |head: &str, row: &dyn Fn(u64) -> String| {
            (0..300).rev().map(row).fold(format!("{head}\n"), |text, row| text + &row + "\n")
        };
        let shown = |text: String| {
            let (_directory, path) = file(text.as_bytes());
            look(&path).unwrap().proposal.unwrap()
        };
        let volts = |k: u64| [6, -3, 0][k as usize / 50 % 3];
        let epoch = |k: u64| format!("{},{},{}", 1_700_000_000_000 + 10 * k, volts(k), k);
        let proposal = shown(table("timestamp,u_v,angle_deg", &epoch));
        assert_eq!(proposal.map, "time=timestamp:ms,voltage=u_v:V,angle=angle_deg:deg");
        assert!(proposal.preview[0].contains("100 samples a second"), "{:?}", proposal.preview);
        // A counter that runs below zero of 32 bits falls too, and is no time: its rows stay.
        let counter = |k: u64| format!("{},{},{}", 10 * (299 - k), volts(k), 4_294_960_000 + 10 * k);
        let proposal = shown(table("t_ms,u_v,count", &counter));
        assert!(proposal.preview[0].contains("100 samples a second"), "{:?}", proposal.preview);
        assert!(proposal.map.starts_with("time=t_ms:ms,voltage=u_v:V,"), "{}", proposal.map);
    }
}
