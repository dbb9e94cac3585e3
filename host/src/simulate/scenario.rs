//! A virtual motor and how it is recorded, as records in memory.

use motorlens_shared::excitation::Player;
use motorlens_virtual_motor::{Effect, EncoderShaft, Motor, Recording, Run, VirtualMotor};

use super::custom::Custom;

use super::args::unplayable;
use super::excitation::{Play, Role};
use crate::error::Result;
use crate::log::Record;

/// A motor with its effects, and how logs of it are made.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// The motor.
    pub motor: Motor,
    /// What the base model does not know.
    pub effects: Vec<Effect>,
    /// What a user wrote as formulas.
    pub formulas: Vec<Custom>,
    /// How it is recorded; its rate is that of `rate_hz`.
    pub run: Run,
    /// Samples per second.
    pub rate_hz: u32,
    /// Picks all noise.
    pub seed: u64,
    /// Whether the logs have the current.
    pub current: bool,
    /// Whether the logs have the supply voltage.
    pub supply: bool,
}

impl Scenario {
    /// A motor recorded at 1 kHz without disturbance, noise or faults.
    pub fn new(motor: Motor, effects: Vec<Effect>, seed: u64) -> Self {
        Self {
            motor,
            effects,
            formulas: Vec::new(),
            run: Run::at(1000.0),
            rate_hz: 1000,
            seed,
            current: false,
            supply: false,
        }
    }

    /// Plays the programmes one after the other on one motor; a record each.
    ///
    /// # Errors
    /// Wrong usage where a programme cannot be played at this rate.
    pub fn records(&self, plays: &[Play]) -> Result<Vec<Record>> {
        let mut plant = VirtualMotor::new(&self.motor, &self.effects, self.seed)
            .with_laws(self.formulas.iter().map(Custom::law).collect());
        let run = Run { rate_hz: f64::from(self.rate_hz), ..self.run.clone() };
        plays
            .iter()
            .map(|play| {
                let player =
                    Player::new(&play.programme, self.rate_hz).map_err(|error| unplayable(play, &error))?;
                // To the microvolt, which is what a log can hold briefly and f32 can tell apart.
                let volts: Vec<f64> = player.map(|v| (f64::from(v) * 1e6).round() / 1e6).collect();
                Ok(self.record(play, plant.record(&volts, &run)))
            })
            .collect()
    }

    /// All effects with their sizes, as they could be typed.
    pub fn effect_texts(&self) -> Vec<String> {
        let library = self.effects.iter().map(ToString::to_string);
        library.chain(self.formulas.iter().map(ToString::to_string)).collect()
    }

    fn record(&self, play: &Play, recording: Recording) -> Record {
        let mut record = Record {
            name: play.log_name(),
            time_s: recording.time_s.iter().map(|t| (t * 1e9).round() / 1e9).collect(),
            voltage_v: recording.voltage_v,
            angle_rad: Some(recording.angle_rad),
            current_a: self.current.then_some(recording.current_a),
            supply_v: self.supply.then_some(recording.supply_v),
            ..Record::default()
        };
        let shaft = match self.motor.encoder_shaft {
            EncoderShaft::Motor => "motor",
            EncoderShaft::Output => "output",
        };
        let mut facts = vec![
            ("programme", play.programme.name.to_string()),
            ("gear_ratio", self.motor.gear_ratio.to_string()),
            ("counts_per_rev", self.motor.counts_per_output_turn().to_string()),
            ("encoder_shaft", shaft.to_owned()),
            ("source", "motorlens simulate".to_owned()),
        ];
        if play.role == Role::Repeat {
            facts.push(("repeat_of", play.programme.name.to_string()));
        }
        for (key, value) in facts {
            // The keys that are checked hold positive numbers and one of two words.
            record.meta.insert(key, &value).expect("metadata of a simulation is legal");
        }
        record
    }
}
