//! Tables of which no column drives the motor, or one that may not: nothing else is put in its place, and it is said why.

use motorlens::log::guess::look;

use super::{kept, refusal};

/// A table of 200 rows.
fn table(header: &str, row: impl Fn(f64) -> Vec<f64>) -> String {
    let line = |k: u32| row(f64::from(k)).iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    format!("{header}\n{}\n", (0..200).map(line).collect::<Vec<_>>().join("\n"))
}

/// Speed and angle of a motor that runs up, rad/s and rad, 100 rows a second.
fn speed(k: f64) -> f64 {
    40.0 * (1.0 - (-k / 15.0).exp()) + 0.1 * (k * k).sin()
}

fn angle(k: f64) -> f64 {
    0.4 * (k - 15.0 * (1.0 - (-k / 15.0).exp()))
}

/// What is proposed for the table; empty where nothing is.
fn map_of(text: &str) -> String {
    let (_directory, path) = kept(text.as_bytes());
    look(&path).unwrap().proposal.map(|proposal| proposal.map).unwrap_or_default()
}

#[test]
fn a_table_without_a_drive_says_so_and_why_no_other_column_is_one() {
    let ms = |k: f64| 10.0 * k;
    for (what, text, told) in [
        (
            "angle and v",
            table("t_ms,angle,v", |k| vec![ms(k), angle(k), speed(k)]),
            "\"v\" is the change of \"angle\"",
        ),
        ("a battery", table("t_ms,Vbat,rpm", |k| vec![ms(k), 12.1, speed(k)]), "\"Vbat\" is the supply's"),
        (
            "a steady voltage beside a target",
            table("t_ms,Speed,Target,Voltage", |k| vec![ms(k), speed(k), 36.0, 12_000.0]),
            "voltage=Voltage:mV",
        ),
        (
            "no names",
            table("0,0,0", |k| vec![0.01 * k, angle(k), speed(k)]),
            "column 2 is the speed of column 1",
        ),
    ] {
        let text = text.replacen("0,0,0\n", "", 1);
        assert_eq!(map_of(&text), "", "{what}");
        let said = refusal(&text).to_string();
        assert!(said.contains(told) && said.contains("no column"), "{what}: {said}");
    }
}

/// A robot's speed beside the one that it was to reach is no voltage, and what counts the rows of each run is no clock.
#[test]
fn what_is_reached_of_a_set_point_drives_nothing_and_what_numbers_the_rows_of_several_runs_tells_no_time() {
    let steps = |k: f64| [0.0, 6.0, -4.0, 3.0][(k / 50.0) as usize];
    let robot = table("t,v_ref,v,omega_L,u_L", |k| {
        vec![0.01 * k, 0.3, 0.01 * speed(k), speed(k) * 0.1 * steps(k), steps(k)]
    });
    assert_eq!(map_of(&robot), "time=t:s,voltage=u_L:V,speed=omega_L:rad/s");
    let runs = table("0,0,0", |k| vec![k % 50.0, steps(k), 5.0 * steps(k) + 0.1 * (k * k).sin()]);
    let map = map_of(&runs.replacen("0,0,0\n", "", 1));
    assert!(!map.contains("time"), "{map}");
}

#[test]
fn what_a_proposal_takes_for_the_drive_is_asked_where_it_may_be_another() {
    let steps = |k: f64| [0.0, 12_000.0, 6000.0, 9000.0][(k / 50.0) as usize];
    for (what, text, map, asked) in [
        (
            "a steady voltage",
            table("t_ms,voltage,rpm", |k| vec![10.0 * k, 12.0 - 0.1 * (k / 9.0).cos(), speed(k)]),
            "voltage=voltage:V",
            "if it is the supply's, it drives nothing",
        ),
        (
            "a steady voltage beside a duty",
            table("t_ms,pwm,voltage,rpm", |k| vec![10.0 * k, (k % 7.0) * 30.0, 12.0, speed(k)]),
            "duty=pwm:255,speed=rpm:rpm,supply=voltage:V",
            "",
        ),
        (
            "millivolts by their size",
            table("t_ms,voltage,rpm", |k| vec![10.0 * k, steps(k), speed(k)]),
            "voltage=voltage:mV",
            "taken for millivolts; where it is a duty",
        ),
        (
            "millivolts called volts",
            table("t_ms,volts,rpm", |k| vec![10.0 * k, steps(k), speed(k)]),
            "voltage=volts:mV",
            "taken for millivolts",
        ),
        (
            "millivolts, or a duty of 12 bits",
            table("t_ms,voltage,rpm", |k| vec![10.0 * k, steps(k) / 3.0, speed(k)]),
            "duty=voltage:4095",
            "where it is millivolts, write voltage=voltage:mV",
        ),
        ("millivolts", table("t_ms,mV,rpm", |k| vec![10.0 * k, steps(k), speed(k)]), "voltage=mV:mV", ""),
        (
            "an encoder with fractions",
            table("t_ms,pwm,enc", |k| vec![10.0 * k, (k % 7.0) * 30.0, angle(k)]),
            "angle=enc:rad",
            "\"enc\" has fractions, as no count has: rad is a guess",
        ),
    ] {
        assert!(map_of(&text).contains(map), "{what}: {}", map_of(&text));
        let said = refusal(&text).to_string();
        assert!(said.contains(asked), "{what}: {said}");
        assert!(
            !asked.is_empty() || !said.contains("supply's, it drives") && !said.contains("taken for"),
            "{what}: {said}"
        );
    }
}

#[test]
fn what_drives_one_motor_is_proposed_with_no_motion_of_another() {
    // Beside what is desired of each motor, "current" is what it does.
    let row =
        |k: f64| vec![10.0 * k, speed(k), 2.0 * speed(k), (k % 7.0) * 14.0, (k % 5.0) * 20.0, 40.0, 80.0];
    let text = table("t_ms,CURRENT_M1,CURRENT_M2,PWM_M1,PWM_M2,DESIRED_M1,DESIRED_M2", row);
    let said = refusal(&text).to_string();
    assert!(said.contains("if \"CURRENT_M1\" is that") && said.contains("speed=CURRENT_M1:rad/s"), "{said}");
    assert!(!said.contains("current=") && !said.contains("=CURRENT_M2"), "{said}");
    // Nothing tells the unit of the time, which is said where a mapping is.
    let said = refusal(&table("stamp,PWM_M1,CURRENT_M1,DESIRED_M1", |k| {
        vec![2.5 * k, (k % 7.0) * 14.0, speed(k), 40.0]
    }));
    assert!(
        said.to_string().contains("time=stamp:ms") && said.to_string().contains("\"stamp\": ms is a guess"),
        "{said}"
    );
    // The current of another motor is none of this one.
    let row = |k: f64| vec![10.0 * k, (k % 7.0) * 30.0, speed(k), 0.1 * speed(k)];
    let map = map_of(&table("t_ms,left_pwm,left_rpm,right_current", row));
    assert_eq!(map, "time=t_ms:ms,duty=left_pwm:255,speed=left_rpm:rpm");
}

#[test]
fn the_motion_in_another_unit_drives_nothing() {
    let said =
        refusal(&table("time,rpm,rpm_rad", |k| vec![0.02 * k, speed(k), 0.10472 * speed(k)])).to_string();
    assert!(said.contains("no column tells what drove the motor") && !said.contains("=rpm_rad"), "{said}");
}

#[test]
fn a_speed_for_each_level_of_the_drive_is_told_from_a_log_without_a_clock() {
    let level = |k: f64| 5.0 * (k % 40.0) - 100.0;
    let said = |row: &dyn Fn(f64) -> Vec<f64>| {
        let text = table("pwm,rpm", row);
        let rows: Vec<&str> = text.lines().take(61).collect();
        refusal(&(rows.join("\n") + "\n"))
    };
    let table_of_levels = said(&|k| vec![level(k), (3.0 * level(k)).round()]);
    assert_eq!(table_of_levels.proposal, None, "pasted, its rate would make a log of them");
    let steady = table_of_levels.to_string();
    assert!(
        steady.contains("these are steady states") && steady.contains("no --rate makes a log of them"),
        "{steady}"
    );
    assert_eq!(steady.matches("these are steady states").count(), 1, "{steady}");
    assert!(steady.contains("speed=rpm:rpm --supply-volts 12 --rate N"), "{steady}");
    let log = said(&|k| vec![if k < 20.0 { 0.0 } else { 100.0 }, speed(k)]).to_string();
    assert!(log.contains("--rate 100") && !log.contains("steady states"), "{log}");
}

#[test]
fn what_numbers_the_rows_drives_nothing_and_is_no_column_beside_the_time() {
    let counts = |k: f64| (7.0 * angle(k)).round();
    let said = refusal(&table("sample_num,left_count,right_count", |k| vec![k, counts(k), counts(k + 1.0)]))
        .to_string();
    assert!(said.contains("no column tells what drove the motor") && !said.contains("=sample_num"), "{said}");
    let said = refusal(&table(",time,value", |k| vec![k, 1e8 * k + 3e4, counts(k)])).to_string();
    assert!(said.contains("beside the time there is only \"value\"") && !said.contains("--map"), "{said}");
}

#[test]
fn columns_that_a_proposal_does_not_use_are_told_with_their_ranges() {
    let row = |k: f64| vec![0.01 * k, 5.0 * (0.1 * k).sin(), 200.0 * (0.1 * k).cos(), angle(k)];
    let (_directory, path) = kept(table("t,u,v2x,theta", row).as_bytes());
    let preview = look(&path).unwrap().proposal.unwrap().preview;
    assert!(preview.last().unwrap().starts_with("unused   v2x: -200 .. 200"), "{preview:?}");
}
