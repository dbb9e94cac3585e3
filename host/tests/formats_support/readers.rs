//! How the readers of logs are asked, and what every one of their answers must be: for the properties here and for the fuzzing.

use motorlens::error::Result;
use motorlens::log::{Format, ReadOptions, Record};

/// The ways to read a table: the guess, names, and numbers with every kind of quantity and time.
pub const WAYS: [&str; 9] = [
    "",
    "time=0:ms,voltage=1,angle=2:deg",
    "time=0+1:ns,voltage=2,speed=3:rpm",
    "interval=0:us,duty=1:255,angle=2:mm",
    "voltage=0,angle=1",
    "time=t_ms:ms,duty=pwm:255,angle=enc:counts",
    "time=0,target=1:deg,angle=2:deg",
    "time=0,duty=1:100,supply=2:mV,speed=3:counts/s,current=4:mA",
    "time=0:ms,duty=1:1500..2000,angle=2:counts",
];

/// One of the [`WAYS`], with everything told that it may ask for.
pub fn told(format: Format, way: &str) -> ReadOptions {
    let mut options = ReadOptions {
        format,
        map: (!way.is_empty()).then(|| way.parse().expect("a mapping of WAYS")),
        supply_volts: Some(12.0),
        rate_hz: Some(100.0),
        ..ReadOptions::default()
    };
    options.motor.counts_per_rev = Some(1320.0);
    options.motor.metres_per_rev = Some(0.008);
    options
}

/// What is wrong with an answer, if anything: it must be clean records, or a message with cause and remedy.
pub fn wrong(answer: &Result<Vec<Record>>) -> Option<String> {
    let records = match answer {
        Ok(records) => records,
        Err(error) => {
            let helps = error.exit_code() == 3 && error.to_string().contains("\n  do: ");
            return (!helps).then(|| error.to_string());
        }
    };
    records.iter().find_map(|record| {
        let columns = [Some(&record.voltage_v), record.angle_rad.as_ref(), record.speed_rad_s.as_ref()];
        for column in columns.into_iter().flatten() {
            if column.len() != record.len() || !column.iter().all(|value| value.is_finite()) {
                return Some(format!("{} of {} samples are not all finite", column.len(), record.len()));
            }
        }
        let rises = record.time_s.windows(2).all(|pair| pair[0] < pair[1]);
        (!rises).then(|| "times that do not rise".into())
    })
}
