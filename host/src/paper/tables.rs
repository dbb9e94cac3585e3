//! Table 2 and what follows from it.

use motorlens_shared::motor::Combinations;
use serde::Serialize;

use crate::compare::measures::Measures;
use crate::log::Record;
use crate::log::motion::peak;
use crate::search::{LinearRecord, Records};

/// The paper's Table 2 as printed: voltage, GA average and largest error, conventional average and largest error.
pub const PRINTED: [(f64, f64, f64, f64, f64); 3] = [
    (3.0, 0.0782, 0.245, 3.3643, 6.68),
    (5.0, 0.7299, 1.45, 6.2678, 12.4),
    (7.0, 1.6698, 3.06, 9.4237, 18.5),
];

/// Errors of one model on one record, rad (or rad/s).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Average of the magnitude: the paper's AE.
    pub ae: f64,
    /// Largest magnitude: the paper's ME.
    pub me: f64,
}

impl From<Measures> for Errors {
    fn from(m: Measures) -> Self {
        Self { ae: m.ae, me: m.me }
    }
}

/// One line of Table 2.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Name of the record.
    pub record: String,
    /// Its largest voltage, V.
    pub volts: f64,
    /// The genetic algorithm's model.
    pub ga: Errors,
    /// The conventional model.
    pub conventional: Errors,
    /// Average error of the conventional model over that of the genetic one.
    pub ratio: f64,
    /// The paper's printed parameters on this record.
    pub printed_table_1: Errors,
}

/// How the error grows from the smallest to the largest voltage.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Growth {
    /// Largest over smallest voltage: what the error of a linear model that is merely mis-tuned would grow by.
    pub voltage: f64,
    /// What it grew by.
    pub error: f64,
}

/// Predictions of a linear model for every record, in the measured unit.
pub fn predictions(records: &Records, measured: &[LinearRecord], motor: &Combinations) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = measured.iter().map(|r| Vec::with_capacity(r.measured.len())).collect();
    records.errors(motor, |record, k, error| all[record].push(measured[record].measured[k] + error));
    all
}

/// Average and largest error of a linear model for every record.
pub fn errors(records: &Records, motor: &Combinations) -> Vec<Errors> {
    let mut sums = vec![(0.0, 0.0_f64, 0_usize); records.len()];
    records.errors(motor, |record, _, error| {
        let (sum, most, count) = &mut sums[record];
        *sum += error.abs();
        *most = most.max(error.abs());
        *count += 1;
    });
    sums.into_iter().map(|(sum, me, count)| Errors { ae: sum / count as f64, me }).collect()
}

/// Table 2 on these records.
pub fn table_2(
    records: &[Record],
    prepared: &Records,
    ga: &Combinations,
    conventional: &Combinations,
    printed: &Combinations,
) -> Vec<Row> {
    let [ga, conventional, printed] = [ga, conventional, printed].map(|m| errors(prepared, m));
    records
        .iter()
        .enumerate()
        .map(|(k, record)| Row {
            record: record.name.clone(),
            volts: peak(&record.voltage_v),
            ga: ga[k],
            conventional: conventional[k],
            ratio: conventional[k].ae / ga[k].ae,
            printed_table_1: printed[k],
        })
        .collect()
}

/// From the first to the last line; `None` with fewer than two voltages.
pub fn growth(rows: &[Row], of: impl Fn(&Row) -> f64) -> Option<Growth> {
    let (first, last) = (rows.first()?, rows.last()?);
    (last.volts > 1.01 * first.volts)
        .then(|| Growth { voltage: last.volts / first.volts, error: of(last) / of(first) })
}

#[cfg(test)]
mod tests {
    use super::PRINTED;

    #[test]
    fn the_printed_ratios_are_not_those_that_the_paper_states() {
        // The paper says 48, 8 and 5 times.
        let ratios = PRINTED.map(|(_, ga, _, conventional, _)| conventional / ga);
        for (ratio, true_ratio) in ratios.into_iter().zip([43.0, 8.6, 5.6]) {
            assert!((ratio - true_ratio).abs() < 0.05, "{ratio}");
        }
        assert!((PRINTED[2].1 / PRINTED[0].1 - 21.35).abs() < 0.01);
    }
}
