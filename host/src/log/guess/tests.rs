//! Proposals for tables as people have them.

use std::f64::consts::TAU;

use super::*;

fn names(text: &str) -> Vec<String> {
    text.split(';').map(str::to_owned).collect()
}

fn rows(row: impl Fn(f64) -> Vec<f64>) -> Vec<Vec<f64>> {
    (0..300).map(|k| row(f64::from(k))).collect()
}

#[test]
fn an_arduino_log_is_proposed_with_duty_supply_and_units() {
    let rows = rows(|k| vec![10.0 * k, (255.0 * (0.1 * k).sin()).round(), 300.0 * (0.1 * k).sin()]);
    let proposal = propose(&names("t_ms;pwm;rpm"), &rows).unwrap();
    assert_eq!(proposal.options(), "--map time=t_ms:ms,duty=pwm:255,speed=rpm:rpm --supply-volts 12");
    assert!(proposal.preview[0].contains("100 samples a second"), "{:?}", proposal.preview);
    assert!(
        proposal.preview[2].contains("rad/s") && proposal.preview[2].contains('█'),
        "{:?}",
        proposal.preview
    );
}

#[test]
fn names_that_a_shell_would_split_are_quoted_and_unusual_ones_are_numbers() {
    let rows = rows(|k| vec![0.01 * k, k.sin(), k.cos()]);
    let proposal = propose(&names("Time (s);Voltage (V);Position (rad)"), &rows).unwrap();
    assert_eq!(
        proposal.options(),
        "--map \"time=Time (s):s,voltage=Voltage (V):V,angle=Position (rad):rad\""
    );
    let rows: Vec<Vec<f64>> = rows.into_iter().map(|row| [row.as_slice(), &[row[2]]].concat()).collect();
    let proposal = propose(&names("t, s;u;u$;pos"), &rows).unwrap();
    assert_eq!(proposal.map, "time=0:s,voltage=u:V,angle=pos:rad");
}

#[test]
fn counts_need_their_number_a_turn_and_a_column_of_the_supply_is_used() {
    let rows =
        rows(|k| vec![10_000.0 * k, (200.0 * k.sin()).round(), (90.0 * k).round(), 11.8 + 0.1 * k.sin()]);
    let proposal = propose(&names("micros;cmd;enc;Vbat"), &rows).unwrap();
    assert_eq!(
        proposal.options(),
        "--map time=micros:us,duty=cmd:255,angle=enc:counts,supply=Vbat:V --counts-per-rev 1320"
    );
    assert!(proposal.assumptions().contains("1320"));
}

#[test]
fn brackets_without_a_unit_between_them_tell_none_and_are_not_asked_about() {
    let rows = rows(|k| vec![10.0 * k, (200.0 * (0.1 * k).sin()).round(), 300.0 * (0.1 * k).sin()]);
    let proposal = propose(&names("t_ms;pwm [];speed ( )"), &rows).unwrap();
    assert_eq!(proposal.map, "time=t_ms:ms,duty=pwm []:255,speed=speed ( ):rad/s");
    let asked = proposal.assumptions();
    assert!(!asked.contains("no unit that is known") && asked.contains("full duty of \"pwm []\""), "{asked}");
    // What stands between them is one, or is said to be unknown.
    let unknown = propose(&names("t_ms;pwm [];speed [furlongs]"), &rows).unwrap().assumptions();
    assert!(unknown.contains("\"furlongs\" of the column"), "{unknown}");
}

#[test]
fn a_setpoint_is_never_proposed_as_a_measurement() {
    let rows = rows(|k| vec![k, k.sin(), 5.0, k.sin()]);
    let proposal = propose(&names("t;pwm;speed_setpoint;speed"), &rows).unwrap();
    assert!(proposal.map.ends_with("speed=speed:rad/s"), "{}", proposal.map);
    assert_eq!(propose(&names("t;pwm;target_rpm;colour"), &rows), None);
}

#[test]
fn a_servo_is_driven_by_its_target_and_the_volts_beside_it_are_its_supply() {
    let rows = rows(|k| vec![0.02 * k, (0.1 * k).sin(), (0.1 * k - 0.2).sin(), 12.0 + 0.1 * k.sin()]);
    let proposal = propose(&names("timestamp;goal_position;present_position;volts"), &rows).unwrap();
    assert_eq!(
        proposal.map,
        "time=timestamp:s,target=goal_position:rad,angle=present_position:rad,supply=volts:V"
    );
    assert_eq!(proposal.supply_volts, None);
}

#[test]
fn a_duty_that_goes_with_the_size_of_an_error_is_asked_for_its_sign() {
    let swing = |k: f64| 20.0 * (0.1 * k).sin();
    let said = |duty: fn(f64) -> f64| {
        let rows =
            rows(|k| vec![10.0 * k, 45.0, 45.0 - swing(k), duty(15.0 * swing(k)).clamp(-255.0, 255.0)]);
        let sample = Sample::of("ms;target;current;pwm", rows);
        let part = Part {
            quantity: Quantity::Duty,
            index: 3,
            rest: None,
            unit: "255".into(),
            guessed: false,
            turn: None,
        };
        size_of_an_error(&sample, &part)
    };
    assert!(said(f64::abs).is_some_and(|said| said.contains("\"pwm\" is never negative")));
    assert_eq!(said(|u| u), None);
    assert_eq!(said(|u| u + 255.0), None);
}

#[test]
fn a_servo_that_is_told_degrees_is_no_servo_of_many_turns() {
    let rows = rows(|k| vec![0.02 * k, 90.5 * (0.1 * k).sin(), 90.1 * (0.1 * k - 0.2).sin()]);
    let proposal = propose(&names("timestamp;goal_position;present_position"), &rows).unwrap();
    assert_eq!(proposal.map, "time=timestamp:s,target=goal_position:deg,angle=present_position:deg");
}

#[test]
fn pins_of_a_bridge_are_no_voltages_and_steps_of_a_counter_no_angle() {
    let pin = |on: bool| f64::from(u8::from(on));
    let sign = |k: f64| (0.1 * k).sin();
    let row =
        |k: f64| vec![k, pin(sign(k) > 0.0), pin(sign(k) < 0.0), (200.0 * sign(k).abs()).round(), 9.0 * k];
    let proposal = propose(&names("ms;in1;in2;ena;count"), &rows(row)).unwrap();
    assert_eq!(proposal.map, "time=ms:ms,duty=ena:255,direction=in1:sign,angle=count:counts");
    let rows = rows(|k| vec![10.0 * k, (100.0 * sign(k)).round(), (5.0 * sign(k)).round()]);
    // What was counted since the row before is a speed.
    let proposal = propose(&names("t_ms;pwm;delta_count"), &rows).unwrap();
    assert_eq!(proposal.map, "time=t_ms:ms,duty=pwm:100,speed=delta_count:counts/s*100");
}

#[test]
fn what_a_person_told_is_not_assumed_and_multiples_are_divided() {
    let rows =
        rows(|k| vec![4.0 * k, (200.0 * (0.1 * k).sin()).round(), 900.0 * (0.1 * k - 0.3).sin(), 80.0]);
    let proposal = propose(&names("ms;pwm;speed_rpm_x10;battery"), &rows).unwrap();
    assert_eq!(proposal.map, "time=ms:ms,duty=pwm:255,speed=speed_rpm_x10:rpm/10,supply=battery:V");
    let told = Known { supply_volts: true, ..Known::default() };
    assert_eq!(
        proposal.with_known(told).options(),
        "--map time=ms:ms,duty=pwm:255,speed=speed_rpm_x10:rpm/10"
    );
    let rows: Vec<Vec<f64>> = rows.iter().map(|row| row.iter().map(|v| v.round()).collect()).collect();
    let counted = propose(&names("ms;pwm;counts"), &rows).unwrap();
    assert!(counted.options().contains("--counts-per-rev") && counted.options().contains("--supply-volts"));
    let told = Known { supply_volts: true, counts_per_rev: true, ..Known::default() };
    assert_eq!(counted.with_known(told).options(), "--map time=ms:ms,duty=pwm:255,angle=counts:counts");
}

#[test]
fn a_table_without_time_is_proposed_with_a_rate() {
    let rows = rows(|k| vec![k.sin(), k.cos()]);
    let proposal = propose(&names("voltage_v;speed_rad_s"), &rows).unwrap();
    assert_eq!(proposal.rate.as_deref(), Some("100"));
    let rows: Vec<Vec<f64>> =
        rows.into_iter().map(|row| [&[9.0 + row[0].round()], row.as_slice()].concat()).collect();
    let proposal = propose(&names("dt_ms;voltage_v;speed_rad_s"), &rows).unwrap();
    assert_eq!(proposal.rate, None);
    assert!(proposal.map.starts_with("interval=dt_ms:ms,"), "{}", proposal.map);
}

#[test]
fn angle_and_speed_that_are_one_motion_tell_each_others_units() {
    let wave = |k: f64| 40.0 * (0.02 * k).sin();
    let change = |k: f64| 0.8 * (0.02 * k).cos() * 100.0;
    for (table, [of_angle, of_speed], map, counts) in [
        ("ms;pwm;position;velocity", [60.0, 60.0], "angle=position:counts,speed=velocity:counts/s", "1320"),
        ("ms;pwm;enc;rpm", [500.0, 60.0], "angle=enc:counts,speed=rpm:rpm", "500"),
        ("ms;pwm;enc;velocity", [558.0, TAU], "angle=enc:counts,speed=velocity:rad/s", "558"),
        ("ms;pwm;pos_deg;speed", [360.0, 60.0], "angle=pos_deg:deg,speed=speed:rpm", ""),
        ("ms;pwm;pos;speed [rpm]", [1.0, 60.0], "angle=pos:rev,speed=speed [rpm]:rpm", ""),
        ("ms;pwm;pos;speed", [1.0, 1.0], "angle=pos:rad,speed=speed:rad/s", ""),
    ] {
        let row = |k: f64| {
            let turns = of_angle * wave(k);
            let angle = if of_angle > 400.0 || of_angle == of_speed && of_angle > 1.0 {
                turns.round()
            } else {
                turns
            };
            vec![10.0 * k, (200.0 * (0.1 * k).sin()).round(), angle, of_speed * change(k)]
        };
        let proposal = propose(&names(table), &rows(row)).unwrap();
        assert!(proposal.map.ends_with(map), "{}", proposal.map);
        let told = proposal.counts_per_rev.as_deref().unwrap_or_default();
        let near = |a: &str, b: &str| {
            a == b
                || a.parse::<f64>().is_ok_and(|a| b.parse::<f64>().is_ok_and(|b| (a / b - 1.0).abs() < 0.01))
        };
        assert!(near(told, counts), "{told} {counts}");
    }
}

#[test]
fn pulses_of_a_servo_are_no_clock_and_the_output_is_what_turns() {
    let swing = |k: f64| (0.1 * k).sin();
    let pulses = rows(|k| vec![10.0 * k, 1500.0 + (400.0 * swing(k)).round(), 60.0 * swing(k)]);
    let proposal = propose(&names("ms;servo_us;rpm"), &pulses).unwrap();
    assert_eq!(proposal.map, "time=ms:ms,duty=servo_us:1500..2000,speed=rpm:rpm");
    // Beside a clock they need not fall: one step up, a ramp. Without one what only rises is the clock.
    let step = |k: f64| if k < 50.0 { 1500.0 } else { 1700.0 };
    let ramp = |k: f64| 1500.0 + k;
    for pulse in [step as fn(f64) -> f64, ramp] {
        let rising = rows(|k| vec![10.0 * k, pulse(k), 0.1 * k]);
        let proposal = propose(&names("ms;motor_us;deg"), &rising).unwrap();
        assert_eq!(proposal.map, "time=ms:ms,duty=motor_us:1500..2000,angle=deg:deg");
    }
    let alone = rows(|k| vec![ramp(k), 9.0 * swing(k), 60.0 * swing(k)]);
    let proposal = propose(&names("t_us;V;rpm"), &alone).unwrap();
    assert!(proposal.map.starts_with("time=t_us:"), "{}", proposal.map);
    let geared = rows(|k| vec![0.01 * k, 9.0 * swing(k), 1800.0 * swing(k), 60.0 * swing(k)]);
    let proposal = propose(&names("t;V;motor_rpm;output_rpm"), &geared).unwrap();
    assert_eq!(proposal.map, "time=t:s,voltage=V:V,speed=output_rpm:rpm");
    let counted = rows(|k| vec![10.0 * k, (200.0 * swing(k)).round(), (50.0 * swing(k)).round()]);
    let proposal = propose(&names("ms;pwm;ticks_per_loop"), &counted).unwrap();
    assert_eq!(proposal.map, "time=ms:ms,duty=pwm:255,speed=ticks_per_loop:counts/s*100");
}

#[test]
fn what_was_counted_since_the_row_before_is_a_speed_with_an_interval_too() {
    let rows = rows(|k| vec![10.0, (200.0 * (0.1 * k).sin()).round(), (5.0 * (0.1 * k).sin()).round()]);
    let proposal = propose(&names("dt_ms;pwm;delta_ticks"), &rows).unwrap();
    assert_eq!(proposal.map, "interval=dt_ms:ms,duty=pwm:255,speed=delta_ticks:counts/s*100");
}

#[test]
fn a_set_value_that_the_angle_goes_far_beyond_is_no_target_and_the_number_of_a_row_no_current() {
    let sent = |k: f64| (200.0 * (0.05 * k).sin()).round();
    let counted = rows(|k| vec![10.0 * k, sent(k), 40.0 * k]);
    assert_eq!(propose(&names("ms;set;enc"), &counted), None);
    let reached = rows(|k| vec![10.0 * k, sent(k), sent(k - 3.0)]);
    assert!(propose(&names("ms;set;enc"), &reached).is_some_and(|p| p.map.contains("target=set")));
    let numbered = rows(|k| vec![k, 10.0 * k, sent(k), 30.0 * (0.05 * k).sin()]);
    let proposal = propose(&names("i;ms;pwm;rpm"), &numbered).unwrap();
    assert_eq!(proposal.map, "time=ms:ms,duty=pwm:255,speed=rpm:rpm");
}

#[test]
fn the_fine_angle_behind_the_gear_is_the_motion() {
    let angle = |k: f64| 1500.0 * (0.02 * k).sin();
    let apart = rows(|k| {
        vec![
            10.0 * k,
            (200.0 * (0.1 * k).sin()).round(),
            (angle(k) / 360.0).floor(),
            angle(k).rem_euclid(360.0),
        ]
    });
    let map = propose(&names("ms;pwm;turns;deg"), &apart).unwrap().map;
    assert!(map.ends_with("angle=deg:deg"), "{map}");
    // 30 turns of the motor are one of the shaft.
    let rpm = |k: f64| 30.0 * 1500.0 * 0.02 * (0.02 * k).cos() * 100.0 / 6.0;
    let geared = rows(|k| vec![0.01 * k, 6.0 * (0.02 * k).cos(), rpm(k), angle(k)]);
    let map = propose(&names("t;u;motor_rpm;out_deg"), &geared).unwrap().map;
    assert_eq!(map, "time=t:s,voltage=u:V,angle=out_deg:deg");
    let pins = rows(|k| {
        vec![
            10.0 * k,
            f64::from(u8::from((0.1 * k).sin() > 0.0)),
            (200.0 * (0.1 * k).sin().abs()).round(),
            9.0 * k,
        ]
    });
    let map = propose(&names("ms;in1;en;count"), &pins).unwrap().map;
    assert_eq!(map, "time=ms:ms,duty=en:255,direction=in1:sign,angle=count:counts");
}

#[test]
fn an_angle_in_tenths_is_in_degrees() {
    let tenths = rows(|k| vec![0.01 * k, 6.0 * (0.02 * k).sin(), (9000.0 * (0.02 * k).sin()).round() / 10.0]);
    let proposal = propose(&names("t;u;position"), &tenths).unwrap();
    assert!(proposal.map.ends_with("angle=position:deg"), "{}", proposal.map);
    assert!(proposal.assumptions().contains("deg is a guess"));
}

#[test]
fn columns_that_no_name_tells_are_proposed_by_their_numbers() {
    let mut speed = 0.0;
    let rows = (0..300).map(|k| {
        let volts = [6.0, -3.0, 0.0, 4.5][k / 50 % 4];
        speed += 0.1 * (2.0 * volts - speed);
        vec![0.01 * k as f64, volts, 0.01 * k as f64, speed]
    });
    let sample = Sample::of("time;value;time;value", rows.collect());
    assert_eq!(propose_for(&sample), None);
    let asked = questions::numbers_question(&sample).unwrap();
    assert!(asked.contains("--map time=0:s,voltage=1:V,speed=3:rad/s"), "{asked}");
}

/// A ramp of the voltage rises as evenly as the clock, and has more values than the speed, which stands at first.
#[test]
fn what_is_called_a_time_is_the_clock_and_a_voltage_or_a_speed_by_its_letter_is_none() {
    let (mut speed, mut rows) = (0.0, Vec::new());
    for k in 0..100 {
        let volts = 0.045 * f64::from(k);
        speed += 0.5 * (4.0 * (volts - 0.5_f64).max(0.0) - speed);
        rows.push(vec![f64::from(180 + k), volts, speed, f64::from(100 * (k + 1)), 1e6]);
    }
    let asked = questions::numbers_question(&Sample::of("id;Vr;Wr;time_r;time_m", rows)).unwrap();
    assert!(asked.contains("--map time=time_r:ms,voltage=Vr:V,speed=Wr:rad/s"), "{asked}");
}

#[test]
fn seconds_and_nanoseconds_in_two_columns_are_one_time() {
    let rows = rows(|k| vec![1.7e9 + (0.01 * k).floor(), (k % 100.0) * 1e7, k.sin(), k.cos()]);
    let proposal = propose(&names("header.stamp.sec;header.stamp.nanosec;u;pos"), &rows).unwrap();
    assert!(proposal.map.starts_with("time=header.stamp.sec+header.stamp.nanosec:ns,"), "{}", proposal.map);
    assert!(proposal.preview[0].contains("100 samples a second"), "{:?}", proposal.preview);
}

#[test]
fn signals_with_clocks_of_their_own_are_no_motion_and_told_where_they_differ() {
    let sample = |late: f64| {
        let row = |k: f64| vec![0.01 * k, (0.02 * k).sin(), 0.01 * k + late, 9.5 * (0.02 * k).cos(), k.cos()];
        Sample::of("volt.Time;volt.Data;speed.Time;speed.Data;ans(5)", rows(row))
    };
    let proposal = propose_for(&sample(0.0)).unwrap();
    assert_eq!(proposal.map, "time=volt.Time:s,voltage=volt.Data:V,speed=speed.Data:rad/s");
    assert!(!proposal.assumptions().contains("other times"), "{}", proposal.assumptions());
    let asked = propose_for(&sample(0.004)).unwrap().assumptions();
    assert!(asked.contains("column 2 is the clock \"speed.Time\" beside \"volt.Time\""), "{asked}");
}

#[test]
fn a_counter_that_never_counts_is_no_level_of_a_channel() {
    let level = |k: f64| f64::from(k % 2.0 > 0.5);
    let asked =
        |row: &dyn Fn(f64) -> Vec<f64>| levels_question(&Sample::of("t_ms;encoder1;encoder2", rows(row)));
    assert!(asked(&|k| vec![k, level(k), level(k + 1.0)]).unwrap().contains("\"encoder1\" and \"encoder2\""));
    assert_eq!(asked(&|k| vec![k, 3.0 * k, 0.0]), None, "one that counts and one that does not");
    assert_eq!(asked(&|k| vec![k, 0.0, 0.0]), None);
    assert_eq!(asked(&|k| vec![k, 3.0 * k, level(k)]), None);
}

#[test]
fn levels_of_the_drive_that_move_nothing_hide_no_table_of_steady_states() {
    let row = |k: u32| {
        let volts = f64::from(16_u32.saturating_sub(k)) * 0.5;
        vec![volts, 300.0 * volts]
    };
    let asked = propose_for(&Sample::of("voltage;rpm", (0..21).map(row).collect())).unwrap().unknown_units;
    assert!(asked.iter().any(|text| text.contains("these are steady states")), "{asked:?}");
}

#[test]
fn a_table_of_steady_states_whose_motion_no_name_tells_is_proposed_with_no_rate_to_paste() {
    let half = |lag: f64| {
        let mut speed = 0.0;
        let mut row = |k: i32| {
            let duty = f64::from(90 - (k - 90).abs());
            let settled = (duty - 7.0).max(0.0).sqrt();
            speed += (settled - speed) * (1.0 - lag);
            vec![duty, 0.0, speed]
        };
        half_question(&Sample::of("pwm;m1;mean", (0..180).map(&mut row).collect())).unwrap()
    };
    let asked = half(0.0);
    assert!(asked.contains("\"pwm\" is another in every row and \"mean\" goes with it"), "{asked}");
    assert!(asked.contains("speed=mean:rad/s --supply-volts 12 --rate N"), "{asked}");
    assert!(!asked.contains("--rate 100"), "{asked}");
    // A motion that comes late.
    let asked = half(0.8);
    assert!(asked.contains("no column tells how it moved") && asked.contains("--rate 100"), "{asked}");
}

/// A sweep of a robot's wheel, a level in each second: its time was read as microseconds.
#[test]
fn a_table_of_steady_states_with_a_slow_clock_or_one_of_an_unknown_unit_is_told_as_one() {
    let asked = |clock: &str, step: f64| {
        let row = |k: u32| {
            let level = 10.0 * f64::from(k % 20);
            vec![4e4 + step * f64::from(k), level, 20.0 * (level - 35.0).max(0.0).sqrt()]
        };
        let sample = Sample::of(&format!("{clock};command;rpm"), (0..40).map(row).collect());
        questions::steady_question(&sample, &propose_for(&sample).unwrap())
    };
    for (clock, step) in [("time", 1100.0), ("time_ms", 1500.0), ("time", 2.0)] {
        let asked = asked(clock, step).unwrap();
        assert!(asked.contains("no clock makes a log of them"), "{asked}");
        assert!(asked.contains(&format!("say --map time={clock}:")), "{asked}");
    }
    assert_eq!(asked("time_ms", 10.0), None);
}

#[test]
fn of_a_mean_and_its_ends_the_mean_is_the_motion_and_a_number_of_readings_is_none() {
    let row = |k: u32| {
        let mean = 0.9 * f64::from(k * 7 % 40);
        vec![f64::from(k * 7 % 40), mean, 1.2 * mean, 0.8 * mean, f64::from(5 + k % 2)]
    };
    let sample = |rows: u32| {
        Sample::of("pwm;avg_velocity;max_velocity;min_velocity;sample_count", (0..rows).map(row).collect())
    };
    let proposal = propose_for(&sample(30)).unwrap();
    assert_eq!(proposal.map, "duty=pwm:255,speed=avg_velocity:rad/s");
    // Neither a line to paste nor, of few rows, a way to make a log of them.
    let asked = |rows: u32| {
        let sample = sample(rows);
        questions::steady_question(&sample, &propose_for(&sample).unwrap()).unwrap()
    };
    assert!(asked(30).contains("--supply-volts 12 --rate N"), "{}", asked(30));
    assert!(asked(18).ends_with("(18 rows are too few for a fit besides)"), "{}", asked(18));
    let timed = rows(|k| vec![0.01 * k, (200.0 * (0.1 * k).sin()).round(), 3.0 * k]);
    let half = half_question(&Sample::of("time_s;pwm;sample_count", timed)).unwrap();
    assert!(half.contains("no column tells how it moved") && !half.contains("--map"), "{half}");
    assert_eq!(words::said("encoder_count").unit, Some("counts"));
}

#[test]
fn a_unit_that_a_name_tells_bars_it_from_what_has_another() {
    let half =
        |header: &str| half_question(&Sample::of(header, rows(|k| vec![0.01 * k, (0.1 * k).sin(), k.cos()])));
    let asked = half("time_s;alpha_m_rad_s2;theta_m_rad").unwrap();
    assert!(asked.contains("no column tells what drove the motor") && !asked.contains("--map"), "{asked}");
    let asked = half("time_s;duty_pct;encoder_V").unwrap();
    assert!(asked.contains("no column tells how it moved") && !asked.contains("--map"), "{asked}");
    for (name, is) in
        [("a [m/s^2]", true), ("alpha_m_rad_s2", true), ("sensors2", false), ("omega_rad_s", false)]
    {
        assert_eq!(unit_names::is_of_acceleration(name), is, "{name}");
    }
}

#[test]
fn a_word_that_is_a_unit_tells_what_it_measures_wherever_it_stands() {
    for (name, of) in [
        ("RPM_left", Some(Quantity::Speed)),
        ("Drehzahl_links", Some(Quantity::Speed)),
        ("millis_since", Some(Quantity::Time)),
        ("encoder_V", Some(Quantity::Voltage)),
        ("speed_left", None),
        ("enc_left", None),
        ("pwm", None),
    ] {
        assert_eq!(words::said(name).unit_of, of, "{name}");
    }
}
