//! Seeded sequences that need no memory: a hash, a maximum-length sequence and a permutation.

/// A well-mixed 32-bit hash of a seed and an index (the finaliser of MurmurHash3, Appleby 2011, public domain).
pub fn hash(seed: u32, index: u32) -> u32 {
    let mut x = seed ^ index.wrapping_mul(0x9e37_79b9);
    x ^= x >> 16;
    x = x.wrapping_mul(0x85eb_ca6b);
    x ^= x >> 13;
    x = x.wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

/// Linear feedback shift register of `x^15 + x^14 + 1`: 32767 chips before it repeats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lfsr(u16);

impl Lfsr {
    /// The register at the place in the sequence that the seed picks.
    pub fn new(seed: u32) -> Self {
        Self((hash(seed, 0) % 32_767 + 1) as u16)
    }

    /// The next chip.
    pub fn next_chip(&mut self) -> bool {
        let bit = ((self.0 >> 14) ^ (self.0 >> 13)) & 1;
        self.0 = ((self.0 << 1) | bit) & 0x7fff;
        bit == 1
    }
}

/// Where `index` of `0..count` goes in the seed's permutation of `0..count`.
///
/// A four-round Feistel network over the next even power of two, walked until it lands inside
/// (Black and Rogaway 2002): every index is reached once without storing the order. `count` in 1..=65536.
pub fn permute(index: u32, count: u32, seed: u32) -> u32 {
    let half = count.max(2).next_power_of_two().trailing_zeros().div_ceil(2);
    let mask = (1 << half) - 1;
    let mut x = index;
    loop {
        let (mut left, mut right) = (x >> half, x & mask);
        for round in 0..4 {
            (left, right) = (right, left ^ (hash(seed ^ (round << 24), right) & mask));
        }
        x = (left << half) | right;
        if x < count {
            return x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{vec, vec::Vec};

    #[test]
    fn the_register_visits_every_state_once_and_is_balanced() {
        let start = Lfsr::new(1);
        let mut register = start;
        let mut ones = 0;
        for chip in 1..=32_767 {
            ones += u32::from(register.next_chip());
            assert_eq!(register == start, chip == 32_767);
        }
        assert_eq!(ones, 16_384);
    }

    #[test]
    fn a_permutation_reaches_every_index_once_whatever_its_length() {
        for count in [1u32, 2, 3, 14, 17, 64, 1000] {
            let mut seen = vec![false; count as usize];
            for index in 0..count {
                let place = permute(index, count, 9) as usize;
                assert!(!seen[place]);
                seen[place] = true;
            }
        }
    }

    #[test]
    fn another_seed_gives_another_order() {
        let order = |seed| (0..14).map(|i| permute(i, 14, seed)).collect::<Vec<_>>();
        assert_eq!(order(3), order(3));
        assert_ne!(order(3), order(4));
    }
}
