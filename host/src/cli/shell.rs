//! `completions` and `man`: what shells and manuals know of the program, from the one description of its options.

use std::path::PathBuf;

use clap::CommandFactory;
use clap_complete::Shell;

use super::next::shell;
use super::{Cli, Console};
use crate::atomic_file;
use crate::error::{Error, Result};

/// Options of `completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens completions bash > ~/.local/share/bash-completion/completions/motorlens
  motorlens completions fish > ~/.config/fish/completions/motorlens.fish
  motorlens completions zsh > \"${fpath[1]}/_motorlens\"
  motorlens completions powershell | Out-String | Invoke-Expression   # in $PROFILE")]
pub struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Options of `man`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  motorlens man ~/.local/share/man/man1 && man motorlens-discover")]
pub struct Man {
    /// Write motorlens.1 and a page for each verb into this directory
    directory: PathBuf,
}

/// Prints the script.
pub fn completions(args: &Completions, _console: &Console) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "motorlens", &mut script);
    // A reader that has gone away is no failure.
    let _ = std::io::Write::write_all(&mut std::io::stdout(), &script);
    Ok(())
}

/// Writes the pages.
pub fn man(args: &Man, console: &Console) -> Result<()> {
    let failed = |source| Error::Io { doing: format!("cannot write {}", args.directory.display()), source };
    std::fs::create_dir_all(&args.directory).map_err(failed)?;
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    let mut pages = vec![("motorlens".to_owned(), program)];
    let mut written = Vec::new();
    // A verb's own verbs, as those of device, have pages too: its page refers to them.
    while let Some((name, command)) = pages.pop() {
        let below = command.get_subcommands().filter(|verb| verb.get_name() != "help");
        pages.extend(below.map(|verb| {
            let name = format!("{name}-{}", verb.get_name());
            let page = verb.clone().bin_name(name.replace('-', " ")).display_name(name.clone());
            (name, page)
        }));
        let mut page = Vec::new();
        clap_mangen::Man::new(command).render(&mut page).map_err(failed)?;
        let path = args.directory.join(format!("{name}.1"));
        atomic_file::write(&path, page)?;
        written.push(path);
    }
    console.answer(&serde_json::json!({ "schema": 1, "pages": written }), || {
        format!("{} pages in {}", written.len(), args.directory.display())
    });
    console.next("read the first", &format!("man {}", shell(&args.directory.join("motorlens.1"))));
    Ok(())
}
