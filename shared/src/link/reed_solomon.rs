//! Reed-Solomon code over GF(256): parity symbols behind a message, from which as many lost symbols, or half as many wrong ones,
//! are found again.
//!
//! The field is that of x^8 + x^4 + x^3 + x^2 + 1, the generator's roots are the first powers of 2 from 2^0 on. Decoding is
//! Berlekamp-Massey on the syndromes without the erasures, a search of the roots, and Forney's values (Blahut, Algebraic Codes
//! for Data Transmission, 2003, sections 7.2 to 7.5). In place and without a heap: both run on boards, where a long word takes
//! milliseconds. So both call `progress` again and again, at least once for each symbol that they work through another.

/// The most symbols of a code word.
pub const LONGEST: usize = 255;
/// The most parity symbols.
pub const MOST_PARITY: usize = 96;

const POLYNOMIAL: u16 = 0x11d;

/// Powers of 2, twice around and to a length that a mask keeps to, and their logarithms.
const fn tables() -> ([u8; 512], [u8; 256]) {
    let (mut exp, mut log) = ([0; 512], [0; 256]);
    let (mut power, mut k) = (1_u16, 0);
    while k < 255 {
        (exp[k], exp[k + 255], log[power as usize]) = (power as u8, power as u8, k as u8);
        power = if power & 0x80 == 0 { power << 1 } else { power << 1 ^ POLYNOMIAL };
        k += 1;
    }
    (exp, log)
}

static TABLES: ([u8; 512], [u8; 256]) = tables();

/// 2 to the power of `exponent`, below 510.
fn exp(exponent: usize) -> u8 {
    TABLES.0[exponent & 511]
}

fn log(value: u8) -> usize {
    usize::from(TABLES.1[usize::from(value)])
}

/// `value` times 2 to the power of `exponent`, at most 255.
fn scaled(value: u8, exponent: usize) -> u8 {
    if value == 0 { 0 } else { exp(log(value) + exponent) }
}

fn mul(one: u8, other: u8) -> u8 {
    if other == 0 { 0 } else { scaled(one, log(other)) }
}

/// 0 for a division by 0, which is left to the message's checksum.
fn div(one: u8, other: u8) -> u8 {
    if other == 0 { 0 } else { scaled(one, 255 - log(other)) }
}

/// The value of a polynomial, lowest coefficient first, at 2 to the power of `exponent`, below 255.
fn eval(coefficients: &[u8], exponent: usize) -> u8 {
    coefficients.iter().rev().fold(0, |sum, coefficient| scaled(sum, exponent) ^ coefficient)
}

/// Adds `scale` times `other`, moved up by `shift`, to `sum`.
fn add_scaled(sum: &mut [u8], other: &[u8], scale: u8, shift: usize) {
    if scale != 0 {
        let exponent = log(scale);
        let moved = sum.get_mut(shift..).unwrap_or_default();
        moved.iter_mut().zip(other).for_each(|(place, value)| *place ^= scaled(*value, exponent));
    }
}

/// The logarithms of the generator's coefficients after the highest, which is 1; none of them is 0.
///
/// By the binomial theorem of Gauss: the product of x + 2^i for i below n has the coefficients 2^(k(k-1)/2) times the product of
/// (2^(n-i+1) - 1) / (2^i - 1) for i from 1 to k.
fn generator(parity: usize) -> [u8; MOST_PARITY] {
    let mut logs = [0; MOST_PARITY];
    let mut sum = 0;
    for (k, place) in (1..=parity).zip(&mut logs) {
        let ratio = log(exp(parity - k + 1) ^ 1) + 255 - log(exp(k) ^ 1);
        sum = (sum + k - 1 + ratio) % 255;
        *place = sum as u8;
    }
    logs
}

/// Fills the last `parity` symbols of `word`, at most [`MOST_PARITY`] of at most [`LONGEST`], from those before them.
pub fn encode(word: &mut [u8], parity: usize, progress: &mut dyn FnMut()) {
    let parity = parity.min(MOST_PARITY).min(word.len());
    let generator = generator(parity);
    let (message, check) = word.split_at_mut(word.len() - parity);
    check.fill(0);
    for symbol in message {
        progress();
        let factor = *symbol ^ check.first().copied().unwrap_or(0);
        if !check.is_empty() {
            check.copy_within(1.., 0);
            check[parity - 1] = 0;
        }
        if factor != 0 {
            let exponent = log(factor);
            let terms = check.iter_mut().zip(&generator);
            terms.for_each(|(place, coefficient)| *place ^= exp(exponent + usize::from(*coefficient)));
        }
    }
}

/// Mends `word` in place, given the places of symbols known to be lost. False when it cannot be, and then it is not touched; true does
/// not promise that it is right, which a checksum must tell.
pub fn decode(word: &mut [u8], erasures: &[u8], parity: usize, progress: &mut dyn FnMut()) -> bool {
    let (length, lost) = (word.len(), erasures.len());
    if length > LONGEST || parity > MOST_PARITY || lost > parity {
        return false;
    }
    let mut syndromes = [0; MOST_PARITY];
    for (root, syndrome) in syndromes[..parity].iter_mut().enumerate() {
        progress();
        *syndrome = word.iter().fold(0, |sum, symbol| scaled(sum, root) ^ symbol);
    }
    if syndromes[..parity].iter().all(|syndrome| *syndrome == 0) {
        return true;
    }
    // The locator of the lost symbols; a place is the power of 2 that the symbol has in the word's polynomial.
    let mut is_lost = [false; LONGEST];
    let mut lost_locator = [0; MOST_PARITY + 1];
    lost_locator[0] = 1;
    for (degree, erasure) in (1..).zip(erasures) {
        progress();
        let Some(place) = length.checked_sub(1 + usize::from(*erasure)) else { return false };
        if core::mem::replace(&mut is_lost[place], true) {
            return false;
        }
        let before = lost_locator;
        add_scaled(&mut lost_locator[..=degree], &before[..degree], exp(place), 1);
    }
    let lost_locator = &lost_locator[..=lost];
    // The syndromes of the wrong symbols alone stand behind the first coefficients of this product.
    let mut without_lost = [0; MOST_PARITY];
    add_product(&mut without_lost[..parity], &syndromes[..parity], lost_locator, progress);
    let Some((locator, wrong)) = locate(&without_lost[lost..parity], progress) else {
        return false;
    };
    let (locator, bad) = (&locator[..=wrong], lost + wrong);
    let mut places = [0; MOST_PARITY];
    let mut found = 0;
    for place in 0..length {
        progress();
        if is_lost[place] || eval(locator, (255 - place) % 255) == 0 {
            // There are no more roots than the degree says.
            places[found % MOST_PARITY] = place;
            found += 1;
        }
    }
    if found != bad {
        return false;
    }
    // Forney: values from the product of syndromes and the locator of all, and that locator's formal derivative, which has even powers only.
    let mut evaluator = [0; MOST_PARITY];
    add_product(&mut evaluator[..bad], &without_lost[..parity], locator, progress);
    let mut all = [0; MOST_PARITY + 1];
    add_product(&mut all[..=bad], lost_locator, locator, progress);
    let mut slope = [0; MOST_PARITY / 2];
    slope.iter_mut().zip(all[1..].iter().step_by(2)).for_each(|(even, coefficient)| *even = *coefficient);
    for place in &places[..bad] {
        progress();
        let inverse = (255 - place) % 255;
        let value = div(eval(&evaluator[..bad], inverse), eval(&slope, 2 * inverse % 255));
        word[length - 1 - place] ^= scaled(value, *place);
    }
    true
}

/// Adds the product of two polynomials, lowest coefficient first, to `sum`, as far as it has coefficients.
fn add_product(sum: &mut [u8], one: &[u8], other: &[u8], progress: &mut dyn FnMut()) {
    for (shift, coefficient) in other.iter().enumerate() {
        progress();
        add_scaled(sum, one, *coefficient, shift);
    }
}

/// The polynomial whose roots are the inverse places of the wrong symbols that leave these syndromes, lowest coefficient first, and its degree.
fn locate(syndromes: &[u8], progress: &mut dyn FnMut()) -> Option<([u8; MOST_PARITY + 1], usize)> {
    let mut locator = [0; MOST_PARITY + 1];
    locator[0] = 1;
    let (mut correction, mut degree) = (locator, 0);
    for step in 0..syndromes.len() {
        progress();
        let terms = locator.iter().zip(syndromes[..=step].iter().rev());
        let discrepancy = terms.fold(0, |sum, (coefficient, syndrome)| sum ^ mul(*coefficient, *syndrome));
        correction.copy_within(..MOST_PARITY, 1);
        correction[0] = 0;
        if discrepancy == 0 {
            continue;
        }
        let before = locator;
        add_scaled(&mut locator, &correction, discrepancy, 0);
        if 2 * degree <= step {
            degree = step + 1 - degree;
            correction = before;
            correction.iter_mut().for_each(|coefficient| *coefficient = div(*coefficient, discrepancy));
        }
    }
    (2 * degree <= syndromes.len()).then_some((locator, degree))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;
    use std::vec::Vec;

    fn coded(message: &[u8], parity: usize) -> Vec<u8> {
        let mut word = message.to_vec();
        word.resize(message.len() + parity, 0);
        encode(&mut word, parity, &mut || ());
        word
    }

    #[test]
    fn the_parity_is_that_of_the_qr_code_standard() {
        // ISO/IEC 18004, annex I: version 1-M, "01234567", ten check words of the same field and roots.
        let message = [16, 32, 12, 86, 97, 128, 236, 17, 236, 17, 236, 17, 236, 17, 236, 17];
        let check = [165, 36, 212, 193, 237, 54, 199, 135, 44, 85];
        assert_eq!(coded(&message, 10)[16..], check);
    }

    proptest! {
        #[test]
        fn as_many_lost_and_wrong_symbols_as_the_parity_bears_are_found(
            message in prop::collection::vec(any::<u8>(), 1..150),
            parity in 0_usize..=MOST_PARITY,
            spoiled in prop::collection::vec((any::<prop::sample::Index>(), 1..=255_u8, any::<bool>()), 0..110),
        ) {
            let good = coded(&message, parity);
            let mut bad = good.clone();
            let (mut erasures, mut left) = (Vec::new(), parity);
            let places: BTreeMap<_, _> =
                spoiled.iter().map(|(place, change, known)| (place.index(good.len()), (*change, *known))).collect();
            for (place, (change, known)) in places {
                let Some(after) = left.checked_sub(if known { 1 } else { 2 }) else { break };
                left = after;
                bad[place] ^= change;
                erasures.extend(known.then_some(place as u8));
            }
            prop_assert!(decode(&mut bad, &erasures, parity, &mut || ()));
            prop_assert_eq!(bad, good);
        }

        #[test]
        fn any_bytes_and_any_places_do_not_panic(
            mut word in prop::collection::vec(any::<u8>(), 0..300),
            erasures in prop::collection::vec(any::<u8>(), 0..120),
            parity in 0_usize..200,
        ) {
            decode(&mut word, &erasures, parity, &mut || ());
        }
    }
}
