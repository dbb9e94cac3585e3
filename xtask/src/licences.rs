//! Every dependency must be usable under a permissive licence.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use cargo_metadata::{CargoOpt, MetadataCommand};
use spdx::{Expression, LicenseReq};

use crate::process;

/// Licences that ask for nothing more than their text kept. MPL-2.0 is not here: a crate under it needs a reason,
/// and gets a row in [`EXCEPTIONS`].
const PERMISSIVE: [&str; 15] = [
    "MIT",
    "MIT-0",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "0BSD",
    "ISC",
    "NCSA",
    "Zlib",
    "Unlicense",
    "CC0-1.0",
    "BSL-1.0",
    "Unicode-3.0",
    "Unicode-DFS-2016",
    "CDLA-Permissive-2.0",
];

/// Crates under another licence, each with the licence that was looked at and accepted.
const EXCEPTIONS: [(&str, &str); 0] = [];

/// Checks the host's workspace and every one beside it.
pub fn check_all() -> Result<()> {
    for manifest in workspaces() {
        let count = check(&manifest)?;
        println!("{}: {count} crates, all permissive", manifest.display());
    }
    Ok(())
}

/// Manifests of all workspaces of the repository: each has a lock file of its own.
pub fn workspaces() -> Vec<PathBuf> {
    let root = process::root();
    let mut directories = vec![root.clone(), root.join("firmware"), root.join("tests"), root.join("python")];
    for parent in [root.join("firmware"), root.join("tests")] {
        let inside = std::fs::read_dir(parent).into_iter().flatten().flatten().map(|entry| entry.path());
        directories.extend(inside);
    }
    let mut manifests: Vec<PathBuf> = directories
        .into_iter()
        .filter(|d| d.join("Cargo.lock").is_file())
        .map(|d| d.join("Cargo.toml"))
        .collect();
    manifests.sort();
    manifests
}

/// Checks one workspace and returns how many crates it uses. The error names every offender.
fn check(manifest: &Path) -> Result<usize> {
    let metadata = MetadataCommand::new()
        .manifest_path(manifest)
        .features(CargoOpt::AllFeatures)
        .other_options(vec!["--filter-platform".to_owned(), "x86_64-unknown-linux-gnu".to_owned()])
        .exec()
        .or_else(|_| MetadataCommand::new().manifest_path(manifest).exec())
        .with_context(|| format!("cargo metadata for {}", manifest.display()))?;
    let used = metadata
        .resolve
        .as_ref()
        .map(|resolve| resolve.nodes.iter().map(|node| &node.id))
        .into_iter()
        .flatten();
    let used: std::collections::HashSet<_> = used.collect();
    let mut offenders = Vec::new();
    for package in metadata.packages.iter().filter(|package| used.contains(&package.id)) {
        let licence = package.license.as_deref().unwrap_or("no licence stated");
        let excepted = EXCEPTIONS.contains(&(package.name.as_str(), licence));
        if !excepted && !permissive(licence) {
            offenders.push(format!("{} {} ({licence})", package.name, package.version));
        }
    }
    if !offenders.is_empty() {
        bail!("not permissive: {}; replace them, or give a reason in EXCEPTIONS", offenders.join(", "));
    }
    Ok(used.len())
}

/// Whether the expression can be satisfied with permissive licences alone.
fn permissive(licence: &str) -> bool {
    let Ok(expression) = Expression::parse_mode(licence, spdx::ParseMode::LAX) else {
        return false;
    };
    expression.evaluate(|requirement: &LicenseReq| {
        requirement.license.id().is_some_and(|id| PERMISSIVE.contains(&id.name))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_workspace_uses_only_permissive_licences() {
        let all = workspaces();
        assert!(all.len() >= 4 && all.contains(&process::root().join("Cargo.toml")), "{all:?}");
        for manifest in all {
            check(&manifest).unwrap();
        }
    }

    #[test]
    fn a_choice_passes_when_one_side_is_permissive() {
        assert!(permissive("MIT OR GPL-3.0-only"));
        assert!(permissive("MIT/Apache-2.0"));
        assert!(permissive("(MIT OR Apache-2.0) AND Unicode-3.0"));
        assert!(!permissive("GPL-3.0-or-later"));
        assert!(!permissive("MIT AND MPL-2.0"));
        assert!(!permissive("no licence stated"));
    }
}
