//! What a formula is: its row, where it enters, its program.

use super::super::spec::{DROP, DRY, EXPLICIT, SERIES, Spec, TORQUE};
use crate::simulator::MAX_PARAMETERS;
use crate::step::Laws;

/// Most numbers that a program may put aside.
pub(super) const DEPTH: usize = 12;

/// What a formula may read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Voltage on the winding so far, V.
    Voltage,
    /// Logged voltage, V.
    Command,
    /// Current times winding resistance, V.
    Current,
    /// Speed of the output shaft, rad/s.
    Speed,
    /// Angle of the output shaft, rad.
    Angle,
    /// Speed of the motor's shaft, rad/s.
    MotorSpeed,
    /// Angle of the motor's shaft, rad.
    MotorAngle,
    /// Time since the record began, s.
    Time,
}

/// One step of a program: takes its arguments from the stack and leaves its result there.
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs)] // the names say it
pub enum Operation {
    /// Leaves a number.
    Number(f64),
    /// Leaves a quantity.
    Read(Quantity),
    /// Leaves a parameter, by its place in the row.
    Parameter(usize),
    Add,
    Subtract,
    Multiply,
    Divide,
    Minimum,
    Maximum,
    Negate,
    Absolute,
    /// -1, 0 or 1.
    Sign,
    /// Of an angle in rad.
    Sine,
    /// Of an angle in rad.
    Cosine,
    /// Any function of one number, with the name that C and Python know.
    Function(&'static str, fn(f64) -> f64),
    /// Any function of two.
    FunctionOfTwo(&'static str, fn(f64, f64) -> f64),
}

impl Operation {
    /// Numbers taken from the stack; one is always left there.
    #[must_use]
    pub const fn takes(&self) -> usize {
        match self {
            Self::Number(_) | Self::Read(_) | Self::Parameter(_) => 0,
            Self::Negate | Self::Absolute | Self::Sign | Self::Sine | Self::Cosine | Self::Function(..) => 1,
            _ => 2,
        }
    }
}

/// Where a formula's value goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Entry {
    /// A torque on the output shaft, positive drives forward, V.
    Torque,
    /// How large a dry friction is (below 0 counts as 0), V.
    Friction,
    /// A voltage added to the winding's, V.
    Voltage,
    /// How large a voltage is that is lost against the current's direction (below 0 counts as 0), V.
    Drop,
    /// A resistance in series with the winding, as a share of the winding's (below 0 counts as 0).
    Resistance,
    /// An angle added to the reading, rad of the output shaft.
    Sensor,
}

impl Entry {
    /// What of a step it needs.
    #[must_use]
    pub const fn laws(self) -> Laws {
        match self {
            Self::Voltage | Self::Sensor => EXPLICIT,
            Self::Torque => TORQUE,
            Self::Friction => DRY,
            Self::Drop => DROP,
            Self::Resistance => SERIES,
        }
    }
    /// Whether a formula that enters here may read `quantity`.
    #[must_use]
    pub const fn knows(self, quantity: Quantity) -> bool {
        let of_the_drive = matches!(quantity, Quantity::Voltage | Quantity::Command | Quantity::Time);
        !(matches!(self, Self::Sensor) && of_the_drive)
    }
}

/// Why a program cannot run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unsound {
    /// It puts more numbers aside than there is room for.
    TooDeep,
    /// It takes what is not there, or does not leave exactly one number.
    Unbalanced,
    /// It reads a parameter that the row does not have, or the row has too many.
    Parameters,
    /// It reads what is not known where it enters.
    Unknown,
}

/// A user's effect: its row, where it enters and its program. It lives as long as the process.
#[derive(Debug)]
pub struct Definition {
    spec: Spec,
    entry: Entry,
    program: &'static [Operation],
}

impl Definition {
    /// Checks that the program can run.
    ///
    /// # Errors
    /// What keeps it from running.
    pub fn new(spec: Spec, entry: Entry, program: &'static [Operation]) -> Result<Self, Unsound> {
        let mut height = 0_usize;
        for operation in program {
            match operation {
                Operation::Parameter(k) if *k >= spec.parameters.len() => return Err(Unsound::Parameters),
                Operation::Read(q) if !entry.knows(*q) => return Err(Unsound::Unknown),
                _ => {}
            }
            height = height.checked_sub(operation.takes()).ok_or(Unsound::Unbalanced)? + 1;
            if height > DEPTH {
                return Err(Unsound::TooDeep);
            }
        }
        if spec.parameters.len() > MAX_PARAMETERS {
            return Err(Unsound::Parameters);
        }
        if height == 1 { Ok(Self { spec, entry, program }) } else { Err(Unsound::Unbalanced) }
    }

    /// Its row.
    #[must_use]
    pub const fn spec(&self) -> &Spec {
        &self.spec
    }
    /// Where its value goes.
    #[must_use]
    pub const fn entry(&self) -> Entry {
        self.entry
    }
    /// Its program.
    #[must_use]
    pub const fn program(&self) -> &'static [Operation] {
        self.program
    }
}

/// A [`Definition`] as a kind of effect: itself only, since two people may give one name to different effects.
#[derive(Clone, Copy)]
pub struct UserDefined(pub &'static Definition);

impl core::fmt::Debug for UserDefined {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.0.spec.name)
    }
}

impl PartialEq for UserDefined {
    fn eq(&self, other: &Self) -> bool {
        core::ptr::eq(self.0, other.0)
    }
}
impl Eq for UserDefined {}
impl PartialOrd for UserDefined {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for UserDefined {
    fn cmp(&self, other: &Self) -> core::cmp::Ordering {
        let place = |own: &Self| core::ptr::from_ref(own.0).addr();
        self.0.spec.name.cmp(other.0.spec.name).then_with(|| place(self).cmp(&place(other)))
    }
}
impl core::hash::Hash for UserDefined {
    fn hash<H: core::hash::Hasher>(&self, state: &mut H) {
        self.0.spec.name.hash(state);
    }
}
