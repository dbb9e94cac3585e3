//! How strongly moves beat with updates of any rate.

use std::f64::consts::TAU;

use super::moves::Move;
use super::updates::Updates;

/// How strongly moves beat with updates of some rate.
pub(super) struct Beat {
    pub(super) power: f64,
    pub(super) updates: Updates,
}

/// The beats of `moves` with updates at `lowest`, and at `spacing` more so many times.
///
/// With `x = (t + age) rate`, a move's excess is `speed / rate` times the drop of `x - floor(x)`, whose first harmonic is
/// `sin(2 pi x) / pi` from one sample to the next: matched to that, and weighted by the speed, stamps may jitter.
pub(super) fn beats(moves: &[Move], lowest: f64, spacing: f64, count: usize) -> Vec<Beat> {
    let turned = |turns: f64| {
        let (sine, cosine) = (TAU * turns).sin_cos();
        [cosine, sine]
    };
    let times = |a: [f64; 2], b: [f64; 2]| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
    let mut sums = vec![[0.0; 3]; count];
    for m in moves {
        let [mut from, mut to] = [m.from, m.to].map(|t| turned(lowest * t));
        let [from_next, to_next] = [m.from, m.to].map(|t| turned(spacing * t));
        let (weight, norm) = (m.speed * m.excess, m.speed * m.speed);
        for sum in &mut sums {
            let [x, y] = [to[0] - from[0], to[1] - from[1]];
            sum[0] += weight * y;
            sum[1] += weight * x;
            sum[2] += norm * (x * x + y * y);
            (from, to) = (times(from, from_next), times(to, to_next));
        }
    }
    // Updates in step with the samples do not beat.
    let least = 1e-9 * moves.iter().map(|m| m.speed * m.speed).sum::<f64>();
    let beat = |(k, [y, x, norm]): (usize, &[f64; 3])| {
        let rate = lowest + k as f64 * spacing;
        let age = (x.atan2(*y) / TAU).rem_euclid(1.0) / rate;
        Beat { power: (x * x + y * y) / (norm + least), updates: Updates { rate, age } }
    };
    sums.iter().enumerate().map(beat).collect()
}

/// The strongest beat within `reach` of `rate`, to within `finest`.
pub(super) fn sharpen(moves: &[Move], rate: f64, reach: f64, finest: f64) -> Updates {
    let spacing = (0.2 * reach).max(finest);
    let steps = (reach / spacing).ceil();
    let found = beats(moves, rate - steps * spacing, spacing, 2 * steps as usize + 1);
    let best = found.iter().max_by(|a, b| a.power.total_cmp(&b.power));
    let best = best.map_or(Updates { rate, age: 0.0 }, |b| b.updates);
    if spacing > finest { sharpen(moves, best.rate, spacing, finest) } else { best }
}
