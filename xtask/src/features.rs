//! The library with each cargo feature alone, and its tests on slices with none: who depends on a part pays for that part only. The program
//! with each part that gives it verbs.
//! Compiled, not run: features choose which files are there, not what a line of them does.

use anyhow::{Context, Result, bail};

use crate::process;
use crate::report::Count;

/// Parts that have verbs of their own in the program.
const WITH_VERBS: [&str; 2] = ["device", "serve"];

/// Checks the library's tests without any feature, then the library with each one that the crate's manifest names, and the program with each
/// of those that have verbs.
pub fn tests() -> Result<Count> {
    let manifest = std::fs::read_to_string(process::root().join("host/Cargo.toml"))
        .context("cannot read the manifest of motorlens")?;
    let names = features(&manifest);
    if names.is_empty() {
        bail!("the manifest of motorlens names no features");
    }
    let check = || {
        let mut check = process::cargo();
        check.args(["check", "--package", "motorlens", "--locked", "--no-default-features"]);
        check
    };
    process::run(check().args(["--test", "library"])).context("motorlens does not build without features")?;
    for name in &names {
        process::run(check().args(["--lib", "--features", name]))
            .with_context(|| format!("motorlens does not build with its feature {name} alone"))?;
    }
    for name in WITH_VERBS {
        process::run(check().args(["--bin", "motorlens", "--features", "cli", "--features", name]))
            .with_context(|| format!("the program does not build with {name} as its only part"))?;
    }
    Ok(Count { passed: (1 + names.len() + WITH_VERBS.len()) as u64, ..Count::default() })
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
