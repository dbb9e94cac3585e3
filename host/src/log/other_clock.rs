//! The clock that may have been meant where the column that is read as the time goes back: another one that is called a time, and rises.

use super::choice::Columns;
use super::guess::words;
use super::numbers::number;
use super::preamble::Preamble;

/// Rows from which a clock is told.
const FEWEST: usize = 20;

/// The name of a column that is not read, is called a time and rises in each of the first rows.
pub(super) fn other_clock(head: &Preamble, wanted: &Columns) -> Option<String> {
    let names = head.headers.as_deref().unwrap_or_default();
    let may_be = |k: &usize| !wanted.reads(*k) && words::is_time(&names[*k]);
    (0..names.len()).filter(may_be).find(|k| rises(head, *k)).map(|k| names[k].clone())
}

fn rises(head: &Preamble, column: usize) -> bool {
    let mut splitter = head.splitter();
    let mut times = Vec::new();
    for (_, line) in &head.rows {
        if splitter.split(line)
            && let Some(time) = splitter.get(column).and_then(number)
        {
            times.push(time);
        }
    }
    times.len() >= FEWEST && times.windows(2).all(|pair| pair[1] > pair[0])
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::{assert_bad, file};
    use super::super::{ReadOptions, read};

    #[test]
    fn where_the_time_goes_back_another_clock_that_rises_is_named() {
        let table = |other: &str, time: &dyn Fn(u32) -> f64| {
            let row = |k: u32| {
                let real = if k == 50 { -0.975 } else { 0.025 * f64::from(k.min(2)) };
                format!("{real},{},{},{k}\n", time(k), k % 7)
            };
            (0..100).map(row).fold(format!("Ts_real_s,{other},u,x\n"), |text, row| text + &row)
        };
        let refused = |other: &str, time: &dyn Fn(u32) -> f64| {
            let (_directory, path) = file(table(other, time).as_bytes());
            let map = Some("time=Ts_real_s:s,voltage=u:V,angle=x:rad".parse().unwrap());
            read(&path, &ReadOptions { map, ..ReadOptions::default() }).unwrap_err()
        };
        let rises = |k: u32| 0.025 * f64::from(k);
        assert_bad(&refused("time_s", &rises), "column Ts_real_s", "backwards", "\"time_s\" rises");
        for error in [refused("time_s", &|k| f64::from(k % 30)), refused("torque", &rises)] {
            assert!(!error.to_string().contains("rises"), "{error}");
        }
    }
}
