//! The motor itself, without any further effect.

use crate::{Rng, between, geometric, pick};

/// SI units; the gear's losses and the load's inertia are given at the motor shaft.
#[derive(Debug, Clone, PartialEq)]
pub struct Motor {
    /// Voltage of the supply, V.
    pub supply_v: f64,
    /// Winding resistance, ohm.
    pub resistance: f64,
    /// Winding inductance, H.
    pub inductance: f64,
    /// Torque per current and back-EMF per speed, N m/A.
    pub constant: f64,
    /// All inertia at the motor shaft, kg m^2.
    pub inertia: f64,
    /// Share of it behind the gear.
    pub load_share: f64,
    /// Viscous damping at the motor shaft, N m s/rad.
    pub damping: f64,
    /// Motor turns per output turn.
    pub gear: f64,
    /// Counts per turn of the output shaft.
    pub counts: f64,
    /// Whether the encoder sits on the output shaft.
    pub encoder_on_output: bool,
}

impl Motor {
    /// A gear motor as people buy them, on one of the supplies that they use.
    pub fn draw(rng: &mut Rng, supplies: &[f64]) -> Self {
        let supply_v = pick(rng, supplies);
        let resistance = geometric(rng, 0.8, 12.0);
        let gear = pick(rng, &[4.4, 6.25, 10.0, 20.4, 29.86, 34.0, 46.85, 74.83, 99.09, 150.0]);
        let no_load = geometric(rng, 350.0, 1100.0);
        let viscous = between(rng, 0.02, 0.14);
        let constant = supply_v * (1.0 - viscous) / no_load;
        let brake = constant * constant / (1.0 - viscous) / resistance;
        let mechanical_s = geometric(rng, 0.015, 0.16);
        let (encoder_on_output, counts) = if between(rng, 0.0, 1.0) < 0.25 {
            (true, pick(rng, &[2048.0, 4096.0, 1440.0, 8192.0]))
        } else {
            let lines: f64 = pick(rng, &[12.0, 28.0, 44.0, 48.0, 64.0, 512.0, 2000.0]);
            (false, gear * if lines * gear < 400.0 { 400.0 } else { lines })
        };
        Self {
            supply_v,
            resistance,
            inductance: resistance * geometric(rng, 0.0002, 0.0025),
            constant,
            inertia: mechanical_s * brake,
            load_share: between(rng, 0.1, 0.6),
            damping: viscous * brake,
            gear,
            counts,
            encoder_on_output,
        }
    }

    /// Torque at the motor shaft that `volts` make when it is held, N m.
    pub fn torque(&self, volts: f64) -> f64 {
        volts * self.constant / self.resistance
    }

    /// Output speed at the full supply, rad/s.
    pub fn no_load_speed(&self) -> f64 {
        self.motor_speed() / self.gear
    }

    /// Motor speed at the full supply, rad/s.
    pub fn motor_speed(&self) -> f64 {
        self.supply_v * self.constant / (self.constant * self.constant + self.resistance * self.damping)
    }

    /// Current at the full supply with the shaft held, A.
    pub fn stall_current(&self) -> f64 {
        self.supply_v / self.resistance
    }

    /// Time constant of the speed, s.
    pub fn mechanical_s(&self) -> f64 {
        self.resistance * self.inertia / (self.constant * self.constant + self.resistance * self.damping)
    }

    /// One count at the output shaft, rad.
    pub fn count_rad(&self) -> f64 {
        std::f64::consts::TAU / self.counts
    }
}
