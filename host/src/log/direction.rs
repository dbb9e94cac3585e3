//! The sign of a voltage or duty that stands in a column of its own: `dir,pwm`.

/// What a word for a direction is read as: numbers that no column of zeros and ones has, so that both are told apart.
const FORTH: f64 = 3.0;

const FORTH_WORDS: [&str; 20] = [
    "f",
    "fw",
    "fwd",
    "forward",
    "forwards",
    "cw",
    "clockwise",
    "+",
    "pos",
    "positive",
    "vor",
    "vorwärts",
    "right",
    "rechts",
    "up",
    "open",
    "avant",
    "avanti",
    "adelante",
    "frente",
];
const BACK_WORDS: [&str; 30] = [
    "r",
    "b",
    "rv",
    "rev",
    "reverse",
    "bw",
    "bwd",
    "back",
    "backward",
    "backwards",
    "ccw",
    "counterclockwise",
    "counter-clockwise",
    "anticlockwise",
    "-",
    "neg",
    "negative",
    "rück",
    "rückwärts",
    "left",
    "links",
    "zurück",
    "rueckwaerts",
    "down",
    "close",
    "arriere",
    "arrière",
    "indietro",
    "atras",
    "atrás",
];
const REST_WORDS: [&str; 15] = [
    "stop", "stopped", "stopp", "s", "halt", "brake", "coast", "free", "float", "off", "aus", "idle", "none",
    "n", "neutral",
];

/// The number that a word for a direction, or for the level of a pin, is read as.
pub(super) fn named(text: &str) -> Option<f64> {
    let lower = text.trim_matches(['"', '\'']).to_lowercase();
    let is_one_of = |words: &[&str]| words.contains(&lower.as_str());
    match lower.as_str() {
        "true" | "high" => Some(1.0),
        "false" | "low" => Some(0.0),
        _ if is_one_of(&FORTH_WORDS) => Some(FORTH),
        _ if is_one_of(&BACK_WORDS) => Some(-FORTH),
        _ if is_one_of(&REST_WORDS) => Some(0.0),
        _ => None,
    }
}

/// Whether `value` is what a word for a direction is read as.
pub(super) fn is_word(value: f64) -> bool {
    value.abs() == FORTH
}

/// The signs that the values of a column of directions stand for, as far as the whole column tells: with negative values among them
/// it is their sign, of 0 and 1 the 0 is backwards, of 1 and 2 (with 0 at rest) the 2 is.
///
/// # Errors
/// The first value that no direction has.
pub(super) fn signs(values: &[f64]) -> Result<Vec<f64>, f64> {
    let size = |value: &f64| value.abs();
    let largest = values.iter().map(size).fold(0.0, f64::max);
    if let Some(odd) = values.iter().find(|v| ![0.0, 1.0, 2.0, FORTH, 255.0].contains(&size(v))) {
        return Err(*odd);
    }
    let signed = values.iter().any(|v| *v < 0.0) || largest >= FORTH;
    let changes = values.iter().any(|v| *v != values[0]);
    let sign = |value: &f64| match *value {
        v if signed => v.signum() * f64::from(v != 0.0),
        2.0 => -1.0,
        0.0 if largest >= 2.0 => 0.0,
        0.0 if changes => -1.0,
        _ => 1.0,
    };
    Ok(values.iter().map(sign).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_is_told_by_signs_by_levels_of_a_pin_by_numbers_and_by_words() {
        let words = |text: &str| text.split(' ').map(|word| named(word).unwrap()).collect::<Vec<_>>();
        for (values, expected) in [
            (vec![1.0, -1.0, 0.0], [1.0, -1.0, 0.0]),
            (vec![1.0, 0.0, 1.0], [1.0, -1.0, 1.0]),
            (vec![1.0, 2.0, 0.0], [1.0, -1.0, 0.0]),
            (vec![0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
            (words("FWD REV stop"), [1.0, -1.0, 0.0]),
            (words("stop fwd fwd"), [0.0, 1.0, 1.0]),
            (words("F R N"), [1.0, -1.0, 0.0]),
            (words("HIGH LOW HIGH"), [1.0, -1.0, 1.0]),
        ] {
            assert_eq!(signs(&values).unwrap(), expected, "{values:?}");
        }
        assert_eq!(signs(&[1.0, 17.0]), Err(17.0));
        assert_eq!(named("purple"), None);
    }
}
