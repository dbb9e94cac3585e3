//! The programmes that come with the tool.

use super::{Programme, Segment, Shape};

/// The voltage that the amplitudes of the default protocol are fractions of, in volts.
pub const NOMINAL_V: f32 = 12.0;

/// Programmes to fit on, and one to keep out of every fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Protocol {
    /// Fitted on.
    pub training: [Programme; 5],
    /// Never fitted on: judges the fit.
    pub held_out: Programme,
}

impl Protocol {
    /// How long all six programmes take, in seconds.
    pub fn seconds(&self) -> f32 {
        self.training.iter().chain([&self.held_out]).map(Programme::seconds).sum()
    }
}

impl Programme {
    /// The default protocol, six programmes of 8 s, for a supply of `volts`: each part shows effects that
    /// the others hide. The amplitudes below are those at 12 V; other supplies scale them.
    ///
    /// | programme | shows |
    /// |---|---|
    /// | triangle, 1 V then 2 V | friction, Stribeck, dead zone, cogging |
    /// | pulse and coast, 10 V | drag, delay, driver's off part, backlash |
    /// | multisine, 8 V | the linear part, compliance, sensor lag |
    /// | PRBS, 9 V | delay, compliance, saturation |
    /// | staircase, 10 V | drag, heating, supply sag, eccentricity |
    /// | held out: multisine, 6 V | |
    pub fn default_protocol(volts: f32) -> Protocol {
        const SECONDS: f32 = 8.0;
        let share = volts / NOMINAL_V;
        let multisine = |nominal_v: f32, seed| Shape::Multisine {
            amplitude_v: nominal_v * share,
            low_hz: 0.1,
            high_hz: 8.0,
            tones: 14,
            seed,
        };
        let triangle = |nominal_v: f32| Segment {
            shape: Shape::Triangle { amplitude_v: nominal_v * share, period_s: SECONDS / 2.0 },
            seconds: SECONDS / 2.0,
        };
        let mut triangles = Self::empty("triangle");
        triangles.segments.extend([triangle(1.0), triangle(2.0)]);
        Protocol {
            training: [
                triangles,
                Self::single("pulse-and-coast", Shape::PulseAndCoast { amplitude_v: 10.0 * share }, SECONDS),
                Self::single("multisine", multisine(8.0, 1), SECONDS),
                Self::single(
                    "prbs",
                    Shape::Prbs { amplitude_v: 9.0 * share, chip_s: 0.06, seed: 1 },
                    SECONDS,
                ),
                Self::single(
                    "staircase",
                    Shape::Staircase { amplitude_v: 10.0 * share, hold_s: 0.6, seed: 1 },
                    SECONDS,
                ),
            ],
            held_out: Self::single("multisine-2", multisine(6.0, 2), SECONDS),
        }
    }

    /// The paper's excitation: `amplitude * sin(0.5 pi t)` for three periods, 12 s
    /// (Soleimani Amiri, Ibrahim and Ramli 2020; their amplitudes are 3, 5 and 7 V).
    pub fn paper(amplitude_v: f32) -> Self {
        Self::single("paper-sine", Shape::Sine { amplitude_v, frequency_hz: 0.25, offset_v: 0.0 }, 12.0)
    }
}
