//! The lowest value of a function of one number, by golden-section search (Kiefer, 1953).

/// What a step leaves of the stretch: of the two places within it one serves the next step too.
const SHARE: f64 = 0.618_033_988_749_894_9;
/// Values that are asked for: the place is known to a hundredth of the stretch.
const ASKED: usize = 12;

/// The lowest value of `of` between two ends, where it falls to one and rises again, and its place.
pub(crate) fn lowest([mut low, mut high]: [f64; 2], of: impl Fn(f64) -> f64) -> (f64, f64) {
    let mut places = [high - SHARE * (high - low), low + SHARE * (high - low)];
    let mut values = places.map(&of);
    for _ in 2..ASKED {
        if values[0] <= values[1] {
            high = places[1];
            let new = high - SHARE * (high - low);
            (places, values) = ([new, places[0]], [of(new), values[0]]);
        } else {
            low = places[0];
            let new = low + SHARE * (high - low);
            (places, values) = ([places[1], new], [values[1], of(new)]);
        }
    }
    let better = usize::from(values[1] < values[0]);
    (values[better], places[better])
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn the_lowest_place_is_found_to_a_hundredth_wherever_it_lies() {
        for place in [2.0, 2.3, 3.1, 4.0, 4.9, 5.0] {
            let asked = Cell::new(0);
            let of = |x: f64| {
                asked.set(asked.get() + 1);
                (x - place).powi(2)
            };
            let (value, found) = lowest([2.0, 5.0], of);
            assert!((found - place).abs() < 0.03 && value < 1e-3, "{found} for {place}");
            assert_eq!(asked.get(), ASKED);
        }
    }
}
