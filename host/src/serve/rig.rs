//! What the fields of the mapping dialogue say of the rig: how a file is read with them, and what they tell of its motor.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::field::Field;
use super::fields::FIELDS;
use crate::error::{Error, Result};
use crate::log::ReadOptions;
use crate::log::mapping::Mapping;
use crate::motor_file::MotorFile;

/// What stands in the fields of the dialogue, by their names; a field that is not there is empty.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Rig(BTreeMap<String, String>);

impl Rig {
    /// What `options` say, and where they say nothing of the motor what is known of it.
    pub fn of(options: &ReadOptions, motor: &MotorFile) -> Self {
        let known = ReadOptions { motor: motor.clone(), ..ReadOptions::default() };
        let said = |field: &Field| {
            let text = field.said(options).or_else(|| field.said(&known))?;
            Some((field.name.to_owned(), text))
        };
        Self(FIELDS.iter().filter_map(said).collect())
    }

    /// These fields with these texts.
    #[cfg(test)]
    pub fn with(texts: &[(&str, &str)]) -> Self {
        Self(texts.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect())
    }

    /// `options` that say what stands in the fields.
    fn said_by(&self, mut options: ReadOptions) -> Result<ReadOptions> {
        for field in &FIELDS {
            field.say(&mut options, self.0.get(field.name).map_or("", String::as_str))?;
        }
        Ok(options)
    }

    /// What is known of the motor: `before`, but for what the fields say.
    pub fn motor(&self, before: MotorFile) -> Result<MotorFile> {
        Ok(self.said_by(ReadOptions { motor: before, ..ReadOptions::default() })?.motor)
    }

    /// How a file is read with the columns of `map`, empty for canonical ones: `before`, but for what map and fields say.
    pub fn options(&self, map: &str, before: ReadOptions) -> Result<ReadOptions> {
        let map = if map.is_empty() { None } else { Some(map.parse()) };
        let map: Option<Mapping> =
            map.transpose().map_err(|why: String| Error::usage(why, "choose the columns again"))?;
        self.said_by(ReadOptions { map, ..before })
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::log::Hold;

    #[test]
    fn a_field_that_is_no_positive_number_is_named() {
        let rig = Rig::with(&[("gear_ratio", "-3")]);
        let refused = rig.motor(MotorFile::default()).unwrap_err().to_string();
        assert!(refused.contains("\"Gear ratio\" is \"-3\""), "{refused}");
        assert_eq!(Rig::default().motor(MotorFile::default()).unwrap(), MotorFile::default());
    }

    #[test]
    fn the_rows_of_one_motor_are_chosen_beside_the_columns_and_left_where_the_field_is_emptied() {
        let rig = Rig::with(&[("only", "id:3")]);
        for (map, written) in [("", "only=id:3"), ("time=t,speed=w:rpm", "time=t,speed=w:rpm,only=id:3")] {
            let options = rig.options(map, ReadOptions::default()).unwrap();
            assert_eq!(options.map.as_ref().unwrap().written(), written);
            assert_eq!(Rig::of(&options, &MotorFile::default()), rig);
            assert_eq!(Rig::default().options("", options).unwrap().map, None);
        }
    }

    #[test]
    fn what_is_shown_of_a_file_reads_it_the_same_way() {
        let rig = Rig::with(&[
            ("supply_volts", "11.1"),
            ("voltage_lead", "0.008"),
            ("hold", "first"),
            ("servo_damping", "0"),
            ("gear_ratio", "50"),
        ]);
        let map = "time=0:ms,duty=1:255,angle=2:counts";
        let options = rig.options(map, ReadOptions::default()).unwrap();
        assert_eq!((options.voltage_lead_s, options.hold), (Some(0.008), Some(Hold::First)));
        let shown = Rig::of(&options, &MotorFile::default());
        assert_eq!(shown, rig);
        assert_eq!(shown.options(map, ReadOptions::default()).unwrap(), options);
        // What is only known of the motor is shown too, and what the file says of it goes before.
        let known = MotorFile { gear_ratio: Some(30.0), ..MotorFile::default() };
        let known = MotorFile { counts_per_rev: Some(1320.0), ..known };
        let shown = json!(Rig::of(&options, &known));
        assert_eq!((&shown["gear_ratio"], &shown["counts_per_rev"]), (&json!("50"), &json!("1320")));
        assert!(shown.get("rate").is_none());
    }
}
