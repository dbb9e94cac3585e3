//! What fuzzing begins with: small logs of every format, and messages of the link.

use std::fmt::Write as _;
use std::path::Path;

use parquet::basic::Compression;

use crate::formats_support::{Wpilog, canonical_columns, mcap_of, npy, parquet_of, zip_of};
use crate::packing::parts;
use crate::{BAM, SYSID};

/// The files of `host/tests/formats`, written by the programs that people use.
macro_rules! fixture {
    ($name:literal) => {
        include_bytes!(concat!("../../../host/tests/formats/", $name)).to_vec()
    };
}

/// Writes a directory of small logs for each family of readers into `directory`.
///
/// # Errors
/// What the disk says.
pub fn write(directory: &Path) -> std::io::Result<()> {
    let families = [
        ("text", text()),
        ("json", json()),
        ("wpilog", wpilog()),
        ("matlab", matlab()),
        ("arrays", arrays()),
    ];
    let more = [
        ("parquet", parquet()),
        ("mcap", mcap()),
        ("sheets", vec![fixture!("sheet.xls")]),
        ("packed", parts()),
        ("link", crate::link::seeds()),
    ];
    for (family, seeds) in families.into_iter().chain(more) {
        let family = directory.join(family);
        std::fs::create_dir_all(&family)?;
        for (number, seed) in seeds.iter().enumerate() {
            std::fs::write(family.join(format!("seed{number}")), seed)?;
        }
    }
    Ok(())
}

/// A table of `head` and 24 lines that `line` writes from the row, its time in s, a voltage in V and an angle in rad.
fn table(way: u8, head: &str, line: impl Fn(u32, f64, f64, f64) -> String) -> Vec<u8> {
    let mut text = head.to_owned();
    for k in 0..24 {
        let t = 0.01 * f64::from(k);
        let _ = writeln!(text, "{}", line(k, t, if k % 8 < 4 { 5.0 } else { -4.5 }, 2.0 * (20.0 * t).sin()));
    }
    [&[way], text.as_bytes()].concat()
}

/// Tables as boards and spreadsheets write them; the first byte is the number of the way to read them.
fn text() -> Vec<Vec<u8>> {
    let comma = |x: f64| format!("{x:.3}").replace('.', ",");
    let canonical = table(0, "time_s,voltage_v,angle_rad\n", |_, t, u, x| format!("{t:.2},{u},{x:.3}"));
    let wide: Vec<u8> =
        String::from_utf8_lossy(&canonical[1..]).encode_utf16().flat_map(u16::to_le_bytes).collect();
    vec![
        [&[0, 0xFF, 0xFE], wide.as_slice()].concat(),
        canonical,
        table(1, "# gear_ratio=30\nt_ms;u;x\n", |_, t, u, x| {
            format!("{};{};{}", 1e3 * t, comma(u), comma(x))
        }),
        table(1, "sep=;\r\nZeit [ms];Spannung;Winkel\r\n(ms);(V);(deg)\r\n", |_, t, u, x| {
            format!("{};{};{}\r", comma(1e3 * t), comma(u), comma(x))
        }),
        table(0, "time_s,voltage_v,angle_rad\n", |_, t, u, x| {
            format!("{},{},{}", comma(t), comma(u), comma(x))
        }),
        table(2, "sec,nanosec,u,rpm\n", |k, _, u, x| format!("1732340000,{},{u},{x:.2}", 10_000_000 * k)),
        table(3, "dt pwm x\n", |k, _, u, x| {
            format!("10000 {} {x:.2}", if k == 9 { "nan".into() } else { u.to_string() })
        }),
        table(4, "u,x\n", |_, _, u, x| format!("{u},{x:.3}")),
        table(5, "ets Jun 8 2016\nrst:0x1 (POWERON_RESET)\n\u{0}t_ms,pwm,enc\n", |k, t, u, x| {
            format!(
                "{:.0},{:.0},{:.0}",
                1e3 * t,
                50.0 * u,
                if k < 12 { 100.0 * x } else { 65536.0 + 100.0 * x }
            )
        }),
        table(0, "", |_, t, u, x| {
            format!("12:34:56.{:03.0} -> t:{:.0} pwm:{u} enc:{x:.3}", 1e3 * t, 1e3 * t)
        }),
        table(1, "time,\"u\",x\n", |_, t, u, x| {
            format!("2024-05-01T12:34:56.{:03.0}+02:00,\"{u}\",{x:.3}", 1e3 * t)
        }),
        table(1, "when,u,x\n", |_, t, u, x| format!("01.05.2024 11:34:56.{:03.0} PM,{u},{x:.3}", 1e3 * t)),
        table(6, "time_s\tgoal\tposition\tstate\n", |k, t, u, x| format!("{t}\t{u}\t{x:.3}\t{}", k / 8)),
        table(7, "  time  duty  Vbat  rate  amp\n", |_, t, u, x| {
            format!("{t:6.2}{:6}{:6}{x:6.1}{x:6.2}", 20.0 * u, 11100)
        }),
        table(0, "", |k, _, u, x| format!(">u:{}:{u}§V|g\n>theta:{}:{x:.3}", 10 * k, 10 * k)),
        table(0, "", |k, _, u, x| format!("millis: {}\nvolts: {u}\nangle: {x:.3}", 10 * k)),
        table(8, "", |k, t, u, x| {
            format!("I ({k}) motor: {:.0},{:.0},0x{:04X}", 1e3 * t, 1500.0 + 60.0 * u, (9e3 * x.abs()) as u16)
        }),
        table(5, "t_ms,pwm,enc\n", |k, _, u, x| format!("{k},{u},{:X}", (9e3 * x.abs()) as u16)),
        table(0, "t_ms,pwm,pwm,setpoint,enc\n", |k, t, u, x| {
            format!("{:.0},{u},{},90,{:.0}", 1e3 * t, k % 2, 1e3 * x)
        }),
    ]
    .into_iter()
    .chain(instruments())
    .chain(readings())
    .collect()
}

/// What instruments and their programs print before their rows.
fn instruments() -> Vec<Vec<u8>> {
    let comma = |x: f64| format!("{x:.3}").replace('.', ",");
    let labview = "LabVIEW Measurement\t\nDecimal_Separator\t,\n***End_of_Header***\t\n\nChannels\t2\t\t\nDelta_X\t0,01\t0,01\t\n\
                   ***End_of_Header***\t\t\t\nX_Value\tVoltage\tAngle\tComment\n";
    let tektronix = "Model,MSO54\n\nHorizontal Units,s\nSample Interval,0.01\nVertical Units,V,V\nLabel,,\n\nTIME,u,theta\n";
    let twincat = "Name\tScope\n\nName\tVoltage\tName\tAngle\nData-Type\tREAL64\tData-Type\tREAL64\n\
                   SampleTime[ms]\t10\tSampleTime[ms]\t10\nUnit\tV\tUnit\trad\n\n";
    let rigol = "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.0e+01,1.0e-02\n";
    vec![
        table(0, labview, |_, _, u, x| format!("\t{}\t{}\t", comma(u), comma(x))),
        table(0, tektronix, |_, t, u, x| format!("{:.4e},{u},{x:.3}", t - 1.0)),
        table(0, twincat, |_, t, u, x| format!("{0}\t{u}\t{0}\t{x:.3}", 1e3 * t)),
        table(4, rigol, |k, _, u, x| format!("{k},{u:.2e},{x:.3e},")),
        table(4, "CH1,CH2,t0 =-1.0e+01, tInc = 1.0e-02,\n", |_, _, u, x| format!("{u:.2e},{x:.3e},,")),
    ]
}

/// Readings that are blank, garbled, clipped, of several motors, or have their thousands and units beside them, and times as few write them.
fn readings() -> Vec<Vec<u8>> {
    vec![
        table(0, "time_s,voltage_v,speed_rad_s\n", |k, t, u, x| {
            format!("{t:.2},{u},{}", if k % 4 == 0 { format!("{x:.3}") } else { String::new() })
        }),
        table(0, "time_s,voltage_v,speed_rad_s\n", |k, t, u, x| {
            format!("{t:.2},{u},{}", if k == 11 { 1e6 } else { (400.0 * x).clamp(-128.0, 127.0).round() })
        }),
        table(0, "time_s,voltage_v,speed_rad_s\n", |k, t, u, x| {
            format!("{t:.2},{u},{}", ((70.0 * x).round() as i32 + if k > 6 { 90 } else { 0 }) as i8)
        }),
        table(0, "time_s,motor_id,voltage_v,angle_rad\n", |k, t, u, x| {
            format!("{t:.2},{},{u},{x:.3}", k % 2)
        }),
        table(1, "t,u,x\n", |_, t, u, x| format!("{:.0} ms,{u}V,{x:.2} deg", 1e3 * t)),
        table(1, "t;u;x\n", |_, t, u, x| format!("{:.0};{u};1.{:03.0},5", 1e3 * t, 100.0 * x.abs())),
        table(0, "Time,Millitm,u,i,rpm,dir,encA\n", |k, _, u, x| {
            format!("{},{},{u},0.5,{:.2},{},{}", k / 10, k % 10 * 100, x.abs(), u32::from(x > 0.0), k % 2)
        }),
        table(1, "time,u,x\n", |_, t, u, x| format!("12:00:00:{:03.0},{u},{x:.3}", 1e3 * t)),
        table(0, "time,u,gx,gz\n", |_, t, u, x| format!("{:.10},{u},0,{x:.3}", 45987.5 + t / 86_400.0)),
        table(0, "time_s,voltage_v,angle_rad\n", |k, t, u, x| {
            let line = format!("{t:.1},{u},{x:.3}");
            if k % 3 == 0 { format!("{line}\n{line}") } else { line }
        }),
    ]
}

/// SysId's and BAM's JSON; their first bytes choose the format, as [`crate::way`] reads them.
fn json() -> Vec<Vec<u8>> {
    let row = |k: u32| [f64::from(k) * 0.02, 4.0, f64::from(k), 2.0];
    let rows: Vec<_> = (0..24).map(row).collect();
    let sides: Vec<_> = (0..24).map(|k| [row(k), row(k), [0.5; 4]].concat()[..10].to_vec()).collect();
    let sysid =
        serde_json::json!({"test": "Arm", "units": "Rotations", "fast-forward": rows, "slow-backward": rows});
    let drive = serde_json::json!({"test": "Drivetrain", "slow-forward": sides, "sysid": true});
    let entries: Vec<_> = (0..24)
        .map(|k| {
            serde_json::json!({"timestamp": 0.02 * f64::from(k), "position": 0.1 * f64::from(k), "goal_position": 2.0,
                               "input_volts": 7.4, "torque_enable": k < 22})
        })
        .collect();
    let bam =
        serde_json::json!({"kp": 8, "mass": 0.5, "length": 0.1, "trajectory": "sin", "entries": entries});
    let seed = |way: u8, text: serde_json::Value| [&[way], text.to_string().as_bytes()].concat();
    let split = serde_json::json!({"columns": ["t", "u", "pos"], "index": [0, 1], "data": rows.iter().map(|row| &row[..3]).collect::<Vec<_>>()});
    let python: String = (0..24)
        .map(|k| {
            format!(
                "{{'t': {}, 'u': np.float64(5.0), 'pos': {}, 'ok': True, 'x': None}}\n",
                0.01 * f64::from(k),
                k % 7
            )
        })
        .collect();
    let python = [&[1], python.as_bytes()].concat();
    vec![
        python,
        seed(1, split),
        seed(SYSID, sysid.clone()),
        seed(SYSID, drive),
        seed(BAM, bam.clone()),
        seed(0, sysid),
        seed(0, bam),
    ]
}

/// Data logs with SysId's entries, with others, and written as lists.
fn wpilog() -> Vec<Vec<u8>> {
    let log = |state: &str, entries: [&str; 2], metadata: &str| {
        let mut log = Wpilog::new();
        let state = log.start(state, "string", "");
        let entries = entries.map(|name| log.start(name, "double", metadata));
        for k in 0..24 {
            log.text(state, f64::from(k) * 0.02, if k < 22 { "dynamic-forward" } else { "none" });
            entries.iter().for_each(|entry| log.number(*entry, f64::from(k) * 0.02, f64::from(k)));
        }
        log.bytes
    };
    let mut list = "Timestamp,Name,Value\n".to_owned();
    for k in 0..24 {
        let t = f64::from(k) * 0.02;
        let _ = writeln!(list, "{t},\"sysid-test-state-arm\",\"quasistatic-reverse\"");
        let _ = writeln!(
            list,
            "{t},\"voltage-m-arm\",{t}\n{t},\"position-m-arm\",{t}\n{t},\"velocity-m-arm\",1.5"
        );
    }
    let influx: String = (0..24)
        .flat_map(|k| ["voltage_v", "angle_rad"].map(|name| format!(",,0,{k},{},{name},motor\n", k % 5)))
        .collect();
    let influx = format!("#group,false,false,true\n,result,table,_time,_value,_field,_measurement\n{influx}");
    // What drives the motor and its motion have stamps of their own, and what repeats is not written.
    let own: String = (0..96)
        .map(|k| match k % 4 {
            0 => format!("{},voltage_v,{}\n", 0.005 * f64::from(k), k % 3),
            1 if k % 12 != 1 => format!("{},angle_rad,{}\n", 0.005 * f64::from(k), k * k),
            2 => format!("{},speed_rad_s,{k}\n", 0.005 * f64::from(k)),
            _ => String::new(),
        })
        .collect();
    vec![
        influx.into_bytes(),
        format!("time_s,signal,value\n{own}").into_bytes(),
        log("sysid-test-state-arm", ["voltage-m-arm", "position-m-arm"], "{\"unit\":\"m\"}"),
        log("/RealOutputs/SysIdTestState", ["/Arm/AppliedVolts", "/Arm/PositionRad"], ""),
        log("note", ["voltage_v", "angle_rad"], ""),
        list.into_bytes(),
    ]
}

fn matlab() -> Vec<Vec<u8>> {
    vec![
        fixture!("v6.mat"),
        fixture!("v7.mat"),
        fixture!("struct.mat"),
        fixture!("groups.h5"),
        fixture!("v73.mat"),
    ]
}

/// Columns of a log short enough to be changed in every byte.
fn columns() -> (Vec<&'static str>, Vec<Vec<f64>>) {
    let (names, columns) = canonical_columns();
    (names, columns.into_iter().map(|column| column[..24].to_vec()).collect())
}

fn arrays() -> Vec<Vec<u8>> {
    let (_, columns) = columns();
    let vector = npy("'<f8'", "False", "(24,)", &columns[0]);
    let fields = "[('time_s', '<f8'), ('voltage_v', '<f8'), ('angle_rad', '<f8'), ('speed_rad_s', '<f8')]";
    let archive = [("time_s.npy".to_owned(), vector.clone()), ("voltage_v.npy".to_owned(), vector)];
    vec![
        npy("'<f8'", "True", "(24, 4)", &columns.concat()),
        npy(fields, "False", "(24,)", &columns.concat()),
        npy("'<M8[ms]'", "False", "(24,)", &columns[0]),
        npy("'<f2'", "False", "(32, 3)", &columns[0]),
        zip_of(&archive, false),
    ]
}

fn parquet() -> Vec<Vec<u8>> {
    let (names, columns) = columns();
    let packed = [Compression::UNCOMPRESSED, Compression::SNAPPY, Compression::LZ4_RAW];
    let mut files: Vec<_> = packed.into_iter().map(|packing| parquet_of(&names, &columns, packing)).collect();
    files.push(fixture!("lists.parquet"));
    files
}

fn mcap() -> Vec<Vec<u8>> {
    let (_, columns) = columns();
    [(true, ""), (false, ""), (true, "lz4"), (false, "zstd")]
        .map(|(ros, packing)| mcap_of(&columns, ros, packing))
        .to_vec()
}
