//! Records: a voltage sequence played to the motor, and what a log would say about it.

use crate::noise::{Coloured, between, gaussian};
use crate::virtual_motor::{Bridge, VirtualMotor};
use rand::RngExt;

/// How a record is made and how its log is spoilt. `Run::at(1000.0)` spoils nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Samples per second.
    pub rate_hz: f64,
    /// Deviation of a torque disturbance, as a share of the stall torque at the nominal voltage.
    pub disturbance: f64,
    /// Correlation time of the disturbance, s.
    pub disturbance_s: f64,
    /// Deviation of the noise on the logged voltage, V.
    pub voltage_noise_v: f64,
    /// The logged voltage is this many samples late (early if negative).
    pub voltage_shift: i32,
    /// Deviation of the noise on the logged current, as a share of the stall current.
    pub current_noise: f64,
    /// Voltage applied for half a second before the record begins, so that it begins in motion, V.
    pub start_v: f64,
    /// The sampling instants, and with them the changes of the voltage, jitter by this share of a period; the time
    /// stamps are right.
    pub jitter: f64,
    /// Share of the rows that are missing.
    pub missing: f64,
    /// The motor is as warm as the record before has left it, after this pause in seconds; `None`: it is cold.
    pub pause_s: Option<f64>,
}

impl Run {
    /// A faultless record at this rate, Hz.
    pub fn at(rate_hz: f64) -> Self {
        Self {
            rate_hz,
            disturbance: 0.0,
            disturbance_s: 0.05,
            voltage_noise_v: 0.0,
            voltage_shift: 0,
            current_noise: 0.005,
            start_v: 0.0,
            jitter: 0.0,
            missing: 0.0,
            pause_s: None,
        }
    }
}

/// What was recorded; all columns have the same length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Recording {
    /// Sampling instants, s.
    pub time_s: Vec<f64>,
    /// The voltage that the log says is applied from this instant to the next, V.
    pub voltage_v: Vec<f64>,
    /// The encoder's reading, rad of the output shaft.
    pub angle_rad: Vec<f64>,
    /// The encoder's counter.
    pub counts: Vec<i64>,
    /// Noisy current, A.
    pub current_a: Vec<f64>,
    /// Voltage behind the bridge, V.
    pub supply_v: Vec<f64>,
    /// Where the output shaft really stood, rad.
    pub true_angle_rad: Vec<f64>,
    /// How fast it really turned, rad/s.
    pub true_speed_rad_s: Vec<f64>,
}

/// How often the disturbance changes, s.
const DISTURBANCE_STEP_S: f64 = 0.001;
/// How long a record that begins in motion is prepared, s.
const RUN_UP_S: f64 = 0.5;

impl VirtualMotor {
    /// Plays `volts`, one per sample, from rest (or from the run-up) and records what a log would hold.
    pub fn record(&mut self, volts: &[f64], run: &Run) -> Recording {
        match run.pause_s {
            Some(seconds) => self.cool(seconds),
            None => self.go_cold(),
        }
        self.settle();
        let stall_nm = self.motor().torque_of_volts(self.motor().nominal_v);
        let mut disturbance = Coloured::new(run.disturbance * stall_nm, run.disturbance_s, &mut self.rng);
        if run.start_v != 0.0 {
            self.advance(RUN_UP_S, Bridge::Volts(run.start_v));
        }
        let period = 1.0 / run.rate_hz;
        let mut recording = Recording::default();
        let mut now = 0.0;
        for (k, &applied) in volts.iter().enumerate() {
            if k == 0 || run.missing == 0.0 || self.rng.random::<f64>() >= run.missing {
                let source = k as i64 - i64::from(run.voltage_shift);
                let logged = volts[source.clamp(0, volts.len() as i64 - 1) as usize];
                self.write_row(&mut recording, now, logged, run);
            }
            let jitter = if run.jitter == 0.0 { 0.0 } else { between(&mut self.rng, -0.5, 0.5) * run.jitter };
            let next = (k as f64 + 1.0 + jitter.clamp(-0.45, 0.45)) * period;
            let parts = ((next - now) / DISTURBANCE_STEP_S - 1e-6).ceil().max(1.0);
            for _ in 0..parts as u64 {
                if run.disturbance > 0.0 {
                    let torque = disturbance.advance((next - now) / parts, &mut self.rng);
                    self.disturb(torque);
                }
                self.advance((next - now) / parts, Bridge::Volts(applied));
            }
            now = next;
        }
        recording
    }

    fn write_row(&mut self, recording: &mut Recording, now: f64, logged: f64, run: &Run) {
        let noise =
            |deviation: f64, rng: &mut _| if deviation == 0.0 { 0.0 } else { deviation * gaussian(rng) };
        let current_noise = run.current_noise * self.motor().stall_current();
        recording.time_s.push(now);
        recording.voltage_v.push(logged + noise(run.voltage_noise_v, &mut self.rng));
        recording.angle_rad.push(self.angle_rad());
        recording.counts.push(self.counts());
        recording.current_a.push(self.current_a() + noise(current_noise, &mut self.rng));
        recording.supply_v.push(self.supply_v());
        recording.true_angle_rad.push(self.true_angle_rad());
        recording.true_speed_rad_s.push(self.true_speed_rad_s());
    }
}
