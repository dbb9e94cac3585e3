//! Binary logs of other programs: told by their content, read into columns, and then a table like any other.
//!
//! Every format is one row of `FORMATS`: how it is recognised, and either its reader or the program that converts it. A reader turns
//! bytes into a `Table` (all columns on one clock) or into `Events` (values with times of their own, held until the next). Either
//! goes the way of a CSV from there on: the same names, blanks, mapping, guess and checks.

#[cfg(feature = "log-xlsx")]
mod biff;
mod bytes;
#[cfg(feature = "log-mcap")]
mod cdr;
#[cfg(feature = "log-xlsx")]
mod chains;
mod convert;
mod events;
#[cfg(feature = "log-mat")]
mod hdf5;
pub(super) mod interval;
mod lines;
mod list;
#[cfg(feature = "log-mat")]
mod mat;
#[cfg(feature = "log-mcap")]
mod mcap;
mod npy;
#[cfg(feature = "log-npz")]
mod npz;
mod objects;
mod octave;
#[cfg(feature = "log-parquet")]
mod parquet;
mod python;
#[cfg(feature = "log-xlsx")]
mod sheets;
mod stamps;
mod table;
mod tagged;
mod teleplot;
mod transposed;
mod wpilog;
#[cfg(feature = "log-xlsx")]
mod xlsx;
mod yaml;

use std::fs::File;
use std::io::{BufReader, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

pub use convert::named;
use events::Events;
use table::Table;

use super::sysid_entries::{self, Entries};
use super::text::cannot_read;
use super::{Format, ReadOptions, Record};
use crate::error::{BadInput, Error, Result};

/// No log of a motor is larger, B; what a file says of its own sizes is believed up to here.
pub const LARGEST: u64 = 1 << 30;
/// So much of the beginning of a file tells what it is, B.
const LOOKED_AT: u64 = 1 << 12;

/// What a reader makes of a file.
pub enum Content {
    /// Columns of one length.
    Table(Table),
    /// Values as they were logged.
    Events(Events),
}

/// Why a reader gave up: cause and remedy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The cause, as a clause without a full stop.
    pub why: String,
    /// What to do.
    pub remedy: String,
}

impl Fault {
    /// A fault of the content.
    pub fn new(why: impl Into<String>, remedy: impl Into<String>) -> Self {
        Fault { why: why.into(), remedy: remedy.into() }
    }

    /// A file that is cut off or damaged at byte `at`.
    pub fn broken(at: u64, what: &str) -> Self {
        let why = format!("the file is cut off or damaged at byte {at}, {what}");
        Fault::new(why, "copy the file again, or export it anew from the program that made it")
    }
}

/// Reads the content of a file.
type Reader = fn(&[u8]) -> Result<Content, Fault>;

/// What can be done with a format.
enum How {
    /// It is read.
    Read(Reader),
    /// It is read where the program was built with this cargo feature.
    #[allow(dead_code)] // with all features there is none
    Without(&'static str),
}

/// A format that the program knows to read.
struct Known {
    name: &'static str,
    extension: &'static str,
    is: fn(&[u8]) -> bool,
    how: How,
}

/// A row's reader, or that it is left out of this build.
macro_rules! reader {
    ($feature:literal, $module:ident) => {
        reader!($feature, $module::read)
    };
    ($feature:literal, $module:ident :: $read:ident) => {{
        #[cfg(feature = $feature)]
        let how = How::Read($module::$read);
        #[cfg(not(feature = $feature))]
        let how = How::Without($feature);
        how
    }};
}

/// How HDF5 begins.
const HDF5: &[u8] = b"\x89HDF\r\n\x1A\n";

/// All formats that are read. The content decides; among archives, what is in them.
const FORMATS: [Known; 15] = [
    Known {
        name: "a WPILib data log",
        extension: "wpilog",
        is: |start| start.starts_with(b"WPILOG"),
        how: How::Read(wpilog::read),
    },
    Known {
        name: "a data log written as a list",
        extension: "csv",
        is: list::is,
        how: How::Read(list::read),
    },
    Known {
        name: "lines of several kinds, each with a word before it",
        extension: "txt",
        is: tagged::is,
        how: How::Read(tagged::read),
    },
    Known { name: "YAML", extension: "yaml", is: yaml::is, how: How::Read(yaml::read) },
    Known {
        name: "a list of values with their names",
        extension: "txt",
        is: teleplot::is,
        how: How::Read(teleplot::read),
    },
    Known {
        name: "a text file of Octave's variables",
        extension: "txt",
        is: octave::is,
        how: How::Read(octave::read),
    },
    Known {
        name: "a NumPy array",
        extension: "npy",
        is: |start| start.starts_with(b"\x93NUMPY"),
        how: How::Read(npy::read),
    },
    Known {
        name: "an archive of NumPy arrays",
        extension: "npz",
        is: |bytes| in_zip(bytes, ".npy"),
        how: reader!("log-npz", npz),
    },
    Known {
        name: "a MATLAB file",
        extension: "mat",
        is: |start| start.starts_with(b"MATLAB 5.0 MAT-file"),
        how: reader!("log-mat", mat),
    },
    Known {
        name: "an HDF5 file (MATLAB 7.3, h5py)",
        extension: "h5",
        // MATLAB puts a text of 512 bytes before it.
        is: |start| {
            [0, 512, 1024, 2048].iter().any(|at| start.get(*at..).is_some_and(|s| s.starts_with(HDF5)))
        },
        how: reader!("log-mat", hdf5),
    },
    Known {
        name: "a spreadsheet",
        extension: "xlsx",
        is: |start| {
            ["[Content_Types].xml", "xl/", "_rels/.rels", "docProps/"].iter().any(|name| in_zip(start, name))
        },
        how: reader!("log-xlsx", xlsx),
    },
    Known {
        name: "an Excel 97 workbook",
        extension: "xls",
        is: |start| start.starts_with(b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"),
        how: reader!("log-xlsx", sheets::xls),
    },
    Known {
        name: "an OpenDocument spreadsheet",
        extension: "ods",
        is: |start| {
            let kind = b"application/vnd.oasis.opendocument.spreadsheet";
            in_zip(start, "mimetype") && start.get(38..).is_some_and(|rest| rest.starts_with(kind))
        },
        how: reader!("log-xlsx", sheets::ods),
    },
    Known {
        name: "a Parquet table",
        extension: "parquet",
        is: |start| start.starts_with(b"PAR1"),
        how: reader!("log-parquet", parquet),
    },
    Known {
        name: "an MCAP recording",
        extension: "mcap",
        is: |start| start.starts_with(b"\x89MCAP0\r\n"),
        how: reader!("log-mcap", mcap),
    },
];

/// Whether the first file of a zip archive, which names it before its content, is one of these.
fn in_zip(start: &[u8], name: &str) -> bool {
    let length = start.get(26..28).map_or(0, |two| usize::from(two[0]) | usize::from(two[1]) << 8);
    start.starts_with(b"PK\x03\x04")
        && start.get(30..30 + length).is_some_and(|first| {
            let first = String::from_utf8_lossy(first);
            first.ends_with(name) || first.starts_with(name)
        })
}

/// The extensions of the files that are read, for messages.
pub fn extensions() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().map(|format| format.extension)
}

/// Reads the records of the file at `path`, or `None` where it is not of a binary format.
///
/// # Errors
/// Bad input where the file is damaged, is of a format that another program has to convert, or its columns are not understood.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Option<Vec<Record>>> {
    content(path)?.map(|content| records(path, content, options)).transpose()
}

/// A file as it can be shown before anybody says what its columns are.
pub enum Shown {
    /// The columns that a guess is made from.
    Table(Table),
    /// The tests of SysId's routines, which need no mapping.
    Tests(Entries),
}

/// Opens the file at `path` to show it, or `None` where it is not of a binary format.
///
/// # Errors
/// Bad input where the file is damaged, or is of a format that another program has to convert.
pub fn look(path: &Path) -> Result<Option<Shown>> {
    let Some(content) = content(path)? else { return Ok(None) };
    let events = match content {
        Content::Table(table) => return Ok(Some(Shown::Table(table))),
        Content::Events(events) => events,
    };
    let entries = events.sysid();
    if entries.are_complete() {
        return Ok(Some(Shown::Tests(entries)));
    }
    let table = events.table(None).map_err(|fault| BadInput::new(path, fault.why, fault.remedy))?;
    Ok(Some(Shown::Table(table)))
}

/// The table in the JSON that `input` is.
///
/// # Errors
/// Bad input where it is no JSON, or no table.
pub fn json(path: &Path, input: impl Read) -> Result<Table> {
    let mut bytes = Vec::new();
    input.take(objects::LARGEST + 1).read_to_end(&mut bytes).map_err(|error| cannot_read(path, &error))?;
    let read = if bytes.len() as u64 > objects::LARGEST {
        Err(Fault::new("JSON of more than 256 MiB is larger than any log of a motor", "write it as CSV"))
    } else {
        objects::read(&bytes)
    };
    read.map_err(|fault| BadInput::new(path, fault.why, fault.remedy).at_line(1).into())
}

/// What is in the file at `path`, or `None` where it is not of a binary format.
fn content(path: &Path) -> Result<Option<Content>> {
    let file = File::open(path).map_err(|error| cannot_read(path, &error))?;
    let about = file.metadata().map_err(|error| cannot_read(path, &error))?;
    if about.is_dir() {
        return Ok(None);
    }
    let mut start = Vec::new();
    let mut input = BufReader::new(file);
    input.by_ref().take(LOOKED_AT).read_to_end(&mut start).map_err(|error| cannot_read(path, &error))?;
    let bad = |fault: Fault| -> Error { BadInput::new(path, fault.why, fault.remedy).into() };
    let Some(format) = FORMATS.iter().find(|format| (format.is)(&start)) else {
        if let Some(fault) = convert::named(&start, path) {
            return Err(bad(fault));
        }
        if !transposed::may_be(&start) {
            return Ok(None);
        }
        let table = transposed::read(start.as_slice().chain(input)).map_err(bad)?;
        return Ok(table.map(Content::Table));
    };
    let How::Read(reader) = &format.how else {
        let How::Without(feature) = &format.how else { return Ok(None) };
        let why = format!("this is {}, which this build does not read", format.name);
        return Err(bad(Fault::new(why, format!("build the program with the cargo feature {feature}"))));
    };
    let too_large = || {
        let why = format!("{} of more than 1 GiB is larger than any log of a motor", format.name);
        bad(Fault::new(why, "export the columns and the minutes that show the motor, or write them as CSV"))
    };
    if about.len() > LARGEST {
        return Err(too_large());
    }
    let mut bytes = start;
    input.take(LARGEST).read_to_end(&mut bytes).map_err(|error| cannot_read(path, &error))?;
    let content = guarded(*reader, &bytes).map_err(|mut fault| {
        fault.why = format!("{}: {}", format.name, fault.why);
        bad(fault)
    })?;
    Ok(Some(content))
}

/// Runs a reader. The crates behind some of them are not made for hostile files: what they take for impossible is a damaged file, not
/// a fault of the program, so their panics end here.
fn guarded(reader: Reader, bytes: &[u8]) -> Result<Content, Fault> {
    catch_unwind(AssertUnwindSafe(|| reader(bytes))).unwrap_or_else(|_| {
        Err(Fault::new(
            "the file is damaged in a way that its reader does not expect",
            "copy the file again, or export it anew as CSV from the program that made it",
        ))
    })
}

fn records(path: &Path, content: Content, options: &ReadOptions) -> Result<Vec<Record>> {
    let table = match content {
        Content::Table(table) => table,
        Content::Events(events) => {
            let entries = events.sysid();
            let asked = options.format == Format::WpilibSysid;
            if asked || (entries.has_tests() && !events.are_mapped(options.map.as_ref())) {
                return sysid_entries::records(path, &entries, options);
            }
            events
                .table(options.map.as_ref())
                .map_err(|fault| BadInput::new(path, fault.why, fault.remedy))?
        }
    };
    table.records(path, options)
}
