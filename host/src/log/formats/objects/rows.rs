//! Rows of named values, as JSON has them, on their way to columns.

use std::collections::HashMap;

use serde_json::Value;

use super::super::Fault;
use super::super::table::{Column, Values};
use super::{CSV, MOST_COLUMNS, MOST_NUMBERS};

/// Rows of named values on their way to columns.
#[derive(Default)]
pub struct Rows {
    places: HashMap<String, usize>,
    columns: Vec<(String, Cells)>,
    /// How many there are.
    pub rows: usize,
    too_large: bool,
}

/// The values of a column so far; it is shorter than the table where nothing came any more.
enum Cells {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
}

impl Rows {
    /// Takes the object of one row; whatever is no object is none.
    pub fn take(&mut self, value: &Value) {
        if value.is_object() && !self.too_large {
            self.put("", value);
            self.count(1);
        }
    }

    /// Takes the array of one row, whose values have these names; whatever is no array is none.
    pub fn take_array(&mut self, names: &[String], value: &Value) {
        let Some(all) = value.as_array().filter(|_| !self.too_large) else { return };
        for (k, value) in all.iter().enumerate() {
            match names.get(k) {
                Some(name) => self.put(name, value),
                None => self.put(&format!("column{k}"), value),
            }
        }
        self.count(1);
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

    /// Takes values one below the other, from the next row on; the rows are counted by whoever takes all of their columns.
    pub fn put_column<'v>(&mut self, name: &str, values: impl Iterator<Item = &'v Value>) {
        let first = self.rows;
        for value in values {
            if self.too_large {
                break;
            }
            self.put(name, value);
            self.count(1);
        }
        self.rows = first;
    }

    /// Counts rows whose values were put.
    pub fn count(&mut self, rows: usize) {
        self.rows += rows;
        self.too_large |= self.rows.saturating_mul(self.columns.len()) > MOST_NUMBERS;
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

    /// The columns, as long as there are rows.
    ///
    /// # Errors
    /// A fault where they are too many numbers.
    pub fn columns(self) -> Result<Vec<Column>, Fault> {
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
