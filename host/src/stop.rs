//! A wish to stop a search, heeded by the thread that runs it.
//!
//! A search that is to stop takes no further steps: every fit it still begins ends where it starts, so that it comes to its
//! end by itself in a fraction of the time, without unwinding. Its answer is then worth nothing, and who asked throws it
//! away. The wish belongs to the thread, so that searches side by side know nothing of each other.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A wish that can be spoken from another thread.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

thread_local! {
    static HEEDED: RefCell<Option<Stop>> = const { RefCell::new(None) };
}

impl Stop {
    /// Speaks the wish.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Runs `work` on this thread, which heeds the wish meanwhile.
    pub fn heeded_by<T>(&self, work: impl FnOnce() -> T) -> T {
        let before = HEEDED.replace(Some(self.clone()));
        let done = work();
        HEEDED.set(before);
        done
    }
}

/// Whether the search on this thread is to stop.
pub(crate) fn asked() -> bool {
    HEEDED.with_borrow(|stop| stop.as_ref().is_some_and(|stop| stop.0.load(Ordering::Relaxed)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wish_is_heeded_while_the_work_runs_and_by_its_thread_alone() {
        let stop = Stop::default();
        let seen = stop.heeded_by(|| {
            let before = asked();
            stop.ask();
            let elsewhere = std::thread::spawn(asked).join().expect("no panic");
            (before, asked(), elsewhere)
        });
        assert_eq!(seen, (false, true, false));
        assert!(!asked());
    }
}
