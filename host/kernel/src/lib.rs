//! The inner loop: a block of candidates through the cells of a record.
//!
//! A crate of its own because it compiles the motor once for every small set of effects, which takes time and
//! changes seldom.

#[cfg(target_arch = "x86_64")]
mod sets;
#[cfg(target_arch = "x86_64")]
mod wide;

use motorlens_shared::effects::together::Effects;
use motorlens_shared::lanes::Lanes;
use motorlens_shared::scalar::Scalar;
use motorlens_shared::simulator::{Motion, Simulator};
use motorlens_shared::step::State;

#[cfg(target_arch = "x86_64")]
pub use sets::run_wide;
#[cfg(target_arch = "x86_64")]
pub use wide::Wide;

/// Candidates that share a pass.
pub const LANES: usize = 8;
/// One number of each of them.
pub type Block = Lanes<f64, LANES>;

/// Cells between two calls of the sink: their readings stay in the nearest cache.
const CHUNK: usize = 64;

/// Reading (rad of the output shaft) and speed that goes with it (rad/s), at the end of a cell.
pub type Reading<T> = [T; 2];

/// Takes what the motion shows at the ends of consecutive cells.
pub trait Sink<T> {
    /// The reading at the start, first of all.
    fn begin(&mut self, reading: Reading<T>);
    /// Readings of the cells `first ..`.
    fn take(&mut self, first: usize, readings: &[Reading<T>]);
}

/// A run through a record.
#[derive(Debug, Clone, Copy)]
pub struct Course<'a, S: Scalar> {
    /// At the first cell.
    pub start: State<S>,
    /// What a late voltage still brings at the start, then the mean voltage of every cell, V.
    pub voltages: &'a [S::Element],
    /// Cells to run, fewer than there are voltages.
    pub cells: usize,
    /// How old the reading at the start is where a sensor holds it, s.
    pub reading_age_s: f64,
    /// Whether the encoder turns with the rotor: whose speed goes with the reading.
    pub encoder_on_motor: bool,
    /// What was measured at the start and at the end of every cell, rad: equations tied to an angle then act where the
    /// shaft was seen, whatever the model's has drifted to. Empty where the run is free.
    pub guide: &'a [S::Element],
    /// Which of these are near a sample: what the shaft is ahead by there holds until a later one is more than a count away,
    /// because in between the model knows better than any curve through them.
    pub seen: &'a [bool],
    /// What a measured angle may lack, rad: within it the model's own shaft counts.
    pub count: f64,
}

/// Whether this processor has AVX2 and fused multiply-add.
#[must_use]
pub fn has_wide() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// A number whose readings can be handed out as plain `f64`.
pub trait Shown: Scalar {
    /// What is handed out.
    type Plain: Copy;
    /// The same number.
    fn plain(self) -> Self::Plain;
}

impl Shown for f64 {
    type Plain = Self;
    #[inline(always)]
    fn plain(self) -> Self {
        self
    }
}

impl Shown for Block {
    type Plain = Self;
    #[inline(always)]
    fn plain(self) -> Self {
        self
    }
}

#[inline(always)]
fn show<S: Shown, E: Effects<S>>(
    simulator: &Simulator<S, E>,
    motion: &Motion<S>,
    ahead: S,
    of_rotor: bool,
) -> Reading<S> {
    let speed = if of_rotor { motion.state.speed } else { motion.state.load_speed };
    [simulator.read_guided(motion, ahead), speed]
}

#[inline(always)]
fn plain<S: Shown>(reading: Reading<S>) -> Reading<S::Plain> {
    reading.map(S::plain)
}

/// Runs `course` and hands the readings to `sink`.
#[inline(always)]
pub fn run<S: Shown, E: Effects<S>>(
    simulator: &Simulator<S, E>,
    course: &Course<S>,
    sink: &mut dyn Sink<S::Plain>,
) {
    let mut motion = simulator.start_aged(course.start, S::lit(course.reading_age_s));
    let mut ahead = S::zero();
    let start = plain(show(simulator, &motion, ahead, course.encoder_on_motor));
    sink.begin(start);
    let mut readings = [start; CHUNK];
    let guided = course.guide.len().min(course.seen.len()) > course.cells;
    // Held at the reading itself, a spring would be driven away for as long as the run lasts by what a count lacks; held at the
    // edge of a count, cogging torque would push a standing shaft that the model balances elsewhere in it.
    let lacking = S::lit(course.count);
    let mut first = 0;
    while first < course.cells {
        let count = CHUNK.min(course.cells - first);
        for k in 0..count {
            simulator.advance_guided(&mut motion, course.voltages, first + k + 1, ahead);
            let reading = show(simulator, &motion, ahead, course.encoder_on_motor);
            if guided && course.seen[first + k + 1] {
                ahead += (S::splat(course.guide[first + k + 1]) - reading[0] - ahead).shrink(lacking);
            }
            readings[k] = plain(reading);
        }
        sink.take(first, &readings[..count]);
        first += count;
    }
}
