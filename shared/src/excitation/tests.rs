//! What every programme promises: bounds, lengths, repeatability, readable faults.

use super::*;
use proptest::prelude::*;
use std::f64::consts::{LN_2, TAU};
use std::string::{String as Text, ToString};
use std::vec::Vec as List;

fn play(programme: &Programme, rate_hz: u32) -> List<f32> {
    Player::new(programme, rate_hz).unwrap().collect()
}

fn any_shape() -> impl Strategy<Value = Shape> {
    let volts = 0.1f32..24.0;
    prop_oneof![
        Just(Shape::Rest),
        (volts.clone(), 0.1f32..20.0, -5.0f32..5.0).prop_map(|(amplitude_v, frequency_hz, offset_v)| {
            Shape::Sine { amplitude_v, frequency_hz, offset_v }
        }),
        (volts.clone(), 0.1f32..1.0, 2.0f32..20.0, 1u8..=14, any::<u32>()).prop_map(
            |(amplitude_v, low_hz, high_hz, tones, seed)| Shape::Multisine {
                amplitude_v,
                low_hz,
                high_hz,
                tones,
                seed,
            }
        ),
        (volts.clone(), 0.1f32..1.0, 2.0f32..20.0)
            .prop_map(|(amplitude_v, low_hz, high_hz)| { Shape::Chirp { amplitude_v, low_hz, high_hz } }),
        (volts.clone(), 0.05f32..3.0, any::<u32>())
            .prop_map(|(amplitude_v, hold_s, seed)| { Shape::Staircase { amplitude_v, hold_s, seed } }),
        (volts.clone(), 0.1f32..10.0)
            .prop_map(|(amplitude_v, period_s)| Shape::Triangle { amplitude_v, period_s }),
        (volts.clone(), 0.02f32..1.0, any::<u32>())
            .prop_map(|(amplitude_v, chip_s, seed)| { Shape::Prbs { amplitude_v, chip_s, seed } }),
        volts.clone().prop_map(|amplitude_v| Shape::PulseAndCoast { amplitude_v }),
        (-24.0f32..24.0).prop_map(|level_v| Shape::Step { level_v }),
        (volts, 0.1f32..20.0)
            .prop_map(|(amplitude_v, frequency_hz)| Shape::Square { amplitude_v, frequency_hz }),
    ]
}

fn any_programme() -> impl Strategy<Value = Programme> {
    prop::collection::vec((any_shape(), 0.6f32..4.0), 1..5).prop_map(|parts| {
        let segments = parts.into_iter().map(|(shape, seconds)| Segment { shape, seconds });
        Programme::sequence("any", segments).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn stays_within_the_stated_peak_and_ends_on_time(programme in any_programme(), rate in 100u32..2000) {
        prop_assume!(programme.validate(100.0).is_ok());
        let volts = play(&programme, rate);
        let peak = programme.peak_v();
        prop_assert!(volts.iter().all(|v| v.abs() <= peak * (1.0 + 2.0 * f32::EPSILON)));
        let expected = programme.seconds() * rate as f32;
        prop_assert!((volts.len() as f32 - expected).abs() <= programme.segments.len() as f32);
    }

    #[test]
    fn plays_the_same_again_after_a_rewind_and_after_json(programme in any_programme()) {
        prop_assume!(programme.validate(100.0).is_ok());
        let text = serde_json::to_string(&programme).unwrap();
        let read: Programme = serde_json::from_str(&text).unwrap();
        prop_assert_eq!(&read, &programme);
        let mut player = Player::new(&read, 500).unwrap();
        let first: List<f32> = player.by_ref().collect();
        prop_assert_eq!(player.len(), 0);
        player.rewind();
        prop_assert_eq!(player.len(), first.len());
        prop_assert_eq!(first, player.collect::<List<f32>>());
    }

    #[test]
    fn a_multisine_reaches_its_crest_but_never_exceeds_it(seed in any::<u32>()) {
        let shape = Shape::Multisine { amplitude_v: 8.0, low_hz: 0.1, high_hz: 8.0, tones: 14, seed };
        let peak = play(&Programme::single("m", shape, 8.0), 1000)
            .into_iter().map(f32::abs).fold(0.0, f32::max);
        prop_assert!(peak <= 8.0 && peak > 0.975 * 8.0, "{peak}");
    }
}

#[test]
fn a_sine_follows_f64_within_the_stated_bound() {
    let shape = Shape::Sine { amplitude_v: 7.0, frequency_hz: 3.7, offset_v: 0.0 };
    let frequency = f64::from(3.7f32);
    for (k, volts) in play(&Programme::single("s", shape, 100.0), 1000).into_iter().enumerate() {
        let exact = 7.0 * (TAU * frequency * k as f64 / 1000.0).sin();
        let bound = 7.0 * (4e-7 + TAU * k as f64 / 2f64.powi(33));
        assert!((f64::from(volts) - exact).abs() <= bound, "sample {k}");
    }
}

#[test]
fn a_chirp_follows_f64_within_the_stated_bound_and_ends_at_its_high_frequency() {
    let shape = Shape::Chirp { amplitude_v: 8.0, low_hz: 0.5, high_hz: 8.0 };
    let octaves = 4.0 / 10.0;
    for (k, volts) in play(&Programme::single("c", shape, 10.0), 1000).into_iter().enumerate() {
        let cycles = 0.5 / (octaves * LN_2) * ((octaves * k as f64 / 1000.0).exp2() - 1.0);
        let bound = 8.0 * (4e-7 + TAU * 3e-7 * (1.0 + cycles));
        assert!((f64::from(volts) - 8.0 * (TAU * cycles).sin()).abs() <= bound, "sample {k}");
    }
}

#[test]
fn a_triangle_starts_at_zero_rises_and_peaks_at_a_quarter() {
    let shape = Shape::Triangle { amplitude_v: 2.0, period_s: 4.0 };
    let volts = play(&Programme::single("t", shape, 4.0), 1000);
    for (k, expected) in [(0, 0.0), (500, 1.0), (1000, 2.0), (2000, 0.0), (3000, -2.0)] {
        assert!((volts[k] - expected).abs() < 1e-5, "sample {k}");
    }
}

#[test]
fn a_staircase_holds_every_level_once() {
    let shape = Shape::Staircase { amplitude_v: 10.0, hold_s: 0.5, seed: 3 };
    let volts = play(&Programme::single("s", shape, 5.5), 100);
    let mut levels: List<f32> = volts
        .chunks(50)
        .map(|held| {
            assert!(held.iter().all(|v| v == &held[0]));
            held[0]
        })
        .collect();
    levels.sort_by(f32::total_cmp);
    for (index, level) in levels.iter().enumerate() {
        assert!((level - (-10.0 + 2.0 * index as f32)).abs() < 1e-5);
    }
    assert_eq!(levels.len(), 11);
}

#[test]
fn a_prbs_changes_only_at_chips_and_its_seed_matters() {
    let prbs = |seed| {
        let shape = Shape::Prbs { amplitude_v: 9.0, chip_s: 0.06, seed };
        play(&Programme::single("p", shape, 30.0), 1000)
    };
    let volts = prbs(1);
    for chip in volts.chunks(60) {
        assert!(chip.iter().all(|v| v == &chip[0] && v.abs() == 9.0));
    }
    let mean: f32 = volts.iter().sum::<f32>() / volts.len() as f32;
    assert!(mean.abs() < 2.0);
    assert_ne!(volts, prbs(2));
}

#[test]
fn pulses_coast_at_zero_between_both_signs() {
    let volts = play(&Programme::single("p", Shape::PulseAndCoast { amplitude_v: 10.0 }, 8.0), 100);
    let at = |seconds: f32| volts[(seconds * 100.0) as usize];
    assert_eq!(
        [0.0, 0.79, 0.8, 1.5, 2.3, 3.0, 3.5, 6.5, 6.6].map(at),
        [10.0, 10.0, 0.0, -10.0, 0.0, 5.0, 0.0, -3.0, 10.0]
    );
}

#[test]
fn the_default_protocol_takes_48_seconds_and_scales_with_the_supply() {
    let protocol = Programme::default_protocol(12.0);
    assert_eq!(protocol.seconds(), 48.0);
    let peaks = protocol.training.clone().map(|programme| programme.peak_v());
    assert_eq!(peaks, [2.0, 10.0, 8.0, 9.0, 10.0]);
    assert_eq!(protocol.held_out.peak_v(), 6.0);
    let half = Programme::default_protocol(6.0);
    for programme in half.training.iter().chain([&half.held_out]) {
        programme.validate(5.0).unwrap();
        assert_eq!(Player::new(programme, 1000).unwrap().samples(), 8000);
    }
}

#[test]
fn faults_name_the_segment_and_the_remedy() {
    let fault = |shape, seconds| -> Text {
        let good = Segment { shape: Shape::Rest, seconds: 1.0 };
        let programme = Programme::sequence("f", [good, Segment { shape, seconds }]).unwrap();
        match programme.validate(12.0) {
            Err(error) => error.to_string(),
            Ok(()) => Player::new(&programme, 100).unwrap_err().to_string(),
        }
    };
    let sine = |amplitude_v, frequency_hz| Shape::Sine { amplitude_v, frequency_hz, offset_v: 0.0 };
    assert!(fault(sine(f32::NAN, 1.0), 1.0).starts_with("segment 2: a parameter is not finite"));
    assert!(fault(sine(13.0, 1.0), 1.0).contains("asks for 13 V but the limit is 12 V"));
    assert!(fault(sine(1.0, 80.0), 1.0).contains("too fast for 100 samples"));
    assert!(fault(Shape::Rest, 0.0).contains("seconds must be"));
    assert!(fault(Shape::Rest, f32::INFINITY).contains("seconds must be"));
    assert!(fault(Shape::Step { level_v: f32::INFINITY }, 1.0).contains("not finite"));
    let multisine =
        |tones, low_hz| Shape::Multisine { amplitude_v: 1.0, low_hz, high_hz: 8.0, tones, seed: 0 };
    assert!(fault(multisine(15, 0.1), 1.0).contains("tones must be 1 to 14"));
    assert!(fault(multisine(14, 9.0), 1.0).contains("the band is empty"));
    assert!(fault(multisine(14, 1.0), 1000.0).contains("more than 4096 cycles"));
    assert_eq!(
        Programme::sequence("e", []).unwrap().validate(1.0),
        Err(ProgrammeError { segment: None, fault: Fault::Empty })
    );
}

#[test]
fn json_reads_like_the_documentation() {
    let programme: Programme = serde_json::from_str(
        r#"{"name":"mine","segments":[{"shape":{"sine":{"amplitude_v":3,"frequency_hz":0.25}},"seconds":12},
            {"shape":"rest","seconds":1}]}"#,
    )
    .unwrap();
    assert_eq!(programme.seconds(), 13.0);
    assert!(serde_json::from_str::<Programme>(r#"{"name":"x","segment":[]}"#).is_err());
}
