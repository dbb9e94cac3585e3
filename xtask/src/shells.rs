//! Completions in the shells that they are for, and the manual pages in `man`. PowerShell is not in Debian's archive: a grammar of it reads
//! its script here.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use crate::report::Count;
use crate::{apt, exports, process};

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

/// Says whether a script has errors in its syntax. The grammar does not know that PowerShell takes a block for a method's only argument without
/// brackets around it.
const POWERSHELL: &str = "
import re, sys, tree_sitter, tree_sitter_powershell
script = re.sub(rb'[.]Where({[^}]*})', rb'.Where(\\1)', sys.stdin.buffer.read())
language = tree_sitter.Language(tree_sitter_powershell.language())
print(tree_sitter.Parser(language).parse(script).root_node.has_error)
";

/// One for each shell, and one for the pages.
pub fn tests() -> Result<Count> {
    apt::ensure_apt(&["bash", "zsh", "fish", "man-db", "python3-venv"])?;
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
    powershell(&program, &here)?;
    process::run(Command::new(&program).arg("man").arg(&pages))?;
    for page in std::fs::read_dir(&pages)? {
        let page = page?.path();
        let read = Command::new("man").args(["--warnings", "-l"]).arg(&page).output();
        let read = read.context("cannot start man")?;
        let said = String::from_utf8_lossy(&read.stderr);
        ensure!(read.status.success() && said.is_empty(), "{}: {said}", page.display());
    }
    Ok(Count { passed: 2 + SHELLS.len() as u64, ..Count::default() })
}

/// Reads the script for PowerShell, and makes sure that the reader would see an error.
fn powershell(program: &Path, here: &Path) -> Result<()> {
    let grammar = [("tree_sitter", "tree-sitter"), ("tree_sitter_powershell", "tree-sitter-powershell")];
    let python = exports::environment(&here.join("venv"), &grammar)?;
    let has_error = |script: &str| -> Result<bool> {
        let mut reader = Command::new(&python)
            .args(["-c", POWERSHELL])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .context("cannot start Python")?;
        reader.stdin.take().context("Python has no input")?.write_all(script.as_bytes())?;
        let said = reader.wait_with_output()?;
        ensure!(said.status.success(), "Python has not read the script for PowerShell");
        Ok(said.stdout.starts_with(b"True"))
    };
    let script = process::output(Command::new(program).args(["completions", "powershell"]))?;
    ensure!(!has_error(&script)?, "the script for PowerShell has an error in its syntax");
    let cut = script.trim_end().trim_end_matches('}');
    ensure!(has_error(cut)?, "a script for PowerShell that lacks its last brace is taken for whole");
    Ok(())
}
