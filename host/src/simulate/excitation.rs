//! Which programmes a simulation plays, and what each is for.

use clap::ValueEnum;
use motorlens_shared::excitation::{Programme, Segment, Shape};

/// What the motor is asked to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Excitation {
    /// The default protocol: five programmes and one held out, each of 8 s, and one repeat
    #[default]
    Default,
    /// The paper's sines of 0.25 Hz: 3 and 7 V, 5 V held out
    Paper,
    /// Sines of 1 Hz
    Sine,
    /// Sums of 14 tones from 0.1 to 8 Hz
    Multisine,
    /// Sweeps from 0.1 to 8 Hz
    Chirp,
    /// Random levels, each held 0.6 s
    Staircase,
    /// Slow ramps up and down
    Triangle,
    /// Random reversals every 60 ms or more
    Prbs,
    /// Pulses with rolling out between them
    Pulse,
}

/// What a log is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// To fit on.
    Training,
    /// The same programme as the training log of its name once more: tells the noise floor.
    Repeat,
    /// To judge by.
    HeldOut,
}

/// A programme and what its log is for.
#[derive(Debug, Clone, PartialEq)]
pub struct Play {
    /// What the log is for.
    pub role: Role,
    /// What is played.
    pub programme: Programme,
}

impl Play {
    /// The name of the log, without ending.
    pub fn log_name(&self) -> String {
        match self.role {
            Role::Training => self.programme.name.to_string(),
            Role::Repeat => format!("{}-repeat", self.programme.name),
            Role::HeldOut => format!("holdout-{}", self.programme.name),
        }
    }
}

/// The programmes of an excitation, training first. `amplitude_v` is the largest of a single shape; `seconds` replaces
/// every length; `seed` picks phases and orders.
pub fn plays(
    excitation: Excitation,
    amplitude_v: f32,
    supply_v: f32,
    seconds: Option<f32>,
    seed: u32,
) -> Vec<Play> {
    let (training, repeated, held_out) = match excitation {
        Excitation::Default => {
            let protocol = Programme::default_protocol(supply_v);
            (protocol.training.to_vec(), 2, protocol.held_out)
        }
        Excitation::Paper => (vec![paper(3.0), paper(7.0)], 1, paper(5.0)),
        single => {
            let part = |share: f32, seed| one(single, share * amplitude_v, seconds.unwrap_or(8.0), seed);
            let other = seed.wrapping_add(1);
            (vec![part(0.4, seed), part(1.0, seed)], 1, part(0.7, other))
        }
    };
    let mut plays: Vec<Play> = Vec::new();
    let mut play = |role, programme: &Programme| {
        let programme = seconds.map_or_else(|| programme.clone(), |seconds| stretched(programme, seconds));
        plays.push(Play { role, programme });
    };
    for programme in &training {
        play(Role::Training, programme);
    }
    play(Role::Repeat, &training[repeated]);
    play(Role::HeldOut, &held_out);
    plays
}

fn paper(amplitude_v: f32) -> Programme {
    let shape = Programme::paper(amplitude_v);
    named(amplitude_v, "sine", shape.segments[0].shape, shape.seconds())
}

fn named(amplitude_v: f32, kind: &str, shape: Shape, seconds: f32) -> Programme {
    Programme::single(&format!("{kind}-{:.3}v", amplitude_v).replace(".000v", "v"), shape, seconds)
}

fn one(excitation: Excitation, amplitude_v: f32, seconds: f32, seed: u32) -> Programme {
    let (low_hz, high_hz) = (0.1, 8.0);
    let shape = match excitation {
        Excitation::Multisine | Excitation::Default => {
            Shape::Multisine { amplitude_v, low_hz, high_hz, tones: 14, seed }
        }
        Excitation::Sine | Excitation::Paper => Shape::Sine { amplitude_v, frequency_hz: 1.0, offset_v: 0.0 },
        Excitation::Chirp => Shape::Chirp { amplitude_v, low_hz, high_hz },
        Excitation::Staircase => Shape::Staircase { amplitude_v, hold_s: 0.6, seed },
        Excitation::Triangle => Shape::Triangle { amplitude_v, period_s: seconds / 2.0 },
        Excitation::Prbs => Shape::Prbs { amplitude_v, chip_s: 0.06, seed },
        Excitation::Pulse => Shape::PulseAndCoast { amplitude_v },
    };
    named(amplitude_v, shape.name(), shape, seconds)
}

/// The programme over another length: the segments keep their shares, triangles their number of periods.
fn stretched(programme: &Programme, seconds: f32) -> Programme {
    let factor = seconds / programme.seconds();
    let mut stretched = programme.clone();
    for Segment { shape, seconds } in &mut stretched.segments {
        *seconds *= factor;
        if let Shape::Triangle { period_s, .. } = shape {
            *period_s *= factor;
        }
    }
    stretched
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_excitation_is_playable_has_one_repeat_and_one_held_out_programme_and_distinct_names() {
        for excitation in Excitation::value_variants() {
            for seconds in [None, Some(3.0)] {
                let plays = plays(*excitation, 9.0, 12.0, seconds, 1);
                let count = |role| plays.iter().filter(|play| play.role == role).count();
                assert_eq!((count(Role::Repeat), count(Role::HeldOut)), (1, 1));
                let mut names: Vec<_> = plays.iter().map(Play::log_name).collect();
                names.sort();
                names.dedup();
                assert_eq!(names.len(), plays.len(), "{names:?}");
                for play in &plays {
                    play.programme.validate(12.0).unwrap();
                    assert!(
                        (play.programme.seconds() - seconds.unwrap_or(play.programme.seconds())).abs() < 1e-4
                    );
                }
            }
        }
    }

    #[test]
    fn the_repeat_is_the_programme_of_a_training_log() {
        let plays = plays(Excitation::Default, 9.0, 12.0, None, 1);
        let repeat = plays.iter().find(|play| play.role == Role::Repeat).unwrap();
        assert_eq!(repeat.log_name(), "multisine-repeat");
        assert!(plays.iter().any(|play| play.role == Role::Training && play.programme == repeat.programme));
    }
}
