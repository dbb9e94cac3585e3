//! Help texts on narrow terminals: prose is wrapped, an example stays one line that can be copied.

use std::io::Write;

use clap::Command;

/// Stands for the blanks of a line that is not to be broken: clap breaks lines at plain blanks only.
const HELD: char = '\u{a0}';

/// `command` and those below it with examples that no wrapping breaks, until they are [`print`]ed.
pub fn with_whole_examples(command: Command) -> Command {
    let help = command.get_after_help().map(|help| held(&help.to_string()));
    let command = match help {
        Some(help) => command.after_help(help),
        None => command,
    };
    command.mut_subcommands(with_whole_examples)
}

/// `help` with its indented lines, the examples, held together.
fn held(help: &str) -> String {
    let line =
        |line: &str| if line.starts_with("  ") { line.replace(' ', &HELD.to_string()) } else { line.into() };
    help.lines().map(line).collect::<Vec<String>>().join("\n")
}

/// Prints the help or the fault that clap answers with.
pub fn print(answer: &clap::Error) {
    let text = answer.render();
    let for_stderr = answer.use_stderr();
    let coloured = if for_stderr { ::console::colors_enabled_stderr() } else { ::console::colors_enabled() };
    let text = if coloured { text.ansi().to_string() } else { text.to_string() };
    let text = text.replace(HELD, " ");
    // A reader that has gone away needs no help text.
    let _ =
        if for_stderr { write!(std::io::stderr(), "{text}") } else { write!(std::io::stdout(), "{text}") };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_a_narrow_terminal_prose_is_wrapped_and_an_example_is_one_line() {
        let example = "  motorlens discover run1.csv run2.csv -v unseen.csv -m motor.toml -o model.json";
        let command = with_whole_examples(crate::cli::command()).term_width(50);
        let answer = command.try_get_matches_from(["motorlens", "discover", "--help"]).unwrap_err();
        let told = answer.render().to_string().replace(HELD, " ");
        assert!(told.lines().any(|line| line == example), "{told}");
        let is_prose = |line: &&str| !line.starts_with("  motorlens ");
        let wide = told.lines().filter(is_prose).find(|line| line.chars().count() > 50);
        assert!(wide.is_none(), "{wide:?}\n{told}");
    }
}
