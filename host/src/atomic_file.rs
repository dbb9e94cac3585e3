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
/// Wrong usage naming the path if its folder is absent or not writable, or if it is a folder itself; [`Error::Io`] if the disk is full, or
/// `fill` fails.
pub fn write_with<F>(path: &Path, fill: F) -> Result<()>
where
    F: FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
{
    may_write(path)?;
    replace(path, fill).map_err(|source| refused(path, source))
}

/// Whether a file may be made at `path`, to be asked before a search of minutes whose result is to be kept there.
///
/// # Errors
/// Wrong usage where its folder is absent, or `path` is a folder itself.
pub fn may_write(path: &Path) -> Result<()> {
    let directory = directory_of(path);
    let cannot = |why: String| format!("cannot write {}: {why}", path.display());
    if path.is_dir() {
        let why = cannot("it is a folder".into());
        return Err(Error::usage(why, "give the name of a file in it"));
    }
    if !directory.is_dir() {
        let why = cannot(format!("there is no folder {}", directory.display()));
        return Err(Error::usage(
            why,
            format!("make it first (mkdir {}), or write elsewhere", directory.display()),
        ));
    }
    Ok(())
}

/// What the operating system refused, with what to do where that is the user's to mend.
fn refused(path: &Path, source: io::Error) -> Error {
    let doing = format!("cannot write {}", path.display());
    match source.kind() {
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            let directory = directory_of(path).display().to_string();
            Error::usage(
                format!("{doing}: this user may make no file in {directory}"),
                "write elsewhere, or take the right to write there",
            )
        }
        _ => Error::Io { doing, source },
    }
}

/// The folder in which the file at `path` is to be.
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
    fn an_absent_folder_is_named_with_what_to_do() {
        let directory = tempfile::tempdir().unwrap();
        for (path, cause, remedy) in [
            (directory.path().join("absent/model.json"), "there is no folder", "do: make it first (mkdir "),
            (directory.path().to_owned(), "it is a folder", "do: give the name of a file"),
        ] {
            let error = write(&path, "").unwrap_err();
            let said = error.to_string();
            assert!(said.contains(&path.display().to_string()) && said.contains(cause), "{said}");
            assert!(error.exit_code() == 2 && said.contains(remedy), "{said}");
        }
        assert!(names(directory.path()).is_empty());
    }
}
