//! Which code page a text of another country is written in: the one that makes words of its names that are known here.

use encoding_rs::{EUC_KR, Encoding, GBK, SHIFT_JIS, WINDOWS_1250, WINDOWS_1251, WINDOWS_1252};

use super::guess::words;

/// Bytes of the beginning that hold the names.
const HEAD: usize = 4096;

/// The page of a text that begins with `start`; none where it is UTF-8, or where no page makes more of its names than that of Western Europe.
pub(super) fn of(start: &[u8]) -> Option<&'static Encoding> {
    let head = &start[..start.len().min(HEAD)];
    // A character may be cut at the end of it, and none at the end of a line.
    let lines = head.iter().rposition(|byte| *byte == b'\n').map_or(head.len(), |end| end + 1);
    let head = &head[..lines];
    if std::str::from_utf8(head).is_ok() {
        return None;
    }
    let known = |page: &'static Encoding| {
        let text = page.decode_without_bom_handling(head).0;
        let names = words::of(&text).into_iter().filter(|word| !word.is_ascii());
        names.filter(|word| words::said(word).quantity.is_some()).count()
    };
    let pages = [GBK, SHIFT_JIS, EUC_KR, WINDOWS_1251, WINDOWS_1250];
    let (best, count) = pages.map(|page| (page, known(page))).into_iter().max_by_key(|(_, count)| *count)?;
    (count > known(WINDOWS_1252)).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_the_one_that_makes_known_words_of_the_names() {
        for (page, text) in [
            (GBK, "时间,电压,速度\n0,1,2\n"),
            (SHIFT_JIS, "時間[s],電圧[V],角速度[rad/s]\n0,1,2\n"),
            (EUC_KR, "시간,전압,속도\n0,1,2\n"),
            (WINDOWS_1251, "Время, с;Напряжение, В;Скорость, об/мин\n0;1;2\n"),
            (WINDOWS_1250, "czas;wypełnienie;położenie\n0;1;2\n"),
        ] {
            assert_eq!(of(&page.encode(text).0), Some(page), "{text}");
            assert_eq!(of(text.as_bytes()), None, "UTF-8: {text}");
        }
        let western = WINDOWS_1252.encode("Zeit;Stellgröße [%];Größe in µV\n0;1;2\n").0;
        assert_eq!(of(&western), None);
        assert_eq!(of(b"t,u,w\n0,1,2\n\xff\xfe0,1\n"), None, "a disturbed line");
    }
}
