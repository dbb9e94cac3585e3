//! Physical effects that the base model leaves out: one file each, one registry row each.
//!
//! Every effect enters as one of four things: a voltage, a torque, a change in the transmission or a change in
//! the sensor. So the exact exponential of the base model stays constant over a record. To add one, copy
//! `template.rs`, then add its line to the registry below: names, help, bounds, report legends and
//! the device's capability message all come from that row.

use crate::base::Base;
use crate::scalar::Scalar;
use crate::step::{Drive, State};

pub mod between;
mod decay;
mod formula;
mod pwm;
mod spec;
#[cfg(test)]
pub(crate) mod testing;
pub mod together;
mod wave;
pub use coast::DIODES_V;
pub use formula::{Definition, Entry, Formula, Operation, Quantity, Unsound, UserDefined};
pub use spec::{Parameter, Port, Scale, Search, Spec};

/// The rig a record was made on: known, not fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rig {
    /// Step of the voltage grid, s.
    pub step_s: f64,
    /// Motor revolutions per revolution of the output shaft.
    pub gear_ratio: f64,
    /// The encoder sits on the motor shaft (else on the output shaft).
    pub encoder_on_motor: bool,
    /// Nominal voltage, V.
    pub nominal_v: f64,
    /// Voltage of the supply behind the driver, V.
    pub supply_v: f64,
    /// No-load speed at the nominal voltage, roughly: only a scale, rad/s.
    pub reference_speed: f64,
    /// One count of the encoder at the output shaft, rad.
    pub count_rad: f64,
}

/// The rig and the base model as the effects see them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting<S> {
    /// From one settling of the effects to the next: a cell of the voltage grid or a part of it, s.
    pub step: S,
    /// Step of the voltage grid, s.
    pub cell: S,
    /// Acceleration per volt-equivalent, rad/s^2 per V.
    pub acceleration: S,
    /// Viscous damping rate, 1/s.
    pub damping: S,
    /// Back-EMF constant, V per rad/s.
    pub back_emf: S,
    /// Electrical time constant, s.
    pub tau_e: S,
    /// Motor turns per radian of the output shaft.
    pub motor_turns: S,
    /// Output turns per radian of the output shaft, 1 / 2 pi.
    pub output_turns: S,
    /// 1 / nominal voltage, 1/V.
    pub per_nominal: S,
    /// 1 / supply voltage, 1/V.
    pub per_supply: S,
    /// No-load speed at the nominal voltage, rad/s.
    pub reference_speed: S,
    /// Motor revolutions per revolution of the output shaft.
    pub gear_ratio: S,
    /// The encoder sits on the motor shaft.
    pub encoder_on_motor: bool,
}

impl<S: Scalar> Setting<S> {
    /// Combines the two; every cell of the grid is passed in so many `parts`.
    pub fn new(base: &Base<S>, rig: &Rig, parts: usize) -> Self {
        const PER_TURN: f64 = 1.0 / core::f64::consts::TAU;
        Self {
            step: S::lit(rig.step_s / parts as f64),
            cell: S::lit(rig.step_s),
            acceleration: base.acceleration(),
            damping: base.damping(),
            back_emf: base.back_emf(),
            tau_e: base.tau_e,
            motor_turns: S::lit(rig.gear_ratio * PER_TURN),
            output_turns: S::lit(PER_TURN),
            per_nominal: S::lit(1.0 / rig.nominal_v),
            per_supply: S::lit(1.0 / rig.supply_v),
            reference_speed: S::lit(rig.reference_speed),
            gear_ratio: S::lit(rig.gear_ratio),
            encoder_on_motor: rig.encoder_on_motor,
        }
    }
}

/// The moment at the beginning of a step.
#[derive(Debug, Clone, Copy)]
pub struct Now<'a, S: Scalar> {
    /// Logged voltage of this cell, V; for [`Effect::settle`] what the bridge was told of it ([`Drive::asked`]).
    pub command: S,
    /// State at its beginning.
    pub state: State<S>,
    /// What was held before the start, then the logged voltage of every cell, V.
    pub voltages: &'a [S::Element],
    /// This cell's place in `voltages`: 1 for the first.
    pub index: usize,
}

/// What one effect remembers from step to step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Memory<S> {
    /// Free for the effect; zero at the start.
    pub store: S,
    /// Time since something happened, s; zero at the start, or the age of a reading that is held.
    pub age: S,
    /// Angle at the start of the record, rad.
    pub origin: S,
}

impl<S: Scalar> Memory<S> {
    /// Nothing happened yet.
    pub fn empty(origin: S) -> Self {
        Self { store: S::zero(), age: S::zero(), origin }
    }
}

/// A physical effect with its parameters fixed. Each implements the one or two hooks of its port.
pub trait Effect<S: Scalar> {
    /// Voltage or torque during the coming step.
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, _memory: &Memory<S>, _drive: &mut Drive<S>) {}
    /// Own memory at the start of a record, where the shaft has long been turning as in `state`.
    #[inline(always)]
    fn begin(&self, _state: &State<S>, _memory: &mut Memory<S>) {}
    /// Own memory, after the step from `now` to `after`.
    #[inline(always)]
    fn settle(&self, _now: &Now<S>, _after: &State<S>, _memory: &mut Memory<S>) {}
    /// Where the shaft seems to be to what follows on the way of the reading and has a memory.
    #[inline(always)]
    fn show(&self, _state: &mut State<S>) {}
    /// What passes between rotor and load in `part` seconds.
    #[inline(always)]
    fn couple(&self, _part: S, _state: &mut State<S>) {}
    /// What the sensor makes of the angle, rad of the output shaft.
    #[inline(always)]
    fn read(&self, _state: &State<S>, _memory: &Memory<S>, _reading: &mut S) {}
}

/// An effect of the library whose kind the compiler knows.
pub trait Named<S: Scalar>: Effect<S> {
    /// Its row.
    const SPEC: &'static Spec;
    /// Its place in the registry.
    const INDEX: usize;
    /// Fixes the parameters (in the order of the row).
    fn named(parameters: &[S], setting: &Setting<S>) -> Self;
}

/// Something to do with an effect's own type, chosen when the program runs.
pub trait Visit<S: Scalar> {
    /// What comes of it.
    type Output;
    /// Does it with an effect of the library.
    fn visit<E: Named<S>>(self) -> Self::Output;
    /// Does it with a user's formula, whose type tells nothing.
    fn formula(self) -> Self::Output;
}

/// The registry: one row an effect. The order is the order of application.
macro_rules! registry {
    ($($module:ident $kind:ident),+ $(,)?) => {
        $(mod $module;)+
        $(pub use $module::$kind;)+

        /// A physical effect by name.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Kind {
            $(#[doc = concat!("See [`", stringify!($kind), "`](struct@", stringify!($kind), ").")] $kind,)+
            /// An effect that a user wrote as a formula.
            Formula(UserDefined),
        }

        impl Kind {
            /// Every effect of the library.
            pub const ALL: &[Self] = &[$(Self::$kind),+];
            /// Its row.
            #[must_use]
            pub const fn spec(self) -> &'static Spec {
                match self {
                    $(Self::$kind => &$module::SPEC,)+
                    Self::Formula(UserDefined(definition)) => definition.spec(),
                }
            }
            /// Does `work` with the type of this effect.
            pub fn with<S: Scalar, V: Visit<S>>(self, work: V) -> V::Output {
                match self {
                    $(Self::$kind => work.visit::<$kind<S>>(),)+
                    Self::Formula(_) => work.formula(),
                }
            }
        }

        /// The places of the rows.
        enum Place { $($kind),+ }
        $(impl<S: Scalar> Named<S> for $kind<S> {
            const SPEC: &'static Spec = &$module::SPEC;
            const INDEX: usize = Place::$kind as usize;
            fn named(parameters: &[S], setting: &Setting<S>) -> Self {
                Self::new(parameters, setting)
            }
        })+

        /// An effect at work in a simulation.
        #[derive(Debug, Clone, Copy)]
        #[allow(missing_docs)] // one variant a row
        pub enum Active<S> { $($kind($kind<S>),)+ Formula(Formula<S>) }

        impl<S: Scalar> Active<S> {
            /// Fixes the parameters (in the order of the row).
            pub fn new(kind: Kind, parameters: &[S], setting: &Setting<S>) -> Self {
                match kind {
                    $(Kind::$kind => Self::$kind($kind::new(parameters, setting)),)+
                    Kind::Formula(UserDefined(definition)) => {
                        Self::Formula(Formula::new(definition, parameters, setting))
                    }
                }
            }
        }

        impl<S: Scalar> Effect<S> for Active<S> {
            #[inline(always)]
            fn drive(&self, now: &Now<S>, memory: &Memory<S>, drive: &mut Drive<S>) {
                match self { $(Self::$kind(e) => e.drive(now, memory, drive),)+ Self::Formula(e) => e.drive(now, memory, drive) }
            }
            #[inline(always)]
            fn begin(&self, state: &State<S>, memory: &mut Memory<S>) {
                match self { $(Self::$kind(e) => e.begin(state, memory),)+ Self::Formula(e) => e.begin(state, memory) }
            }
            #[inline(always)]
            fn settle(&self, now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
                match self { $(Self::$kind(e) => e.settle(now, after, memory),)+ Self::Formula(e) => e.settle(now, after, memory) }
            }
            #[inline(always)]
            fn show(&self, state: &mut State<S>) {
                match self { $(Self::$kind(e) => e.show(state),)+ Self::Formula(e) => e.show(state) }
            }
            #[inline(always)]
            fn couple(&self, part: S, state: &mut State<S>) {
                match self { $(Self::$kind(e) => e.couple(part, state),)+ Self::Formula(e) => e.couple(part, state) }
            }
            #[inline(always)]
            fn read(&self, state: &State<S>, memory: &Memory<S>, reading: &mut S) {
                match self { $(Self::$kind(e) => e.read(state, memory, reading),)+ Self::Formula(e) => e.read(state, memory, reading) }
            }
        }
    };
}

registry! {
    delay Delay,
    dead_zone DeadZone,
    coast Coast,
    freewheel Freewheel,
    supply_sag SupplySag,
    winding_heating WindingHeating,
    voltage_drop VoltageDrop,
    coulomb Coulomb,
    coulomb_asymmetric CoulombAsymmetric,
    stribeck Stribeck,
    load_friction LoadFriction,
    quadratic_drag QuadraticDrag,
    gravity Gravity,
    constant_load ConstantLoad,
    cogging Cogging,
    spring Spring,
    saturation Saturation,
    backlash Backlash,
    compliance Compliance,
    eccentricity Eccentricity,
    lost_counts LostCounts,
    sensor_lag SensorLag,
}

impl Kind {
    /// The effect that users call `name`.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|k| k.name() == name)
    }
    /// The name that users type and JSON prints.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.spec().name
    }
    /// Stands between rotor and load.
    #[must_use]
    pub const fn is_transmission(self) -> bool {
        self.spec().transmits()
    }
    /// Place in the registry: the bit of the device's capability message. None for a user's formula.
    #[must_use]
    pub fn index(self) -> Option<usize> {
        Self::ALL.iter().position(|kind| *kind == self)
    }
}

impl core::fmt::Display for Kind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.name())
    }
}

impl serde::Serialize for Kind {
    fn serialize<Z: serde::Serializer>(&self, z: Z) -> Result<Z::Ok, Z::Error> {
        z.serialize_str(self.name())
    }
}

impl<'de> serde::Deserialize<'de> for Kind {
    fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Name;
        impl serde::de::Visitor<'_> for Name {
            type Value = Kind;
            fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str("the name of an effect (motorlens effects lists them)")
            }
            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Kind, E> {
                Kind::by_name(name).ok_or_else(|| E::invalid_value(serde::de::Unexpected::Str(name), &self))
            }
        }
        d.deserialize_str(Name)
    }
}

#[cfg(test)]
mod template;
#[cfg(test)]
mod tests;
