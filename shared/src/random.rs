//! Random numbers by counting: every (seed, generation, index) has its own stream.
//!
//! A child of the genetic algorithm draws from a stream that depends only on where the child stands,
//! never on who computed the child before it. So a seed gives the same answer on one thread, on many,
//! and on the board.

use core::convert::Infallible;
use rand_core::{Rng, SeedableRng, TryRng, utils};

/// Weyl step: the odd integer nearest to 2^64 divided by the golden ratio.
const STEP: u64 = 0x9E37_79B9_7F4A_7C15;

/// Bijective mixing of 64 bits (the finaliser of `SplitMix64`; Steele, Lea and Flood, 2014).
const fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// A stream of random numbers. Not for cryptography.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stream {
    counter: u64,
}

impl Stream {
    /// The stream of one place in a run.
    #[must_use]
    pub const fn new(seed: u64, generation: u32, index: u32) -> Self {
        let place = ((generation as u64) << 32) | index as u64;
        // Two rounds of mixing, so that neighbouring seeds and places start far apart.
        let key = mix(seed.wrapping_add(STEP));
        Self { counter: mix(key ^ mix(place.wrapping_add(STEP))) }
    }

    /// Uniform on 0 ..= 1 - 2^-53.
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Uniform between two numbers.
    #[inline]
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// An integer below `n` (bias below n / 2^32, far below what a search could notice).
    #[inline]
    pub fn below(&mut self, n: usize) -> usize {
        (((self.next_u64() >> 32) * n as u64) >> 32) as usize
    }

    /// True with probability `p`.
    #[inline]
    pub fn chance(&mut self, p: f64) -> bool {
        self.uniform() < p
    }

    /// Normally distributed, mean 0, standard deviation 1 (Box and Muller, 1958).
    pub fn gaussian(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.uniform()));
        radius * libm::cos(core::f64::consts::TAU * self.uniform())
    }
}

impl TryRng for Stream {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        self.try_next_u64().map(|x| (x >> 32) as u32)
    }
    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        self.counter = self.counter.wrapping_add(STEP);
        Ok(mix(self.counter))
    }
    fn try_fill_bytes(&mut self, destination: &mut [u8]) -> Result<(), Infallible> {
        utils::fill_bytes_via_next_word(destination, || self.try_next_u64())
    }
}

impl SeedableRng for Stream {
    type Seed = [u8; 8];

    fn from_seed(seed: [u8; 8]) -> Self {
        Self::new(u64::from_le_bytes(seed), 0, 0)
    }
    fn seed_from_u64(seed: u64) -> Self {
        Self::new(seed, 0, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::Stream;
    use rand_core::Rng;

    #[test]
    fn a_stream_depends_on_seed_generation_and_index() {
        let first = |seed, generation, index| Stream::new(seed, generation, index).next_u64();
        let here = first(7, 3, 5);
        assert_eq!(here, first(7, 3, 5));
        for other in [first(8, 3, 5), first(7, 4, 5), first(7, 3, 6), first(7, 5, 3)] {
            assert_ne!(here, other);
        }
    }

    #[test]
    fn neighbouring_streams_are_uncorrelated_and_uniform() {
        let n = 40_000;
        let (mut sum, mut square, mut product) = (0.0, 0.0, 0.0);
        for k in 0..n {
            let a = Stream::new(1, 0, k).uniform() - 0.5;
            let b = Stream::new(1, 0, k + 1).uniform() - 0.5;
            sum += a;
            square += a * a;
            product += a * b;
        }
        let n = f64::from(n);
        // Five standard errors each.
        assert!((sum / n).abs() < 5.0 / (12.0 * n).sqrt());
        assert!((square / n - 1.0 / 12.0).abs() < 5.0 / (180.0 * n).sqrt());
        assert!((product / n).abs() < 5.0 / (144.0 * n).sqrt());
    }

    #[test]
    fn gaussian_has_unit_variance_and_light_tails() {
        let mut stream = Stream::new(3, 0, 0);
        let (mut sum, mut square, mut fourth) = (0.0, 0.0, 0.0);
        let n = 100_000;
        for _ in 0..n {
            let x = stream.gaussian();
            sum += x;
            square += x * x;
            fourth += x * x * x * x;
        }
        let n = f64::from(n);
        assert!((sum / n).abs() < 5.0 / n.sqrt());
        assert!((square / n - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
        assert!((fourth / n - 3.0).abs() < 5.0 * (96.0 / n).sqrt());
    }

    #[test]
    fn below_reaches_every_integer_and_no_other() {
        let mut stream = Stream::new(1, 0, 0);
        let mut seen = [0_u32; 7];
        for _ in 0..7_000 {
            seen[stream.below(7)] += 1;
        }
        assert!(seen.iter().all(|&count| (850..1150).contains(&count)), "{seen:?}");
    }
}
