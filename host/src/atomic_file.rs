//! Output files appear whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::error::{Error, Result};

/// Writes a file through `fill`, in a temporary file beside `path` that takes its name only when all is written.
///
/// A failure of `fill` or of the disk leaves an older file of that name as it was and nothing else behind.
///
/// # Errors
/// [`Error::Usage`] if the directory is absent or not writable, [`Error::Io`] if the disk is full or `fill` fails; either names the path.
pub fn write_with<F>(path: &Path, fill: F) -> Result<()>
where
    F: FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
{
    replace(path, fill).map_err(|source| cannot_write(path, source))
}

/// Why a file was not written, with what to do where the place that was given is at fault.
fn cannot_write(path: &Path, source: io::Error) -> Error {
    let directory = directory_of(path);
    let why = |what: &str| format!("cannot write {}: {what}", path.display());
    if !directory.is_dir() {
        let absent = why(&format!("there is no directory {}", directory.display()));
        return Error::usage(absent, "make the directory first, or give a path in one that there is");
    }
    if path.is_dir() {
        return Error::usage(why("this is a directory"), "give the name of a file in it");
    }
    if source.kind() == io::ErrorKind::PermissionDenied {
        let denied = why("this user may not write there");
        return Error::usage(denied, "give a path in a directory of your own");
    }
    Error::Io { doing: format!("cannot write {}", path.display()), source }
}

/// The directory that holds `path`.
fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Writes `content` to `path`, whole or not at all.
///
/// # Errors
/// As [`write_with`].
pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    write_with(path, |file| file.write_all(content.as_ref()))
}

fn replace<F>(path: &Path, fill: F) -> io::Result<()>
where
    F: FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
{
    let mut builder = tempfile::Builder::new();
    builder.prefix(".motorlens-");
    // A temporary file is private; a result is as readable as any other file of the user.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let temporary = builder.tempfile_in(directory_of(path))?;
    let mut file = BufWriter::new(temporary.as_file());
    fill(&mut file)?;
    file.flush()?;
    drop(file);
    temporary.as_file().sync_data()?;
    temporary.persist(path).map_err(|error| error.error)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        std::fs::read_dir(directory)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect()
    }

    #[test]
    fn a_written_file_is_whole_and_alone() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("model.json");
        write(&path, "{}").unwrap();
        write(&path, "{\"a\":1}").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "{\"a\":1}");
        assert_eq!(names(directory.path()), ["model.json"]);
    }

    #[test]
    fn a_failure_half_way_keeps_the_old_file_and_leaves_nothing() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("model.json");
        write(&path, "old").unwrap();
        let error = write_with(&path, |file| {
            file.write_all(b"half of the new")?;
            Err(io::Error::other("the disk is full"))
        })
        .unwrap_err();
        assert_eq!(error.exit_code(), 1);
        assert!(error.to_string().contains("model.json"));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(directory.path()), ["model.json"]);
    }

    #[test]
    fn an_absent_directory_is_named_with_what_to_do_and_so_is_one_in_the_place_of_a_file() {
        let directory = tempfile::tempdir().unwrap();
        let error = write(&directory.path().join("absent/model.json"), "").unwrap_err().to_string();
        assert!(error.contains("absent/model.json: there is no directory"), "{error}");
        assert!(error.contains("do: make the directory"), "{error}");
        let error = write(directory.path(), "").unwrap_err().to_string();
        assert!(error.contains("this is a directory") && error.contains("do: give the name"), "{error}");
    }
}
