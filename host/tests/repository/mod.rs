//! The files of this repository, for the tests that read them.

use std::path::{Path, PathBuf};

/// Where the repository begins.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// All files below `folder` that end as one of `extensions` says, but for what was built or fetched there.
pub fn files_below(folder: PathBuf, extensions: &[&str]) -> Vec<PathBuf> {
    let (mut folders, mut files) = (vec![folder], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a directory") {
            let path = entry.expect("an entry").path();
            let foreign = path.file_name().is_some_and(|name| name == "target" || name == "node_modules");
            if path.is_dir() && !foreign {
                folders.push(path);
            } else if path.extension().is_some_and(|e| extensions.iter().any(|one| e == *one)) {
                files.push(path);
            }
        }
    }
    files
}

/// What is in a file.
pub fn text_of(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
