//! The registry row of an effect.

use super::Rig;
use crate::step::Laws;

/// Where an effect enters the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Port {
    /// Changes the voltage on the winding.
    Voltage,
    /// Adds a torque.
    Torque,
    /// Changes what passes from rotor to load.
    Transmission,
    /// Changes what the encoder shows.
    Sensor,
}

impl Port {
    /// The word that users see.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Voltage => "voltage",
            Self::Torque => "torque",
            Self::Transmission => "transmission",
            Self::Sensor => "sensor",
        }
    }
}

/// What one unit of a bound or probe stands for, so that one row serves every motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// A plain number.
    One,
    /// The parameter's own unit, whatever the rig.
    Own,
    /// A twelfth of the nominal voltage, V.
    Volt,
    /// The no-load speed at nominal voltage, rad/s.
    Speed,
    /// `Volt` at the no-load speed, growing with its square, V per (rad/s)^2.
    VoltPerSpeedSquared,
    /// `Volt` per revolution of the output shaft, V/rad.
    VoltPerTurn,
    /// A millisecond, s.
    Millisecond,
    /// A degree, rad.
    Degree,
    /// A count of the encoder, rad of the output shaft.
    Count,
    /// A radian of the shaft that the encoder is on, rad of the output shaft.
    EncoderRadian,
}

impl Scale {
    /// One unit on `rig`, in the unit that the parameter is stored in.
    #[must_use]
    pub fn unit(self, rig: &Rig) -> f64 {
        let volt = rig.nominal_v / 12.0;
        match self {
            Self::One | Self::Own => 1.0,
            Self::Volt => volt,
            Self::Speed => rig.reference_speed,
            Self::VoltPerSpeedSquared => volt / (rig.reference_speed * rig.reference_speed),
            Self::VoltPerTurn => volt / core::f64::consts::TAU,
            Self::Millisecond => 1e-3,
            Self::Degree => core::f64::consts::PI / 180.0,
            Self::Count => rig.count_rad,
            Self::EncoderRadian if rig.encoder_on_motor => 1.0 / rig.gear_ratio,
            Self::EncoderRadian => 1.0,
        }
    }
}

/// A parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name in the model file.
    pub name: &'static str,
    /// Unit of the stored value.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// Unit of `low`, `high`, `typical` and the probes.
    pub scale: Scale,
    /// Lowest value.
    pub low: f64,
    /// Highest value.
    pub high: f64,
    /// The largest size there is of either sign, in a scale of its own: where `low` and `high` go on beyond it on a rig, they end there.
    pub most: Option<(f64, Scale)>,
    /// A size one meets; the step of searches.
    pub typical: f64,
    /// The effect vanishes when this parameter is zero.
    pub strength: bool,
    /// Found by a search; else read off the data and kept.
    pub searched: bool,
}

impl Parameter {
    /// `size` of its scale on `rig`, in the unit that it is stored in.
    #[must_use]
    pub fn plain(&self, size: f64, rig: &Rig) -> f64 {
        size * self.scale.unit(rig)
    }

    /// Lowest and highest value on `rig`, in units of its scale there.
    #[must_use]
    pub fn bounds(&self, rig: &Rig) -> [f64; 2] {
        let most =
            self.most.map_or(f64::INFINITY, |(size, scale)| size * scale.unit(rig) / self.scale.unit(rig));
        [self.low.max(-most), self.high.min(most)]
    }
}

/// Where a search for an effect begins, beside the row's probes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Search {
    /// Nowhere else.
    Probes,
    /// At the orders to which the records answer: a torque that is periodic in the motor's angle, with the sine, the cosine, those of the
    /// second harmonic and the order as parameters.
    Orders,
    /// At the time for which the records show that a reading is held, in this parameter.
    Hold(&'static str),
    /// Only in records in which the shaft comes back to where it was: a torque that depends on where the shaft is, and does not repeat with
    /// its turns, is on a way that is gone once and one way the same as one that changes with time.
    Retraced,
    /// Beside a base with this viscous share, too: where the winding does not brake the motor, friction alone does, and next to a base
    /// without friction the effect looks wrong.
    Damped(f64),
}

/// A row of the registry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spec {
    /// Name that users type.
    pub name: &'static str,
    /// Where it enters.
    pub port: Port,
    /// A line of plain words.
    pub title: &'static str,
    /// The equation, in the symbols of [`crate::base`].
    pub equation: &'static str,
    /// Where the equation is from.
    pub source: &'static str,
    /// What it looks like in data.
    pub signature: &'static str,
    /// Parameters, in order.
    pub parameters: &'static [Parameter],
    /// Finite trial values for the diagnosis, in each parameter's scale. The more shapes are tried, the more the best has to gain.
    pub probes: &'static [&'static [f64]],
    /// Where else a search for it begins.
    pub search: Search,
    /// What of a step it needs.
    pub laws: Laws,
    /// Has something to remember from step to step.
    pub remembers: bool,
    /// Repeats with the turns of a shaft: its size rests on the unit that the angle is read in.
    pub periodic: bool,
    /// Depends on the duty, which is the voltage over that of the supply: its size rests on the supply that the rig has.
    pub by_duty: bool,
    /// Simpler effects of one parameter that this one contains, each with the parameter here that is its own.
    pub contains: &'static [(&'static str, &'static str)],
}

impl Spec {
    /// Parameters of the typical size and shape on `rig`, in the units that they are stored in.
    pub fn typical<'a>(&'a self, rig: &'a Rig) -> impl Iterator<Item = f64> + 'a {
        self.parameters.iter().map(|p| p.plain(p.typical, rig))
    }
    /// The probes in the units that the parameters are stored in on `rig`.
    pub fn probes_on<'a>(
        &'a self,
        rig: &'a Rig,
    ) -> impl Iterator<Item = impl Iterator<Item = f64> + 'a> + 'a {
        self.probes.iter().map(|probe| probe.iter().zip(self.parameters).map(|(size, p)| p.plain(*size, rig)))
    }
    /// Whether it is the effect `name` or contains it.
    #[must_use]
    pub fn holds(&self, name: &str) -> bool {
        self.name == name || self.contains.iter().any(|(simpler, _)| *simpler == name)
    }
    /// Whether the effects that it contains are all there is to it: it is their sum.
    #[must_use]
    pub const fn is_sum(&self) -> bool {
        self.contains.len() == self.parameters.len()
    }
    /// Place of the parameter `name`.
    #[must_use]
    pub fn place(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }
    /// Whether all that it is is late: its only size is a time, as a delay's or a filter's.
    #[must_use]
    pub const fn is_late(&self) -> bool {
        let (mut times, mut k) = (0, 0);
        while k < self.parameters.len() {
            let p = &self.parameters[k];
            if p.strength && !matches!(p.unit.as_bytes(), b"s") {
                return false;
            }
            times += p.strength as usize;
            k += 1;
        }
        times > 0
    }
    /// Stands between rotor and load.
    #[inline(always)]
    #[must_use]
    pub const fn transmits(&self) -> bool {
        matches!(self.port, Port::Transmission)
    }
    /// Which parameter is the load's share of the inertia; none unless this is a transmission.
    #[must_use]
    pub fn load_share(&self) -> Option<usize> {
        self.place("load_share")
    }
    /// Which parameter is the load's share of the viscous friction, where a transmission has one.
    #[must_use]
    pub fn load_damping(&self) -> Option<usize> {
        self.place("load_damping")
    }
}

/// A parameter whose zero switches the effect off.
pub(super) const fn strength(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    scale: Scale,
    [low, typical, high]: [f64; 3],
) -> Parameter {
    Parameter { name, unit, meaning, scale, low, high, most: None, typical, strength: true, searched: true }
}

/// The same parameter of which there is no larger size than `most` of `scale`, whatever its own scale comes to.
pub(super) const fn at_most(most: f64, scale: Scale, parameter: Parameter) -> Parameter {
    Parameter { most: Some((most, scale)), ..parameter }
}

/// A parameter that shapes an effect.
pub(super) const fn shape(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    scale: Scale,
    [low, typical, high]: [f64; 3],
) -> Parameter {
    Parameter { name, unit, meaning, scale, low, high, most: None, typical, strength: false, searched: true }
}

/// A parameter that no search can find downhill: the data show it, or it is zero.
pub(super) const fn shown(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    scale: Scale,
    range: [f64; 3],
) -> Parameter {
    Parameter { searched: false, ..shape(name, unit, meaning, scale, range) }
}

const NONE: Laws = Laws {
    torque: false,
    drop: false,
    brush: false,
    series: false,
    dry: false,
    meshing: false,
    parts: 1,
    turning: false,
};
/// Acts through voltage or sensor alone.
pub(super) const EXPLICIT: Laws = NONE;
/// Acts between rotor and load, in so many parts of a step.
pub(super) const fn between_masses(parts: usize) -> Laws {
    Laws { parts, ..NONE }
}
/// Acts through a torque.
pub(super) const TORQUE: Laws = Laws { torque: true, ..NONE };
/// Acts through a drop of fixed size against the current.
pub(super) const DROP: Laws = Laws { drop: true, ..NONE };
/// Acts through a drop that grows with the current.
pub(super) const BRUSH: Laws = Laws { brush: true, ..NONE };
/// Acts through a resistance.
pub(super) const SERIES: Laws = Laws { series: true, ..NONE };
/// Acts through dry friction.
pub(super) const DRY: Laws = Laws { dry: true, turning: true, ..NONE };
/// Acts through dry friction that grows with the motor's torque.
pub(super) const MESHING: Laws = Laws { meshing: true, ..DRY };
