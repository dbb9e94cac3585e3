//! A duty beyond full duty: no driver gives more than its supply.

use super::Record;
use super::suspicion::Odd;
use super::units::Quantity;

/// Shares of full duty are not always kept to it.
const BEYOND: f64 = 1.2;
/// A supply of less than this share of its mean was off, or was not read.
const OFF: f64 = 0.5;

/// A mapped duty goes beyond what is said to be full.
pub(super) fn beyond_full(record: &Record) -> Option<Odd> {
    let source = record.source(Quantity::Duty)?;
    let mean = record.mean_supply_v().filter(|volts| *volts > 0.0)?;
    let shares = record.voltage_v.iter().enumerate().filter_map(|(k, volts)| {
        let supply = record.supply_v.as_ref().map_or(mean, |supply| supply[k]);
        (supply > OFF * mean).then(|| volts.abs() / supply)
    });
    let most = shares.fold(0.0, f64::max);
    (most > BEYOND).then(|| {
        let (column, full) = (&source.column, &source.written);
        (
            "beyond_full_duty",
            "voltage_v",
            format!(
                "\"{column}\" goes to {most:.2} times full duty ({full}), and no driver gives more than its supply: another number is full duty, \
                 or the largest is a code of the program, as for a brake"
            ),
            format!(
                "say which number is full duty, duty={column}:FULL; or write in the rows of a code what the driver gave, 0 where it braked or let \
                 the motor run out"
            ),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duty_beyond_full_is_told_and_one_that_hardly_passes_it_is_not() {
        let told = |voltage_v: Vec<f64>, supply_v: Option<Vec<f64>>| {
            let map = "time=t:s,duty=pwm:255,speed=w".parse().ok();
            let mut record = Record { voltage_v, supply_v, map, ..Record::default() };
            record.meta.insert("voltage", "it is the duty times 12 V, whatever the supply did").unwrap();
            beyond_full(&record)
        };
        let (name, _, why, fix) = told(vec![0.0, 12.0, 47.06, -12.0], None).unwrap();
        assert_eq!(name, "beyond_full_duty");
        assert!(why.contains("\"pwm\" goes to 3.92 times full duty (255)"), "{why}");
        assert!(fix.contains("duty=pwm:FULL"), "{fix}");
        assert_eq!(told(vec![0.0, 12.5, -12.0], None), None);
        // The supply's reading of the first row is none.
        assert_eq!(told(vec![0.1, 11.0, -11.5], Some(vec![0.0, 11.0, 11.5])), None);
    }

    #[test]
    fn a_voltage_has_no_full_duty() {
        let map = "time=t:s,voltage=u:V,speed=w".parse().ok();
        assert_eq!(beyond_full(&Record { voltage_v: vec![0.0, 47.0], map, ..Record::default() }), None);
    }
}
