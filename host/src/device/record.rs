//! A captured run as a record in SI units.

use super::Captured;
use crate::log::{EncoderShaft, Metadata, Record};
use motorlens_shared::excitation::Programme;

/// What turns encoder counts into an angle of the output shaft.
#[derive(Debug, Clone, Copy)]
pub struct Shaft {
    /// Counts per turn of the output shaft, after x4 and gearing.
    pub counts_per_rev: f64,
    /// Motor turns per output turn, where known.
    pub gear_ratio: Option<f64>,
    /// Where the encoder sits, where known.
    pub encoder: Option<EncoderShaft>,
}

impl Shaft {
    /// The output shaft's turn per count, rad.
    pub fn rad_per_count(&self) -> f64 {
        std::f64::consts::TAU / self.counts_per_rev
    }
}

/// The record of a captured run; what is missing from it stands in its metadata.
///
/// # Errors
/// A metadata value that the log format does not admit.
pub fn record(captured: &Captured, shaft: &Shaft, programme: &Programme) -> Result<Record, String> {
    let samples = &captured.samples;
    let column = |value: &dyn Fn(u32, &motorlens_shared::link::Sample) -> f64| {
        samples.iter().map(|(index, sample)| value(*index, sample)).collect::<Vec<f64>>()
    };
    let scaling = captured.scaling;
    let capabilities = &captured.capabilities;
    let mut meta = Metadata::default();
    meta.insert("counts_per_rev", &shaft.counts_per_rev.to_string())?;
    if let Some(ratio) = shaft.gear_ratio {
        meta.insert("gear_ratio", &ratio.to_string())?;
    }
    match shaft.encoder {
        Some(EncoderShaft::Motor) => meta.insert("encoder_shaft", "motor")?,
        Some(EncoderShaft::Output) => meta.insert("encoder_shaft", "output")?,
        None => {}
    }
    meta.insert("programme", &programme.name)?;
    meta.insert("drive", captured.setup.drive.name())?;
    meta.insert("supply", if capabilities.measures_supply { "measured" } else { "stated" })?;
    meta.insert("sample_rate_hz", &scaling.rate_hz.to_string())?;
    meta.insert("pwm_hz", &capabilities.pwm_hz.to_string())?;
    meta.insert("ended", &captured.cause.to_string())?;
    if !captured.holes.is_empty() {
        let holes: Vec<_> =
            captured.holes.iter().map(|hole| format!("{}-{}", hole.start, hole.end - 1)).collect();
        meta.insert("missing_samples", &holes.join(" "))?;
    }
    Ok(Record {
        name: programme.name.to_string(),
        time_s: column(&|index, sample| scaling.seconds(index, sample)),
        voltage_v: column(&|_, sample| f64::from(scaling.volts(sample))),
        angle_rad: Some(column(&|_, sample| f64::from(sample.count) * shaft.rad_per_count())),
        current_a: capabilities
            .measures_current
            .then(|| column(&|_, sample| f64::from(sample.current_ma) * 1e-3)),
        supply_v: capabilities
            .measures_supply
            .then(|| column(&|_, sample| f64::from(sample.supply_mv) * 1e-3)),
        meta,
        ..Record::default()
    })
}
