//! Units in the header, below it and beside the numbers.

use super::{ROWS, assert_same, lines, mapped, read_bytes, refusal};

/// A unit in the header, or in the row below it, holds where the mapping names none.
#[test]
fn the_unit_of_a_header_holds_where_the_mapping_leaves_it_open() {
    let rows = |k: u32, u: f64, x: f64| format!("{},{},{}", 10 * k, 1e3 * u, x.to_degrees());
    for (head, map) in [
        ("t_ms,u_mV,pos_deg\n", "time=t_ms,voltage=u_mV,angle=pos_deg"),
        ("Time [ms],U [mV],Angle (deg)\n", "time=Time [ms],voltage=U [mV],angle=Angle (deg)"),
        ("Time,U,Angle\n(ms),(mV),(deg)\n", "time=0,voltage=1,angle=2"),
        ("millis,mv,shaftAngleDegrees\n", "time=millis,voltage=mv,angle=shaftAngleDegrees"),
        ("t_us,u,angle\n", "time=t_us:ms,voltage=u:mV,angle=angle:deg"),
    ] {
        let record = read_bytes(lines(head, |k, _, u, x| rows(k, u, x)).as_bytes(), &mapped(map)).unwrap();
        assert_same(&record, head, 0);
    }
}

#[test]
fn units_beside_the_numbers_hold_and_a_number_in_another_unit_is_no_row() {
    let text = lines("t,u,pos\n", |k, t, u, x| {
        let volts = if k == 50 { format!("{:.1}mV", 1e3 * u) } else { format!("{u:.4}V") };
        format!("{:.0} ms,{volts},{x:.4}", 1e3 * t)
    });
    let record = read_bytes(text.as_bytes(), &mapped("time=t,voltage=u,angle=pos")).unwrap();
    assert_eq!(record.len(), ROWS as usize - 1);
    assert!((record.time_s[199 - 1] - record.time_s[0] - 1.99).abs() < 1e-9);
    assert!(record.warnings.iter().any(|w| w.place.contains("line 52")), "{:?}", record.warnings);
    let proposal = refusal(&text).proposal.unwrap();
    assert_eq!(proposal.map, "time=t:ms,voltage=u:V,angle=pos:rad");
    // Names beside the numbers too.
    let text = lines("", |_, t, u, x| format!("t:{:.0}ms u:{u:.4}V pos:{x:.4}rad", 1e3 * t));
    assert_same(&read_bytes(text.as_bytes(), &mapped("time=t,voltage=u,angle=pos")).unwrap(), "names", 0);
}
