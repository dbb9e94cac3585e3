//! The library's front door: plain slices in, findings out.
//!
//! [`discover`] takes time, voltage and angle (or speed) of one record; [`discover_records`] takes several, with records to judge by
//! and what is known of the motor. Work runs on a thread of its own while the caller's thread hands every [`Event`] to the
//! observer, which stops it by returning [`Break`](std::ops::ControlFlow::Break): the search then takes no further steps, and the call ends with
//! [`Error::Cancelled`]. Nothing of a call outlives it, and no state is shared between calls.
//!
//! ```
//! use std::ops::ControlFlow;
//! use motorlens::{Measured, Options, discover};
//!
//! // A second-order motor that swallows a volt in each direction: 4 s of steps, 500 samples a second.
//! let time: Vec<f64> = (0..2000).map(|k| f64::from(k) * 2e-3).collect();
//! let volts: Vec<f64> = (0..2000).map(|k| [6.0, 0.0, -4.0, 2.0, 9.0, -7.0][k / 250 % 6]).collect();
//! let mut angle = vec![0.0];
//! let (mut x, mut w) = (0.0, 0.0);
//! for k in 0..1999 {
//!     for _ in 0..20 {
//!         let v: f64 = volts[k];
//!         w += 1e-4 * (0.9 * v.signum() * (v.abs() - 1.0).max(0.0) - w) / 0.05;
//!         x += 1e-4 * w;
//!     }
//!     angle.push((x / 1e-3_f64).round() * 1e-3);
//! }
//! let found = discover(&time, &volts, Measured::Angle(&angle), &Options::default(), &mut |_| ControlFlow::Continue(()))?;
//! println!("{}: {:?}", found.findings.headline, found.findings.effects);
//! # assert!(found.model.base.gain > 0.5);
//! # Ok::<(), motorlens::Error>(())
//! ```

mod discovery;
mod fits;
mod observed;
mod slices;

use motorlens_shared::effects::Kind;

pub use crate::error::{Error, Result};
pub use crate::model_file::Model;
pub use discovery::{Discovered, discover, discover_records, plan};
pub use fits::{add, compare, fit, same};
pub(crate) use observed::watched;
pub use observed::{Event, Observer};
pub use slices::{Measured, record};
pub(crate) use slices::{check, laid_out};

use crate::diagnose::discover as search;
use crate::log::Record;
use crate::motor_file::MotorFile;

/// What to look for, and what is known.
#[derive(Debug, Clone)]
pub struct Options {
    /// Records that touch no fit and no choice: they are scored once, at the end.
    pub validation: Vec<Record>,
    /// What is known of the motor.
    pub motor: MotorFile,
    /// Effects that may be added.
    pub library: Vec<Kind>,
    /// Most effects to add.
    pub most: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { validation: Vec::new(), motor: MotorFile::default(), library: Kind::ALL.to_vec(), most: 4 }
    }
}

impl Options {
    /// What a search is asked for.
    fn asked(&self) -> search::Options {
        search::Options { library: self.library.clone(), most: self.most }
    }
}
