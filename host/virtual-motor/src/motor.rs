//! The linear geared motor: what remains when every effect is switched off.

use crate::noise::{between, geometric, pick};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use std::f64::consts::TAU;

/// The shaft that the encoder disc sits on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EncoderShaft {
    /// Before the gear.
    Motor,
    /// After the gear.
    Output,
}

/// Physical parameters in SI units. Motor-side values are per radian of the motor shaft, load-side values per
/// radian of the output shaft.
///
/// `L di/dt = v - R i - K_e w`, `J dw/dt = K_t i - b w` with `J = J_motor + J_load / N^2`, `b` alike
/// (Franklin, Powell, Emami-Naeini, Feedback Control of Dynamic Systems, section 2.3).
#[derive(Debug, Clone, PartialEq)]
pub struct Motor {
    /// Voltage of the supply, which the driver cannot exceed, V.
    pub nominal_v: f64,
    /// Winding resistance, ohm.
    pub resistance_ohm: f64,
    /// Winding inductance, H.
    pub inductance_h: f64,
    /// Torque per current, N m/A.
    pub torque_constant: f64,
    /// Back-EMF per motor speed, V s/rad.
    pub back_emf_constant: f64,
    /// Inertia of the rotor, kg m^2.
    pub rotor_inertia: f64,
    /// Inertia of the load at the output shaft, kg m^2.
    pub load_inertia: f64,
    /// Viscous damping at the motor shaft, N m s/rad.
    pub rotor_damping: f64,
    /// Viscous damping at the output shaft, N m s/rad.
    pub load_damping: f64,
    /// Motor turns per output turn.
    pub gear_ratio: f64,
    /// Counts per turn of the shaft that the encoder sits on, after x4.
    pub encoder_counts: f64,
    /// That shaft.
    pub encoder_shaft: EncoderShaft,
}

/// A motor as its time constants, from which the physical parameters follow.
struct Character {
    nominal_v: f64,
    resistance_ohm: f64,
    no_load_motor_speed: f64,
    viscous_share: f64,
    mechanical_s: f64,
    electrical_s: f64,
    load_share: f64,
    gear_ratio: f64,
    encoder_counts: f64,
    encoder_shaft: EncoderShaft,
}

impl Character {
    fn motor(&self) -> Motor {
        let back_emf = self.nominal_v * (1.0 - self.viscous_share) / self.no_load_motor_speed;
        // beta = R b / (R b + K_t K_e), tau_m = R J / (R b + K_t K_e)
        let braking = back_emf * back_emf / (1.0 - self.viscous_share);
        let damping = self.viscous_share * braking / self.resistance_ohm;
        let inertia = self.mechanical_s * braking / self.resistance_ohm;
        let at_output = self.gear_ratio * self.gear_ratio;
        Motor {
            nominal_v: self.nominal_v,
            resistance_ohm: self.resistance_ohm,
            inductance_h: self.electrical_s * self.resistance_ohm,
            torque_constant: back_emf,
            back_emf_constant: back_emf,
            rotor_inertia: inertia * (1.0 - self.load_share),
            load_inertia: inertia * self.load_share * at_output,
            rotor_damping: damping * 0.7,
            load_damping: damping * 0.3 * at_output,
            gear_ratio: self.gear_ratio,
            encoder_counts: self.encoder_counts,
            encoder_shaft: self.encoder_shaft,
        }
    }
}

impl Motor {
    /// A planetary geared motor of ratio 104 with an encoder of 5000 counts on the output shaft, like the paper's.
    pub fn paper() -> Self {
        Character {
            nominal_v: 12.0,
            resistance_ohm: 5.3,
            no_load_motor_speed: 720.0,
            viscous_share: 0.06,
            mechanical_s: 0.045,
            electrical_s: 1.0 / 1500.0,
            load_share: 0.25,
            gear_ratio: 104.0,
            encoder_counts: 5000.0,
            encoder_shaft: EncoderShaft::Output,
        }
        .motor()
    }

    /// A hobby gearmotor of ratio 30 with 48 counts on the motor shaft.
    pub fn small() -> Self {
        Character {
            nominal_v: 12.0,
            resistance_ohm: 2.4,
            no_load_motor_speed: 1050.0,
            viscous_share: 0.08,
            mechanical_s: 0.035,
            electrical_s: 0.0006,
            load_share: 0.2,
            gear_ratio: 30.0,
            encoder_counts: 48.0,
            encoder_shaft: EncoderShaft::Motor,
        }
        .motor()
    }

    /// A motor that nobody chose: gear 5 to 104, mechanical time constant 10 to 150 ms, electrical 0.2 to 3 ms,
    /// at least 300 counts per output turn. The same seed gives the same motor.
    pub fn hidden(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x6d6f_746f_7221);
        let gear_ratio = pick(&mut rng, &[5.0, 9.7, 14.0, 19.0, 30.0, 51.0, 64.0, 75.0, 99.5, 104.0]);
        let mechanical_s = geometric(&mut rng, 0.010, 0.150);
        let on_output = between(&mut rng, 0.0, 1.0) < 0.3;
        let (encoder_shaft, encoder_counts) = if on_output {
            (EncoderShaft::Output, pick(&mut rng, &[1440.0, 2000.0, 4096.0, 5000.0, 8192.0]))
        } else {
            let all = [12.0, 28.0, 44.0, 48.0, 64.0, 128.0, 256.0, 400.0, 1024.0, 2048.0, 4096.0];
            let fine_enough: Vec<f64> =
                all.into_iter().filter(|counts| counts * gear_ratio >= 300.0).collect();
            (EncoderShaft::Motor, pick(&mut rng, &fine_enough))
        };
        Character {
            nominal_v: 12.0,
            resistance_ohm: geometric(&mut rng, 1.0, 15.0),
            no_load_motor_speed: geometric(&mut rng, 300.0, 1200.0),
            viscous_share: between(&mut rng, 0.03, 0.15),
            mechanical_s,
            electrical_s: geometric(&mut rng, 0.0002, 0.003_f64.min(mechanical_s / 5.0)),
            load_share: between(&mut rng, 0.05, 0.6),
            gear_ratio,
            encoder_counts,
            encoder_shaft,
        }
        .motor()
    }

    /// Rotor and load together, at the motor shaft, kg m^2.
    pub fn inertia(&self) -> f64 {
        self.rotor_inertia + self.load_inertia / (self.gear_ratio * self.gear_ratio)
    }

    /// Rotor's and load's viscous damping together, at the motor shaft, N m s/rad.
    pub fn damping(&self) -> f64 {
        self.rotor_damping + self.load_damping / (self.gear_ratio * self.gear_ratio)
    }

    /// Steady output speed per volt, rad/s per V.
    pub fn gain(&self) -> f64 {
        self.torque_constant / self.braking() / self.gear_ratio
    }

    /// Output speed at the nominal voltage without load, rad/s.
    pub fn no_load_speed(&self) -> f64 {
        self.gain() * self.nominal_v
    }

    /// Current at the nominal voltage with the shaft held, A.
    pub fn stall_current(&self) -> f64 {
        self.nominal_v / self.resistance_ohm
    }

    /// Time constant of the speed when the inductance is neglected, s.
    pub fn mechanical_time_constant(&self) -> f64 {
        self.resistance_ohm * self.inertia() / self.braking()
    }

    /// Time constant of the current with the shaft held, s.
    pub fn electrical_time_constant(&self) -> f64 {
        self.inductance_h / self.resistance_ohm
    }

    /// Viscous part of the damping, `R b / (R b + K_t K_e)`.
    pub fn viscous_share(&self) -> f64 {
        self.resistance_ohm * self.damping() / self.braking()
    }

    /// Load's share of the inertia.
    pub fn load_share(&self) -> f64 {
        1.0 - self.rotor_inertia / self.inertia()
    }

    /// Counts per turn of the output shaft, after x4 and gearing.
    pub fn counts_per_output_turn(&self) -> f64 {
        match self.encoder_shaft {
            EncoderShaft::Motor => self.encoder_counts * self.gear_ratio,
            EncoderShaft::Output => self.encoder_counts,
        }
    }

    /// One count, as an angle of the output shaft, rad.
    pub fn count_rad(&self) -> f64 {
        TAU / self.counts_per_output_turn()
    }

    /// The torque at the motor shaft that a voltage makes with the shaft held, N m: volt-equivalents to torque.
    pub fn torque_of_volts(&self, volts: f64) -> f64 {
        volts * self.torque_constant / self.resistance_ohm
    }

    fn braking(&self) -> f64 {
        self.resistance_ohm * self.damping() + self.torque_constant * self.back_emf_constant
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_motors_keep_their_stated_ranges_and_differ() {
        for seed in 0..500 {
            let motor = Motor::hidden(seed);
            assert_eq!(motor, Motor::hidden(seed));
            assert!((5.0..=104.0).contains(&motor.gear_ratio));
            assert!((0.0099..0.1501).contains(&motor.mechanical_time_constant()));
            assert!((0.00019..0.00301).contains(&motor.electrical_time_constant()));
            assert!((0.029..0.151).contains(&motor.viscous_share()));
            assert!((0.049..0.61).contains(&motor.load_share()));
            assert!(motor.counts_per_output_turn() >= 300.0);
        }
        assert_ne!(Motor::hidden(1), Motor::hidden(2));
    }

    #[test]
    fn presets_have_the_speeds_they_were_written_for() {
        assert!((Motor::paper().no_load_speed() - 720.0 / 104.0).abs() < 1e-9);
        assert!((Motor::small().no_load_speed() - 35.0).abs() < 1e-9);
        assert!((Motor::small().counts_per_output_turn() - 1440.0).abs() < 1e-9);
    }
}
