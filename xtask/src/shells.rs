//! Completions in the shells that they are for, and the manual pages in `man`. PowerShell is not in Debian's archive: its script is written
//! by the same generator, and read by nobody here.

use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::report::Count;
use crate::{apt, process};

/// A shell, the option before a command of its own, how it is asked what it makes of the beginning of a verb, and the answer's first word.
const SHELLS: [[&str; 4]; 3] = [
    [
        "bash",
        "-c",
        "source ./script; COMP_WORDS=(motorlens tu); COMP_CWORD=1; _motorlens motorlens tu motorlens; echo ${COMPREPLY[@]}",
        "tune",
    ],
    // Its completions ask for a terminal: whether it has taken them is asked instead.
    [
        "zsh",
        "-fc",
        "autoload -Uz compinit && compinit -u -D && source ./script && print $_comps[motorlens]",
        "_motorlens",
    ],
    ["fish", "-c", "source script; complete -C 'motorlens tu'", "tune"],
];

/// One for each shell, and one for the pages.
pub fn tests() -> Result<Count> {
    apt::ensure_apt(&["bash", "zsh", "fish", "man-db"])?;
    let program = process::program()?;
    let here = process::target().join("shells");
    let pages = here.join("pages");
    std::fs::create_dir_all(&pages)?;
    for [shell, option, asked, wanted] in SHELLS {
        let script = process::output(Command::new(&program).args(["completions", shell]))?;
        std::fs::write(here.join("script"), script)?;
        let said = process::output(Command::new(shell).current_dir(&here).args([option, asked]))?;
        ensure!(said.split_whitespace().next() == Some(wanted), "{shell} says \"{said}\", not {wanted}");
    }
    process::run(Command::new(&program).arg("man").arg(&pages))?;
    for page in std::fs::read_dir(&pages)? {
        let page = page?.path();
        let read = Command::new("man").args(["--warnings", "-l"]).arg(&page).output();
        let read = read.context("cannot start man")?;
        let said = String::from_utf8_lossy(&read.stderr);
        ensure!(read.status.success() && said.is_empty(), "{}: {said}", page.display());
    }
    Ok(Count { passed: 1 + SHELLS.len() as u64, ..Count::default() })
}
