//! Advice on a mapping: the option that changes what is wrong and keeps everything else as the log was read.

use super::Record;
use super::guess::quoted;
use super::only::Only;
use super::sysid::{TEST_KEY, UNIT_KEY};
use super::units::Quantity;

/// A column that was taken for one quantity and is another, or in another unit. A unit that begins with `*` or `/` scales the one
/// that the column was read in.
pub type Change<'a> = (Quantity, Quantity, &'a str);

/// `--map ...` that reads the log of `record` as it was read but for `changes`.
pub fn remapped(record: &Record, changes: &[Change]) -> String {
    let motion = [Quantity::Angle, Quantity::Speed];
    let displaces = changes.iter().any(|(_, to, _)| motion.contains(to));
    let is_canonical = record.map.as_ref().is_none_or(|map| map.sources().is_empty());
    let mut parts = Vec::new();
    for quantity in Quantity::ALL {
        let given = record.source(quantity);
        let change = changes.iter().find(|(from, ..)| *from == quantity);
        // A mapping of one motion takes the place of every canonical one.
        let displaced = displaces && motion.contains(&quantity) && present(record, quantity) && is_canonical;
        if given.is_none() && change.is_none() && !displaced {
            continue;
        }
        let (native_column, native_unit) = native(record, quantity);
        let column = given.map_or(native_column, |source| &source.column);
        let written = given.map(|source| source.written.as_str()).filter(|unit| !unit.is_empty());
        let unit = written.unwrap_or(native_unit);
        let (to, unit) = match change {
            Some((_, to, scale)) if scale.starts_with(['*', '/']) => (*to, format!("{unit}{scale}")),
            Some((_, to, unit)) => (*to, (*unit).to_owned()),
            None => (quantity, unit.to_owned()),
        };
        // Turned round twice is as it was.
        parts.push(format!("{to}={column}:{}", unit.replace("*-1*-1", "")));
    }
    parts.extend(record.map.as_ref().and_then(|map| map.only()).map(Only::written));
    format!("--map {}", quoted(&parts.join(",")))
}

/// `--map ...` that reads the log of `record` as it was read but without its angle or its speed.
pub(super) fn without(record: &Record, left_out: Quantity) -> String {
    // A mapping of one motion takes the place of both canonical ones.
    let kept = if left_out == Quantity::Angle { Quantity::Speed } else { Quantity::Angle };
    match &record.map {
        None => {
            let (column, unit) = native(record, kept);
            format!("--map {}", quoted(&format!("{kept}={column}:{unit}")))
        }
        Some(map) => format!("--map {}", quoted(&map.without(left_out).written())),
    }
}

fn present(record: &Record, quantity: Quantity) -> bool {
    match quantity {
        Quantity::Angle => record.angle_rad.is_some(),
        Quantity::Speed => record.speed_rad_s.is_some(),
        _ => true,
    }
}

/// What a quantity is called in the record's own layout, and its unit there: the mapping's unit would take the place of it.
fn native(record: &Record, quantity: Quantity) -> (&'static str, &'static str) {
    let sysid = record.meta.get(TEST_KEY).is_some();
    let unit = record.meta.get(UNIT_KEY);
    match quantity {
        Quantity::Angle if sysid => (
            "position",
            match unit {
                Some("rad") => "rad",
                Some("deg") => "deg",
                Some("m") => "m",
                Some("cm") => "cm",
                Some("mm") => "mm",
                _ => "rev",
            },
        ),
        Quantity::Speed if sysid => (
            "velocity",
            match unit {
                Some("rad") => "rad/s",
                Some("deg") => "deg/s",
                Some("m") => "m/s",
                Some("cm") => "cm/s",
                Some("mm") => "mm/s",
                _ => "rev/s",
            },
        ),
        Quantity::Voltage if sysid => ("voltage", "V"),
        _ => (quantity.canonical().unwrap_or("COLUMN"), quantity.si()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Quantity::{Angle, Duty, Speed, Time, Voltage};

    fn record(map: &str) -> Record {
        let map = (!map.is_empty()).then(|| map.parse().unwrap());
        Record { angle_rad: Some(Vec::new()), speed_rad_s: Some(Vec::new()), map, ..Record::default() }
    }

    #[test]
    fn advice_keeps_the_units_in_which_the_log_was_read() {
        let turned = [(Angle, Angle, "*-1")];
        for (map, advice) in [
            (
                "time=t:ms,duty=pwm:255,angle=enc:counts",
                "--map \"time=t:ms,duty=pwm:255,angle=enc:counts*-1\"",
            ),
            ("angle=pos:deg*-1", "--map angle=pos:deg"),
            ("voltage=1,angle=my pos", "--map \"voltage=1:V,angle=my pos:rad*-1\""),
            ("", "--map \"angle=angle_rad:rad*-1,speed=speed_rad_s:rad/s\""),
        ] {
            assert_eq!(remapped(&record(map), &turned), advice);
        }
        let both = [(Angle, Angle, "*-1"), (Speed, Speed, "*-1")];
        assert_eq!(
            remapped(&record(""), &both),
            "--map \"angle=angle_rad:rad*-1,speed=speed_rad_s:rad/s*-1\""
        );
        assert_eq!(
            remapped(&record("time=t,voltage=u,speed=w"), &[(Voltage, Duty, "100"), (Time, Time, "ms")]),
            "--map time=t:ms,duty=u:100,speed=w:rad/s"
        );
    }

    #[test]
    fn one_of_two_motions_is_left_out_of_a_mapping() {
        let mapped = record("time=t:ms,duty=pwm:255,angle=my pos:deg,speed=w");
        assert_eq!(without(&mapped, Speed), "--map \"time=t:ms,duty=pwm:255,angle=my pos:deg\"");
        assert_eq!(without(&mapped, Angle), "--map time=t:ms,duty=pwm:255,speed=w");
        assert_eq!(without(&record(""), Speed), "--map angle=angle_rad:rad");
    }

    #[test]
    fn the_units_of_a_sysid_log_are_its_own() {
        let mut record = record("");
        record.meta.insert(TEST_KEY, "dynamic-forward").unwrap();
        let both = [(Angle, Angle, "*-1"), (Speed, Speed, "*-1")];
        assert_eq!(remapped(&record, &both), "--map \"angle=position:rev*-1,speed=velocity:rev/s*-1\"");
        record.meta.insert(UNIT_KEY, "rad").unwrap();
        assert_eq!(remapped(&record, &both), "--map \"angle=position:rad*-1,speed=velocity:rad/s*-1\"");
    }
}
