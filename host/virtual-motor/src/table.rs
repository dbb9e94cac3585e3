//! One row per effect: its name, parameters, bounds and the range that random draws use.
//!
//! "V" as the unit of a torque means volt-equivalents: the voltage whose stall torque it equals, `torque R / K_t`,
//! referred through the gear to the motor shaft.

use std::f64::consts::PI;

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// The key that users type.
    pub key: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// Value when nothing is said.
    pub default: f64,
    /// Smallest and largest legal value.
    pub bounds: (f64, f64),
    /// Weak-but-visible and strong value; random draws lie between, geometrically when both are positive.
    pub drawn: (f64, f64),
}

/// One effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The effect.
    pub kind: Kind,
    /// The name that users type.
    pub name: &'static str,
    /// The equation that the virtual motor uses.
    pub equation: &'static str,
    /// The parameters; the first one is the size.
    pub parameters: &'static [Parameter],
}

const fn parameter(
    key: &'static str,
    unit: &'static str,
    meaning: &'static str,
    default: f64,
    bounds: (f64, f64),
    drawn: (f64, f64),
) -> Parameter {
    Parameter { key, unit, meaning, default, bounds, drawn }
}

/// An angle at which something periodic starts, drawn from the whole circle.
const fn phase(default: f64) -> Parameter {
    parameter("phase", "rad", "angle offset", default, (-10.0, 10.0), (-PI, PI))
}

/// Share of the inertia that sits behind the gear; the total stays the motor's.
const SHARE: Parameter =
    parameter("share", "1", "load's share of the inertia", 0.45, (0.02, 0.95), (0.25, 0.65));

macro_rules! rows {
    ($($kind:ident $name:literal $equation:literal [$($parameter:expr),+ $(,)?])+) => {
        /// Which physical effect.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[allow(missing_docs, reason = "each is documented by its row")]
        pub enum Kind { $($kind),+ }

        /// Every effect, in the order of [`Kind`].
        pub const ROWS: &[Row] = &[$(Row {
            kind: Kind::$kind, name: $name, equation: $equation, parameters: &[$($parameter),+],
        }),+];
    };
}

rows! {
    Coulomb "coulomb" "T = -level sign(w), sticking at rest" [
        parameter("level", "V", "friction", 0.3, (0.0, 6.0), (0.06, 0.9)),
    ]
    CoulombAsymmetric "coulomb_asymmetric" "T = -level (1 + asymmetry sign(w)) sign(w)" [
        parameter("level", "V", "mean friction", 0.3, (0.0, 6.0), (0.12, 0.8)),
        parameter("asymmetry", "1", "forward excess", 0.4, (-1.0, 1.0), (0.25, 0.7)),
    ]
    Stribeck "stribeck" "T = -(level + excess exp(-|w / speed|^exponent)) sign(w)" [
        parameter("level", "V", "kinetic friction", 0.3, (0.0, 6.0), (0.15, 0.7)),
        parameter("excess", "V", "breakaway minus kinetic friction", 0.25, (0.0, 6.0), (0.12, 0.5)),
        parameter("speed", "1", "share of the no-load speed over which it falls", 0.025, (0.001, 1.0), (0.01, 0.04)),
        parameter("exponent", "1", "sharpness", 1.3, (0.3, 4.0), (1.0, 2.0)),
    ]
    QuadraticDrag "quadratic_drag" "T = -level w |w| / w_0^2, w_0 the no-load speed" [
        parameter("level", "V", "drag at the no-load speed", 0.8, (0.0, 24.0), (0.25, 2.0)),
    ]
    Gravity "gravity" "T = -level sin(output angle + phase)" [
        parameter("level", "V", "unbalance", 0.5, (0.0, 12.0), (0.1, 1.2)), phase(0.0),
    ]
    ConstantLoad "constant_load" "T = -level" [
        parameter("level", "V", "load, positive against forward motion", 0.3, (-12.0, 12.0), (0.08, 0.9)),
    ]
    Cogging "cogging" "T = -level (sin(n a) + harmonic sin(2 n a)), a = motor angle + phase" [
        parameter("level", "V", "amplitude", 0.35, (0.0, 12.0), (0.12, 0.7)),
        parameter("periods", "1/rev", "periods n per motor turn", 6.0, (1.0, 60.0), (3.0, 12.0)),
        phase(0.4),
        parameter("harmonic", "1", "share of the second harmonic", 0.15, (0.0, 1.0), (0.0, 0.25)),
    ]
    Spring "spring" "T = -rate (output angle) / 2 pi" [
        parameter("rate", "V/rev", "torque per output turn", 0.2, (0.0, 24.0), (0.05, 0.8)),
    ]
    LoadFriction "load_friction" "T = -share (sqrt(T_i^2 + t^2) - t) sign(w), T_i = K_t i, t = 2 % of stall" [
        parameter("share", "1", "share of the motor's torque", 0.15, (0.0, 0.9), (0.06, 0.35)),
    ]
    Backlash "backlash" "stiff damped contact at 200 Hz beyond a dead band of the gap" [
        parameter("gap", "deg", "whole gap at the output shaft", 1.5, (0.0, 30.0), (0.4, 4.0)), SHARE,
    ]
    Compliance "compliance" "spring and damper between rotor and load" [
        parameter("frequency", "Hz", "load's frequency with the rotor held; lower is stronger", 12.0, (1.0, 200.0), (30.0, 4.0)),
        SHARE,
        parameter("damping", "1", "damping ratio of the load", 0.06, (0.0, 2.0), (0.03, 0.12)),
    ]
    DeadZone "dead_zone" "v = sign(u) max(|u| - width, 0)" [
        parameter("width", "V", "lost voltage of each sign", 0.4, (0.0, 11.0), (0.08, 1.2)),
    ]
    VoltageDrop "voltage_drop" "v = u - drop i / sqrt(i^2 + i_0^2), i_0 = 3 % of stall" [
        parameter("drop", "V", "brush and switch drop", 0.5, (0.0, 6.0), (0.12, 1.1)),
    ]
    SupplySag "supply_sag" "bus V_b = V_0 - R_s i_bus behind 2 ms, v = u V_b / V_0" [
        parameter("resistance", "1", "source resistance over winding resistance", 0.3, (0.0, 3.0), (0.1, 0.7)),
    ]
    Coast "coast" "bridge off for the rest of each PWM period; current returns through diodes, then floats" [
        parameter("share", "1", "share of the off part that floats (the rest brakes)", 1.0, (0.0, 1.0), (0.4, 1.0)),
        parameter("pwm_hz", "Hz", "PWM frequency", 490.0, (50.0, 10_000.0), (250.0, 1000.0)),
    ]
    Freewheel "freewheel" "in the off part of each PWM period the current goes on through a diode across the winding, then nothing" [
        parameter("pwm_hz", "Hz", "PWM frequency", 490.0, (50.0, 10_000.0), (4000.0, 250.0)),
    ]
    WindingHeating "winding_heating" "R = R_0 (1 + h), h' = rate (i / i_stall)^2 (1 + h) - (h - g) / time, g the housing" [
        parameter("rate", "1/s", "rise of the resistance per second at stall", 0.1, (0.0, 2.0), (0.03, 0.3)),
        parameter("time", "s", "winding to housing", 30.0, (0.1, 1000.0), (15.0, 60.0)),
    ]
    Saturation "saturation" "K_t and K_e times tanh(x) / x, x = i / i_s" [
        parameter("loss", "1", "share of the torque lost at stall", 0.25, (0.0, 0.9), (0.1, 0.5)),
    ]
    Delay "delay" "u(t) = command(t - time)" [
        parameter("time", "ms", "from the logged command to the winding", 6.0, (0.0, 500.0), (1.5, 25.0)),
    ]
    Eccentricity "eccentricity" "reading = a + atan2(e sin(a + phase), 1 - e cos(a + phase)), a: encoder shaft" [
        parameter("counts", "counts", "amplitude of the reading error", 3.0, (0.0, 1000.0), (1.0, 6.0)), phase(0.8),
    ]
    LostCounts "lost_counts" "each edge is lost with a chance that rises to share above a speed" [
        parameter("share", "%", "edges lost at speed", 1.5, (0.0, 90.0), (0.4, 5.0)),
        parameter("threshold", "1", "share of the no-load speed where it begins", 0.3, (0.0, 2.0), (0.2, 0.42)),
    ]
    SensorLag "sensor_lag" "first-order filter of the reading, or a reading that is held" [
        parameter("time", "ms", "time constant, or how long a reading is held", 6.0, (0.0, 1000.0), (2.0, 25.0)),
        parameter("held", "0/1", "1: stale readings instead of a filter", 0.0, (0.0, 1.0), (0.0, 1.0)),
    ]
}

impl Kind {
    /// The effect's row.
    pub fn row(self) -> &'static Row {
        &ROWS[self as usize]
    }

    /// Every effect.
    pub fn all() -> impl Iterator<Item = Self> {
        ROWS.iter().map(|row| row.kind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_in_the_order_of_their_kinds_with_defaults_and_draws_in_bounds() {
        for (index, row) in ROWS.iter().enumerate() {
            assert_eq!(row.kind as usize, index);
            for parameter in row.parameters {
                let (low, high) = parameter.bounds;
                for value in [parameter.default, parameter.drawn.0, parameter.drawn.1] {
                    assert!((low..=high).contains(&value), "{} {}", row.name, parameter.key);
                }
            }
        }
    }

    #[test]
    fn names_are_those_of_the_contract() {
        let contract = "coulomb coulomb_asymmetric stribeck quadratic_drag gravity constant_load cogging spring \
            load_friction backlash compliance dead_zone voltage_drop supply_sag coast winding_heating saturation \
            delay eccentricity lost_counts sensor_lag";
        // More may be added.
        let contract: Vec<_> = contract.split_whitespace().collect();
        let names: Vec<_> = ROWS.iter().map(|row| row.name).filter(|name| contract.contains(name)).collect();
        assert_eq!(names, contract);
    }
}
