//! What the winding saw: the mean of the logged voltage over every cell of a grid.

use crate::log::{Hold, Record};

/// Nothing before the start, then the mean of the held (or straight) voltage over each cell. A voltage that acts before its row does so by
/// its record's metadata.
pub(super) fn mean_voltages(record: &Record, step: f64, cells: usize) -> Vec<f64> {
    let (t, v) = (&record.time_s, &record.voltage_v);
    let (origin, lead) = (t[0], record.meta.voltage_lead_s().unwrap_or(0.0));
    let mut voltages = vec![0.0; cells + 1];
    let mut add = |from: f64, to: f64, at_from: f64, at_to: f64| {
        // Spreads one piece over the cells it covers.
        let (mut a, b) = (((from - origin) / step).max(0.0), (to - origin) / step);
        while a < b - 1e-9 {
            let cell = ((a + 1e-9) as usize).min(cells - 1);
            let edge = (cell as f64 + 1.0).min(b);
            let edge = if edge > a { edge } else { b };
            let middle = 0.5 * (a + edge);
            let share = (middle * step + origin - from) / (to - from);
            voltages[cell + 1] += (edge - a) * (at_from + share * (at_to - at_from));
            a = edge;
        }
    };
    for k in 0..t.len() - 1 {
        let to = if record.hold == Hold::First { v[k + 1] } else { v[k] };
        add(t[k] - lead, t[k + 1] - lead, v[k], to);
    }
    let (last, end) = (t[t.len() - 1] - lead, origin + cells as f64 * step);
    let held = v[v.len() - 1];
    if end > last {
        add(last, end, held, held);
    }
    voltages
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_volt_second_is_kept_under_jitter() {
        let time_s: Vec<f64> =
            (0..500).map(|k| f64::from(k) * 0.02 + 0.004 * f64::sin(f64::from(k * k))).collect();
        let voltage_v: Vec<f64> = (0..500).map(|k| f64::from(k % 7) - 3.0).collect();
        let truth: f64 = (0..499).map(|k| voltage_v[k] * (time_s[k + 1] - time_s[k])).sum();
        let record = Record { time_s, voltage_v, ..Record::default() };
        let (step, until) = (1e-3, record.duration_s() / 1e-3);
        let cells = mean_voltages(&record, step, until.ceil() as usize + 1);
        let whole: f64 = cells[1..=until as usize].iter().sum::<f64>() * step;
        let rest = cells[until as usize + 1] * until.fract() * step;
        assert!((whole + rest - truth).abs() < 1e-4, "{} {truth}", whole + rest);
    }

    #[test]
    fn a_voltage_with_a_lead_acts_that_long_before_its_row() {
        let time_s: Vec<f64> = (0..10).map(|k| f64::from(k) * 0.02).collect();
        let voltage_v = (0..10).map(|k| if k < 5 { 0.0 } else { 6.0 }).collect();
        let mut record = Record { time_s, voltage_v, ..Record::default() };
        record.meta.insert("voltage_lead_s", "0.0125").unwrap();
        let cells = mean_voltages(&record, 1e-3, 181);
        // The row at 100 ms acts from 87.5 ms on.
        let near = |cell: usize, volts: f64| (cells[cell + 1] - volts).abs() < 1e-6;
        assert!(
            near(0, 0.0) && near(86, 0.0) && near(87, 3.0) && near(88, 6.0) && near(180, 6.0),
            "{cells:?}"
        );
    }
}
