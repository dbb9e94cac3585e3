//! Tables of numbers: side by side where the terminal has room, else every name above its numbers, on the narrowest every number by itself.

/// A row of a table.
#[derive(Debug, Default)]
pub struct Row {
    /// What the numbers are of.
    pub name: String,
    /// One below each head.
    pub cells: Vec<String>,
    /// What is to be said of them, mostly nothing.
    pub remark: String,
}

/// Blanks in front of what stands below a name.
const SET_IN: &str = "    ";

/// `rows` below `heads`, their names below `title`, within `width` columns.
pub fn table(title: &str, heads: &[&str], rows: &[Row], width: usize) -> String {
    let widest = |k: usize| rows.iter().map(|row| letters(&row.cells[k])).fold(letters(heads[k]), usize::max);
    let widths: Vec<usize> = (0..heads.len()).map(widest).collect();
    let names = rows.iter().map(|row| letters(&row.name)).fold(letters(title), usize::max);
    let remarked = rows.iter().filter(|row| !row.remark.is_empty());
    let remarks = remarked.map(|row| letters(&row.remark) + 2).max().unwrap_or(0);
    let numbers: usize = widths.iter().map(|wide| wide + 2).sum();
    let head = line(heads, &widths);
    if names + numbers + remarks <= width {
        let row =
            |row: &Row| ended(&format!("{:<names$}{}  {}", row.name, line(&row.cells, &widths), row.remark));
        return ended(&format!("{title:<names$}{head}")) + &rows.iter().map(row).collect::<String>();
    }
    let below = numbers + 2 <= width;
    let head = if below { ended(&format!("  {head}")) } else { String::new() };
    let row = |row: &Row| {
        let numbers =
            if below { ended(&format!("  {}", line(&row.cells, &widths))) } else { one_each(heads, row) };
        let remark = if row.remark.is_empty() { String::new() } else { format!("{SET_IN}{}\n", row.remark) };
        ended(&row.name) + &numbers + &remark
    };
    ended(title) + &head + &rows.iter().map(row).collect::<String>()
}

fn letters(text: &str) -> usize {
    text.chars().count()
}

fn ended(text: &str) -> String {
    text.trim_end().to_owned() + "\n"
}

/// `cells` at the right of columns that are so wide.
fn line<S: AsRef<str>>(cells: &[S], widths: &[usize]) -> String {
    cells.iter().zip(widths).map(|(cell, &wide)| format!("  {:>wide$}", cell.as_ref())).collect()
}

/// The numbers of `row`, a line each, beside their heads.
fn one_each(heads: &[&str], row: &Row) -> String {
    let longest = heads.iter().map(|head| letters(head)).max().unwrap_or(0);
    let cells = heads.iter().zip(&row.cells);
    cells.map(|(head, cell)| format!("{SET_IN}{head:<longest$}  {cell}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_stays_below_its_head_or_beside_it_at_any_width() {
        let row = |name: &str, cells: [&str; 2], remark: &str| Row {
            name: name.into(),
            cells: cells.map(Into::into).into(),
            remark: remark.into(),
        };
        let rows =
            [row("feedback alone", ["0.08966", "never"], ""), row("with kS", ["0.0073", "1.9"], "moves")];
        let at = |width| table("a step", &["rise / s", "left"], &rows, width);
        assert_eq!(
            at(80),
            "a step          rise / s   left\nfeedback alone   0.08966  never\nwith kS           0.0073    1.9  moves\n"
        );
        assert_eq!(
            at(30),
            "a step\n    rise / s   left\nfeedback alone\n     0.08966  never\nwith kS\n      0.0073    1.9\n    moves\n"
        );
        assert_eq!(
            at(18),
            "a step\nfeedback alone\n    rise / s  0.08966\n    left      never\nwith kS\n    rise / s  0.0073\n    left      1.9\n    moves\n"
        );
    }
}
