//! MCAP, the container of ROS 2 and Foxglove: channels of JSON and of ROS 2 messages, each number as `topic/field`.
//!
//! A file is a row of records, each with its kind and length; chunks are records of which the data are packed records again (MCAP
//! specification at mcap.dev). A message with a header counts from the stamp in it, where that is near the time of logging.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;

use serde_json::Value;

use super::bytes::Bytes;
use super::cdr::Schema;
use super::events::{Events, Series};
use super::{Content, Fault, LARGEST};
use crate::log::structure;

/// Kinds of records.
const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const DATA_END: u8 = 15;
/// Elements of an array beyond these are no signals.
const MOST_ELEMENTS: usize = 64;
/// More signals than this are not followed.
const MOST_SERIES: usize = 5000;
/// A stamp further from the time of logging is of another clock, s.
const NEAR_S: f64 = 1.0;

/// How the messages of a channel are written.
enum Kind {
    Json,
    Cdr(u16),
    Other,
}

struct Channel {
    topic: String,
    kind: Kind,
}

#[derive(Default)]
struct File {
    schemas: BTreeMap<u16, Schema>,
    channels: BTreeMap<u16, Channel>,
    series: BTreeMap<String, Series>,
    left_out: BTreeSet<String>,
    /// Time of the first message, ns.
    begin: Option<u64>,
}

/// Reads all messages. A file without its end, as of a recorder that was switched off, is read up to there.
///
/// # Errors
/// A fault where a record is damaged or no channel is of a kind that is read.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let mut bytes = Bytes::new(all);
    bytes.take(8)?;
    let mut file = File::default();
    file.records(&mut bytes, true)?;
    if file.series.is_empty() {
        let inside: Vec<String> = file.left_out.into_iter().take(12).collect();
        let inside = if inside.is_empty() { "no message".to_owned() } else { inside.join(", ") };
        return Err(Fault::new(
            format!("of its channels none has numbers in JSON or ROS 2 messages; it holds {inside}"),
            "open it in PlotJuggler or Foxglove and export the signals as CSV",
        ));
    }
    Ok(Content::Events(Events::new(file.series, file.left_out)))
}

impl File {
    fn records(&mut self, bytes: &mut Bytes<'_>, outer: bool) -> Result<(), Fault> {
        while bytes.left() > 0 {
            let at = bytes.at() as u64;
            let record = (|| {
                let kind = bytes.u8()?;
                let length = bytes.u64()?;
                Ok((kind, bytes.take(usize::try_from(length).unwrap_or(usize::MAX))?))
            })();
            let (kind, data) = match record {
                Ok(record) => record,
                Err(_) if outer && !self.series.is_empty() => return Ok(()),
                Err(fault) => return Err(fault),
            };
            let mut data = Bytes::new(data);
            let done: Result<(), Fault> = match kind {
                SCHEMA => self.schema(&mut data),
                CHANNEL => self.channel(&mut data),
                MESSAGE => self.message(&mut data),
                CHUNK if outer => self.chunk(&mut data),
                DATA_END => return Ok(()),
                _ => Ok(()),
            };
            done.map_err(|fault| {
                Fault::new(format!("in the record at byte {at}: {}", fault.why), fault.remedy)
            })?;
        }
        Ok(())
    }

    fn chunk(&mut self, bytes: &mut Bytes<'_>) -> Result<(), Fault> {
        bytes.take(16)?;
        let size = bytes.u64()?;
        bytes.u32()?;
        let packing = bytes.text()?;
        let length = bytes.u64()?;
        let data = bytes.take(usize::try_from(length).unwrap_or(usize::MAX))?;
        if size > LARGEST {
            return Err(Fault::new("a chunk of more than 1 GiB is damaged", "copy the file again"));
        }
        let mut unpacked = Vec::new();
        let read = match packing.as_str() {
            "" => return self.records(&mut Bytes::new(data), false),
            "lz4" => lz4_flex::frame::FrameDecoder::new(data).take(size).read_to_end(&mut unpacked),
            "zstd" => zstd::stream::read::Decoder::new(data)
                .and_then(|decoder| decoder.take(size).read_to_end(&mut unpacked)),
            other => {
                let why = format!("its chunks are packed with {other}, which is not read");
                return Err(Fault::new(why, "pack it anew: mcap compress OLD -o NEW.mcap"));
            }
        };
        read.map_err(|why| {
            Fault::new(format!("a chunk is damaged: {why}"), "run mcap recover OLD -o NEW.mcap")
        })?;
        self.records(&mut Bytes::new(&unpacked), false)
    }

    fn schema(&mut self, bytes: &mut Bytes<'_>) -> Result<(), Fault> {
        let id = bytes.u16()?;
        let name = bytes.text()?;
        let encoding = bytes.text()?;
        let text = bytes.text()?;
        if encoding == "ros2msg" {
            self.schemas.insert(id, Schema::parse(&name, &text));
        }
        Ok(())
    }

    fn channel(&mut self, bytes: &mut Bytes<'_>) -> Result<(), Fault> {
        let (id, schema) = (bytes.u16()?, bytes.u16()?);
        let (topic, encoding) = (bytes.text()?, bytes.text()?);
        let kind = match encoding.as_str() {
            "json" => Kind::Json,
            "cdr" if self.schemas.contains_key(&schema) => Kind::Cdr(schema),
            _ => {
                self.left_out.insert(format!("{topic} ({encoding})"));
                Kind::Other
            }
        };
        self.channels.insert(id, Channel { topic, kind });
        Ok(())
    }

    fn message(&mut self, bytes: &mut Bytes<'_>) -> Result<(), Fault> {
        let id = bytes.u16()?;
        bytes.u32()?;
        let logged = bytes.u64()?;
        bytes.u64()?;
        let data = bytes.take(bytes.left())?;
        let Some(channel) = self.channels.get(&id) else { return Ok(()) };
        let message = match &channel.kind {
            Kind::Json => serde_json::from_slice(data).ok(),
            Kind::Cdr(schema) => self.schemas.get(schema).and_then(|schema| schema.decode(data).ok()),
            Kind::Other => return Ok(()),
        };
        let topic = channel.topic.clone();
        let Some(message) = message else {
            self.left_out.insert(format!("{topic} (messages that are damaged or of another layout)"));
            return Ok(());
        };
        let begin = *self.begin.get_or_insert(logged);
        let since = |time: u64| (i128::from(time) - i128::from(begin)) as f64 * 1e-9;
        let logged = since(logged);
        let stamped = stamp(&message).map(since).filter(|stamp| (stamp - logged).abs() < NEAR_S);
        self.take(&topic, &message, None, stamped.unwrap_or(logged), 0);
        Ok(())
    }

    /// Takes the numbers in a value; `names` are those of the elements of arrays beside it, as joints have.
    fn take(&mut self, path: &str, value: &Value, names: Option<&[Value]>, time_s: f64, depth: usize) {
        if depth > 8 {
            return;
        }
        match value {
            Value::Number(number) => self.number(path, time_s, number.as_f64().unwrap_or(f64::NAN)),
            Value::Bool(truth) => self.number(path, time_s, f64::from(u8::from(*truth))),
            Value::String(text) if structure::is_state(path) && self.has_room(path) => {
                let series = self.series.entry(path.to_owned()).or_default();
                if series.numbers.is_empty() {
                    series.times.push(time_s);
                    series.texts.push(text.clone());
                }
            }
            Value::Array(all) => {
                let names = names.filter(|names| names.len() == all.len());
                for (k, element) in all.iter().enumerate().take(MOST_ELEMENTS) {
                    let name = names.and_then(|names| names[k].as_str());
                    let own = name.map_or_else(|| format!("{path}[{k}]"), |name| format!("{path}[{name}]"));
                    self.take(&own, element, None, time_s, depth + 1);
                }
            }
            Value::Object(fields) => {
                let names = fields.get("name").and_then(Value::as_array).map(Vec::as_slice);
                for (field, value) in fields {
                    let own = if depth == 0 { format!("{path}/{field}") } else { format!("{path}.{field}") };
                    self.take(&own, value, names, time_s, depth + 1);
                }
            }
            Value::String(_) | Value::Null => {}
        }
    }

    fn has_room(&self, path: &str) -> bool {
        self.series.len() < MOST_SERIES || self.series.contains_key(path)
    }

    fn number(&mut self, path: &str, time_s: f64, value: f64) {
        if !self.has_room(path) {
            return;
        }
        let series = match self.series.get_mut(path) {
            Some(series) => series,
            None => self.series.entry(path.to_owned()).or_default(),
        };
        if series.texts.is_empty() {
            series.times.push(time_s);
            series.numbers.push(value);
        }
    }
}

/// The stamp in the header of a message, ns.
fn stamp(message: &Value) -> Option<u64> {
    let stamp = message.get("header")?.get("stamp")?;
    let nanoseconds = stamp.get("nanosec").or_else(|| stamp.get("nsec"))?.as_u64()?;
    stamp.get("sec")?.as_u64()?.checked_mul(1_000_000_000)?.checked_add(nanoseconds)
}
