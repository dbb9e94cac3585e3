//! Logs as tools, drives and servos write them: what is proposed reads them, and nothing that was commanded is taken for measured.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use motorlens::log::ReadOptions;

use super::{ROWS, assert_same, clock, lines, mapped, read_bytes, refusal, row};

/// What a tool writes, the options that are proposed (empty: none are needed), and what reads the whole motion (where the log keeps all
/// of it; empty: the proposal does not).
type Case = (&'static str, String, &'static str, &'static str);

/// Values one a line, in whatever way.
fn one_a_line() -> Vec<Case> {
    let stamped = |k: u32, u: f64, x: f64| format!(">u:{}:{u}§V|g\n>theta:{}:{x}", 10 * k, 10 * k);
    let map = "time=time_s:s,voltage=u [V]:V,angle=theta:rad";
    let mut list = "time_s,signal,value\n".to_owned();
    for k in 0..ROWS {
        let (t, u, x) = row(k);
        let _ = writeln!(list, "{t},voltage,{u}\n{t},theta,{x}");
    }
    let metrics = lines("Time,Metric,Value\n", |k, _, u, x| {
        let moment = format!("2024-05-01T{}Z", clock(45_000, 10 * k));
        format!("{moment},voltage,{u}\n{moment},theta,{x}")
    });
    vec![
        (
            "Teleplot with stamps",
            lines("boot\n", |k, _, u, x| stamped(k, u, x)),
            "--map \"time=time_s:s,voltage=u [V]:V,angle=theta:rad\"",
            map,
        ),
        (
            "Teleplot with stamps of micros()",
            lines("", |k, _, u, x| format!(">u:{}:{u}\n>theta:{}:{x}", 10_000 * k, 10_000 * k)),
            "--map time=time_s:s,voltage=u:V,angle=theta:rad",
            "time=time_s,voltage=u,angle=theta",
        ),
        (
            "Teleplot without stamps",
            lines("", |k, _, u, x| format!(">t_ms:{}\n>u:{u}\n>theta:{x}\nloop", 10 * k)),
            "--map time=t_ms:ms,voltage=u:V,angle=theta:rad",
            "time=t_ms,voltage=u,angle=theta",
        ),
        (
            "a print for each value",
            lines("", |k, _, u, x| format!("millis: {}\r\nVolts: {u}\r\nAngle: {x}\r", 10 * k)),
            "--map time=millis:ms,voltage=Volts:V,angle=Angle:rad",
            "time=millis,voltage=Volts,angle=Angle",
        ),
        (
            "Grafana",
            metrics,
            "--map time=time_s:s,voltage=voltage:V,angle=theta:rad",
            "time=time_s,voltage=voltage,angle=theta",
        ),
        (
            "a list of signals",
            list,
            "--map time=time_s:s,voltage=voltage:V,angle=theta:rad",
            "time=time_s,voltage=voltage,angle=theta",
        ),
    ]
}

/// Stamps, remarks and separators of programs that log.
fn logged() -> Vec<Case> {
    let rows = |k: u32, u: f64, x: f64| format!("{},{u},{x}", 10 * k);
    let map = "time=t_ms,voltage=u,angle=theta";
    let options = "--map time=t_ms:ms,voltage=u:V,angle=theta:rad";
    let stamp = |k: u32| format!("12:34:{:02}.{:03}", k / 100, 10 * (k % 100));
    let lvm = "LabVIEW Measurement\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nMulti_Headings\tNo\n\
               X_Columns\tOne\nTime_Pref\tRelative\nOperator\tsomebody\nDate\t2024/05/01\nTime\t12:00:00.5\n***End_of_Header***\n\t\n\
               Channels\t2\t\t\nSamples\t200\t200\t\nDate\t2024/05/01\t2024/05/01\t\nTime\t12:00:00.5\t12:00:00.5\t\n\
               X_Dimension\tTime\tTime\t\nX0\t0.0E+0\t0.0E+0\t\nDelta_X\t0.010000\t0.010000\t\n***End_of_Header***\t\t\t\n\
               X_Value\tVoltage\tAngle\tComment\n";
    vec![
        (
            "stamps in brackets",
            lines("", |k, _, u, x| format!("[{}] u:{u} theta:{x}", stamp(k))),
            "--map voltage=u:V,angle=theta:rad",
            "voltage=u,angle=theta",
        ),
        (
            "Tera Term",
            lines("", |k, _, u, x| format!("[Wed May 01 {} 2024] u:{u} theta:{x}", stamp(k))),
            "--map voltage=u:V,angle=theta:rad",
            "voltage=u,angle=theta",
        ),
        (
            "CoolTerm",
            lines("", |k, _, u, x| format!("2024-05-01 {} u:{u},theta:{x}", stamp(k))),
            "--map voltage=u:V,angle=theta:rad",
            "voltage=u,angle=theta",
        ),
        (
            "Python's logging",
            lines("", |k, _, u, x| {
                format!("2024-05-01 {} - motor - INFO - u={u} theta={x}", stamp(k).replace('.', ","))
            }),
            "--map voltage=u:V,angle=theta:rad",
            "voltage=u,angle=theta",
        ),
        (
            "Zephyr",
            lines("", |k, _, u, x| format!("[{},000] <inf> motor: u: {u}, theta: {x}", stamp(k))),
            "--map voltage=u:V,angle=theta:rad",
            "voltage=u,angle=theta",
        ),
        (
            "defmt",
            lines("", |_, t, u, x| format!("{t:.6} [INFO ] u={u} theta={x} (motor src/main.rs:42)")),
            "--map voltage=u:V,angle=theta:rad",
            "voltage=u,angle=theta",
        ),
        (
            "ESP-IDF",
            lines("", |k, _, u, x| format!("\u{1b}[0;32mI ({}) motor: u:{u} theta:{x}\u{1b}[0m", 10 * k)),
            "--map voltage=u:V,angle=theta:rad",
            "voltage=u,angle=theta",
        ),
        (
            "PuTTY",
            lines("=~=~=~=~=~= PuTTY log 2024.05.01 12:00:00 =~=~=~=~=~=\nt_ms,u,theta\n", |k, _, u, x| {
                rows(k, u, x)
            }),
            options,
            map,
        ),
        (
            "LabVIEW",
            lines(lvm, |_, t, u, x| format!("{t:.6}\t{u:.6}\t{x:.6}")),
            "--map time=X_Value:s,voltage=Voltage:V,angle=Angle:rad",
            "time=X_Value,voltage=Voltage,angle=Angle",
        ),
        (
            "a comma behind the names",
            lines("boot\nt_ms,u,theta,\n", |k, _, u, x| rows(k, u, x)),
            options,
            map,
        ),
        (
            "a comma behind the numbers",
            lines("boot\nt_ms,u,theta\n", |k, _, u, x| rows(k, u, x) + ","),
            options,
            map,
        ),
        (
            "PlotJuggler",
            lines("__time,/motor/volts,/motor/theta\n", |_, t, u, x| {
                format!("{},{u},{x}", 1_732_340_000.0 + t)
            }),
            "--map time=__time:s,voltage=/motor/volts:V,angle=/motor/theta:rad",
            "time=__time,voltage=/motor/volts,angle=/motor/theta",
        ),
        (
            "a German spreadsheet",
            lines("Datum und Zeit;Spannung [mV];Winkel [rad]\n", |k, _, u, x| {
                let digits = format!("{:.1}", (1e3 * u).abs()).replace('.', ",");
                let at = digits.len().saturating_sub(5);
                let grouped =
                    if at > 0 { format!("{}.{}", &digits[..at], &digits[at..]) } else { digits.clone() };
                let sign = if u < 0.0 { "-" } else { "" };
                format!(
                    "01.05.2024 {};{sign}{grouped};{}",
                    clock(45_000, 10 * k).replace('.', ","),
                    x.to_string().replace('.', ",")
                )
            }),
            "--map \"time=Datum und Zeit:s,voltage=Spannung [mV]:mV,angle=Winkel [rad]:rad\"",
            "time=Datum und Zeit,voltage=Spannung [mV],angle=Winkel [rad]",
        ),
    ]
}

/// Counts in hexadecimal digits, pulses, registers of servos, columns of drives.
fn drives() -> Vec<Case> {
    let count = |x: f64| (1e4 * x).round() as i32 - 5000;
    vec![
        (
            "hexadecimal counts with their mark",
            lines("t_ms,u,enc\n", |k, _, u, x| format!("{},{u},0x{:08X}", 10 * k, count(x))),
            "--map time=t_ms:ms,voltage=u:V,angle=enc:counts --counts-per-rev 1320",
            "",
        ),
        (
            "hexadecimal counts without",
            lines("t_ms,u,enc\n", |k, _, u, x| format!("{},{u},{:X}", 10 * k, count(x))),
            "--map time=t_ms:ms,voltage=u:V,angle=enc:counts --counts-per-rev 1320",
            "",
        ),
        (
            "pulses of an ESC",
            lines("millis,esc,theta\n", |k, _, u, x| format!("{},{},{x}", 10 * k, 1500.0 + 100.0 * u)),
            "--map time=millis:ms,duty=esc:1500..2000,angle=theta:rad --supply-volts 12",
            "time=millis,duty=esc:1500..2000,angle=theta",
        ),
        (
            "Dynamixel",
            lines("time,goal_pwm,present_pwm,present_position,present_input_voltage\n", |k, t, u, x| {
                let pwm = (200.0 * u).round();
                format!("{t},{pwm},{pwm},{},{}", (2048.0 + 4096.0 * x / TAU).round(), 120 - k % 2)
            }),
            "--map \"time=time:s,duty=present_pwm:885,angle=present_position:rev/4096,supply=present_input_voltage:V*0.1\"",
            "",
        ),
        (
            "Dynamixel told where to go",
            lines("time,goal_position,present_position\n", |_, t, u, x| {
                format!("{t},{:.0},{:.0}", 2048.0 + 500.0 * u, 2048.0 + 4096.0 * x / TAU)
            }),
            "--map time=time:s,target=goal_position:rev/4096,angle=present_position:rev/4096 --supply-volts 12",
            "",
        ),
        (
            "VESC",
            lines(
                "ms_today;input_voltage;temp_mos_max;current_motor;current_in;d_axis_current;q_axis_current;erpm;duty_cycle;tachometer;\
                 fault_code;vesc_id;d_axis_voltage;ms_today_setup;speed_meters_per_sec\n",
                |k, _, u, x| {
                    let ms = 40_000_000 + 10 * k;
                    format!(
                        "{ms};{:.1};31.2;1.5;0.4;0.1;1.5;{:.0};{:.3};{k};0;12;0.2;{ms};{x:.3}",
                        24.0 - 0.1 * u.abs(),
                        1000.0 * x,
                        u / 5.0
                    )
                },
            ),
            "--map time=ms_today:ms,duty=duty_cycle:1,speed=erpm:rpm/7,current=current_motor:A,supply=input_voltage:V",
            "",
        ),
        (
            "ODrive",
            lines(
                "time,axis0.pos_estimate,axis0.vel_estimate,axis0.motor.foc.Iq_measured,axis0.motor.foc.Vq_setpoint,vbus_voltage\n",
                |_, t, u, x| format!("{t},{},{},0.1,{u},24.1", x / TAU, 1.5 * u / TAU),
            ),
            "--map time=time:s,voltage=axis0.motor.foc.Vq_setpoint:V,angle=axis0.pos_estimate:rev,speed=axis0.vel_estimate:rev/s,\
             current=axis0.motor.foc.Iq_measured:A,supply=vbus_voltage:V",
            "",
        ),
        (
            "Phoenix",
            lines(
                "Timestamp,Phoenix6/TalonFX-3/SupplyVoltage,Phoenix6/TalonFX-3/MotorVoltage,Phoenix6/TalonFX-3/Position\n",
                |k, t, u, x| format!("{t},{},{u},{}", 12.1 - 0.1 * f64::from(k % 3), x / TAU),
            ),
            "--map time=Timestamp:s,voltage=Phoenix6/TalonFX-3/MotorVoltage:V,angle=Phoenix6/TalonFX-3/Position:rev,\
             supply=Phoenix6/TalonFX-3/SupplyVoltage:V",
            "",
        ),
        (
            "moteus",
            lines(
                "timestamp,mode,position,velocity,torque,q_current,d_current,voltage,temperature,fault,command_voltage_q\n",
                |_, t, u, x| format!("{t},6,{},{},{u},{u},0.01,24.0,30.5,0,{u}", x / TAU, 1.5 * u / TAU),
            ),
            "--map time=timestamp:s,voltage=command_voltage_q:V,angle=position:rev,speed=velocity:rev/s,current=q_current:A,\
             supply=voltage:V",
            "",
        ),
        (
            "turns and rpm that no name tells",
            lines("Timestamp,Applied Output,Bus Voltage,Position,Velocity\n", |_, t, u, x| {
                format!("{t},{},16,{},{}", u / 16.0, x / TAU, 1.5 * u * 60.0 / TAU)
            }),
            "--map \"time=Timestamp:s,duty=Applied Output:1,angle=Position:rev,speed=Velocity:rpm,supply=Bus Voltage:V\"",
            "",
        ),
        (
            "units a blank behind named values",
            lines("", |k, _, u, x| {
                format!("Time: {} ms, Motor: {u} V, Shaft: {} deg", 10 * k, x.to_degrees())
            }),
            "--map time=Time:ms,voltage=Motor:V,angle=Shaft:deg",
            "",
        ),
        (
            "the arrays of a bag's only joint",
            lines("time,name,position,velocity,voltage\n", |_, t, u, x| {
                format!("{t},\"['wheel']\",\"[{x}]\",\"[{}]\",{u}", 1.5 * u)
            }),
            "--map time=time:s,voltage=voltage:V,angle=position:rad,speed=velocity:rad/s",
            "",
        ),
        (
            "a command is no measurement",
            lines("t,u,cmd_vel,input_pos,vel,theta\n", |_, t, u, x| format!("{t},{u},1,{},{u},{x}", 2.0 * x)),
            "--map time=t:s,voltage=u:V,angle=theta:rad,speed=vel:rad/s",
            "time=t,voltage=u,angle=theta",
        ),
    ]
}

#[test]
fn what_tools_and_drives_write_is_proposed_and_read() {
    let mut wrong = String::new();
    for (what, text, options, map) in one_a_line().into_iter().chain(logged()).chain(drives()) {
        let proposal = refusal(&text).proposal;
        let proposed = proposal.as_ref().map_or_else(|| "nothing".to_owned(), |proposal| proposal.options());
        if proposed != options {
            let _ = writeln!(wrong, "{what}: {proposed}");
            continue;
        }
        let map = if map.is_empty() {
            proposal.map_or_else(String::new, |proposal| proposal.map)
        } else {
            map.to_owned()
        };
        let mut options = ReadOptions { supply_volts: Some(5.0), ..mapped(&map) };
        options.motor.counts_per_rev = Some(1e4 * TAU);
        let record = read_bytes(text.as_bytes(), &options).unwrap_or_else(|e| panic!("{what}: {e}"));
        let whole = ["Dynamixel", "VESC", "hexadecimal"].iter().all(|not| !what.starts_with(not));
        if whole {
            assert_same(&record, what, 0);
        } else if what.starts_with("hexadecimal") {
            let angle = record.angle_rad.as_ref().unwrap();
            for k in 0..ROWS {
                let off = angle[k as usize] + 0.5 - row(k).2;
                assert!(off.abs() < 1e-9, "{what}: {off} in row {k}");
            }
        } else {
            assert_eq!(record.len(), ROWS as usize, "{what}: {:?}", record.warnings);
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// A drive that is told a torque logs its supply, and there is no voltage of the motor in it.
#[test]
fn a_supply_beside_a_torque_is_no_voltage_of_the_motor() {
    let text = lines("time,position,velocity,torque,q_curr,d_curr,voltage\n", |k, t, u, x| {
        format!("{t},{x},{u},{u},{u},0,{}", 24.0 - 0.01 * f64::from(k % 5))
    });
    let refused = refusal(&text);
    assert!(refused.proposal.is_none() && refused.to_string().contains("torque"), "{refused}");
}
