//! Torque that nobody asked for: of several families, because no bench has a textbook's.

use crate::{Rng, between, chance, gaussian, geometric, pick};

/// A family and its times.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Family {
    /// First-order coloured noise.
    Coloured(f64),
    /// A slow and a fast one together.
    TwoTimes(f64, f64),
    /// Jumps between levels.
    Jumps(f64),
    /// A hum whose frequency wanders.
    Hum(f64),
}

/// A disturbance: deviation as a share of the stall torque, and its family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disturbance {
    /// Deviation over stall torque.
    pub share: f64,
    family: Family,
}

impl Disturbance {
    /// None.
    pub const NONE: Self = Self { share: 0.0, family: Family::Coloured(1.0) };

    /// One of 1 to 5 % of stall.
    pub fn draw(rng: &mut Rng) -> Self {
        let family = match pick(rng, &[0, 0, 1, 1, 2, 3]) {
            0 => Family::Coloured(geometric(rng, 0.01, 1.5)),
            1 => Family::TwoTimes(geometric(rng, 0.005, 0.05), geometric(rng, 0.3, 4.0)),
            2 => Family::Jumps(geometric(rng, 0.1, 1.5)),
            _ => Family::Hum(geometric(rng, 1.0, 20.0)),
        };
        Self { share: between(rng, 0.01, 0.05), family }
    }

    /// In words.
    pub fn words(&self) -> String {
        format!("{:.1} % {:?}", 100.0 * self.share, self.family)
    }
}

/// Its course in one record, in deviations of one.
pub struct Course {
    disturbance: Disturbance,
    a: f64,
    b: f64,
    phase: f64,
}

impl Course {
    /// Begins a record.
    pub fn new(disturbance: Disturbance, rng: &mut Rng) -> Self {
        let (a, b) = (gaussian(rng), gaussian(rng));
        Self { disturbance, a, b, phase: between(rng, 0.0, std::f64::consts::TAU) }
    }

    /// Goes on by `dt`; the torque over the stall torque.
    pub fn advance(&mut self, dt: f64, rng: &mut Rng) -> f64 {
        let mut walk = |x: &mut f64, time: f64| {
            let keep = (-dt / time).exp();
            *x = keep * *x + (1.0 - keep * keep).sqrt() * gaussian(rng);
        };
        let unit = match self.disturbance.family {
            _ if self.disturbance.share == 0.0 => 0.0,
            Family::Coloured(time) => {
                walk(&mut self.a, time);
                self.a
            }
            Family::TwoTimes(fast, slow) => {
                walk(&mut self.a, fast);
                walk(&mut self.b, slow);
                0.6 * self.a + 0.8 * self.b
            }
            Family::Jumps(time) => {
                if chance(rng, dt / time) {
                    self.a = gaussian(rng);
                }
                self.a
            }
            Family::Hum(hertz) => {
                walk(&mut self.b, 2.0);
                self.phase += std::f64::consts::TAU * hertz * (1.0 + 0.1 * self.b) * dt;
                std::f64::consts::SQRT_2 * self.phase.sin()
            }
        };
        self.disturbance.share * unit
    }
}
