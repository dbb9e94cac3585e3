//! Tables in JSON: one object a line as boards print them, an array of objects, or an object of columns; Python's dictionaries too.
//!
//! What is inside an object is named by its way there (`motor.volts`), the members of an array by their number (`q[0]`).

use std::collections::HashMap;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::Value;

use super::Fault;
use super::python;
use super::table::{Column, Table, Values};

/// More JSON than this is larger than any log of a motor, B.
pub const LARGEST: u64 = 1 << 28;
/// More columns than this are not looked through, nor more numbers than this kept.
const MOST_COLUMNS: usize = 1000;
const MOST_NUMBERS: usize = 1 << 25;

const CSV: &str = "convert it to CSV with a column per quantity, or name its layout with --format";

/// Rows of named values on their way to columns.
#[derive(Default)]
struct Rows {
    places: HashMap<String, usize>,
    columns: Vec<(String, Cells)>,
    rows: usize,
    too_large: bool,
}

/// The values of a column so far; it is shorter than the table where nothing came any more.
enum Cells {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
}

impl Rows {
    /// Takes the object of one row; whatever is no object is none.
    fn take(&mut self, value: &Value) {
        if value.is_object() && !self.too_large {
            self.put("", value);
            self.rows += 1;
            self.too_large |= self.rows.saturating_mul(self.columns.len()) > MOST_NUMBERS;
        }
    }

    /// Takes the array of one row, whose values have these names; whatever is no array is none.
    fn take_array(&mut self, names: &[String], value: &Value) {
        let Some(all) = value.as_array().filter(|_| !self.too_large) else { return };
        for (k, value) in all.iter().enumerate() {
            match names.get(k) {
                Some(name) => self.put(name, value),
                None => self.put(&format!("column{k}"), value),
            }
        }
        self.rows += 1;
        self.too_large |= self.rows.saturating_mul(self.columns.len()) > MOST_NUMBERS;
    }

    fn put(&mut self, name: &str, value: &Value) {
        let below = |key: &str| if name.is_empty() { key.to_owned() } else { format!("{name}.{key}") };
        match value {
            Value::Object(all) => all.iter().for_each(|(key, value)| self.put(&below(key), value)),
            Value::Array(all) => {
                all.iter().enumerate().for_each(|(k, value)| self.put(&format!("{name}[{k}]"), value));
            }
            Value::Null => {}
            Value::Bool(truth) => self.number(name, f64::from(u8::from(*truth))),
            Value::Number(number) => self.number(name, number.as_f64().unwrap_or(f64::NAN)),
            Value::String(text) => match text.trim().parse() {
                Ok(number) => self.number(name, number),
                Err(_) => self.text(name, text),
            },
        }
    }

    fn cells(&mut self, name: &str, new: Cells) -> Option<&mut Cells> {
        let place = match self.places.get(name) {
            Some(place) => *place,
            None if self.columns.len() >= MOST_COLUMNS || self.too_large => return None,
            None => {
                self.columns.push((name.to_owned(), new));
                self.too_large |= self.rows.saturating_mul(self.columns.len()) > MOST_NUMBERS;
                self.places.insert(name.to_owned(), self.columns.len() - 1);
                self.columns.len() - 1
            }
        };
        Some(&mut self.columns[place].1)
    }

    fn number(&mut self, name: &str, number: f64) {
        let row = self.rows;
        if let Some(Cells::Numbers(numbers)) = self.cells(name, Cells::Numbers(Vec::new())) {
            numbers.resize(row, f64::NAN);
            numbers.push(number);
        }
    }

    fn text(&mut self, name: &str, text: &str) {
        let row = self.rows;
        if let Some(Cells::Texts(texts)) = self.cells(name, Cells::Texts(Vec::new())) {
            texts.resize(row, String::new());
            texts.push(text.to_owned());
        }
    }

    fn columns(self) -> Result<Vec<Column>, Fault> {
        if self.too_large {
            return Err(Fault::new("it holds more numbers than any log of a motor", CSV));
        }
        let rows = self.rows;
        let whole = |(name, cells)| {
            let values = match cells {
                Cells::Numbers(mut numbers) => {
                    numbers.resize(rows, f64::NAN);
                    Values::Numbers(numbers)
                }
                Cells::Texts(mut texts) => {
                    texts.resize(rows, String::new());
                    Values::Texts(texts)
                }
            };
            Column { name, values }
        };
        Ok(self.columns.into_iter().map(whole).collect())
    }
}

/// What a document holds: rows, or columns.
#[derive(Default)]
struct Document {
    rows: Rows,
    columns: Vec<Column>,
    /// Names, and rows without names, as pandas writes them apart: `{"columns": [...], "data": [[...], ...]}`.
    names: Vec<String>,
    arrays: Vec<Value>,
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
        let mut next = all.next_element::<Value>()?;
        if next.is_none()
            && let Some(rows) = rows_of_columns(std::slice::from_ref(&first))
        {
            rows.iter().for_each(|row| self.rows.take(row));
            return Ok(());
        }
        self.take(&first);
        while let Some(value) = next {
            self.take(&value);
            next = all.next_element()?;
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

/// An array in an object of columns is at least so many times as long as the list of such objects, and so long.
const LONGER: usize = 10;
const FEWEST_ROWS: usize = 20;

/// The rows of a list of objects that are columns each: two arrays of one length or more, far longer than the list. None where the objects
/// are rows themselves.
fn rows_of_columns(list: &[Value]) -> Option<Vec<Value>> {
    let mut rows = Vec::new();
    for object in list {
        let object = object.as_object()?;
        let arrays = || object.iter().filter_map(|(name, value)| Some((name, value.as_array()?)));
        let alike = |length: usize| arrays().filter(|(_, all)| all.len() == length).count();
        let length = arrays().map(|(_, all)| all.len()).filter(|length| alike(*length) >= 2).max()?;
        if length < FEWEST_ROWS.max(LONGER * list.len()) {
            return None;
        }
        rows.extend((0..length).map(|k| {
            let columns = arrays().filter(|(_, all)| all.len() == length);
            Value::Object(columns.map(|(name, all)| (name.clone(), all[k].clone())).collect())
        }));
    }
    Some(rows)
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

    /// Takes an entry of the outermost object: a column, or the rows themselves.
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
                let unfolded = rows_of_columns(all);
                unfolded.as_ref().unwrap_or(all).iter().for_each(|row| self.rows.take(row));
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
                for (key, value) in all.iter().filter(|(_, value)| value.is_array()) {
                    self.put(format!("{name}.{key}"), value);
                }
            }
            _ => {}
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
    let (mut lines, mut bad) = (Rows::default(), 0);
    for line in bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty()) {
        match serde_json::from_slice(line) {
            Ok(value @ Value::Object(_)) => lines.take(&value),
            _ => bad += 1,
        }
        // Half a first line and a remark are none of the log; a document over many lines is.
        if bad > 2 + lines.rows {
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
    let Document { mut rows, mut columns, names, arrays } = document;
    arrays.iter().for_each(|row| rows.take_array(&names, row));
    columns.extend(rows.columns()?);
    Table::of(columns, Vec::new()).map_err(|_| Fault::new("this is JSON, not a table", CSV))
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
}
