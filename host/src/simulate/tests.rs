//! The verbs `simulate` and `reveal` from their options to their files.

use super::*;
use crate::log::{ReadOptions, read};
use clap::Parser;

#[derive(Parser)]
enum Verb {
    Simulate(SimulateArgs),
    Reveal(RevealArgs),
}

fn simulate(out: &Path, options: &str) -> Result<Simulated> {
    let out = out.to_str().unwrap();
    let words = ["motorlens", "simulate", "--out", out].into_iter().chain(options.split_whitespace());
    match Verb::parse_from(words) {
        Verb::Simulate(args) => run(&args),
        Verb::Reveal(_) => unreachable!(),
    }
}

fn revealed(directory: &Path) -> Result<Answer> {
    match Verb::parse_from(["motorlens", "reveal", directory.to_str().unwrap()]) {
        Verb::Reveal(args) => reveal(&args),
        Verb::Simulate(_) => unreachable!(),
    }
}

#[test]
fn the_default_protocol_becomes_logs_that_the_reader_understands() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("new/logs");
    let simulated = simulate(&out, "--effect coulomb=0.4 --rate 200 --current").unwrap();
    assert_eq!(simulated.training.len(), 5);
    assert_eq!(simulated.held_out, [out.join("holdout-multisine-2.csv")]);
    assert_eq!(simulated.effects.as_deref(), Some(&["coulomb=0.4".to_owned()][..]));
    let options =
        ReadOptions { motor: motor_file::read(&simulated.motor).unwrap(), ..ReadOptions::default() };
    for path in simulated.training.iter().chain(&simulated.repeats).chain(&simulated.held_out) {
        let record = &read(path, &options).unwrap()[0];
        assert_eq!(record.len(), 1600, "{}", path.display());
        assert!(record.warnings.is_empty(), "{:?}", record.warnings);
        assert!(record.current_a.is_some() && record.supply_v.is_none());
        assert_eq!(record.meta.gear_ratio(), Some(104.0));
        assert_eq!(record.meta.counts_per_rev(), Some(5000.0));
    }
}

#[test]
fn the_repeat_has_the_voltage_of_its_original_and_other_noise() {
    let directory = tempfile::tempdir().unwrap();
    let simulated = simulate(directory.path(), "--rate 200 --disturbance 0.02").unwrap();
    let options = ReadOptions::default();
    let original = &read(&directory.path().join("multisine.csv"), &options).unwrap()[0];
    let repeat = &read(&simulated.repeats[0], &options).unwrap()[0];
    assert_eq!(original.voltage_v, repeat.voltage_v);
    assert_ne!(original.angle_rad, repeat.angle_rad);
    assert_eq!(repeat.meta.get("repeat_of"), original.meta.programme());
}

#[test]
fn a_hidden_effect_is_told_by_reveal_and_by_no_file() {
    let directory = tempfile::tempdir().unwrap();
    let seed =
        (0..).find(|seed| hidden(*seed, &motorlens_virtual_motor::Motor::hidden(*seed)).len() == 2).unwrap();
    let simulated = simulate(directory.path(), &format!("--hidden {seed} --rate 100 --seconds 2")).unwrap();
    assert_eq!(simulated.effects, None);
    let answer = revealed(directory.path()).unwrap();
    assert_eq!(answer.effects.len(), 2);
    for file in std::fs::read_dir(directory.path()).unwrap() {
        let text = std::fs::read_to_string(file.unwrap().path()).unwrap();
        assert!(answer.effects.iter().all(|effect| !text.contains(effect.as_str())));
    }
    assert!(!simulated.to_string().contains(&answer.effects[0]));
    assert!(answer.to_string().contains(&answer.sizes[1]));
}

#[test]
fn the_same_options_write_the_same_bytes() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for directory in [&one, &two] {
        simulate(
            directory.path(),
            "--motor random --seed 9 --excitation prbs --disturbance 0.01 --jitter 0.1 --rate 300",
        )
        .unwrap();
    }
    for file in std::fs::read_dir(one.path()).unwrap() {
        let name = file.unwrap().file_name();
        let read = |directory: &tempfile::TempDir| std::fs::read(directory.path().join(&name)).unwrap();
        assert!(read(&one) == read(&two), "{name:?}");
    }
}

#[test]
fn wrong_usage_is_named_and_writes_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("never");
    for (options, cause) in [
        ("--effect frction=1", "no effect is called 'frction'"),
        ("--effect coulomb=-3", "outside 0 to 6"),
        ("--effect coulomb --effect coulomb=1", "given twice"),
        ("--excitation sine --amplitude 99", "the limit is 12 V"),
        ("--rate 5", "too fast for 5 samples"),
    ] {
        let error = simulate(&out, options).unwrap_err();
        assert_eq!(error.exit_code(), 2, "{options}");
        assert!(error.to_string().contains(cause), "{options}: {error}");
        assert!(!out.exists());
    }
}

#[test]
fn reveal_says_where_there_is_nothing_to_reveal_and_notices_a_change() {
    let directory = tempfile::tempdir().unwrap();
    let error = revealed(directory.path()).unwrap_err();
    assert_eq!(error.exit_code(), 3);
    assert!(error.to_string().contains("there is no sealed answer"), "{error}");
    simulate(directory.path(), "--effect gravity --rate 100 --seconds 2").unwrap();
    assert_eq!(revealed(directory.path()).unwrap().effects, ["gravity"]);
    let path = directory.path().join(SEALED_FILE);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace(&text[90..92], "zz")).unwrap();
    assert!(revealed(directory.path()).unwrap_err().to_string().contains("it was changed"));
}
