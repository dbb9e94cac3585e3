//! Texts of every encoding, line end, separator and decimal sign.

use super::{HEADER, lines, mapped, plain, read_same};

/// The same rows in every encoding, with the mapping that names their columns.
fn encoded() -> (Vec<(&'static str, Vec<u8>)>, &'static str) {
    let header = "Zeit [s],Spannung µ [V],Winkel für ° [rad]\n";
    let text = plain().replace(HEADER, header);
    let wide = |order: fn(u16) -> [u8; 2]| -> Vec<u8> { text.encode_utf16().flat_map(order).collect() };
    let (little, big) = (wide(u16::to_le_bytes), wide(u16::to_be_bytes));
    let map = "time=Zeit [s],voltage=Spannung µ [V],angle=Winkel für ° [rad]";
    let rows = vec![
        ("UTF-8", text.clone().into_bytes()),
        ("UTF-8 with its mark", [b"\xEF\xBB\xBF", text.as_bytes()].concat()),
        ("UTF-16 LE with its mark", [b"\xFF\xFE", little.as_slice()].concat()),
        ("UTF-16 BE with its mark", [b"\xFE\xFF", big.as_slice()].concat()),
        ("UTF-16 LE", little.clone()),
        ("UTF-16 BE", big.clone()),
        ("Windows-1252", text.chars().map(|c| c as u8).collect()),
        ("CR LF", text.replace('\n', "\r\n").into_bytes()),
        ("CR", text.replace('\n', "\r").into_bytes()),
        ("a block of zeros behind", [text.as_bytes(), &[0; 900]].concat()),
    ];
    (rows, map)
}

/// The same rows however their fields are separated and their numbers written, under canonical names.
fn separated() -> Vec<(&'static str, String)> {
    let comma = |x: f64| format!("{x:.4}").replace('.', ",");
    let semicolons = |_: u32, t: f64, u: f64, x: f64| format!("{};{};{}", comma(t), comma(u), comma(x));
    let names = HEADER.replace(',', ";");
    vec![
        (
            "decimal commas between commas",
            lines(HEADER, |_, t, u, x| format!("{},{},{}", comma(t), comma(u), comma(x))),
        ),
        (
            "decimal commas in quotes",
            lines(HEADER, |_, t, u, x| format!("\"{}\",\"{}\",\"{}\"", comma(t), comma(u), comma(x))),
        ),
        ("semicolons and decimal commas", lines(&names, semicolons)),
        ("a spreadsheet's remark", lines(&format!("sep=;\r\n{names}"), semicolons)),
        ("blanks", lines("time_s voltage_v angle_rad\n", |_, t, u, x| format!("{t:.4} {u:.4} {x:.4}"))),
        (
            "columns aligned",
            lines("  time_s   voltage_v   angle_rad\n", |_, t, u, x| format!("{t:10.4} {u:10.4} {x:10.4}")),
        ),
        ("tabs", lines("time_s\tvoltage_v\tangle_rad\n", |_, t, u, x| format!("{t}\t{u}\t{x}"))),
        (
            "NumPy's header",
            lines("# time_s voltage_v angle_rad\n", |_, t, u, x| format!("{t:.18e} {u:.18e} {x:.18e}")),
        ),
        ("a row of units", lines(&format!("{HEADER}(s),(V),(rad)\n\n"), |_, t, u, x| format!("{t},{u},{x}"))),
        ("units beside the numbers", lines(HEADER, |_, t, u, x| format!("{t:.4}s,{u:.4}V,{x:.4} rad"))),
        ("half a row first", format!("4,1.25\n{}", plain())),
        (
            "boot text first",
            format!("rst:0x1 (POWERON_RESET),boot:0x13\r\nentry 0x400805e4\r\nREADY\r\n{}", plain()),
        ),
        ("noise before the header", plain().replace(HEADER, &format!("\u{0}\u{0}{HEADER}"))),
    ]
}

#[test]
fn texts_of_any_encoding_line_end_separator_and_decimal_are_read_alike() {
    let (encoded, map) = encoded();
    let encoded = encoded.into_iter().map(|(what, bytes)| (what, bytes, map));
    let separated = separated().into_iter().map(|(what, text)| (what, text.into_bytes(), ""));
    for (what, bytes, map) in encoded.chain(separated) {
        read_same(&bytes, &mapped(map), what);
    }
}
