//! What drives a motor between two of its readings.
//!
//! A table may tell the voltage in rows in which it tells no motion. Those rows are no samples, but what drove the motor in them did: a
//! sample's voltage is the mean by time until the next one, so that no volt-second is lost.

use super::choice::Wanted;
use super::robot_loop::turn_of;
use super::units::Quantity;

/// Stamps are decimals: a turn that is as long as it may be is not longer by what they are rounded to.
const ROUNDED: f64 = 1.0 + 1e-6;

/// The voltage since the last sample, of each column that drives the motor.
#[derive(Debug, Default)]
pub(super) struct Between {
    /// Places of those columns among the numbers of a row, whose first is the time.
    places: Vec<usize>,
    /// Time of the last sample and of the last row, s; none before the first.
    since: Option<(f64, f64)>,
    /// What held until the last row, what has held since, and the volt-seconds before it.
    earlier: Vec<f64>,
    values: Vec<f64>,
    sums: Vec<f64>,
    /// Whether there was a row without a motion since the last sample.
    passed: bool,
}

impl Between {
    /// Of rows with these columns. Where the sign stands in a column of its own, a mean would have none.
    pub fn new(columns: &[Wanted]) -> Self {
        let signed = columns.iter().all(|column| column.quantity != Quantity::Direction);
        let drives =
            |column: &Wanted| signed && matches!(column.quantity, Quantity::Voltage | Quantity::Duty);
        let places: Vec<usize> = (0..columns.len()).filter(|k| drives(&columns[*k])).map(|k| k + 1).collect();
        let zeros = vec![0.0; places.len()];
        Self {
            places,
            since: None,
            earlier: zeros.clone(),
            values: zeros.clone(),
            sums: zeros,
            passed: false,
        }
    }

    /// Takes a row, without a motion or a sample, and tells what drove the motor since the last sample, column by column, where this is
    /// the next one and there were rows between.
    pub fn take(&mut self, row: &[f64], is_sample: bool) -> Vec<(usize, f64)> {
        let time = row[0];
        let Some((begin, before)) = self.since.filter(|(_, before)| time >= *before) else {
            self.begin(row, is_sample);
            return Vec::new();
        };
        // What drives the motor from then on stands before the motion of the same turn of a loop.
        let one_turn = is_sample && self.passed && time - before <= ROUNDED * turn_of(time - begin);
        for (k, place) in self.places.iter().enumerate() {
            let held = if one_turn { self.earlier[k] } else { self.values[k] };
            self.sums[k] += held * (time - before);
            self.earlier[k] = self.values[k];
            self.values[k] = row[*place];
        }
        self.since = Some((begin, time));
        self.passed |= !is_sample;
        if !is_sample {
            return Vec::new();
        }
        let means = self.places.iter().zip(&self.sums).map(|(place, sum)| (*place, sum / (time - begin)));
        let means = if self.passed && time > begin { means.collect() } else { Vec::new() };
        self.begin(row, true);
        means
    }

    fn begin(&mut self, row: &[f64], is_sample: bool) {
        self.since = is_sample.then_some((row[0], row[0]));
        for (k, place) in self.places.iter().enumerate() {
            self.values[k] = row[*place];
        }
        self.earlier.clone_from(&self.values);
        self.sums.fill(0.0);
        self.passed = false;
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::file;
    use super::super::{ReadOptions, read};

    #[test]
    fn the_voltage_of_rows_without_a_motion_counts_by_its_time() {
        let mut text = "time_s,voltage_v,speed_rad_s\n".to_owned();
        for k in 0..200 {
            // Four rows a reading: 1, 2, 3 and 6 V, the last for twice as long.
            let speeds = if k % 4 == 0 { format!("{k}") } else { String::new() };
            let time = 0.05 * f64::from(k / 4) + [0.0, 0.01, 0.02, 0.03][k as usize % 4];
            text += &format!("{time:.3},{},{speeds}\n", [1, 2, 3, 6][k as usize % 4]);
        }
        let (_directory, path) = file(text.as_bytes());
        let record = read(&path, &ReadOptions::default()).unwrap().remove(0);
        assert_eq!(record.len(), 50);
        assert!(record.voltage_v[..49].iter().all(|v| (v - 3.6).abs() < 1e-9), "{:?}", record.voltage_v);
    }
}
