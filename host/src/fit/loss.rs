//! How much an error counts: the pseudo-Huber loss, squared while small and linear beyond, so that outliers do not lead a search.

/// Beyond this many times the noise the loss grows linearly.
const HUBER: f64 = 6.0;

/// An error beyond this is counted as this, in the measured unit or in that of the noise.
pub const MOST: f64 = 1e12;

/// `error`, at most so large. A run that is lost, whose error is no number, is as wrong as can be: as a gradient it would spoil
/// a search.
#[inline(always)]
pub fn bounded(error: f64, most: f64) -> f64 {
    // Unlike a clamp, both let a number win over none.
    error.max(-most).min(most)
}

/// Square root of the pseudo-Huber loss, with the sign of `d`: its square is d^2 for small d, linear for large.
///
/// d sqrt(2 / (1 + sqrt(1 + (d/D)^2))) is the same number without cancellation.
#[inline(always)]
pub fn robust(d: f64) -> f64 {
    let (limited, share) = limit(d);
    limited * share.sqrt()
}

/// Its square: the pseudo-Huber loss.
#[inline(always)]
pub fn loss(d: f64) -> f64 {
    let (limited, share) = limit(d);
    limited * limited * share
}

/// An error that can be squared, and the share of its square that counts.
#[inline(always)]
fn limit(d: f64) -> (f64, f64) {
    let limited = bounded(d, 1e7);
    let x = limited * (1.0 / HUBER);
    (limited, 2.0 / (1.0 + (1.0 + x * x).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_errors_count_squared_and_large_ones_linearly() {
        assert!((robust(0.1) / 0.1 - 1.0).abs() < 1e-3);
        let (a, b) = (robust(1e3).powi(2), robust(2e3).powi(2));
        assert!((b / a - 2.0).abs() < 0.02);
        assert_eq!(robust(-3.0), -robust(3.0));
    }
}
