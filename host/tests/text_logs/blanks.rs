//! Fields without a value: what drives the motor holds through them, and no motion is made up.

use motorlens::log::ReadOptions;

use super::{HEADER, ROWS, assert_same, lines, read_bytes, refusal, row};

#[test]
fn what_drives_the_motor_holds_through_blanks_and_motion_is_never_filled() {
    let text =
        lines(HEADER, |k, t, u, x| if k % 10 == 0 { format!("{t},{u},{x}") } else { format!("{t},,{x}") });
    let record = read_bytes(text.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(record.len(), ROWS as usize);
    assert!((0..record.len()).all(|k| record.voltage_v[k] == row(k as u32 / 10 * 10).1));
    assert!(record.warnings.iter().any(|w| w.what.contains("180 blank fields")), "{:?}", record.warnings);
    // What says that there is no value is a blank.
    for nothing in ["NaN", "nan", "null", "None", "NA", "-"] {
        let text =
            lines(
                HEADER,
                |k, t, u, x| {
                    if k % 10 == 0 { format!("{t},{u},{x}") } else { format!("{t},{nothing},{x}") }
                },
            );
        let record = read_bytes(text.as_bytes(), &ReadOptions::default()).unwrap();
        assert!((0..record.len()).all(|k| record.voltage_v[k] == row(k as u32 / 10 * 10).1), "{nothing}");
        assert!(record.warnings.iter().any(|w| w.what.contains("first in line 3")), "{:?}", record.warnings);
    }
    let empty = refusal(&lines(HEADER, |_, t, u, _| format!("{t},{u},nan"))).to_string();
    assert!(empty.contains("angle_rad") && empty.contains("no row has a value here"), "{empty}");
    // Voltages and angles in rows of their own.
    let text = lines(HEADER, |_, t, u, x| format!("{t},{u},\n{:.4},,{x}", t + 0.001));
    let record = read_bytes(text.as_bytes(), &ReadOptions::default()).unwrap();
    assert_same(&record, "apart", 0);
}
