//! WPILib's data log, version 1.0: records of `double`, `float`, `int64`, `boolean` and `string`, in microseconds.
//!
//! An entry is started under a number, with its name, type and metadata; records with that number follow, in any order of time. The
//! layout is public (WPILib Data Log File Format Specification 1.0). SysId's units stand in the metadata.

use std::collections::{BTreeMap, BTreeSet};

use super::bytes::Bytes;
use super::events::{Events, Series};
use super::{Content, Fault};

/// What an entry logs.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Double,
    Float,
    Integer,
    Boolean,
    Text,
    Other,
}

impl Kind {
    fn of(name: &str) -> Kind {
        match name {
            "double" => Kind::Double,
            "float" => Kind::Float,
            "int64" => Kind::Integer,
            "boolean" => Kind::Boolean,
            "string" => Kind::Text,
            _ => Kind::Other,
        }
    }
}

/// Reads a data log. Records of other types are left out; a file whose last record is cut off, as by a robot that was switched off, is
/// read up to there.
///
/// # Errors
/// A fault where the header is of another version or the file holds no record.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let mut bytes = Bytes::new(all);
    bytes.take(6)?;
    let version = bytes.u16()?;
    if version >> 8 != 1 {
        let why = format!("its version is {}.{}, and 1.0 is known", version >> 8, version & 0xFF);
        return Err(Fault::new(why, "export it as CSV with AdvantageScope or DataLogTool"));
    }
    bytes.text()?;
    let mut started: BTreeMap<u32, (String, Kind)> = BTreeMap::new();
    let mut series: BTreeMap<String, Series> = BTreeMap::new();
    let mut left_out = BTreeSet::new();
    while bytes.left() > 0 {
        let at = bytes.at();
        let Ok((entry, time_s, payload)) = record(&mut bytes) else {
            if series.values().any(|series| !series.times.is_empty()) && at + LONGEST_TAIL > all.len() {
                break;
            }
            return Err(Fault::broken(at as u64, "where a record should be"));
        };
        if entry == 0 {
            control(payload, at, &mut started, &mut series, &mut left_out)?;
            continue;
        }
        let Some((name, kind)) = started.get(&entry) else {
            return Err(Fault::broken(
                at as u64,
                &format!("where entry {entry} is logged that was never started"),
            ));
        };
        let Some(series) = series.get_mut(name) else { continue };
        let mut payload = Bytes::new(payload);
        let number = match kind {
            Kind::Double => payload.f64()?,
            Kind::Float => f64::from(payload.f32()?),
            Kind::Integer => payload.i64()? as f64,
            Kind::Boolean => f64::from(payload.u8()?.min(1)),
            Kind::Text => {
                let text = String::from_utf8_lossy(payload.take(payload.left())?).into_owned();
                series.times.push(time_s);
                series.texts.push(text);
                continue;
            }
            Kind::Other => continue,
        };
        series.times.push(time_s);
        series.numbers.push(number);
    }
    Ok(Content::Events(Events::new(series, left_out)))
}

/// A record that is cut off at the end of a file is no longer than this, B; a longer one is a damaged length.
const LONGEST_TAIL: usize = 1 << 20;

/// Number of the entry, time in s, and payload of the next record.
fn record<'a>(bytes: &mut Bytes<'a>) -> Result<(u32, f64, &'a [u8]), Fault> {
    let lengths = usize::from(bytes.u8()?);
    let entry = bytes.unsigned((lengths & 3) + 1)? as u32;
    let size = bytes.unsigned((lengths >> 2 & 3) + 1)? as usize;
    let time_us = bytes.unsigned((lengths >> 4 & 7) + 1)? as i64;
    Ok((entry, time_us as f64 * 1e-6, bytes.take(size)?))
}

/// Starts or finishes an entry, or updates its metadata.
fn control(
    payload: &[u8],
    at: usize,
    started: &mut BTreeMap<u32, (String, Kind)>,
    series: &mut BTreeMap<String, Series>,
    left_out: &mut BTreeSet<String>,
) -> Result<(), Fault> {
    let broken = |_| Fault::broken(at as u64, "where an entry should be started or finished");
    let mut bytes = Bytes::new(payload);
    let what = bytes.u8().map_err(broken)?;
    let entry = bytes.u32().map_err(broken)?;
    match what {
        0 => {
            let [name, kind, about] = [bytes.text(), bytes.text(), bytes.text()];
            let (name, kind_name, about) =
                (name.map_err(broken)?, kind.map_err(broken)?, about.map_err(broken)?);
            let kind = Kind::of(&kind_name);
            if kind == Kind::Other {
                left_out.insert(format!("{name} ({kind_name})"));
            } else {
                let known = series.entry(name.clone()).or_default();
                known.about = about;
                // An entry that was finished and started anew as another type keeps what it was.
                let other =
                    if kind == Kind::Text { !known.numbers.is_empty() } else { !known.texts.is_empty() };
                if other {
                    started.insert(entry, (name, Kind::Other));
                    return Ok(());
                }
            }
            started.insert(entry, (name, kind));
        }
        1 => {
            started.remove(&entry);
        }
        2 => {
            let about = bytes.text().map_err(broken)?;
            if let Some(series) = started.get(&entry).and_then(|(name, _)| series.get_mut(name)) {
                series.about = about;
            }
        }
        _ => {}
    }
    Ok(())
}
