//! The plant against closed forms, and the cases against what they promise.

use motorlens_bench_motor::{Bench, Case, Group};

/// A stand-in for the default protocol: steps each way.
fn steps(supply: f64, rate: f64) -> Vec<(String, Vec<f64>)> {
    let square = |top: f64, period: f64| -> Vec<f64> {
        (0..(6.0 * rate) as usize)
            .map(|k| if ((k as f64 / rate / period) as usize).is_multiple_of(2) { top } else { -top })
            .collect()
    };
    vec![
        ("steps".into(), square(0.6 * supply, 0.7)),
        ("fast".into(), square(0.3 * supply, 0.2)),
        ("kept out".into(), square(0.5 * supply, 0.45)),
    ]
}

#[test]
fn the_same_seed_gives_the_same_case_and_every_column_has_a_value_for_every_stamp() {
    for bench in Bench::ALL {
        let (a, b) = (Case::new(bench, 3, &steps), Case::new(bench, 3, &steps));
        assert_eq!(a.hidden, b.hidden);
        assert!(!a.training.is_empty() && !a.held_out.is_empty());
        for (x, y) in a.training.iter().chain(&a.held_out).zip(b.training.iter().chain(&b.held_out)) {
            assert_eq!(x.reading(), y.reading());
            assert_eq!(x.time_s.len(), x.reading().len());
            assert_eq!(x.time_s.len(), x.voltage_v.len());
            assert!(x.time_s.windows(2).all(|w| w[1] > w[0]), "{bench:?}");
            assert!(x.reading().iter().all(|x| x.is_finite()), "{bench:?} {:?}", a.hidden);
        }
    }
}

#[test]
fn what_is_asked_for_shows_in_the_records() {
    for seed in 1..6 {
        let case = Case::new(Bench::FewDecimals, seed, &steps);
        for hidden in case.hidden.iter().filter(|h| h.asked) {
            assert!(hidden.visibility.is_some_and(|seen| seen >= 0.5), "{hidden:?}");
        }
        let asked = case.hidden.iter().filter(|h| h.asked).count();
        let own = usize::from(case.group == Group::Single || case.group == Group::Outside);
        assert!(asked >= own, "{:?} {:?}", case.group, case.hidden);
    }
}
