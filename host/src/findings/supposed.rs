//! What an answer supposes that no file tells: the unit of the motion or the voltage of the supply, on which the size of an effect rests.
//!
//! A weight hangs once in a turn of the shaft, and so do cogging and an encoder that is off centre. Where degrees are read as counts, what
//! looks like a weight is a spring, or nothing. A bridge that floats is off for the rest of the duty, which is the voltage over that of the
//! supply: a log in volts does not tell it.

use motorlens_shared::effects::{Kind, Rig, Spec};

use crate::fit::rig::highest_voltage;
use crate::log::guess::{ASSUMED_COUNTS, words};
use crate::log::units::Quantity;
use crate::log::{Record, place_of};
use crate::motor_file::MotorFile;
use crate::report::figure::in_words;
use crate::sentence::listed;

/// What an answer supposes that no file tells.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Supposed {
    /// In sentences with a blank before each, to be said behind a headline; empty where nothing is supposed.
    pub text: String,
    /// The file and the column of the first of them.
    pub place: Option<String>,
}

impl Supposed {
    /// By an answer with `effects` that was found on `records` of a `motor` on `rig`.
    pub fn by(effects: &[Kind], records: &[Record], motor: &MotorFile, rig: &Rig) -> Self {
        Self::by_parts(effects, records, motor, rig, highest_voltage(records))
    }

    /// The same where only parts of the `records` were used, whose highest voltage is `peak_v`.
    pub(crate) fn by_parts<'a>(
        effects: &[Kind],
        records: impl IntoIterator<Item = &'a Record>,
        motor: &MotorFile,
        rig: &Rig,
        peak_v: f64,
    ) -> Self {
        let records: Vec<&Record> = records.into_iter().collect();
        let all = [unit_of_motion(effects, &records), supply(effects, &records, motor, rig, peak_v)];
        let (texts, places): (Vec<String>, Vec<String>) = all.into_iter().flatten().unzip();
        let text = texts.into_iter().map(|text| format!(" {text}.")).collect();
        Self { text, place: places.into_iter().next() }
    }

    /// The sentences by themselves, if there are any.
    pub fn sentences(&self) -> Option<&str> {
        Some(self.text.trim_start()).filter(|text| !text.is_empty())
    }
}

/// The names of those `effects` that have a property; none where none has.
fn resting(effects: &[Kind], property: fn(&Spec) -> bool) -> Option<String> {
    let names: Vec<&str> =
        effects.iter().filter(|kind| property(kind.spec())).map(|kind| kind.name()).collect();
    (!names.is_empty()).then(|| listed(&names))
}

/// What is said, and of which column, of `effects` found on `records` whose angle, or speed where there is none, is in a unit that only a mapping
/// says; none where a header says it too, or where no effect rests on it.
fn unit_of_motion(effects: &[Kind], records: &[&Record]) -> Option<(String, String)> {
    let resting = resting(effects, |spec| spec.periodic)?;
    records.iter().find_map(|record| {
        let map = record.map.as_ref()?;
        let source = map.source(Quantity::Angle).or_else(|| map.source(Quantity::Speed))?;
        let name = &source.column;
        // Any other factor was worked out and not guessed.
        let sign = ["*-1", "/-1"].into_iter().find_map(|sign| source.written.strip_suffix(sign));
        let unit = sign.unwrap_or(&source.written);
        let counts = ASSUMED_COUNTS.to_string();
        let (what, per, once_round) = match unit {
            "" | "rad" | "rad/s" => ("rad", " a second", "6.283"),
            "deg" | "deg/s" => ("degrees", " a second", "360"),
            "rev" | "rev/s" => ("turns", " a second", "1"),
            "rpm" => ("turns", " a minute", "60"),
            "counts" | "counts/s" if record.meta.counts_per_rev() == Some(ASSUMED_COUNTS) => {
                ("counts", " a second", counts.as_str())
            }
            _ => return None,
        };
        let is_told = what != "counts" && words::told(name).is_some_and(|(of, _)| of == source.quantity);
        let (per, changes) = if source.quantity == Quantity::Angle {
            ("", "by which it must change by")
        } else {
            (per, "over which its integral over the time in seconds must come to")
        };
        let of_a_turn = if what == "counts" { format!(" ({counts} a turn)") } else { String::new() };
        (!is_told).then(|| {
            let text = format!(
                "The size of {resting} supposes that \"{name}\" is in {what}{per}{of_a_turn}, which the mapping says and no header does: turn \
                 the shaft once by hand, {changes} {once_round}, and write the unit into the header; in another unit this is another effect, or none"
            );
            (text, place_of(record, name))
        })
    })
}

/// What is said, and of which column, of `effects` that depend on the duty, found on `records` in volts, where the supply on `rig` is only `peak_v`,
/// the highest voltage in them.
fn supply(
    effects: &[Kind],
    records: &[&Record],
    motor: &MotorFile,
    rig: &Rig,
    peak_v: f64,
) -> Option<(String, String)> {
    let resting = resting(effects, |spec| spec.by_duty)?;
    // A name plate below the peak is not what the supply had.
    let on_plate = motor.nameplate.voltage_v.is_some_and(|plate| plate >= peak_v);
    let is_told = on_plate || records.iter().any(|record| record.mean_supply_v().is_some());
    // A model that was fitted before tells a supply of its own, by another figure than that of these records.
    let is_assumed = !is_told && rig.supply_v == peak_v;
    let record = records.first().filter(|_| is_assumed)?;
    let column = record.source(Quantity::Voltage);
    let text = format!(
        "The size of {resting} supposes a supply of {}, the highest voltage of these records, for none of them tells it: give the supply with \
         --supply-volts, or log it beside the voltage; on a higher one that size and the gain are others",
        in_words(rig.supply_v, "V")
    );
    Some((text, place_of(record, column.map_or("voltage_v", |source| source.column.as_str()))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::rig::rig;

    fn record(map: &str) -> Record {
        Record { map: Some(map.parse().unwrap()), ..Record::default() }
    }

    #[test]
    fn what_repeats_with_the_turns_names_the_unit_that_only_the_mapping_says() {
        let said =
            |effects: &[Kind], map: &str| unit_of_motion(effects, &[&record(map)]).map(|(text, _)| text);
        let guessed = "time=t:s,voltage=u:V,angle=position:deg";
        let text = said(&[Kind::Coulomb, Kind::Gravity], guessed).unwrap();
        assert!(
            text.contains("gravity supposes") && text.contains("degrees,") && text.contains("change by 360"),
            "{text}"
        );
        assert_eq!(said(&[Kind::Coulomb], guessed), None);
        assert_eq!(said(&[Kind::Gravity], "time=t:s,voltage=u:V,angle=position_deg:deg"), None);
        assert_eq!(said(&[Kind::Gravity], "time=t:s,voltage=u:V,angle=position:rev/1400"), None);
        let mut counted = record("time=t:s,voltage=u:V,angle=enc:counts");
        counted.meta.insert("counts_per_rev", "1320").unwrap();
        assert!(unit_of_motion(&[Kind::Cogging], &[&counted]).is_some());
        counted.meta.insert("counts_per_rev", "979.6").unwrap();
        assert_eq!(unit_of_motion(&[Kind::Cogging], &[&counted]), None);
        assert_eq!(unit_of_motion(&[Kind::Gravity], &[&Record::default()]), None);
    }

    /// The shaft turns by what a speed adds up to: in another unit it turns more often, or less.
    #[test]
    fn where_only_a_speed_is_read_the_turns_rest_on_its_unit() {
        let said = |map: &str| unit_of_motion(&[Kind::Gravity], &[&record(map)]).map(|(text, _)| text);
        for (unit, in_words, once) in [
            ("rad/s", "in rad a second,", "come to 6.283,"),
            ("rad/s*-1", "in rad a second,", "come to 6.283,"),
            ("deg/s", "in degrees a second,", "come to 360,"),
            ("rev/s", "in turns a second,", "come to 1,"),
            ("rpm", "in turns a minute,", "come to 60,"),
        ] {
            let text = said(&format!("time=t:s,voltage=u:V,speed=2:{unit}")).unwrap();
            assert!(text.contains(in_words) && text.contains(once), "{text}");
        }
        assert_eq!(said("time=t:s,voltage=u:V,speed=speed_rpm:rpm"), None);
        assert_eq!(said("time=t:s,voltage=u:V,angle=theta_deg:deg,speed=2:rpm"), None, "the angle is told");
    }

    #[test]
    fn of_several_files_the_one_is_named_whose_column_is_to_be_looked_at() {
        let of = |path: &str, map: &str| Record { path: path.into(), ..record(map) };
        let told = of("told.csv", "time=t:s,voltage=u:V,angle=position_deg:deg");
        let open = of("logs/open.csv", "time=t:s,voltage=u:V,angle=position:deg");
        let records = [told, open];
        let rig = rig(&records, &MotorFile::default());
        let supposed = |effects: &[Kind]| Supposed::by(effects, &records, &MotorFile::default(), &rig);
        assert_eq!(supposed(&[Kind::Gravity]).place.as_deref(), Some("logs/open.csv, column position"));
        assert_eq!(supposed(&[Kind::Coulomb]), Supposed::default());
    }

    #[test]
    fn what_depends_on_the_duty_names_a_supply_that_nothing_tells() {
        let volts = Record {
            voltage_v: vec![0.0, 6.0],
            time_s: vec![0.0, 0.1],
            ..record("time=t:s,voltage=u:V,speed=w:rpm")
        };
        let said = |effects: &[Kind], record: &Record, motor: &MotorFile| {
            let rig = rig(std::slice::from_ref(record), motor);
            supply(effects, &[record], motor, &rig, 6.0).map(|(text, _)| text)
        };
        let unknown = MotorFile::default();
        let text = said(&[Kind::Coulomb, Kind::Coast], &volts, &unknown).unwrap();
        assert!(text.contains("coast supposes a supply of 6 V") && text.contains("--supply-volts"), "{text}");
        assert_eq!(said(&[Kind::Coulomb], &volts, &unknown), None);
        let mut plate = unknown.clone();
        plate.nameplate.voltage_v = Some(6.0);
        assert_eq!(said(&[Kind::Coast], &volts, &plate), None);
        plate.nameplate.voltage_v = Some(5.0);
        assert!(said(&[Kind::Coast], &volts, &plate).is_some(), "the supply was above the name plate's");
        let logged = Record { supply_v: Some(vec![12.0; 2]), ..volts.clone() };
        assert_eq!(said(&[Kind::Coast], &logged, &unknown), None);
        let mut stated = volts.clone();
        stated.meta.insert("supply_volts", "12").unwrap();
        assert_eq!(said(&[Kind::Coast], &stated, &unknown), None);
        let mut of_model = rig(std::slice::from_ref(&volts), &unknown);
        for of_its_own in [12.0, 5.8] {
            of_model.supply_v = of_its_own;
            assert_eq!(supply(&[Kind::Coast], &[&volts], &unknown, &of_model, 6.0), None);
        }
    }
}
