//! Made readings, held and not.

use super::*;

const COUNT: f64 = 1e-3;

/// `seconds` of samples, that many intervals apart, each off by up to `jitter` of one.
fn stamps(interval: f64, seconds: f64, jitter: f64) -> Vec<f64> {
    let off = |k: usize| jitter * ((k as f64 * 0.754_877_666).fract() - 0.5);
    (0..(seconds / interval) as usize).map(|k| (k as f64 + off(k)) * interval).collect()
}

fn counted(angles: impl Iterator<Item = f64>) -> Vec<f64> {
    angles.map(|angle| (angle / COUNT).floor() * COUNT).collect()
}

/// A motion with turns and a stop, rad; `counts` at its fastest in a sampling interval.
fn angle(t: f64, interval: f64, counts: f64) -> f64 {
    let full = counts * COUNT / interval;
    full * (0.6 * (1.3 * t).sin() / 1.3 + 0.4 * (2.9 * t + 1.0).sin() / 2.9)
}

/// The same, updated every `hold` seconds, first `age` seconds before the first sample.
fn held(time_s: &[f64], interval: f64, counts: f64, hold: f64, age: f64) -> Vec<f64> {
    let read = |t: &f64| ((t - time_s[0] + age) / hold + 1e-9).floor() * hold - age + time_s[0];
    counted(time_s.iter().map(|t| angle(read(t), interval, counts)))
}

#[test]
fn hold_and_age_are_found_around_and_below_the_sampling_interval() {
    for (interval, ratio, jitter) in [
        (1e-2, 1.098_3, 0.0),
        (1e-2, 0.211_3, 0.0),
        (5e-3, 0.542_27, 0.0),
        (5e-3, 0.364_7, 0.3),
        (2e-3, 0.853_1, 0.0),
        (2e-3, 1.191_7, 0.3),
        (2e-3, 0.655_9, 0.3),
        (1e-3, 0.703_1, 0.0),
        (1e-3, 0.951_3, 0.0),
        // A skip every 120 samples, and one update more every 80.
        (5e-3, 1.008_4, 0.0),
        (5e-3, 0.496_9, 0.0),
    ] {
        let (hold, age) = (ratio * interval, 0.37 * ratio * interval);
        let time_s = stamps(interval, 8.0, jitter);
        let values = held(&time_s, interval, 40.0, hold, age);
        let Shown::Held(found) = beat(&time_s, &values, COUNT, None) else {
            panic!("a hold of {ratio} intervals of {interval} s went unseen")
        };
        assert!((found.time_s / hold - 1.0).abs() < 4e-5, "{} for {hold}", found.time_s);
        for dated in [found.age_s, super::age(&time_s, &values, COUNT, hold)] {
            let wrong = (dated - age) / hold;
            assert!((wrong - wrong.round()).abs() < 0.03, "{dated} s old for {age}");
        }
        let Shown::Held(again) = beat(&time_s, &values, COUNT, Some(hold)) else {
            panic!("{hold} s are denied")
        };
        assert!((again.time_s / hold - 1.0).abs() < 4e-5, "{} for {hold}", again.time_s);
        assert_eq!(beat(&time_s, &values, COUNT, Some(1.07 * hold)), Shown::Otherwise);
    }
}

#[test]
fn numbers_of_updates_sharpen_hold_and_ages_of_several_records() {
    for (interval, ratio, jitter) in [(1e-2, 1.098_3, 0.0), (5e-3, 0.542_27, 0.0), (2e-3, 0.655_9, 0.3)] {
        let (hold, time_s) = (ratio * interval, stamps(interval, 8.0, jitter));
        let ages = [0.11, 0.52, 0.93].map(|share| share * hold);
        let records = ages.map(|age| held(&time_s, interval, 400.0, hold, age));
        let about = hold * (1.0 + 2e-5);
        let guess = |values: &[f64]| super::age(&time_s, values, COUNT, about);
        let numbers = records.map(|values| Numbers::new(&time_s, &values, COUNT, about, guess(&values)));
        let found = hold_of(&numbers, about);
        assert!((found / hold - 1.0).abs() < 6e-6, "{found} for {hold}");
        for (numbers, age) in numbers.iter().zip(ages) {
            let dated = numbers.age(found).expect("an age");
            assert!((dated - age).abs() < 0.005 * interval, "{dated} s old for {age}");
        }
    }
}

#[test]
fn readings_that_are_not_held_show_none() {
    for interval in [1e-3, 2e-3, 5e-3, 1e-2] {
        for (counts, jitter) in [(3.0, 0.0), (12.0, 0.3), (40.0, 0.0), (400.0, 0.3), (3000.0, 0.0)] {
            let time_s = stamps(interval, 8.0, jitter);
            let values = counted(time_s.iter().map(|t| angle(*t, interval, counts)));
            let shown = beat(&time_s, &values, COUNT, None);
            assert!(!matches!(shown, Shown::Held(_)), "{shown:?}");
        }
    }
}

#[test]
fn beats_of_the_counting_at_a_steady_speed_are_none() {
    for speed in [0.31, 1.52, 5.09, 12.52, 87.31] {
        let values = counted((0..4000).map(|k| f64::from(k) * speed * COUNT));
        assert_eq!(beat(&stamps(2e-3, 8.0, 0.0), &values, COUNT, None), Shown::Nothing);
    }
}

#[test]
fn ripple_of_teeth_is_none() {
    for (counts, order, ripple) in
        [(40.0, 12.0, 4.0), (40.0, 57.0, 2.0), (400.0, 3.0, 40.0), (15.0, 130.0, 3.0)]
    {
        let time_s = stamps(5e-3, 8.0, 0.0);
        let turned = |t: &f64| angle(*t, 5e-3, counts);
        let angles = time_s.iter().map(turned).map(|a| a + ripple * COUNT * (order * a).sin());
        let shown = beat(&time_s, &counted(angles), COUNT, None);
        assert!(!matches!(shown, Shown::Held(_)), "{shown:?}");
    }
}

#[test]
fn long_holds_are_left_to_the_instants_of_their_changes() {
    let time_s = stamps(1e-3, 8.0, 0.0);
    for hold in [4.3e-3, 6.224e-3, 12.8e-3] {
        let values = held(&time_s, 1e-3, 40.0, hold, 0.0);
        assert!(!matches!(beat(&time_s, &values, COUNT, None), Shown::Held(_)), "{hold}");
    }
}
