//! Tables in JSON: one object a line as boards print them, an array of objects, or an object of columns; Python's dictionaries too.
//!
//! What is inside an object is named by its way there (`motor.volts`), the members of an array by their number (`q[0]`).

mod rows;
mod runs;

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::Value;

use super::Fault;
use super::python;
use super::table::{Column, Table, Values};
use crate::log::several::ELEMENT;
use rows::Rows;

/// More JSON than this is larger than any log of a motor, B.
pub const LARGEST: u64 = 1 << 28;
/// More columns than this are not looked through, nor more numbers than this kept.
const MOST_COLUMNS: usize = 1000;
const MOST_NUMBERS: usize = 1 << 25;

const CSV: &str = "convert it to CSV with a column per quantity, or name its layout with --format";

/// What a document holds: rows, or columns.
#[derive(Default)]
struct Document {
    rows: Rows,
    columns: Vec<Column>,
    /// Numbers beside them.
    numbers: Vec<Column>,
    /// Names, and rows without names, as pandas writes them apart: `{"columns": [...], "data": [[...], ...]}`.
    names: Vec<String>,
    arrays: Vec<Value>,
    /// What is none of these, for messages.
    left_out: Vec<String>,
}

impl<'de> DeserializeSeed<'de> for &mut Document {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for &mut Document {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array of objects, or an object of arrays")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut all: A) -> Result<(), A::Error> {
        let Some(first) = all.next_element::<Value>()? else { return Ok(()) };
        if runs::rows_in(&first, 1).is_some() {
            let mut list = vec![first];
            while let Some(value) = all.next_element()? {
                list.push(value);
            }
            if !self.take_runs(&list) {
                list.iter().for_each(|row| self.take(row));
            }
            return Ok(());
        }
        self.take(&first);
        while let Some(value) = all.next_element::<Value>()? {
            self.take(&value);
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut all: A) -> Result<(), A::Error> {
        while let Some((name, value)) = all.next_entry::<String, Value>()? {
            self.put(name, &value);
        }
        Ok(())
    }
}

impl Document {
    /// Takes a row.
    fn take(&mut self, value: &Value) {
        if value.is_array() {
            self.rows.take_array(&[], value);
        } else {
            self.rows.take(value);
        }
    }

    /// Takes a list of objects that are columns each, one below the other; false where they are rows themselves. A number beside the columns
    /// of the only object is one of the table; one that differs between several is one of each of their rows. Each of several is a record of its
    /// own, but where one recording was cut for the list.
    fn take_runs(&mut self, list: &[Value]) -> bool {
        let rows: Option<Vec<usize>> = list.iter().map(|object| runs::rows_in(object, list.len())).collect();
        let Some(rows) = rows else { return false };
        let are_apart = list.len() > 1 && !runs::go_on(list, &rows);
        for (run, (object, rows)) in list.iter().filter_map(Value::as_object).zip(rows).enumerate() {
            for (name, value) in object {
                match value {
                    Value::Array(all) if all.len() == rows => self.rows.put_column(name, all.iter()),
                    Value::Number(_) if list.iter().any(|other| other.get(name) != Some(value)) => {
                        self.rows.put_column(name, std::iter::repeat_n(value, rows));
                    }
                    _ if run > 0 => {}
                    // Between the rows of several there is no interval that one number could tell.
                    Value::Number(_) if list.len() == 1 => self.put(name.clone(), value),
                    _ => self.left_out.push(name.clone()),
                }
            }
            if are_apart {
                let name = Value::String(runs::name(object, run));
                self.rows.put_column(ELEMENT, std::iter::repeat_n(&name, rows));
            }
            self.rows.count(rows);
        }
        true
    }

    /// Takes an entry of the outermost object: a column, a number beside the columns, or the rows themselves.
    fn put(&mut self, name: String, value: &Value) {
        match value {
            // What pandas tells of the columns of the rows beside.
            Value::Object(all) if name == "schema" && all.contains_key("fields") => {}
            Value::Array(all) if name == "columns" && all.iter().all(Value::is_string) => {
                self.names = all.iter().filter_map(Value::as_str).map(str::to_owned).collect();
            }
            Value::Array(all) if name == "data" && !all.is_empty() && all.iter().all(Value::is_array) => {
                self.arrays.clone_from(all);
            }
            Value::Array(all) if all.iter().any(Value::is_object) => {
                if !self.take_runs(all) {
                    all.iter().for_each(|row| self.rows.take(row));
                }
            }
            Value::Number(number) if self.numbers.len() < MOST_COLUMNS => {
                let values = Values::Numbers(vec![number.as_f64().unwrap_or(f64::NAN)]);
                self.numbers.push(Column { name, values });
            }
            Value::Array(all) if self.columns.len() < MOST_COLUMNS => {
                let number =
                    |value: &Value| value.as_f64().or(value.as_bool().map(|t| f64::from(u8::from(t))));
                let values = if all.iter().any(Value::is_string) {
                    let text =
                        |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                    Values::Texts(all.iter().map(text).collect())
                } else {
                    Values::Numbers(all.iter().map(|value| number(value).unwrap_or(f64::NAN)).collect())
                };
                self.columns.push(Column { name, values });
            }
            Value::Object(all) if !all.is_empty() && all.keys().all(|key| key.parse::<u64>().is_ok()) => {
                // A column as pandas writes it: the number of each row, and its value.
                let mut rows: Vec<(u64, &Value)> =
                    all.iter().map(|(key, value)| (key.parse().unwrap_or_default(), value)).collect();
                rows.sort_by_key(|(number, _)| *number);
                self.put(name, &Value::Array(rows.into_iter().map(|(_, value)| value.clone()).collect()));
            }
            Value::Object(all) => {
                for (key, value) in all {
                    let name = format!("{name}.{key}");
                    match value {
                        Value::Array(_) | Value::Number(_) => self.put(name, value),
                        _ => self.left_out.push(name),
                    }
                }
            }
            _ => self.left_out.push(name),
        }
    }
}

/// Reads the table of a JSON file.
///
/// # Errors
/// A fault where it is no JSON, or holds no table.
pub fn read(bytes: &[u8]) -> Result<Table, Fault> {
    let from_python = python::is(bytes).then(|| python::as_json(&String::from_utf8_lossy(bytes)));
    let bytes = from_python.as_ref().map_or(bytes, String::as_bytes);
    let (mut lines, mut first, mut bad) = (Rows::default(), None, 0);
    for line in bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty()) {
        match serde_json::from_slice(line) {
            // One object alone is a document, whose arrays are no cells of a row.
            Ok(value @ Value::Object(_)) if lines.rows == 0 && first.is_none() => first = Some(value),
            Ok(value @ Value::Object(_)) => {
                first.take().iter().for_each(|row| lines.take(row));
                lines.take(&value);
            }
            _ => bad += 1,
        }
        // Half a first line and a remark are none of the log; a document over many lines is.
        if bad > 2 + lines.rows + usize::from(first.is_some()) {
            break;
        }
    }
    if lines.rows >= 2 {
        return Table::of(lines.columns()?, Vec::new());
    }
    let mut document = Document::default();
    let mut parser = serde_json::Deserializer::from_slice(bytes);
    (&mut document).deserialize(&mut parser).and_then(|()| parser.end()).map_err(|error| {
        Fault::new(
            format!("this is not JSON: {error}"),
            "check that the file was copied in full and is complete",
        )
    })?;
    let Document { mut rows, mut columns, numbers, names, arrays, left_out } = document;
    arrays.iter().for_each(|row| rows.take_array(&names, row));
    columns.extend(rows.columns()?);
    columns.extend(numbers);
    Table::of(columns, left_out).map_err(|_| Fault::new("this is JSON, not a table", CSV))
}

#[cfg(test)]
mod tests {
    use crate::log::read_tests::file;
    use crate::log::{ReadOptions, read};

    fn row(k: u32) -> serde_json::Value {
        let t = 0.01 * f64::from(k);
        serde_json::json!({"t": t, "motor": {"u": (7.0 * t).sin(), "on": true}, "q": [0.5 * t, 1.0 - (7.0 * t).cos()]})
    }

    #[test]
    fn objects_by_line_in_an_array_and_columns_in_an_object_are_tables() {
        let rows: Vec<_> = (0..200).map(row).collect();
        let lines: String = rows.iter().map(|row| format!("{row}\n")).collect();
        let column = |of: &dyn Fn(&serde_json::Value) -> f64| rows.iter().map(of).collect::<Vec<_>>();
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let columns = serde_json::json!({
            "rate": 100, "t": column(&|row| number(&row["t"])), "motor": {"u": column(&|row| number(&row["motor"]["u"]))},
            "q[1]": column(&|row| number(&row["q"][1])),
        });
        let one_run = serde_json::json!({
            "kind": "run", "t": column(&|row| number(&row["t"])), "motor.u": column(&|row| number(&row["motor"]["u"])),
            "q[1]": column(&|row| number(&row["q"][1])), "labels": ["a", "b"],
        });
        // As pandas writes a table: `{"t": {"0": 0.0, "1": 0.01, ...}, ...}`.
        let numbered = |all: Vec<f64>| {
            let of = |(k, x): (usize, f64)| (k.to_string(), x.into());
            serde_json::Value::Object(all.into_iter().enumerate().map(of).collect())
        };
        let pandas = serde_json::json!({
            "t": numbered(column(&|row| number(&row["t"]))),
            "motor.u": numbered(column(&|row| number(&row["motor"]["u"]))),
            "q[1]": numbered(column(&|row| number(&row["q"][1]))),
        });
        let flat = |row: &serde_json::Value| serde_json::json!([row["t"], row["motor"]["u"], row["q"][1]]);
        let split = serde_json::json!({
            "columns": ["t", "motor.u", "q[1]"], "index": (0..200).collect::<Vec<_>>(),
            "data": rows.iter().map(flat).collect::<Vec<_>>(),
        });
        let fields =
            serde_json::json!([{"name": "index", "type": "integer"}, {"name": "t", "type": "number"}]);
        let table =
            serde_json::json!({"schema": {"fields": fields, "pandas_version": "1.4.0"}, "data": rows});
        let map = "time=t,voltage=motor.u,angle=q[1]";
        let options = ReadOptions { map: Some(map.parse().unwrap()), ..ReadOptions::default() };
        for (what, text) in [
            ("lines", lines.clone()),
            ("lines with noise", format!("{{\"boot\": 1\nready\n{lines}")),
            ("array", serde_json::to_string_pretty(&rows).unwrap()),
            ("array in an object", serde_json::json!({"name": "run", "data": rows}).to_string()),
            ("columns", columns.to_string()),
            ("columns in a list", serde_json::json!({"limits": [-1, 1], "data": [one_run]}).to_string()),
            ("nothing but that list", serde_json::json!([one_run]).to_string()),
            ("columns by row", pandas.to_string()),
            ("columns and rows apart", split.to_string()),
            ("rows with what they are", table.to_string()),
            ("what Python prints", lines.replace('"', "'").replace("true", "True")),
        ] {
            let (_directory, path) = file(text.as_bytes());
            let record = read(&path, &options).unwrap_or_else(|error| panic!("{what}: {error}")).remove(0);
            assert_eq!(record.len(), 200, "{what}");
            assert!((record.voltage_v[30] - 2.1_f64.sin()).abs() < 1e-12, "{what}");
            assert!((record.angle_rad.as_ref().unwrap()[30] - 1.0 + 2.1_f64.cos()).abs() < 1e-12, "{what}");
        }
        let (_directory, path) = file(lines.as_bytes());
        let refused = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("motor.u") && refused.contains("--map"), "{refused}");
    }

    #[test]
    fn numbers_beside_the_columns_tell_the_time_or_are_named_and_texts_are_named() {
        let columns = |of: &dyn Fn(u32) -> f64| (0..200).map(of).collect::<Vec<_>>();
        let run = |volts: f64| {
            serde_json::json!({
                "dt": 0.01, "inertia": 0.2, "operator": "Ada", "volts": volts,
                "u": columns(&|k| f64::from(k).sin()), "x": columns(&|k| f64::from(k).cos()),
            })
        };
        let map = |map: &str| ReadOptions { map: Some(map.parse().unwrap()), ..ReadOptions::default() };
        let nested =
            serde_json::json!({"about": {"dt": 0.01}, "motor": {"u": run(6.0)["u"], "x": run(6.0)["x"]}});
        for (document, names) in [
            (run(6.0), "voltage=u,angle=x"),
            (serde_json::json!([run(6.0)]), "voltage=u,angle=x"),
            (nested, "voltage=motor.u,angle=motor.x"),
        ] {
            let (_directory, path) = file(document.to_string().as_bytes());
            let record = read(&path, &map(names)).unwrap().remove(0);
            assert!((record.time_s[100] - 1.0).abs() < 1e-9);
            assert!(record.warnings.iter().any(|warning| warning.what.contains("dt = 0.01 makes 100 rows")));
        }
        let (_directory, path) = file(run(6.0).to_string().as_bytes());
        let refused = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("inertia (one value)") && refused.contains("operator"), "{refused}");
    }
}
