//! What names and values say of units, clocks and bridges, and what they leave open.

use std::f64::consts::TAU;

use motorlens::log::ReadOptions;

use super::{ROWS, assert_same, lines, mapped, read_bytes, refusal, row};

#[test]
fn clocks_in_multiples_of_a_unit_are_read_in_them() {
    for (name, ticks, unit) in [
        ("t_cs", 1.0, "ms*10"),
        ("t_10us", 1000.0, "us*10"),
        ("time_100us", 100.0, "us*100"),
        ("time [min]", 0.01 / 60.0, "s*60"),
        ("time_h", 0.01 / 3600.0, "s*3600"),
        ("time [d]", 0.01 / 86_400.0, "s*86400"),
        ("t_days", 0.01 / 86_400.0, "s*86400"),
    ] {
        let text =
            lines(&format!("{name},u,theta\n"), |k, _, u, x| format!("{},{u},{x}", ticks * f64::from(k)));
        let map = refusal(&text).proposal.unwrap().map;
        assert_eq!(map, format!("time={name}:{unit},voltage=u:V,angle=theta:rad"));
        assert_same(&read_bytes(text.as_bytes(), &mapped(&map)).unwrap(), name, 0);
    }
    // What rises and is called otherwise is no clock.
    let text = lines("freq_Hz,u,theta\n", |_, t, u, x| format!("{},{u},{x}", 1.0 + t));
    assert_eq!(refusal(&text).proposal.unwrap().options(), "--map voltage=u:V,angle=theta:rad --rate 100");
}

#[test]
fn a_wrap_tells_the_unit_of_an_angle_and_a_guess_is_called_one() {
    for (turn, unit) in [(360.0, "deg"), (TAU, "rad"), (1.0, "rev"), (4096.0, "counts")] {
        let text = lines("t,u,angle\n", |k, t, u, _| {
            let wrapped = (turn * 0.03 * f64::from(k)).rem_euclid(turn);
            format!("{t},{u},{}", if unit == "counts" { wrapped.floor() } else { wrapped })
        });
        let proposal = refusal(&text).proposal.unwrap();
        assert_eq!(proposal.map, format!("time=t:s,voltage=u:V,angle=angle:{unit}"));
        // Of counts the turn is told too.
        let said = |text: &String| unit == "counts" && text.contains("begins anew at 4096");
        assert!(proposal.unknown_units.iter().all(said), "{:?}", proposal.unknown_units);
    }
    for (name, said) in [("pos", "rad is a guess; put deg, rev or counts in its place"), ("pos_rad", "")] {
        let text = lines(&format!("t,u,{name}\n"), |_, t, u, x| format!("{t},{u},{x}"));
        let asked = refusal(&text).proposal.unwrap().assumptions();
        assert!(asked.contains(said) && asked.is_empty() == said.is_empty(), "{asked}");
    }
}

#[test]
fn names_and_units_of_other_languages_are_known() {
    for (names, units) in [
        ("Tempo [s],Tensione [V],Posizione [rad]", ["s", "V", "rad"]),
        ("tempo,tensao,posicao_rad", ["s", "V", "rad"]),
        ("czas [s],napięcie [V],kąt [rad]", ["s", "V", "rad"]),
        ("tijd [s],spanning [V],hoek [rad]", ["s", "V", "rad"]),
        ("时间(s),电压(V),角度(rad)", ["s", "V", "rad"]),
    ] {
        let text = lines(&format!("{names}\n"), |_, t, u, x| format!("{t},{u},{x}"));
        let map = refusal(&text).proposal.unwrap().map;
        let columns: Vec<&str> = names.split(',').collect();
        let [t, u, x] = units;
        assert_eq!(
            map,
            format!("time={}:{t},voltage={}:{u},angle={}:{x}", columns[0], columns[1], columns[2])
        );
        assert_same(&read_bytes(text.as_bytes(), &mapped(&map)).unwrap(), names, 0);
    }
    let text = lines("Время, с;Напряжение, В;Угол, рад\n", |_, t, u, x| {
        format!("{t};{u};{x}")
    });
    assert_eq!(refusal(&text).proposal.unwrap().map, "time=0:s,voltage=1:V,angle=2:rad");
}

#[test]
fn a_controllers_input_is_what_it_measures_and_asked_about() {
    let text = lines("time,setpoint,input,output\n", |k, _, u, x| {
        format!("{},{},{},{}", 10 * k, 60, (1e3 * x).round(), (50.0 * u).round())
    });
    let asked = refusal(&text).to_string();
    assert!(asked.contains("time=time:ms,duty=output:255,speed=input:rpm"), "{asked}");
    assert!(asked.contains("time=time:ms,duty=output:255,angle=input:counts"), "{asked}");
    assert!(!asked.contains("voltage=input"), "{asked}");
}

#[test]
fn two_sides_of_a_bridge_are_read_as_their_difference() {
    for (forth, back) in [("in1", "in2"), ("rpwm", "lpwm"), ("pwm_fwd", "pwm_rev"), ("IN1-PWM", "IN2-PWM")] {
        let text = lines(&format!("t_ms,{forth},{back},theta\n"), |k, _, u, x| {
            let duty = (50.0 * u).round();
            format!("{},{},{},{x}", 10 * k, duty.max(0.0), (-duty).max(0.0))
        });
        let map = refusal(&text).proposal.unwrap().map;
        assert_eq!(map, format!("time=t_ms:ms,duty={forth}-{back}:255,angle=theta:rad"));
        for map in [map.as_str(), "time=0:ms,duty=1-2:255,angle=3:rad"] {
            let options = ReadOptions { supply_volts: Some(5.1), ..mapped(map) };
            let record = read_bytes(text.as_bytes(), &options).unwrap();
            let off = |k: usize| record.voltage_v[k] - 0.02 * (50.0 * row(k as u32).1).round();
            assert!((0..ROWS as usize).all(|k| off(k).abs() < 1e-9), "{map}");
        }
    }
}

#[test]
fn numbers_of_rows_that_are_missing_are_time_that_passed() {
    for width in [256, 1 << 20] {
        let text = lines("sample,u,pos\n", |k, _, u, x| format!("{},{u},{x}", (k + 100) % width));
        let options = ReadOptions { rate_hz: Some(100.0), ..mapped("voltage=u,angle=pos") };
        assert_same(&read_bytes(text.as_bytes(), &options).unwrap(), "all", 0);
        let lost = |k: usize| [30, 60, 61, 155].contains(&k);
        let holed: Vec<&str> =
            text.lines().enumerate().filter(|(k, _)| *k == 0 || !lost(k - 1)).map(|(_, l)| l).collect();
        let record = read_bytes(holed.join("\n").as_bytes(), &options).unwrap();
        let left: Vec<usize> = (0..ROWS as usize).filter(|k| !lost(*k)).collect();
        assert_eq!(record.len(), left.len());
        assert!(left.iter().zip(&record.time_s).all(|(k, t)| (t - 0.01 * *k as f64).abs() < 1e-9), "{width}");
        assert!(
            record.warnings.iter().any(|w| w.what.contains("4 numbers are missing")),
            "{:?}",
            record.warnings
        );
    }
}
