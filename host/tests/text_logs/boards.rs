//! What a board prints on its serial port: names before numbers, stamps of a monitor, and noise between.

use super::{HEADER, clock, lines, mapped, read_same};

#[test]
fn what_a_board_prints_is_read_with_names_stamps_and_noise() {
    let noisy = |text: String| {
        let at = text.match_indices('\n').nth(77).unwrap().0 + 1;
        let (before, after) = text.split_at(at);
        format!("{before}*** watchdog ***\n{after}")
    };
    let arrow = |line: &str, k: u32| format!("{} -> {line}", clock(45_296, 10 * k));
    for (what, text, map) in [
        (
            "names, blanks",
            lines("", |_, t, u, x| format!("t:{t} u:{u} pos:{x}")),
            "time=t,voltage=u,angle=pos",
        ),
        (
            "names, commas",
            lines("boot\n", |_, t, u, x| format!("t: {t}, u: {u}, pos: {x}")),
            "time=t,voltage=u,angle=pos",
        ),
        (
            "names, tabs",
            lines("", |_, t, u, x| format!("t={t}\tu={u}\tpos={x}")),
            "time=t,voltage=u,angle=pos",
        ),
        (
            "half of the first names",
            format!("u:1 pos:0\n{}", lines("", |_, t, u, x| format!("t:{t} u:{u} pos:{x}"))),
            "time=t,voltage=u,angle=pos",
        ),
        (
            "stamps beside a time",
            lines(&arrow(HEADER, 0), |k, t, u, x| arrow(&format!("{t},{u},{x}"), k + k % 3)),
            "",
        ),
        (
            "stamps alone",
            lines(&arrow("voltage_v,angle_rad\n", 0), |k, _, u, x| arrow(&format!("{u},{x}"), k)),
            "",
        ),
        (
            "stamps and names",
            lines("", |k, _, u, x| arrow(&format!("u:{u} pos:{x}"), k)),
            "voltage=u,angle=pos",
        ),
    ] {
        for text in [text.clone(), noisy(text)] {
            let record = read_same(text.as_bytes(), &mapped(map), what);
            let noise =
                record.warnings.iter().any(|w| w.place.contains("line ") && w.what.contains("left out"));
            assert!(noise || !text.contains("watchdog"), "{what}: {:?}", record.warnings);
            let stamps = record.warnings.iter().any(|w| w.what.contains("serial monitor"));
            assert_eq!(stamps, what.starts_with("stamps a") || what.ends_with("and names"), "{what}");
        }
    }
}
