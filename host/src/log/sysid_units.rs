//! The units of what SysId logs: those of the mapping, or else those that the log itself gives.

use std::path::Path;

use super::ReadOptions;
use super::units::{PerTurn, Quantity, Unit};
use crate::error::{BadInput, Result};

/// The factor from a number of the log to SI, where `own` is the unit that the log gives, as `--map` writes it.
///
/// # Errors
/// Bad input where the unit is none of turns, and nobody told how many of it one turn of the output shaft is.
pub fn factor(path: &Path, quantity: Quantity, own: &str, options: &ReadOptions) -> Result<f64> {
    let source = options.map.as_ref().and_then(|map| map.source(quantity));
    let unit = match source {
        Some(source) => source.unit,
        None => Unit::parse(quantity, own).map_err(|why| {
            BadInput::new(path, format!("the log gives a unit that is none: {why}"), "say it with --map")
        })?,
    };
    let Some(per_turn) = unit.per_turn else { return Ok(unit.factor) };
    let known = match per_turn {
        PerTurn::Counts => options.motor.counts_per_rev,
        PerTurn::Metres => options.motor.metres_per_rev,
    };
    let known = known.ok_or_else(|| {
        let column = source.map_or(own, |source| source.column.as_str());
        let (why, mut remedy) = per_turn.unknown(quantity, column);
        if per_turn == PerTurn::Metres {
            remedy += ", or give the radius of the wheel or drum in metres: \
                       --map angle=position:rad/0.0762,speed=velocity:rad/s/0.0762";
        }
        let written = source.map_or(own, |source| source.written.as_str());
        BadInput::new(path, format!("the {quantity} is in {written}: {why}"), remedy)
    })?;
    Ok(unit.factor / known)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor_file::MotorFile;
    use std::f64::consts::TAU;

    fn options(map: &str, metres_per_rev: Option<f64>) -> ReadOptions {
        let map = (!map.is_empty()).then(|| map.parse().unwrap());
        let motor = MotorFile { metres_per_rev, ..MotorFile::default() };
        ReadOptions { map, motor, ..ReadOptions::default() }
    }

    fn of(quantity: Quantity, own: &str, options: &ReadOptions) -> Result<f64> {
        factor(Path::new("log.wpilog"), quantity, own, options)
    }

    #[test]
    fn metres_become_turns_by_the_metres_of_a_turn() {
        let wheel = options("", Some(0.5));
        assert_eq!(of(Quantity::Angle, "m", &wheel).unwrap(), TAU / 0.5);
        assert_eq!(of(Quantity::Speed, "m/s", &wheel).unwrap(), TAU / 0.5);
        assert_eq!(of(Quantity::Angle, "rev", &wheel).unwrap(), TAU);
        // A mapping's unit counts before the log's, and needs the metres as well.
        let mapped = options("angle=position:mm", Some(0.5));
        assert!((of(Quantity::Angle, "rev", &mapped).unwrap() - TAU / 500.0).abs() < 1e-15);
    }

    #[test]
    fn metres_of_an_unknown_wheel_are_refused_whether_the_log_or_the_mapping_says_them() {
        for (own, map) in [("m", ""), ("rev", "angle=position:m"), ("m", "speed=velocity:rad/s/0.1")] {
            let told = of(Quantity::Angle, own, &options(map, None)).unwrap_err().to_string();
            assert!(told.contains("angle is in m") && told.contains("--metres-per-rev"), "{told}");
        }
        let radius = options("angle=position:rad/0.25", None);
        assert_eq!(of(Quantity::Angle, "m", &radius).unwrap(), 4.0);
        let counts = of(Quantity::Angle, "rev", &options("angle=position:counts", None)).unwrap_err();
        assert!(counts.to_string().contains("--counts-per-rev"), "{counts}");
    }
}
