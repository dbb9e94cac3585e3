//! A list of objects that are columns each: the tests of one file, or one recording that was cut.

use serde_json::{Map, Value};

/// An array in an object of columns is at least so many times as long as the list of such objects, and so long.
const LONGER: usize = 10;
const FEWEST_ROWS: usize = 20;

/// How many rows the columns have that an object of a list of so many holds: two arrays of one length or more, far longer than the list.
/// None where the object is a row itself.
pub(super) fn rows_in(object: &Value, objects: usize) -> Option<usize> {
    let lengths: Vec<usize> =
        object.as_object()?.values().filter_map(Value::as_array).map(Vec::len).collect();
    let alike = |rows: usize| lengths.iter().filter(|length| **length == rows).count();
    let rows = lengths.iter().copied().filter(|rows| alike(*rows) >= 2).max()?;
    (rows >= FEWEST_ROWS.max(LONGER * objects)).then_some(rows)
}

/// From one object of a cut recording to the next its clock goes on by at most so many of its own intervals.
const ONE_STEP: f64 = 1.5;

/// Whether the objects of a list, which have so many rows each, are one recording that was cut: a column rises evenly through them all.
pub(super) fn go_on(list: &[Value], rows: &[usize]) -> bool {
    let names = list.first().and_then(Value::as_object).map(Map::keys);
    names.into_iter().flatten().any(|name| rises_through(list, rows, name))
}

fn rises_through(list: &[Value], rows: &[usize], name: &str) -> bool {
    let (mut last, mut within, mut between) = (None, 0.0_f64, 0.0_f64);
    for (object, rows) in list.iter().zip(rows) {
        let all = object.get(name).and_then(Value::as_array).filter(|all| all.len() == *rows);
        let Some(all) = all else { return false };
        for (row, value) in all.iter().enumerate() {
            let Some(now) = value.as_f64() else { return false };
            let step = last.map(|last: f64| now - last);
            if step.is_some_and(|step| step <= 0.0) {
                return false;
            }
            let longest = if row == 0 { &mut between } else { &mut within };
            *longest = longest.max(step.unwrap_or(0.0));
            last = Some(now);
        }
    }
    between <= ONE_STEP * within
}

/// What may name a test, the plainest first; a longer text says something of it.
const NAMES: [&str; 6] = ["name", "test", "label", "title", "id", "type"];
const LONGEST_NAME: usize = 40;

/// What the record of an object is called: by its own name, or as a test, and by its number in the list, from 1.
pub(super) fn name(object: &Map<String, Value>, index: usize) -> String {
    let is_name =
        |text: &&str| text.len() <= LONGEST_NAME && text.trim_start().starts_with(char::is_alphabetic);
    let own = NAMES.iter().find_map(|key| object.get(*key).and_then(Value::as_str).filter(is_name));
    format!("{} {}", own.unwrap_or("test").trim(), index + 1)
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use crate::log::read_tests::file;
    use crate::log::{ReadOptions, Record, read};

    /// A test of a servo without a clock, whose angle begins at `from`.
    fn servo_test(kind: &str, rows: u32, from: f64) -> Value {
        let column = |of: &dyn Fn(f64) -> f64| (0..rows).map(|k| of(f64::from(k))).collect::<Vec<_>>();
        json!({
            "type": kind, "targets": [], "volts": column(&|k| (0.2 * k).sin()),
            "angle": column(&|k| from + 1.0 - (0.2 * k).cos()),
        })
    }

    fn records(document: &Value, map: &str) -> Vec<Record> {
        let (_directory, path) = file(document.to_string().as_bytes());
        let map = (!map.is_empty()).then(|| map.parse().unwrap());
        read(&path, &ReadOptions { map, rate_hz: Some(50.0), ..ReadOptions::default() }).unwrap()
    }

    #[test]
    fn each_test_of_a_list_is_a_record_of_its_own_with_its_name() {
        let list = json!([
            servo_test("chirp", 150, 0.0),
            servo_test("step", 50, 0.01),
            servo_test("step", 50, -0.01)
        ]);
        for document in [json!({"dataset": "real", "data": list}), list.clone()] {
            let all = records(&document, "voltage=volts:V,angle=angle:rad");
            let names: Vec<&str> = all.iter().map(|record| record.name.as_str()).collect();
            assert_eq!(names, ["run chirp 1", "run step 2", "run step 3"]);
            assert_eq!(all.iter().map(Record::len).collect::<Vec<_>>(), [150, 50, 50]);
            assert!((all[2].angle_rad.as_ref().unwrap()[0] + 0.01).abs() < 1e-12);
            let said = all[0].warnings.iter().find(|warning| warning.what.contains("several_tests")).unwrap();
            assert!(said.what.contains("each is an element of a list"), "{}", said.what);
            let one = records(&document, "voltage=volts:V,angle=angle:rad,only=list_element:step 2");
            assert_eq!((one.len(), one[0].len()), (1, 50));
        }
    }

    #[test]
    fn what_goes_on_from_object_to_object_is_one_record_and_what_pauses_or_starts_anew_is_not() {
        let run = |first: f64| {
            let column = |of: &dyn Fn(f64) -> f64| (0..60).map(|k| of(f64::from(k))).collect::<Vec<_>>();
            json!({
                "time_s": column(&|k| first + 0.01 * k), "voltage_v": column(&|k| (0.2 * k).sin()),
                "speed_rad_s": column(&|k| (0.2 * k).cos()),
            })
        };
        let lengths = |second: f64| {
            let all = records(&json!({"runs": [run(0.0), run(second)]}), "");
            all.iter().map(Record::len).collect::<Vec<_>>()
        };
        assert_eq!(lengths(0.6), [120]);
        assert_eq!(lengths(5.0), [60, 60]);
        assert_eq!(lengths(0.0), [60, 60]);
    }

    #[test]
    fn a_number_that_is_another_in_every_run_of_a_list_is_a_column_of_its_rows() {
        let run = |k: u32, volts: f64| {
            let rows = |of: &dyn Fn(f64) -> f64| (0..60).map(|row| of(f64::from(row))).collect::<Vec<_>>();
            json!({
                "time_s": rows(&|row| 0.6 * f64::from(k) + 0.01 * row), "voltage_v": volts,
                "speed_rad_s": rows(&|row| volts - 3.0 * (-0.1 * row).exp()),
            })
        };
        let text = json!({"runs": [run(0, 3.0), run(1, 6.0)]}).to_string();
        let (_directory, path) = file(text.as_bytes());
        let record = read(&path, &ReadOptions::default()).unwrap().remove(0);
        assert_eq!((record.len(), record.voltage_v[59], record.voltage_v[60]), (120, 3.0, 6.0));
    }
}
