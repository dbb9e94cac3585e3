//! A column that holds one number and tells with it how fast the rows of its table come: `fs` of 10 beside the first of them.

use super::formats::interval;
use super::guess::words;
use super::sample::{Sample, numbers};

/// Takes the columns that hold one number and tell with it how fast the rows came: `fs` of 10 in the first row, or in all of them.
pub(super) fn take(sample: &mut Sample) -> Option<interval::Clock> {
    let (names, rows) = (&sample.names, &sample.rows);
    let only = |k: usize| {
        let mut values = numbers(rows, k);
        let first = values.next().filter(|_| interval::may_tell(&names[k]))?;
        // An interval in every row is the time since the row before.
        let is_told = values.clone().next().is_none() || !words::is_interval(&names[k]);
        (is_told && values.all(|value| value == first)).then_some((k, first))
    };
    let told: Vec<(usize, f64)> = (0..names.len()).filter_map(only).collect();
    let is_other = |k: &usize| told.iter().all(|(column, _)| column != k);
    let others = (0..names.len()).filter(is_other).map(|k| names[k].as_str());
    let clock = interval::among(others, told.iter().map(|(k, number)| (names[*k].as_str(), *number)))?;
    if sample.stamped {
        return None;
    }
    for (k, _) in told {
        sample.rows.iter_mut().filter_map(|row| row.get_mut(k)).for_each(|value| *value = f64::NAN);
    }
    Some(clock)
}

#[cfg(test)]
mod tests {
    use crate::log::read_tests::{assert_bad, file};
    use crate::log::{ReadOptions, read};

    #[test]
    fn the_only_number_of_a_column_that_is_called_a_rate_or_an_interval_is_the_rate_that_is_proposed() {
        let proposed = |header: &str, first: &str, next: &str| {
            let row = |k: u32| {
                let told = if k == 0 { first } else { next };
                format!("{},{:.3},{told}\n", k / 7 % 2 * 5, 0.2 * f64::from(k * k % 11))
            };
            let text = format!("{header}\n{}", (0..60).map(row).collect::<String>());
            let (_directory, path) = file(text.as_bytes());
            read(&path, &ReadOptions::default()).unwrap_err()
        };
        for (header, first, next, remedy) in [
            ("u,y,fs", "10", "", "--map voltage=u:V,speed=y:rad/s --rate 10 (nothing"),
            ("u,y,fs", "10", "10", "--rate 10 (nothing"),
            ("u,y,Ts", "0.02", "", "--map voltage=u:V,speed=y:rad/s --rate 50 (nothing"),
            ("u,y,dt", "0.02", "", "--rate 50 (nothing"),
            // What is another number in a later row tells nothing, and an interval in every row is a clock.
            ("u,y,fs", "10", "20", "--rate 100 (nothing"),
            ("u,y,dt", "0.02", "0.02", "interval=dt:s"),
        ] {
            assert_bad(&proposed(header, first, next), "column time_s", "no column is called time_s", remedy);
        }
        assert!(proposed("u,y,fs", "10", "").to_string().contains("fs = 10 makes 10 rows a second"));
        // Where the motion is not recognised either.
        let asked = proposed("pwm,m1,fs", "10", "").to_string();
        assert!(asked.contains("speed=m1:rad/s --supply-volts 12 --rate 10 "), "{asked}");
    }
}
