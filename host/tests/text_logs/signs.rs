//! Columns that look like a motion or a drive and are none, or have no sign of their own.

use motorlens::log::ReadOptions;

use super::{ROWS, assert_same, lines, mapped, read_bytes, refusal, row};

#[test]
fn levels_of_an_encoder_are_no_count() {
    let level = |x: f64, from: f64| ((40.0 * x + from).floor().rem_euclid(4.0) > 1.0) as u32;
    let with_count = lines("t,u,encA,encB,count\n", |_, t, u, x| {
        format!("{t},{u},{},{},{}", level(x, 0.0), level(x, 1.0), (1e4 * x).round())
    });
    assert_eq!(refusal(&with_count).proposal.unwrap().map, "time=t:s,voltage=u:V,angle=count:counts");
    let alone = lines("t,u,encA,encB\n", |_, t, u, x| format!("{t},{u},{},{}", level(x, 0.0), level(x, 1.0)));
    let refused = refusal(&alone);
    assert!(refused.proposal.is_none(), "{refused}");
    assert!(refused.to_string().contains("\"encA\" and \"encB\" hold 0 and 1 only"), "{refused}");
}

#[test]
fn pulses_a_second_a_current_i_and_a_gyroscope_are_proposed_as_what_they_are() {
    for (head, map) in [
        ("t,u,qpps", "time=t:s,voltage=u:V,speed=qpps:counts/s"),
        ("t,u,w,i", "time=t:s,voltage=u:V,speed=w:rad/s,current=i:A"),
    ] {
        let text = lines(&format!("{head}\n"), |_, t, u, x| {
            let more = if head.ends_with('i') { format!(",{:.3}", 0.3 * u) } else { String::new() };
            format!("{t},{u},{x}{more}")
        });
        assert_eq!(refusal(&text).proposal.unwrap().map, map);
    }
    let imu = |encoder: bool, scale: f64| {
        let angle = if encoder { ",theta" } else { "" };
        lines(&format!("t,u,ax,gx,gy,gz{angle}\n"), |k, t, u, x| {
            let angle = if encoder { format!(",{x}") } else { String::new() };
            format!("{t},{u},9.81,{},{},{}{angle}", k % 3, 0.01 * f64::from(k % 5), scale * x)
        })
    };
    for (scale, unit) in [(3.0, "rad/s"), (170.0, "deg/s")] {
        let proposal = refusal(&imu(false, scale)).proposal.unwrap();
        assert_eq!(proposal.map, format!("time=t:s,voltage=u:V,speed=gz:{unit}"));
        let asked = proposal.assumptions();
        assert!(asked.contains("gyroscope") && asked.contains(&format!("{unit} is a guess")), "{asked}");
    }
    assert_eq!(refusal(&imu(true, 3.0)).proposal.unwrap().map, "time=t:s,voltage=u:V,angle=theta:rad");
}

#[test]
fn a_speed_without_a_sign_beside_a_direction_gets_it_or_is_asked_about() {
    // The motion of `row` as that of a speed.
    let text = lines("t,u,rpm,dir\n", |_, t, u, x| {
        let speed = x - 2.0;
        format!("{t},{u},{},{}", speed.abs(), if speed < 0.0 { "CCW" } else { "CW" })
    });
    let proposal = refusal(&text).proposal.unwrap();
    assert_eq!(proposal.map, "time=t:s,voltage=u:V,direction=dir:sign,speed=rpm:rpm");
    assert!(proposal.assumptions().contains("gets its sign from \"dir\""), "{}", proposal.assumptions());
    let record =
        read_bytes(text.as_bytes(), &mapped("time=t,voltage=u,direction=dir,speed=rpm:rad/s")).unwrap();
    for k in 0..ROWS as usize {
        let (_, u, x) = row(k as u32);
        let off = [record.voltage_v[k] - u, record.speed_rad_s.as_ref().unwrap()[k].abs() - (x - 2.0).abs()];
        assert!(off.iter().all(|off| off.abs() < 1e-9), "{off:?} in row {k}");
        assert!(
            record.speed_rad_s.as_ref().unwrap()[k] * record.speed_rad_s.as_ref().unwrap()[0] * (x - 2.0)
                <= 0.0
        );
    }
    let text = lines("t_ms,pwm,dir,rpm\n", |k, _, u, x| {
        format!("{},{},{},{}", 10 * k, (50.0 * u).round().abs(), u32::from(u > 0.0), (x - 2.0).abs())
    });
    let asked = refusal(&text).proposal.unwrap().assumptions();
    assert!(asked.contains("\"rpm\" is never negative") && asked.contains("with its sign"), "{asked}");
}

#[test]
fn an_example_names_what_was_measured_and_no_setpoint() {
    let text = lines("t,setpoint,u,blue\n", |_, t, u, x| format!("{t},{},{u},{x}", 2.0 * u));
    let refused = refusal(&text).to_string();
    assert!(refused.contains("--map time=t:s,voltage=u:V,speed=blue:rad/s"), "{refused}");
    assert_same(&read_bytes(text.as_bytes(), &mapped("time=t,voltage=u,angle=blue")).unwrap(), "u", 0);
}

#[test]
fn a_log_without_a_drive_or_a_motion_is_told_what_it_lacks_and_gets_no_line_that_calls_something_else_so() {
    for (head, said) in [
        (
            "timestamp_ms,setpoint_rpm,actual_rpm",
            "\"actual_rpm\" is the motion, and no column tells what drove",
        ),
        ("time,angle", "beside the time there is only \"angle\""),
        ("time,output", "beside the time there is only \"output\""),
        ("time,pwm,blue,green", "\"pwm\" drives the motor, and no column tells how it moved"),
    ] {
        let columns = head.split(',').count();
        let text = lines(&format!("{head}\n"), |_, t, u, x| {
            [t.to_string(), u.to_string(), x.to_string(), format!("{}", 2.0 * x)][..columns].join(",")
        });
        let refused = refusal(&text).to_string();
        assert!(refused.contains(said), "{head}: {refused}");
        assert!(!refused.contains("voltage=setpoint_rpm") && !refused.contains("voltage=angle"), "{refused}");
    }
}

#[test]
fn a_switch_and_a_heading_are_no_duty_and_no_current() {
    let text = lines("t,Power,CurrX,CurrDeg,RPM_M1,DriveM1\n", |k, t, u, x| {
        format!("{t},OFF,0.0,{},{x},{}", k % 90, (20.0 * u).round())
    });
    assert_eq!(refusal(&text).proposal.unwrap().map, "time=t:s,duty=DriveM1:255,speed=RPM_M1:rpm");
}

/// One reading that is no number a fit can use is a row that was not read.
#[test]
fn a_single_infinite_reading_is_left_out_and_named() {
    let text = lines(
        super::HEADER,
        |k, t, u, x| {
            if k == 77 { format!("{t},{u},inf") } else { format!("{t},{u},{x}") }
        },
    );
    let record = read_bytes(text.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(record.len(), ROWS as usize - 1);
    assert!(
        record.warnings[0].what.starts_with("\"inf\" is not a number a fit can use"),
        "{:?}",
        record.warnings
    );
}

#[test]
fn a_direction_in_a_column_of_its_own_gives_the_duty_its_sign() {
    for (forth, back) in [("1", "-1"), ("1", "0"), ("1", "2"), ("FWD", "REV"), ("cw", "ccw"), ("HIGH", "LOW")]
    {
        let text = lines("t_ms,dir,pwm,theta\n", |_, t, u, x| {
            format!("{:.0},{},{:.4},{x}", 1e3 * t, if u < 0.0 { back } else { forth }, 20.0 * u.abs())
        });
        let proposal = refusal(&text).proposal.unwrap();
        assert_eq!(proposal.map, "time=t_ms:ms,duty=pwm:100,direction=dir:sign,angle=theta:rad", "{forth}");
        let options = ReadOptions { supply_volts: Some(5.0), ..mapped(&proposal.map) };
        assert_same(&read_bytes(text.as_bytes(), &options).unwrap(), forth, 0);
        let turned = mapped("time=t_ms:ms,duty=pwm:100,direction=dir:*-1,angle=theta:rad");
        let turned = read_bytes(text.as_bytes(), &ReadOptions { supply_volts: Some(5.0), ..turned }).unwrap();
        assert!((turned.voltage_v[50] + row(50).1).abs() < 1e-9, "{forth}");
    }
    // A duty with a sign of its own needs none.
    let text =
        lines("t,dir,pwm,theta\n", |_, t, u, x| format!("{t},{},{},{x}", i32::from(u > 0.0), 20.0 * u));
    assert!(!refusal(&text).proposal.unwrap().map.contains("direction"));
    let text = lines("t,dir,u,theta\n", |k, t, u, x| format!("{t},{k},{},{x}", u.abs()));
    let options = mapped("time=t,voltage=u,direction=dir,angle=theta");
    let error = read_bytes(text.as_bytes(), &options).unwrap_err().to_string();
    assert!(error.contains("is no direction") && error.contains("FWD and REV"), "{error}");
}
