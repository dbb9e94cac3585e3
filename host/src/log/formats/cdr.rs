//! ROS 2 messages: the layout as `.msg` files tell it, and values in CDR, the common data representation of DDS.
//!
//! Numbers stand at multiples of their own size from the beginning, sequences and texts behind their length.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use super::Fault;
use super::bytes::Bytes;

/// Messages within messages are followed so far.
const DEEPEST: usize = 8;
/// Longer arrays are pictures and clouds, no signals.
const LONGEST_ARRAY: usize = 256;

/// How many values a field has.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Count {
    One,
    Fixed(usize),
    Any,
}

#[derive(Debug, Clone, PartialEq)]
struct Field {
    name: String,
    kind: String,
    count: Count,
}

/// The layout of a message and of those within it.
#[derive(Debug, Clone, PartialEq)]
pub struct Schema {
    root: String,
    types: BTreeMap<String, Vec<Field>>,
}

impl Schema {
    /// Understands a `.msg` file with those that it uses behind rows of `=`.
    pub fn parse(name: &str, text: &str) -> Schema {
        let mut types: BTreeMap<String, Vec<Field>> = BTreeMap::new();
        let root = short(name);
        let mut current = root.clone();
        types.insert(root.clone(), Vec::new());
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if let Some(name) = line.strip_prefix("MSG:") {
                current = short(name.trim());
                types.insert(current.clone(), Vec::new());
            } else if let Some(field) = field(line) {
                types.entry(current.clone()).or_default().push(field);
            }
        }
        // Not every writer spells these out.
        let whole =
            |kind: &str, name: &str| Field { name: name.into(), kind: kind.into(), count: Count::One };
        for (name, seconds) in [("Time", "int32"), ("Duration", "int32")] {
            types
                .entry(format!("builtin_interfaces/{name}"))
                .or_insert_with(|| vec![whole(seconds, "sec"), whole("uint32", "nanosec")]);
        }
        Schema { root, types }
    }

    /// The values of a message; arrays that are too long for signals are null.
    ///
    /// # Errors
    /// A fault where the bytes are of another layout.
    pub fn decode(&self, all: &[u8]) -> Result<Value, Fault> {
        let mut head = Bytes::new(all);
        let head = head.take(4)?;
        let other = || Fault::new("this encoding of ROS 2 messages is not read", "record with CDR");
        let big = match head[1] {
            0 => true,
            1 => false,
            _ => return Err(other()),
        };
        self.message(&self.root, &mut Bytes::new(&all[4..]).big_endian(big), 0)
    }

    fn message(&self, kind: &str, bytes: &mut Bytes<'_>, depth: usize) -> Result<Value, Fault> {
        let unknown =
            || Fault::new(format!("the layout of {kind} is not in the file"), "record it with its schemas");
        // A package's messages name each other without it: `MultiArrayLayout` in std_msgs/Float64MultiArray.
        let without_package = || {
            self.types
                .iter()
                .find(|(name, _)| name.rsplit('/').next() == Some(kind))
                .map(|(_, fields)| fields)
        };
        let fields = self.types.get(kind).or_else(without_package);
        let fields = fields.filter(|_| depth < DEEPEST).ok_or_else(unknown)?;
        let mut values = Map::new();
        for field in fields {
            let count = match field.count {
                Count::One => {
                    values.insert(field.name.clone(), self.value(&field.kind, bytes, depth)?);
                    continue;
                }
                Count::Fixed(count) => count,
                Count::Any => {
                    bytes.align(4);
                    bytes.u32()? as usize
                }
            };
            // Every element has a byte at least.
            if count > bytes.left() {
                return Err(Fault::broken(bytes.at() as u64, &format!("where {count} values should follow")));
            }
            let mut array = Vec::new();
            for _ in 0..count {
                let value = self.value(&field.kind, bytes, depth)?;
                if count <= LONGEST_ARRAY {
                    array.push(value);
                }
            }
            let array = if count <= LONGEST_ARRAY { Value::Array(array) } else { Value::Null };
            values.insert(field.name.clone(), array);
        }
        Ok(Value::Object(values))
    }

    fn value(&self, kind: &str, bytes: &mut Bytes<'_>, depth: usize) -> Result<Value, Fault> {
        bytes.align(match kind {
            "int16" | "uint16" => 2,
            "int32" | "uint32" | "float32" | "string" => 4,
            "int64" | "uint64" | "float64" => 8,
            _ => 1,
        });
        let number = match kind {
            "bool" | "uint8" | "byte" | "char" => f64::from(bytes.u8()?),
            "int8" => f64::from(bytes.i8()?),
            "int16" => f64::from(bytes.i16()?),
            "uint16" => f64::from(bytes.u16()?),
            "int32" => return Ok(bytes.i32()?.into()),
            "uint32" => return Ok(bytes.u32()?.into()),
            "int64" => return Ok(bytes.i64()?.into()),
            "uint64" => return Ok(bytes.u64()?.into()),
            "float32" => f64::from(bytes.f32()?),
            "float64" => bytes.f64()?,
            "string" => {
                let text = bytes.text()?;
                return Ok(Value::String(text.trim_end_matches('\0').to_owned()));
            }
            other => return self.message(other, bytes, depth + 1),
        };
        Ok(number.into())
    }
}

/// `sensor_msgs/msg/JointState` as `.msg` files name it.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// A line such as `float64[<=3] position 0`; none where it is blank, a rule or a constant.
fn field(line: &str) -> Option<Field> {
    let mut words = line.split_whitespace();
    let (kind, name) = (words.next()?, words.next()?);
    if line.starts_with('=') || name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
        return None;
    }
    let (kind, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((kind, size)) => {
            let size = size.trim_end_matches(']');
            (kind, size.parse().map_or(Count::Any, Count::Fixed))
        }
    };
    let kind = match kind.split_once("<=").map_or(kind, |(kind, _)| kind) {
        "Header" => "std_msgs/Header".to_owned(),
        "time" => "builtin_interfaces/Time".to_owned(),
        "duration" => "builtin_interfaces/Duration".to_owned(),
        kind => short(kind),
    };
    Some(Field { name: name.to_owned(), kind, count })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_at_multiples_of_their_size_and_constants_are_no_fields() {
        let text = "uint8 MODE=3\nuint8 mode # how\nfloat64[] q\nmy/Inner inner\n====\nMSG: my/Inner\nint16[2] n\nstring s";
        let schema = Schema::parse("my/msg/Outer", text);
        let mut bytes = vec![0, 1, 0, 0];
        bytes.extend([7, 0, 0, 0, 1, 0, 0, 0]);
        bytes.extend(2.5f64.to_le_bytes());
        bytes.extend([1, 0, 255, 255, 3, 0, 0, 0, b'o', b'k', 0]);
        let value = schema.decode(&bytes).unwrap();
        let expected = serde_json::json!({"mode": 7.0, "q": [2.5], "inner": {"n": [1.0, -1.0], "s": "ok"}});
        assert_eq!(value, expected);
        for end in 0..bytes.len() {
            assert!(schema.decode(&bytes[..end]).is_err());
        }
        // Within a package it may be named without it.
        let shorter = Schema::parse("my/msg/Outer", &text.replace("my/Inner inner", "Inner inner"));
        assert_eq!(shorter.decode(&bytes).unwrap(), expected);
    }
}
