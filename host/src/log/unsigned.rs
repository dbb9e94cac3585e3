//! Negative numbers that were printed as those of a type without a sign: -1 of 16 bits is 65535.
//!
//! They show as values near zero and near the width of the type with nothing between, and with their signs the course is much smoother.

/// The widths of such types, and one of which nothing is sure: a duty that is off or full is written so.
const WIDTHS: [f64; 2] = [65_536.0, 4_294_967_296.0];
const BYTE: f64 = 256.0;
/// What is near an end, in shares of the width; a signed number of that type reaches half of it.
const NEAR: f64 = 0.25;
/// Different values at either end from which they are no two levels of a duty.
const FEWEST: usize = 4;
/// What is left of the changes from row to row with the signs.
const SMOOTHER: f64 = 0.5;

/// The width of the type that took the signs of `values` away, if one did.
pub(super) fn width_of(values: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    among(&WIDTHS, values)
}

/// Whether a type of 8 bits may have taken the signs of `values` away.
pub(super) fn may_be_bytes(values: impl Iterator<Item = f64> + Clone) -> bool {
    among(&[BYTE], values).is_some()
}

fn among(widths: &[f64], values: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let mut high = f64::MIN;
    for value in values.clone() {
        if value < 0.0 || value.fract() != 0.0 {
            return None;
        }
        high = high.max(value);
    }
    let width = widths.iter().copied().find(|width| high < *width && high >= (1.0 - NEAR) * width)?;
    let is_near = |value: f64| value < NEAR * width || value >= (1.0 - NEAR) * width;
    if !values.clone().all(is_near) {
        return None;
    }
    let different = |is_high: bool| {
        let mut found: Vec<f64> = Vec::new();
        for value in values.clone().filter(|value| (*value > 0.5 * width) == is_high) {
            if !found.contains(&value) {
                found.push(value);
            }
            if found.len() == FEWEST {
                return true;
            }
        }
        false
    };
    let changes = |value: &dyn Fn(f64) -> f64| {
        let after = values.clone().skip(1);
        values.clone().zip(after).map(|(a, b)| (value(b) - value(a)).abs()).sum::<f64>()
    };
    let is_smoother = changes(&|value| signed(value, width)) < SMOOTHER * changes(&|value| value);
    (different(false) && different(true) && is_smoother).then_some(width)
}

/// The number of a type with a sign that has the bits of `value`.
pub(super) fn signed(value: f64, width: f64) -> f64 {
    if value >= 0.5 * width { value - width } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_that_a_type_took_away_are_told_from_large_numbers() {
        let course = |k: i64| (300.0 * (0.05 * k as f64).sin()).round();
        for width in WIDTHS {
            let taken: Vec<f64> = (0..300).map(|k| course(k).rem_euclid(width)).collect();
            assert_eq!(width_of(taken.iter().copied()), Some(width));
            assert!((0..300).all(|k| signed(taken[k as usize], width) == course(k)));
        }
        assert!(may_be_bytes((0..300).map(|k| (course(k) / 6.0).round().rem_euclid(BYTE))));
        // A duty of 16 bits that is off or full; one that rises; a duty of 8 bits.
        for duty in [
            (0..300).map(|k| f64::from(k / 20 % 2) * 65_535.0).collect::<Vec<_>>(),
            (0..300).map(|k| f64::from(k * 218)).collect(),
            (0..300).map(|k| f64::from(k % 256)).collect(),
        ] {
            assert_eq!(width_of(duty.iter().copied()), None);
            assert!(!may_be_bytes(duty.into_iter()));
        }
    }
}
