//! Time on a machine that others use too.

use std::time::Instant;

/// Seconds of the fastest of `times` runs: what others take only ever adds.
pub fn fastest(times: u32, mut run: impl FnMut()) -> f64 {
    (0..times)
        .map(|_| {
            let began = Instant::now();
            run();
            began.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}
