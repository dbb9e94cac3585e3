//! What a board with other firmware was heard to say, and what that calls for.

/// Characters that are shown.
const SHOWN: usize = 60;

/// The text that was heard, without the first and last line, which may be cut; none where it is no text.
fn text(heard: &[u8]) -> Option<String> {
    let printable = |b: &&u8| (0x20..0x7f).contains(*b) || b"\r\n\t".contains(b);
    let share = heard.iter().filter(printable).count() as f64 / heard.len().max(1) as f64;
    (share > 0.95).then(|| String::from_utf8_lossy(heard).into_owned())
}

fn lines(text: &str) -> Vec<&str> {
    let all: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    if all.len() > 2 { all[1..all.len() - 1].to_vec() } else { all }
}

/// What was heard, for a message.
pub(super) fn shown(heard: &[u8]) -> String {
    match text(heard) {
        Some(text) => {
            let line: String =
                lines(&text).first().copied().unwrap_or_default().chars().take(SHOWN).collect();
            format!("\"{line}\"")
        }
        None => {
            let bytes: Vec<String> = heard.iter().take(8).map(|b| format!("{b:02x}")).collect();
            format!("{} bytes that are no text ({} ...)", heard.len(), bytes.join(" "))
        }
    }
}

/// What to do about it.
pub(super) fn remedy(heard: &[u8]) -> &'static str {
    let rows = |text: &str| {
        let number = |field: &str| field.trim().parse::<f64>().is_ok();
        lines(text)
            .iter()
            .filter(|line| line.split([',', ';', '\t', ' ']).filter(|f| !f.is_empty()).all(number))
            .count()
    };
    match text(heard) {
        Some(text) if rows(&text) > 1 => {
            "this board prints lines of numbers: motorlens capture --listen takes them (docs/LINE_PROTOCOL.md), or save them to a file and \
             give that to motorlens discover"
        }
        Some(_) => {
            "flash the firmware that belongs to this program: motorlens device flash; or name another port"
        }
        None => {
            "the port may be another device's, or at another speed; else flash the firmware that belongs to this program: motorlens device \
             flash"
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use motorlens_shared::link::{NEWEST, OLDEST, ToBoard};

    use super::super::{Exchange, Fault};
    use super::*;

    fn asked(heard: &[u8], seconds: u64) -> Option<Fault> {
        let mut exchange = Exchange::default();
        exchange.ask(ToBoard::Hello { oldest: OLDEST, newest: NEWEST }, Duration::ZERO);
        let mut out = Vec::new();
        exchange.poll(Duration::ZERO, &mut out);
        exchange.receive(heard);
        exchange.poll(Duration::from_secs(seconds), &mut out);
        exchange.take_answer().and_then(Result::err)
    }

    #[test]
    fn a_board_with_other_firmware_is_told_by_what_it_says() {
        let rows = "12,0.5,3\n".repeat(40);
        let fault = asked(rows.as_bytes(), 4).unwrap();
        assert!(fault.to_string().contains("\"12,0.5,3\""), "{fault}");
        assert!(remedy(rows.as_bytes()).contains("--listen"));
        let fault = asked(b"Marlin 2.1 ready\n", 11).unwrap();
        assert!(fault.to_string().contains("Marlin 2.1 ready"), "{fault}");
        assert!(remedy(b"Marlin 2.1 ready\n").contains("flash"));
        assert!(asked(&[0x91; 300], 4).unwrap().to_string().contains("no text (91 91"));
    }

    #[test]
    fn a_board_that_says_nothing_is_silent_and_little_is_waited_for() {
        assert_eq!(asked(b"", 11), Some(Fault::Silent));
        assert_eq!(asked(b"Mar", 4), None);
    }
}
