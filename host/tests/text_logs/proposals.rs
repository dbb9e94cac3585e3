//! What is proposed for a log of names that are not canonical, and that it reads the log as it stands.

use std::fmt::Write as _;

use motorlens::log::ReadOptions;

use super::{clock, lines, mapped, read_same, refusal};

/// The proposal reads the file as it stands, in the right units.
#[test]
fn every_proposal_reads_its_log() {
    let mut wrong = String::new();
    for (what, text, options) in [
        (
            "unit row",
            lines("Time,Voltage,Angle\n(ms),(V),(deg)\n", |k, _, u, x| {
                format!("{},{u},{}", 10 * k, x.to_degrees())
            }),
            "--map time=Time:ms,voltage=Voltage:V,angle=Angle:deg",
        ),
        (
            "in",
            lines("Zeit in s;Spannung in V;Winkel in rad\n", |_, t, u, x| format!("{t};{u};{x}")),
            "--map \"time=Zeit in s:s,voltage=Spannung in V:V,angle=Winkel in rad:rad\"",
        ),
        (
            "suffixes",
            lines("t_ms,u_mV,pos_deg\n", |k, _, u, x| format!("{},{},{}", 10 * k, 1e3 * u, x.to_degrees())),
            "--map time=t_ms:ms,voltage=u_mV:mV,angle=pos_deg:deg",
        ),
        (
            "ROS",
            lines("sec,nanosec,u,position\n", |k, _, u, x| {
                format!("{},{},{u},{x}", 1_732_340_000 + k / 100, 10_000_000 * (k % 100))
            }),
            "--map time=sec+nanosec:ns,voltage=u:V,angle=position:rad",
        ),
        (
            "intervals",
            lines("dt_ms,u,theta\n", |_, _, u, x| format!("10,{u},{x}")),
            "--map interval=dt_ms:ms,voltage=u:V,angle=theta:rad",
        ),
        (
            "no time",
            lines("voltage,angle\n", |_, _, u, x| format!("{u},{x}")),
            "--map voltage=voltage:V,angle=angle:rad --rate 100",
        ),
        (
            "clock times",
            lines("Timestamp,u,theta\n", |k, _, u, x| format!("{},{u},{x}", clock(40_000, 10 * k))),
            "--map time=Timestamp:s,voltage=u:V,angle=theta:rad",
        ),
        (
            "names",
            lines("", |k, _, u, x| format!("millis:{} u:{u} theta:{x}", 10 * k)),
            "--map time=millis:ms,voltage=u:V,angle=theta:rad",
        ),
        (
            "a clock of no known name",
            lines("frame;logged;u;theta\n", |k, t, u, x| format!("{k};{t};{u};{x}")),
            "--map time=logged:s,voltage=u:V,angle=theta:rad",
        ),
        (
            "names that are units",
            lines("ms,V,deg\n", |k, _, u, x| format!("{},{u},{}", 10 * k, x.to_degrees())),
            "--map time=ms:ms,voltage=V:V,angle=deg:deg",
        ),
        (
            "names of AdvantageKit",
            lines("time;LeftAppliedVolts;LeftPositionRotations\n", |_, t, u, x| {
                format!("{t};{u};{}", x / std::f64::consts::TAU)
            }),
            "--map time=time:s,voltage=LeftAppliedVolts:V,angle=LeftPositionRotations:rev",
        ),
        (
            "a column that never changes is no motion",
            lines("time,x,y,voltage,angle\n", |_, t, u, x| format!("{t},1,2,{u},{x}")),
            "--map time=time:s,voltage=voltage:V,angle=angle:rad",
        ),
        (
            "stamps",
            lines("", |k, _, u, x| format!("{} -> u:{u} theta:{x}", clock(50_000, 10 * k))),
            "--map voltage=u:V,angle=theta:rad",
        ),
    ] {
        let proposal = refusal(&text).proposal.unwrap_or_else(|| panic!("{what}: no proposal"));
        if proposal.options() != options {
            let _ = writeln!(wrong, "{what}: {}", proposal.options());
            continue;
        }
        let rate_hz = proposal.rate.as_ref().map(|rate| rate.parse().unwrap());
        read_same(text.as_bytes(), &ReadOptions { rate_hz, ..mapped(&proposal.map) }, what);
    }
    assert!(wrong.is_empty(), "{wrong}");
}
