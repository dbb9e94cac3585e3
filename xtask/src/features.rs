//! The library with each cargo feature alone, and its tests on slices with none: who depends on a part pays for that part only.

use anyhow::{Context, Result, bail};

use crate::process;
use crate::report::Count;

/// Checks every feature that the crate's manifest names, then runs the library's tests without any.
pub fn tests() -> Result<Count> {
    let manifest = std::fs::read_to_string(process::root().join("host/Cargo.toml"))
        .context("cannot read the manifest of motorlens")?;
    let names = features(&manifest);
    if names.is_empty() {
        bail!("the manifest of motorlens names no features");
    }
    let library = || {
        let mut check = process::cargo();
        check.args(["check", "--package", "motorlens", "--lib", "--locked", "--no-default-features"]);
        check
    };
    for name in &names {
        process::run(library().args(["--features", name]))
            .with_context(|| format!("motorlens does not build with its feature {name} alone"))?;
    }
    let mut slices = process::cargo();
    slices.args(["test", "--package", "motorlens", "--test", "library", "--locked", "--no-default-features"]);
    let mut count = process::run_tests(&mut slices)?;
    count.passed += names.len() as u64;
    Ok(count)
}

/// The names under `[features]`, but for `default`.
fn features(manifest: &str) -> Vec<String> {
    let lines = manifest.lines().skip_while(|line| *line != "[features]").skip(1);
    lines
        .take_while(|line| !line.starts_with('['))
        .filter_map(|line| line.split_once(" = "))
        .map(|(name, _)| name.to_owned())
        .filter(|name| name != "default" && !name.starts_with('#'))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::features;

    #[test]
    fn features_are_the_names_of_their_table() {
        let manifest = "[dependencies]\nserde = \"1\"\n\n[features]\ndefault = [\"cli\"]\n# The program = all.\ncli = []\nlog-mat = []\n\n[[bin]]\nname = \"x\"\n";
        assert_eq!(features(manifest), ["cli", "log-mat"]);
    }
}
