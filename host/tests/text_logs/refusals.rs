//! Tables of which too little can be told are refused with what to do.

use super::{HEADER, lines, refusal};

#[test]
fn what_cannot_be_told_is_refused_with_what_to_do() {
    for (text, words) in [
        (
            lines(HEADER, |k, _, u, x| {
                format!("{k},{},{}", format!("{u:.2}").replace('.', ","), format!("{x:.2}").replace('.', ","))
            }),
            ["line 1", "decimal commas", "semicolons"],
        ),
        (
            lines(&format!("{HEADER}ms,V,rad\n"), |_, t, u, x| format!("{t},{u},{x}")),
            ["time_s", "\"ms\"", "--map time=time_s:ms"],
        ),
        (
            lines("t,u,pos,pos\n", |_, t, u, x| format!("{t},{u},{x},{x}")),
            ["the columns are t, u, pos, pos", "angle=2:rad", "voltage=u:V"],
        ),
        (
            lines("t,ch1,ch2\n", |_, t, u, x| format!("{t},{u},{x}")),
            [
                "the columns are t, ch1, ch2",
                "time=t:s,voltage=ch1:V,speed=ch2:rad/s",
                "channels of an oscilloscope",
            ],
        ),
        (
            lines("t,effort,position\n", |_, t, u, x| format!("{t},{u},{x}")),
            ["torque in ROS", "--map time=t:s,voltage=effort:V,angle=position:rad", "duty=effort:100"],
        ),
        (
            lines("MOT: Monitor enabled!\nMOT: Align sensor.\nMOT: Ready.\n", |_, _, u, x| {
                format!("{u:.4}\t{u:.4}\t{:.4}\t{x:.4}", 1.5 * u)
            }),
            ["SimpleFOC", "--map voltage=1:V,speed=2:rad/s,angle=3:rad --rate 100", "micros()"],
        ),
        (
            lines(HEADER, |_, _, u, x| format!("0.01,{u},{x}")),
            ["repeat the time", "--map interval=time_s:s", "time since the row before"],
        ),
        (
            lines(HEADER, |k, _, u, x| format!("{:.4},{u},{x}", 0.01 + 1e-4 * f64::from(k % 3))),
            ["backwards", "--map interval=time_s:s", "time since the row before"],
        ),
    ] {
        let said = refusal(&text).to_string();
        assert!(words.iter().all(|word| said.contains(word)), "{words:?} in {said}");
    }
}
