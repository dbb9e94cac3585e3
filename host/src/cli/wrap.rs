//! How wide the terminal is, and lines that are broken to it.

/// `items` in a row with commas between them, set in, and none of them parted by the end of a line.
pub fn filled(items: &[String], width: usize) -> String {
    let mut text = String::from(" ");
    let mut long = 1;
    for (k, item) in items.iter().enumerate() {
        let end = if k + 1 < items.len() { "," } else { "." };
        let letters = item.chars().count() + 2;
        if long > 1 && long + letters > width {
            text += "\n ";
            long = 1;
        }
        text += &format!(" {item}{end}");
        long += letters;
    }
    text + "\n"
}

/// Columns of the terminal that shows the prose; 80 where it is none.
pub fn width() -> usize {
    known_width().unwrap_or(80)
}

/// Columns that the prose has: as COLUMNS says, else of the terminal; none where it goes into a file.
pub fn known_width() -> Option<usize> {
    width_of(&console::Term::stderr())
}

/// `text` of a list, which goes to standard output, as wide as the terminal there; as it is where it goes into a file.
pub fn listed(text: &str) -> String {
    width_of(&console::Term::stdout()).map_or_else(|| text.to_owned(), |width| wrapped(text, width))
}

fn width_of(terminal: &console::Term) -> Option<usize> {
    let told = std::env::var("COLUMNS").ok().and_then(|columns| columns.trim().parse().ok());
    let told = told.filter(|columns| *columns >= NARROWEST);
    told.or_else(|| terminal.size_checked().map(|(_, columns)| usize::from(columns)))
}

/// A terminal is taken to have this many columns at least.
const NARROWEST: usize = 30;

/// Breaks lines that are longer than `width` between words, and sets what follows in. Commands stay whole, so that they can be
/// copied.
pub fn wrapped(text: &str, width: usize) -> String {
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines() {
        let words = line.trim_start();
        let indent = line.len() - words.len();
        if line.chars().count() <= width || COMMANDS.iter().any(|command| words.starts_with(command)) {
            lines.push(line.to_owned());
            continue;
        }
        let hanging = (indent + 4).min(width / 3);
        let (mut row, mut long, mut begun) = (" ".repeat(indent), indent, false);
        // Blanks between the columns of a table go with the word after them.
        for word in pieces(words) {
            let letters = word.trim_end().chars().count();
            if begun && long + letters > width {
                lines.push(row.trim_end().to_owned());
                (row, long, begun) = (" ".repeat(hanging), hanging, false);
            }
            if !begun && letters == 0 {
                continue;
            }
            row += word;
            long += word.chars().count();
            begun = true;
        }
        lines.push(row.trim_end().to_owned());
    }
    lines.join("\n")
}

/// An error within `width`; a line with options or a command to be pasted stays whole.
pub fn fault(text: &str, width: usize) -> String {
    let is_pasted = |line: &str| ["--map ", "motorlens "].iter().any(|part| line.contains(part));
    let line = |line: &str| if is_pasted(line) { line.to_owned() } else { wrapped(line, width) };
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

/// The words of a line with the blanks after them; a number stays with its unit, and with the other end of its range.
fn pieces(line: &str) -> Vec<&str> {
    let mut all = Vec::new();
    let (mut from, mut to) = (0, 0);
    let mut words = line.split_inclusive(' ').peekable();
    while let Some(word) = words.next() {
        to += word.len();
        if words.peek().is_none_or(|next| !holds(word, next)) {
            all.push(&line[from..to]);
            from = to;
        }
    }
    all
}

/// Whether no line ends between `word` and `next`.
fn holds(word: &str, next: &str) -> bool {
    let number = |word: &str| word.trim_start_matches('(').parse::<f64>().is_ok();
    let range = |word: &str| matches!(word, ".." | "->");
    let (word, next) = (word.trim_end(), next.trim_end());
    !next.is_empty() && (range(word) || number(word) && !number(next))
}

/// What lines begin with that are for pasting.
const COMMANDS: [&str; 2] = ["motorlens ", "cargo "];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_fits_and_its_options_can_be_pasted() {
        let text = "error: a.csv: no column is called time_s, voltage_v or duty.\n  \
                    do: it looks like --map time=t:ms,duty=u:255 --supply-volts 12 (put your supply's voltage in the place of 12)\n      \
                    duty     u: 36 .. 255  = 0.1412 .. 1 of full duty  ▁▂▄▆████";
        let told = fault(text, 40);
        assert!(told.contains("--map time=t:ms,duty=u:255 --supply-volts 12 (put"), "{told}");
        let wide = told.lines().find(|line| line.chars().count() > 40 && !line.contains("--map"));
        assert!(wide.is_none() && told.contains("▁▂▄▆████"), "{told}");
    }

    #[test]
    fn a_value_stays_with_its_unit_at_any_width() {
        let text = "the error on the records fitted falls from 0.02436 rad to 6.13e-5 rad (28.71 % of it)";
        for width in [40, 60, 80] {
            let told = wrapped(text, width);
            for whole in ["0.02436 rad", "6.13e-5 rad", "(28.71 %"] {
                assert!(told.contains(whole), "{told}");
            }
            assert!(told.lines().all(|line| line.len() <= width), "{told}");
        }
    }

    #[test]
    fn long_lines_break_between_words_and_commands_do_not() {
        let text = "  1. coulomb   the residual torque steps at zero speed, as dry friction\n  motorlens discover a-long-name.csv another-long-name.csv";
        let told = wrapped(text, 40);
        let lines: Vec<&str> = told.lines().collect();
        assert_eq!(lines[0], "  1. coulomb   the residual torque steps");
        assert_eq!(lines[1], "      at zero speed, as dry friction");
        assert!(lines[2].ends_with("another-long-name.csv"), "{told}");
        assert_eq!(wrapped("short\n\nlines", 40), "short\n\nlines");
    }
}
