//! Time on a machine that others use too: processor time, and the fastest of several runs.

use cpu_time::ProcessTime;

/// Processor seconds of this process, all threads together.
pub fn processor_seconds() -> f64 {
    ProcessTime::now().as_duration().as_secs_f64()
}

/// Wall seconds of the fastest of `times` runs: what others take only ever adds.
pub fn fastest(times: u32, mut run: impl FnMut()) -> f64 {
    (0..times)
        .map(|_| {
            let began = std::time::Instant::now();
            run();
            began.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}
