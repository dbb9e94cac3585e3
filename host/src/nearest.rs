//! What was meant by a word that nobody knows.

/// The nearest of the `known` words, unless half of its letters are wrong.
pub(crate) fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let distances = known.into_iter().map(|known| (strsim::damerau_levenshtein(word, known), known));
    distances.min().filter(|(distance, known)| distance * 2 <= known.len()).map(|(_, known)| known)
}
