//! What goes on during a call, and how its caller stops it.

use std::ops::ControlFlow;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use motorlens_shared::effects::Kind;

use crate::diagnose::discover::Progress;
use crate::error::{Error, Result};
use crate::stop::Stop;

/// What goes on, for whoever watches.
#[derive(Debug, Clone)]
pub enum Event {
    /// Nothing new in the last tenth of a second: a moment to look for a wish to stop.
    Waiting,
    /// An effect is tried on the model of so many effects.
    Trying {
        /// Effects in the model so far.
        depth: usize,
        /// The effect on trial.
        effect: Kind,
    },
    /// A model of the sequence is fitted.
    Model {
        /// Its effects.
        effects: Vec<Kind>,
        /// Root mean square error on the records fitted, in the measured unit.
        rmse: f64,
    },
    /// A generation of the genetic algorithm is done.
    Generation {
        /// Its number.
        number: u32,
        /// Its best integral of the absolute error.
        iae: f64,
    },
    /// A call goes on whose work is known beforehand: an export's tool runs through the records, two sets of records are fitted.
    Running {
        /// How much of it is done, 0 to 1.
        share: f64,
    },
}

/// Sees every event; stops the call by returning [`ControlFlow::Break`].
pub type Observer<'a> = &'a mut dyn FnMut(&Event) -> ControlFlow<()>;

/// What a search tells, as the observer's events.
pub(super) fn told(tell: &dyn Fn(Event)) -> impl FnMut(Progress) {
    move |progress| match progress {
        Progress::Trying { depth, effect } => tell(Event::Trying { depth, effect }),
        Progress::Rung(rung) => tell(Event::Model { effects: rung.effects, rmse: rung.train.rmse }),
        Progress::Anew(_) => {}
    }
}

/// Runs `work` on a thread of its own, and the observer here.
pub(crate) fn watched<T: Send>(
    observer: Observer,
    work: impl FnOnce(&dyn Fn(Event)) -> Result<T> + Send,
) -> Result<T> {
    const PATIENCE: Duration = Duration::from_millis(100);
    let (events, seen) = channel();
    let stop = Stop::default();
    let stopped = std::thread::scope(|scope| {
        let stop = &stop;
        let worker = scope.spawn(move || {
            // A search that is to stop has no listener any more.
            stop.heeded_by(|| work(&|event| drop(events.send(event))))
        });
        loop {
            let event = match seen.recv_timeout(PATIENCE) {
                Ok(event) => event,
                Err(RecvTimeoutError::Timeout) => Event::Waiting,
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if observer(&event).is_break() {
                stop.ask();
                drop(seen);
                drop(worker.join());
                return None;
            }
        }
        Some(worker.join().unwrap_or_else(|fault| std::panic::resume_unwind(fault)))
    });
    stopped.unwrap_or(Err(Error::Cancelled))
}
