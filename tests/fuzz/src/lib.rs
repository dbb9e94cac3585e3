//! What every target does with an input: read it as the program would, and hold what is true of every answer. The link's has its own
//! ([`link`]).
//!
//! A panic that the readers' own guard turns into "the file is damaged" is an answer like any other; one that gets past it, a stack
//! that overflows and an allocation beyond [`MOST_MEMORY`] end the target, and libFuzzer keeps the input.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use motorlens::error::Result;
use motorlens::log::guess::look;
use motorlens::log::{Format, Record, data_faults, read};
use readers::{told, wrong};

#[path = "../../../host/tests/formats_support/mod.rs"]
pub mod formats_support;
pub mod link;
pub mod packing;
#[path = "../../../host/tests/formats_support/readers.rs"]
pub mod readers;
mod seeds;

/// What all of a reader's numbers and buffers may take together, B.
pub const MOST_MEMORY: usize = 1 << 30;

/// Refuses to allocate more than [`MOST_MEMORY`] at a time, which ends the target.
#[global_allocator]
static MEMORY: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, MOST_MEMORY);

/// Looking for faults of the data takes long where there are many rows, and is no part of reading.
const CHECKED_ROWS: usize = 200;

/// The first bytes of an input that is read as SysId's JSON, and as BAM's.
pub const SYSID: u8 = 253;
/// See [`SYSID`].
pub const BAM: u8 = 254;

/// Names the directory into which a target writes the seeds, instead of reading inputs.
pub const SEEDS: &str = "MOTORLENS_FUZZ_SEEDS";

/// Writes the seeds and ends where that is asked for. Makes a panic that is caught quiet, in place of libFuzzer's hook that ends the
/// program at once.
pub fn begin() {
    if let Some(directory) = std::env::var_os(SEEDS) {
        seeds::write(Path::new(&directory)).expect("a directory for the seeds");
        std::process::exit(0);
    }
    std::panic::set_hook(Box::new(|_| {}));
}

/// The file that every input is written to, in memory where the system has such a directory.
fn place() -> PathBuf {
    thread_local! {
        static DIRECTORY: RefCell<Option<tempfile::TempDir>> = const { RefCell::new(None) };
    }
    DIRECTORY.with_borrow_mut(|directory| {
        let new = || {
            let memory = Path::new("/dev/shm");
            let made = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
            made.expect("a temporary directory")
        };
        directory.get_or_insert_with(new).path().join("log.csv")
    })
}

/// Reads `content` as the program would, in one of the [`WAYS`].
///
/// # Panics
/// Where the answer is not one that a reader may give.
pub fn answer(content: &[u8], format: Format, way: &str) {
    let path = place();
    std::fs::write(&path, content).expect("the temporary file");
    holds(read(&path, &told(format, way)));
    if way.is_empty() {
        // What the page's dialogue asks for.
        let _ = look(&path);
    }
}

/// Reads `content` as the first byte of its input says: as SysId's or BAM's JSON, or a table in one of the [`readers::WAYS`].
pub fn way(first: u8, content: &[u8]) {
    match first {
        SYSID => answer(content, Format::WpilibSysid, ""),
        BAM => answer(content, Format::BamJson, ""),
        _ => answer(content, Format::Csv, readers::WAYS[usize::from(first) % readers::WAYS.len()]),
    }
}

/// What holds for every answer of the reader.
fn holds(answer: Result<Vec<Record>>) {
    let wrong = wrong(&answer);
    assert!(wrong.is_none(), "{wrong:?}");
    let records = answer.unwrap_or_default();
    if records.iter().map(Record::len).sum::<usize>() <= CHECKED_ROWS {
        data_faults(&records);
    }
}

/// Whether a panic leaves `read`, which must not be: libFuzzer keeps the input of a target that ends.
pub fn must_answer(read: impl FnOnce()) {
    if let Err(panic) = std::panic::catch_unwind(std::panic::AssertUnwindSafe(read)) {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a panic");
        eprintln!("a panic left the reader: {text}");
        std::process::abort();
    }
}
