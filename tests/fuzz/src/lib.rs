//! What every target does with an input: read it as the program would, and hold what is true of every answer.
//!
//! A panic that the readers' own guard turns into "the file is damaged" is an answer like any other; one that gets past it, a stack
//! that overflows and an allocation beyond [`MOST_MEMORY`] end the target, and libFuzzer keeps the input.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use motorlens::error::Result;
use motorlens::log::guess::look;
use motorlens::log::{Format, ReadOptions, Record, data_faults, read};

#[path = "../../../host/tests/formats_support/mod.rs"]
pub mod formats_support;
pub mod packing;
mod seeds;

/// What all of a reader's numbers and buffers may take together, B.
pub const MOST_MEMORY: usize = 1 << 30;

/// Refuses to allocate more than [`MOST_MEMORY`] at a time, which ends the target.
#[global_allocator]
static MEMORY: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, MOST_MEMORY);

/// Looking for faults of the data takes long where there are many rows, and is no part of reading.
const CHECKED_ROWS: usize = 200;

/// The ways to read a table: the guess, names, and numbers with every kind of quantity and time.
pub const WAYS: [&str; 8] = [
    "",
    "time=0:ms,voltage=1,angle=2:deg",
    "time=0+1:ns,voltage=2,speed=3:rpm",
    "interval=0:us,duty=1:255,angle=2:mm",
    "voltage=0,angle=1",
    "time=t_ms:ms,duty=pwm:255,angle=enc:counts",
    "time=0,target=1:deg,angle=2:deg",
    "time=0,duty=1:100,supply=2:mV,speed=3:counts/s,current=4:mA",
];

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
    let mut options = ReadOptions {
        format,
        map: (!way.is_empty()).then(|| way.parse().expect("a mapping of WAYS")),
        supply_volts: Some(12.0),
        rate_hz: Some(100.0),
        ..ReadOptions::default()
    };
    options.motor.counts_per_rev = Some(1320.0);
    options.motor.metres_per_rev = Some(0.008);
    holds(read(&path, &options));
    if way.is_empty() {
        // What the page's dialogue asks for.
        let _ = look(&path);
    }
}

/// What holds for every answer of the reader: clean records, or a message with cause and remedy.
fn holds(answer: Result<Vec<Record>>) {
    let records = match answer {
        Ok(records) => records,
        Err(error) => {
            assert!(error.exit_code() == 3 && error.to_string().contains("\n  do: "), "{error}");
            return;
        }
    };
    for record in &records {
        let columns = [Some(&record.voltage_v), record.angle_rad.as_ref(), record.speed_rad_s.as_ref()];
        for column in columns.into_iter().flatten() {
            assert_eq!(column.len(), record.len());
            assert!(column.iter().all(|value| value.is_finite()));
        }
        assert!(record.time_s.windows(2).all(|pair| pair[0] < pair[1]));
    }
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
