//! Logs of motors: from files of many kinds to [`Record`]s in SI units, and back.
//!
//! The way of the data, step by step; what a file of a step calls are its parts:
//!
//! 1. `read` tells which reader a file has: `table`, `sysid`, `bam`, `apart` for two files, `formats` for those that are no tables of text.
//! 2. `text` opens a file and vouches for its encoding, `preamble` takes metadata and header by the `layout` of the first lines.
//! 3. `choice` finds the wanted columns, by a `mapping` or by name; where it cannot, `sample` holds what `guess` proposes a mapping from.
//! 4. `table` turns rows into numbers (`taken`, `rows`), `samples` keeps those that a fit can use, `structure` parts the tests of one file.
//! 5. `repair` undoes or leaves out what no motor did, and `servo` works out a voltage where a log has a target instead.
//! 6. `args` reads several files; `roles` and `still` part what is fitted from what judges and from what tells nothing.
//!
//! What a record says about the motor is judged later, by the verbs that need to: `usable` refuses what teaches nothing (wrong units, a reversed
//! sign), `suspicion` lists the checks that tell what misleads, most of them a file each. They see a record through `motion`, `timing`, `quantum`,
//! `hold` and `weak`, and write their remedies by `remap` (`--map`) and `times` (`--skip`).

mod agreement;
mod apart;
mod args;
pub mod bam;
pub mod beat;
mod beside;
mod between;
mod beyond_full;
mod bursts;
mod choice;
mod clipped;
mod clock;
mod code_pages;
mod counter;
mod direction;
mod disagreeing;
mod dropouts;
mod early;
mod edges;
mod encoding;
mod ends;
mod fields;
pub mod formats;
mod garbled;
pub mod guess;
mod header;
mod headless;
mod heads;
mod held_back;
mod hexadecimal;
pub mod hold;
mod holes;
mod json;
mod labels;
mod layout;
mod line_ends;
mod low_active;
mod many_garbled;
pub mod mapping;
mod metadata;
mod mistaken;
pub(crate) mod motion;
mod newest;
mod numbered;
mod numbers;
mod one_level;
mod only;
mod other_clock;
mod own_rate;
mod pairs;
mod preamble;
mod properties;
pub mod quantum;
mod rates;
mod read;
mod readings;
mod record;
mod refused;
mod remap;
mod repair;
pub mod repeats;
mod reversed;
mod ripple;
mod robot_loop;
pub mod roles;
mod rows;
mod sample;
mod samples;
mod sentinels;
pub mod servo;
mod several;
mod shifted;
mod slow_sensor;
mod stale;
mod stamped;
mod stands_amid;
mod steady_states;
mod still;
mod stops;
mod structure;
mod supply_as_drive;
mod suspicion;
mod switched_off;
pub mod sysid;
mod sysid_entries;
mod sysid_mechanisms;
mod sysid_names;
mod sysid_units;
mod table;
mod taken;
mod target_as_drive;
mod target_check;
mod tektronix;
mod text;
mod ticks;
mod times;
pub mod timing;
mod together;
mod turned_from_outside;
mod unit_check;
pub mod units;
mod unread;
mod unsigned;
mod unsigned_current;
mod usable;
mod voltages;
pub(crate) mod weak;
mod wraps;
mod write;

use std::path::Path;

#[cfg(feature = "cli")]
pub(crate) use apart::halves;
pub use args::{Loaded, ReadArgs, load};
pub use labels::Labels;
pub use metadata::{EncoderShaft, Metadata};
pub use read::{Format, ReadOptions, read};
pub use record::{Hold, Record, Warning};
pub(crate) use repair::part;
pub use samples::FEWEST_SAMPLES;
pub use still::{breakaway, set_aside_still, still_beside};
pub(crate) use suspicion::{BEFORE_ITS_VOLTAGE, BEYOND_SUPPLY, place_of};
pub use suspicion::{data_faults, suspicions};
pub(crate) use text::{cannot_read, open as open_text};
pub use together::together;
pub(crate) use usable::check_some;
pub use usable::{Fault, check_all_usable, check_usable, content_faults, faults};
pub use write::write_canonical;

/// The name of a record from its file.
fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned())
}

#[cfg(test)]
mod read_tests;
