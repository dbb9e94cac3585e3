//! How a sentence begins, and how it lists.

/// `text` as it begins after a full stop: with a capital first letter.
pub(crate) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// `all` in one breath: commas between them, and the last after "and".
pub(crate) fn listed<S: AsRef<str>>(all: &[S]) -> String {
    let names: Vec<&str> = all.iter().map(AsRef::as_ref).collect();
    match names.as_slice() {
        [before @ .., last] if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        few => few.concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_of_several_stands_after_and() {
        assert_eq!(listed::<&str>(&[]), "");
        assert_eq!(listed(&["coulomb"]), "coulomb");
        assert_eq!(listed(&["coulomb", "delay"]), "coulomb and delay");
        assert_eq!(listed(&["compliance", "supply sag", "stribeck"]), "compliance, supply sag and stribeck");
    }

    #[test]
    fn the_first_letter_alone_becomes_a_capital() {
        assert_eq!(
            ["dead zone (0.6 V)", "kV", "", "\u{e9}cart"].map(capital),
            ["Dead zone (0.6 V)", "KV", "", "\u{c9}cart"]
        );
    }
}
