//! Columns of hexadecimal numbers without a mark, told by their letters.

use super::fields::Splitter;

/// Whether a text may be a hexadecimal number without a mark, of at most 32 bits.
pub fn is_hex(text: &str) -> bool {
    (1..=8).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_hexdigit())
}

/// What tells the columns of hexadecimal numbers without a mark.
#[derive(Debug, Default)]
pub struct Hexadecimal {
    /// Of each column the fields, those that may be such numbers, those that are no others, and those with a decimal digit.
    seen: Vec<[usize; 4]>,
}

impl Hexadecimal {
    /// Looks at the row that was split last.
    pub fn see(&mut self, row: &Splitter) {
        self.seen.resize(self.seen.len().max(row.len()), [0; 4]);
        for (text, seen) in row.iter().zip(&mut self.seen).filter(|(text, _)| !text.is_empty()) {
            let hex = is_hex(text);
            let letters =
                hex && text.bytes().any(|b| b.is_ascii_alphabetic() && !b.eq_ignore_ascii_case(&b'e'));
            let digits = text.bytes().any(|b| b.is_ascii_digit());
            let more = [true, hex, letters, digits].map(usize::from);
            *seen = std::array::from_fn(|k| seen[k] + more[k]);
        }
    }

    /// The columns where nothing else stands, and not few of whose numbers have letters among their digits (more than the `e` of an
    /// exponent).
    pub fn columns(&self) -> Vec<usize> {
        // Half a line may end within one. Letters alone are a word: F is forwards.
        let is = |[all, hex, letters, digits]: &[usize; 4]| {
            50 * (all - hex) <= *all && 5 * letters >= *all && *letters > 1 && *digits > 0
        };
        self.seen.iter().enumerate().filter(|(_, seen)| is(seen)).map(|(column, _)| column).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::fields::Separator;
    use super::*;

    #[test]
    fn hexadecimal_columns_are_told_by_their_letters_and_marked() {
        let rows = ["1,00FF,1E5,on,F", "2,0A10,2E5,ff,F", "3,FFD2,3E5,x,B"];
        let mut splitter = Splitter::of(Separator::Byte(b','), false);
        let mut hexadecimal = Hexadecimal::default();
        for row in rows {
            splitter.split(row);
            hexadecimal.see(&splitter);
        }
        assert_eq!(hexadecimal.columns(), [1]);
        let mut splitter = splitter.with_hex(vec![1]);
        splitter.split(rows[2]);
        assert_eq!(splitter.iter().collect::<Vec<_>>(), ["3", "0xFFD2", "3E5", "x", "B"]);
    }
}
