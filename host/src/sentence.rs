//! How a sentence begins.

/// `text` as it begins after a full stop: with a capital first letter.
pub(crate) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_letter_alone_becomes_a_capital() {
        assert_eq!(
            ["dead zone (0.6 V)", "kV", "", "\u{e9}cart"].map(capital),
            ["Dead zone (0.6 V)", "KV", "", "\u{c9}cart"]
        );
    }
}
