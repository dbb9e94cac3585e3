//! Dictionaries as Python prints them, made JSON: `{'t': 0.1, 'ok': True, 'v': None}`.

/// Python's words, and JSON's for them; a number that JSON has not is none.
const WORDS: [(&str, &str); 6] = [
    ("True", "true"),
    ("False", "false"),
    ("None", "null"),
    ("nan", "null"),
    ("inf", "null"),
    ("-inf", "null"),
];

/// Whether `text` begins as Python prints a dictionary, or a list of them.
pub fn is(text: &[u8]) -> bool {
    let inside = text.trim_ascii_start();
    let inside = inside.strip_prefix(b"[").unwrap_or(inside).trim_ascii_start();
    inside.strip_prefix(b"{").is_some_and(|rest| rest.trim_ascii_start().starts_with(b"'"))
}

/// The JSON that `text` means, which may be none: parsing it says so.
pub fn as_json(text: &str) -> String {
    let mut json = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = match c {
            '\'' | '"' => quoted(rest, c, &mut json),
            c if c.is_alphabetic() || c == '-' => word(rest, &mut json),
            c => {
                json.push(c);
                c.len_utf8()
            }
        };
        rest = &rest[length..];
    }
    json
}

/// A text between quotes of either kind, which may hold the other; tells its length in bytes.
fn quoted(text: &str, quote: char, json: &mut String) -> usize {
    json.push('"');
    let mut escaped = false;
    let mut length = text.len();
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => {
                // JSON knows no escaped apostrophe.
                if c != '\'' {
                    json.push('\\');
                }
                json.push(c);
                escaped = false;
            }
            '\\' => escaped = true,
            c if c == quote => {
                length = at + 1;
                break;
            }
            '"' => json.push_str("\\\""),
            c => json.push(c),
        }
    }
    json.push('"');
    length
}

fn word(text: &str, json: &mut String) -> usize {
    let is_inside = |c: char| c.is_alphanumeric() || c == '_';
    let end = text.char_indices().skip(1).find(|(_, c)| !is_inside(*c)).map_or(text.len(), |(at, _)| at);
    let word = &text[..end];
    // NumPy prints its numbers with their type: `np.float64(0.5)`.
    if let Some(number) = text.strip_prefix("np.").and_then(|rest| {
        let (kind, number) = rest.split_once('(')?;
        let (number, _) = number.split_once(')')?;
        kind.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_').then_some((kind, number))
    }) {
        json.push_str(in_json(number.1));
        return "np.".len() + number.0.len() + 2 + number.1.len();
    }
    json.push_str(in_json(word));
    end
}

/// JSON's word for one of Python's; any other as it is.
fn in_json(word: &str) -> &str {
    WORDS.iter().find(|(python, _)| *python == word).map_or(word, |(_, json)| json)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dictionary_of_python_is_the_json_that_it_means() {
        for (python, json) in [
            ("{'t': 0.1, 'ok': True, 'v': None}", r#"{"t": 0.1, "ok": true, "v": null}"#),
            (
                "{'a\\'b': \"it's\", 'c': -1e-05, 'd': 'say \"x\"'}",
                r#"{"a'b": "it's", "c": -1e-05, "d": "say \"x\""}"#,
            ),
            (
                "[{'w': -inf, 'x': np.float64(0.5), 'y': np.float64(nan)}]",
                r#"[{"w": null, "x": 0.5, "y": null}]"#,
            ),
            ("{'open", r#"{"open""#),
        ] {
            assert!(is(python.as_bytes()), "{python}");
            assert_eq!(as_json(python), json, "{python}");
        }
        assert!(!is(br#"{"t": 0.1}"#) && !is(b"'t'") && !is(b""));
    }
}
