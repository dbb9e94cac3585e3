//! A generation's work shared among threads, with the same answer for any number of them.
//!
//! The work is cut into (block of candidates, record). Each piece is computed alike by whoever takes it, and
//! the pieces are added in a fixed order. The threads live as long as the search and wait by spinning, because
//! a generation lasts a few hundred microseconds and waking a sleeping thread would cost a good part of it.

use super::dispatch::LANES;
use super::record::{Candidates, Records};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock};

/// Turns of the waiting loop before a thread offers its processor to others.
const SPINS: u32 = 20_000;

/// What the threads share.
pub struct Crew<'r> {
    records: &'r Records,
    candidates: RwLock<Candidates>,
    /// One result per piece; locked by the one thread that took the piece.
    sums: Vec<Mutex<[f64; LANES]>>,
    pieces: AtomicUsize,
    taken: AtomicUsize,
    done: AtomicUsize,
    round: AtomicUsize,
    stop: AtomicBool,
}

impl<'r> Crew<'r> {
    /// For at most `most` candidates at a time.
    pub fn new(records: &'r Records, most: usize) -> Self {
        let pieces = most.div_ceil(LANES) * records.len();
        Self {
            records,
            candidates: RwLock::default(),
            sums: (0..pieces).map(|_| Mutex::new([0.0; LANES])).collect(),
            pieces: AtomicUsize::new(0),
            taken: AtomicUsize::new(0),
            done: AtomicUsize::new(0),
            round: AtomicUsize::new(0),
            stop: AtomicBool::new(false),
        }
    }

    /// Runs `search` on this thread with `threads - 1` helpers.
    pub fn with_helpers<R>(&self, threads: usize, search: impl FnOnce() -> R) -> R {
        std::thread::scope(|scope| {
            for _ in 1..threads {
                scope.spawn(|| self.help());
            }
            let end = StopOnDrop(&self.stop);
            let result = search();
            drop(end);
            result
        })
    }

    fn help(&self) {
        let mut seen = 0;
        loop {
            let stopped = || self.stop.load(Ordering::Acquire);
            wait_until(|| stopped() || self.round.load(Ordering::Acquire) != seen);
            if stopped() {
                return;
            }
            seen = self.round.load(Ordering::Acquire);
            self.work();
        }
    }

    fn work(&self) {
        let candidates = self.candidates.read().unwrap_or_else(PoisonError::into_inner);
        loop {
            let piece = self.taken.fetch_add(1, Ordering::AcqRel);
            if piece >= self.pieces.load(Ordering::Acquire) {
                return;
            }
            let (block, record) = (piece / self.records.len(), piece % self.records.len());
            *locked(&self.sums[piece]) = self.records.lane_iae(record, &candidates, block);
            self.done.fetch_add(1, Ordering::AcqRel);
        }
    }

    /// IAE of the candidates that `fill` writes, summed over the records in their order.
    pub fn iae_of(&self, fill: impl FnOnce(&mut Candidates), iae: &mut [f64]) {
        let pieces = iae.len().div_ceil(LANES) * self.records.len();
        {
            // Helpers let go of the candidates when they find no piece left.
            let mut candidates = self.candidates.write().unwrap_or_else(PoisonError::into_inner);
            fill(&mut candidates);
            self.pieces.store(pieces, Ordering::Release);
            self.done.store(0, Ordering::Release);
            self.taken.store(0, Ordering::Release);
        }
        self.round.fetch_add(1, Ordering::AcqRel);
        self.work();
        wait_until(|| self.done.load(Ordering::Acquire) >= pieces);
        for (iae, sums) in iae.chunks_mut(LANES).zip(self.sums.chunks(self.records.len())) {
            iae.fill(0.0);
            for sums in sums {
                for (total, sum) in iae.iter_mut().zip(*locked(sums)) {
                    *total += sum;
                }
            }
        }
    }
}

/// Lets the helpers go even where the search panics, so that the panic is seen and not a hang.
struct StopOnDrop<'a>(&'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn wait_until(ready: impl Fn() -> bool) {
    let mut turns = 0;
    while !ready() {
        turns += 1;
        if turns < SPINS {
            std::hint::spin_loop();
        } else {
            std::thread::yield_now();
        }
    }
}
