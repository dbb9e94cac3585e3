//! Random numbers: draws for hidden values, Gaussian and coloured noise.

use rand::{Rng, RngExt};
use std::f64::consts::TAU;

/// Uniform in `low..high`.
pub fn between(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

/// Log-uniform in `low..high`.
pub fn geometric(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    low * (high / low).powf(rng.random::<f64>())
}

/// One of `choices`, which must not be empty.
pub fn pick(rng: &mut impl Rng, choices: &[f64]) -> f64 {
    choices[rng.random_range(0..choices.len())]
}

/// Zero mean and unit variance (Box and Muller 1958).
pub fn gaussian(rng: &mut impl Rng) -> f64 {
    let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
    radius * (TAU * rng.random::<f64>()).cos()
}

/// Zero-mean Gaussian noise with an exponential correlation (Ornstein and Uhlenbeck 1930).
#[derive(Debug, Clone)]
pub struct Coloured {
    deviation: f64,
    correlation_s: f64,
    value: f64,
}

impl Coloured {
    /// Stationary from the start.
    pub fn new(deviation: f64, correlation_s: f64, rng: &mut impl Rng) -> Self {
        Self { deviation, correlation_s, value: deviation * gaussian(rng) }
    }

    /// The value after `dt` more seconds; exact for any `dt`.
    pub fn advance(&mut self, dt: f64, rng: &mut impl Rng) -> f64 {
        let keep = (-dt / self.correlation_s).exp();
        self.value = keep * self.value + self.deviation * (1.0 - keep * keep).sqrt() * gaussian(rng);
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;

    #[test]
    fn coloured_noise_has_its_deviation_and_its_correlation() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut noise = Coloured::new(2.0, 0.05, &mut rng);
        let values: Vec<f64> = (0..200_000).map(|_| noise.advance(0.01, &mut rng)).collect();
        let moment = |lag: usize| {
            let products = values.iter().zip(&values[lag..]).map(|(a, b)| a * b);
            products.sum::<f64>() / (values.len() - lag) as f64
        };
        assert!((moment(0).sqrt() - 2.0).abs() < 0.05);
        assert!((moment(5) / moment(0) - (-1.0f64).exp()).abs() < 0.03);
    }

    #[test]
    fn draws_stay_in_their_ranges() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for _ in 0..1000 {
            assert!((3.0..7.0).contains(&between(&mut rng, 3.0, 7.0)));
            assert!((0.1..10.0).contains(&geometric(&mut rng, 0.1, 10.0)));
            assert!([1.0, 4.0].contains(&pick(&mut rng, &[1.0, 4.0])));
        }
    }
}
