//! The step of a quantised column, estimated from its values.
//!
//! That most values are multiples of one step is what tells it, as in D. G. Kendall, "Hunting quanta", *Phil. Trans. R. Soc. A* 276, 1974;
//! of multiples written with few digits the gaps between neighbouring levels are, too. A few readings that lie between the levels (a mean of
//! two, a garbled digit) would make the step as small as they like, and the noise with it: so the step is the largest one that up to a
//! twentieth of the readings contradict (trimming; P. J. Huber, *Robust Statistics*, 1981).

/// Share of the gaps between neighbouring levels that must be multiples of the step.
const AGREEING: f64 = 0.95;
/// How far, in steps, a gap may lie from a multiple: values are rounded when written.
const TOLERANCE: f64 = 0.2;
/// Levels closer than this share of the span are one level written with rounding noise.
const SAME_LEVEL: f64 = 1e-9;
/// Readings that may lie between the levels, as a share of all, where each level has so many readings in the mean.
const ODD: f64 = 0.05;
const OFTEN: usize = 3;
/// A coarser step holds for so many of the levels too: a motor that mostly stands still has most readings on one.
const MOST_LEVELS: f64 = 0.8;
/// With fewer levels there is nothing to agree on.
const FEWEST_LEVELS: usize = 4;

/// The smallest step of which all differences of `values` are multiples, in their unit, tolerant of rounding on
/// writing; `None` where the values look continuous or hardly change.
///
/// The smallest gap between neighbouring levels, or a half or third of it, is tried as the step and then refined by
/// least squares over all gaps.
pub fn quantum(values: &[f64]) -> Option<f64> {
    let mut readings: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    readings.sort_unstable_by(f64::total_cmp);
    let span = readings.last()? - readings.first()?;
    let mut levels = readings.clone();
    levels.dedup_by(|next, kept| *next - *kept <= SAME_LEVEL * span);
    let step = step_of(&levels)?;
    if readings.len() < OFTEN * levels.len() {
        return Some(step);
    }
    Some(coarser(&readings, &levels, step).unwrap_or(step))
}

/// The largest multiple of `step` of which nearly all `readings`, and most of their `levels`, both in order, are multiples; none where that
/// is `step` itself.
fn coarser(readings: &[f64], levels: &[f64], step: f64) -> Option<f64> {
    let mut begins: Vec<usize> =
        levels.iter().map(|level| readings.partition_point(|reading| reading < level)).collect();
    begins.push(readings.len());
    let counts: Vec<usize> = begins.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let anchor = levels[(0..levels.len()).max_by_key(|k| counts[*k])?];
    let places: Vec<i64> = levels.iter().map(|level| ((level - anchor) / step).round() as i64).collect();
    let mut multiples: Vec<i64> =
        places.windows(2).map(|pair| pair[1] - pair[0]).filter(|m| *m > 1).collect();
    multiples.sort_unstable();
    multiples.dedup();
    let is_step = |multiple: &i64| {
        let on = || (0..places.len()).filter(|k| places[*k] % multiple == 0);
        let readings_on: usize = on().map(|k| counts[k]).sum();
        let readings_on = readings_on as f64 >= (1.0 - ODD) * readings.len() as f64;
        readings_on && on().count() as f64 >= MOST_LEVELS * places.len() as f64
    };
    multiples.into_iter().rev().find(is_step).map(|multiple| multiple as f64 * step)
}

/// The step of `levels` in order.
fn step_of(levels: &[f64]) -> Option<f64> {
    if levels.len() < FEWEST_LEVELS {
        return None;
    }
    let gaps: Vec<f64> = levels.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let smallest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let near: Vec<f64> = gaps.iter().copied().filter(|gap| *gap < 1.5 * smallest).collect();
    let typical = near.iter().sum::<f64>() / near.len() as f64;
    (1..=3).find_map(|divisor| fit(&gaps, typical / f64::from(divisor)))
}

/// What one count may be written as in a few digits.
const MOST_ROUNDINGS: usize = 3;

fn fit(gaps: &[f64], start: f64) -> Option<f64> {
    let mut step = start;
    for _ in 0..3 {
        let (mut numerator, mut denominator) = (0.0, 0.0);
        for gap in gaps {
            let multiple = (gap / step).round();
            numerator += gap * multiple;
            denominator += multiple * multiple;
        }
        step = numerator / denominator;
    }
    if !is_counted(gaps, step) {
        return None;
    }
    let agreeing = gaps.iter().filter(|&gap| ((gap / step) - (gap / step).round()).abs() < TOLERANCE).count();
    (agreeing as f64 >= AGREEING * gaps.len() as f64).then_some(step)
}

/// Whether `gaps` can be whole numbers of a `step`. Where every gap is one and the same number of steps they are alike, or as many as the last
/// digit makes of one: a shaft that turns on evenly goes nearly as far in every interval, but not quite.
fn is_counted(gaps: &[f64], step: f64) -> bool {
    let multiple = |gap: &f64| (gap / step).round();
    if gaps.iter().any(|gap| multiple(gap) != multiple(&gaps[0])) {
        return true;
    }
    let mut sizes = gaps.to_vec();
    sizes.sort_unstable_by(f64::total_cmp);
    sizes.dedup_by(|next, kept| *next - *kept < 1e-4 * step);
    sizes.len() <= MOST_ROUNDINGS
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn swing(i: usize) -> f64 {
        (i as f64 * 0.013).sin() * 2.0 + (i as f64 * 0.0071).cos()
    }

    #[test]
    fn a_shaft_that_turns_on_shows_no_step_in_the_way_of_an_interval() {
        let turning: Vec<f64> =
            (0..100).map(|k| f64::from(k) * 1.24 + 0.4 * (f64::from(k) * 0.15).sin()).collect();
        let written: Vec<f64> = turning.iter().map(|x| (x * 1e4).round() / 1e4).collect();
        assert_eq!(quantum(&written), None);
        let counted: Vec<f64> = (0..100).map(|k| (f64::from(k) * 0.006_14 * 1e3).round() / 1e3).collect();
        assert!(
            quantum(&counted).is_some_and(|step| (step / 0.006_14 - 1.0).abs() < 0.02),
            "{:?}",
            quantum(&counted)
        );
    }

    #[test]
    fn an_encoder_step_is_found_even_if_written_with_few_digits() {
        let step = TAU / 4992.0;
        let counted: Vec<f64> = (0..5000).map(|i| (swing(i) / step).floor() * step + 0.77).collect();
        let found = quantum(&counted).unwrap();
        assert!((found / step - 1.0).abs() < 1e-6, "{found} {step}");
        let written: Vec<f64> = counted.iter().map(|value| (value * 1e4).round() / 1e4).collect();
        let found = quantum(&written).unwrap();
        assert!((found / step - 1.0).abs() < 0.01, "{found} {step}");
    }

    #[test]
    fn a_speed_that_skips_levels_still_shows_its_step() {
        let levels = [0.0, 2.0, 5.0, 7.0, 11.0, 14.0, 20.0, 23.0];
        let speed: Vec<f64> = (0..400).map(|i| levels[(i * 7) % 8] * 0.1122).collect();
        let found = quantum(&speed).unwrap();
        assert!((found - 0.1122).abs() < 1e-6, "{found}");
    }

    /// Tens of turns a minute, of which four readings in a hundred lie between.
    #[test]
    fn a_few_odd_readings_do_not_make_the_step_small() {
        let level = |k: usize| 10.0 * ((k * 7) % 19) as f64;
        let speed: Vec<f64> = (0..200).map(|k| if k % 25 == 3 { 59.0 } else { level(k) }).collect();
        assert!(quantum(&speed).is_some_and(|step| (step - 10.0).abs() < 1e-6), "{:?}", quantum(&speed));
        // More than that are a level of their own.
        let speed: Vec<f64> = (0..200).map(|k| if k % 5 == 3 { 59.0 } else { level(k) }).collect();
        assert!(quantum(&speed).is_some_and(|step| step < 1.01), "{:?}", quantum(&speed));
    }

    #[test]
    fn continuous_and_constant_columns_have_no_step() {
        let smooth: Vec<f64> = (0..3000).map(swing).collect();
        assert_eq!(quantum(&smooth), None);
        assert_eq!(quantum(&[1.0; 100]), None);
        assert_eq!(quantum(&[]), None);
    }
}
