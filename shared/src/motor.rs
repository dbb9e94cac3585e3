//! The paper's linear model of a geared DC motor: eight parameters, of which voltage and angle show three.
//!
//! Source: Soleimani Amiri, Ibrahim and Ramli, "Optimal parameter estimation for a DC motor using genetic
//! algorithm", IJPEDS 11(2):1047-1054, 2020, equations 1 to 12.

use serde::{Deserialize, Serialize};

/// Number of unknowns of the paper's model.
pub const PARAMETERS: usize = 8;

/// Symbols and units in the paper's order, as printed in tables: x = \[Km Kb L R Jsh Jr Br Bsh\].
pub const SYMBOLS: [(&str, &str); PARAMETERS] = [
    ("Km", "N m/A"),
    ("Kb", "V s/rad"),
    ("L", "H"),
    ("R", "ohm"),
    ("Jsh", "kg m^2"),
    ("Jr", "kg m^2"),
    ("Br", "N m s/rad"),
    ("Bsh", "N m s/rad"),
];

/// A geared DC motor as the paper describes it. SI units; every parameter is positive.
///
/// ```text
/// V - Kb w_r = L di/dt + R i              Km i = Tr + Tsh / Kg
/// Tr = Jr dw_r/dt + Br w_r                Tsh = Jsh dw_sh/dt + Bsh w_sh        w_r = Kg w_sh
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PaperMotor {
    /// Km, N m/A at the rotor. In SI equal to `back_emf_constant` in a real machine; the paper lets them differ.
    pub torque_constant: f64,
    /// Kb, V s/rad at the rotor.
    pub back_emf_constant: f64,
    /// L, H.
    pub inductance: f64,
    /// R, ohm.
    pub resistance: f64,
    /// Jsh, kg m^2 at the output shaft.
    pub shaft_inertia: f64,
    /// Jr, kg m^2 at the rotor.
    pub rotor_inertia: f64,
    /// Br, N m s/rad at the rotor.
    pub rotor_damping: f64,
    /// Bsh, N m s/rad at the output shaft.
    pub shaft_damping: f64,
    /// Kg: rotor turns for one turn of the output shaft. Known, not fitted.
    pub gear_ratio: f64,
}

/// theta(s) / V(s) = b / (a1 s^3 + a2 s^2 + a3 s); the paper's a4 is zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TransferFunction {
    /// Kg Km.
    pub b: f64,
    /// (Jr Kg^2 + Jsh) L.
    pub a1: f64,
    /// (Jr Kg^2 + Jsh) R + (Kg^2 Br + Bsh) L.
    pub a2: f64,
    /// Kb Kg^2 Km + (Kg^2 Br + Bsh) R.
    pub a3: f64,
}

/// All that voltage and angle can tell about a [`TransferFunction`]: three ratios.
///
/// Multiplying b, a1, a2 and a3 by one number changes nothing that is measured, and the eight parameters
/// enter through these four only: five of the eight directions cannot be learnt.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Combinations {
    /// b / a1, rad/(V s^3).
    pub b_over_a1: f64,
    /// a2 / a1, 1/s: the sum of the two decay rates.
    pub a2_over_a1: f64,
    /// a3 / a1, 1/s^2: the product of the two decay rates.
    pub a3_over_a1: f64,
}

impl PaperMotor {
    /// From the paper's order x = \[Km Kb L R Jsh Jr Br Bsh\] and the known gear ratio.
    #[must_use]
    pub const fn from_genes(x: [f64; PARAMETERS], gear_ratio: f64) -> Self {
        Self {
            torque_constant: x[0],
            back_emf_constant: x[1],
            inductance: x[2],
            resistance: x[3],
            shaft_inertia: x[4],
            rotor_inertia: x[5],
            rotor_damping: x[6],
            shaft_damping: x[7],
            gear_ratio,
        }
    }

    /// The eight parameters in the paper's order.
    #[must_use]
    pub const fn genes(&self) -> [f64; PARAMETERS] {
        [
            self.torque_constant,
            self.back_emf_constant,
            self.inductance,
            self.resistance,
            self.shaft_inertia,
            self.rotor_inertia,
            self.rotor_damping,
            self.shaft_damping,
        ]
    }

    /// The paper's Table 1 as printed, with its gear ratio of 104.
    #[must_use]
    pub const fn printed_table_1() -> Self {
        Self::from_genes([15.422, 0.0035, 0.0277, 0.0021, 0.0518, 0.1, 0.1, 0.0035], 104.0)
    }

    /// Equations 8 to 12.
    #[must_use]
    pub fn transfer_function(&self) -> TransferFunction {
        let ratio2 = self.gear_ratio * self.gear_ratio;
        let inertia = self.rotor_inertia * ratio2 + self.shaft_inertia;
        let damping = self.rotor_damping * ratio2 + self.shaft_damping;
        TransferFunction {
            b: self.gear_ratio * self.torque_constant,
            a1: inertia * self.inductance,
            a2: inertia * self.resistance + damping * self.inductance,
            a3: self.back_emf_constant * ratio2 * self.torque_constant + damping * self.resistance,
        }
    }

    /// The three numbers that a record of voltage and angle determines.
    #[must_use]
    pub fn combinations(&self) -> Combinations {
        self.transfer_function().combinations()
    }
}

impl TransferFunction {
    /// Divided by a1.
    #[must_use]
    pub fn combinations(&self) -> Combinations {
        Combinations {
            b_over_a1: self.b / self.a1,
            a2_over_a1: self.a2 / self.a1,
            a3_over_a1: self.a3 / self.a1,
        }
    }
}

impl Combinations {
    /// From a steady speed per volt, rad/(s V), and two real decay rates, 1/s.
    #[must_use]
    pub fn from_gain_and_rates(gain: f64, slow: f64, fast: f64) -> Self {
        Self { b_over_a1: gain * slow * fast, a2_over_a1: slow + fast, a3_over_a1: slow * fast }
    }

    /// b / a3: steady speed per volt, rad/(s V).
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.b_over_a1 / self.a3_over_a1
    }

    /// Mechanical and electrical time constants in s, the longer first, where both poles are real.
    #[must_use]
    pub fn time_constants(&self) -> Option<(f64, f64)> {
        let discriminant = self.a2_over_a1 * self.a2_over_a1 - 4.0 * self.a3_over_a1;
        if discriminant < 0.0 {
            return None;
        }
        let fast = 0.5 * (self.a2_over_a1 + libm::sqrt(discriminant));
        // The small root from the product: the difference would lose its digits.
        Some((fast / self.a3_over_a1, 1.0 / fast))
    }

    /// One of the infinitely many parameter sets with these combinations: `like` with its `b`, `a1`, `a2`
    /// and `a3` moved onto them by changing L, R, Km and Kb and leaving inertias and dampings alone.
    /// `None` where no positive set of these four exists.
    #[must_use]
    pub fn realised_near(&self, like: &PaperMotor) -> Option<PaperMotor> {
        let ratio2 = like.gear_ratio * like.gear_ratio;
        let inertia = like.rotor_inertia * ratio2 + like.shaft_inertia;
        let damping = like.rotor_damping * ratio2 + like.shaft_damping;
        let inductance = like.inductance;
        let a1 = inertia * inductance;
        let resistance = (self.a2_over_a1 * a1 - damping * inductance) / inertia;
        let torque_constant = self.b_over_a1 * a1 / like.gear_ratio;
        let back_emf_constant = (self.a3_over_a1 * a1 - damping * resistance) / (ratio2 * torque_constant);
        let all = [resistance, torque_constant, back_emf_constant];
        all.iter().all(|x| x.is_finite() && *x > 0.0).then_some(PaperMotor {
            torque_constant,
            back_emf_constant,
            resistance,
            ..*like
        })
    }
}

/// What a motor's data sheet tells; enough for a first guess of all eight parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Nameplate {
    /// V.
    pub voltage: f64,
    /// Speed of the output shaft without load at that voltage, rad/s.
    pub no_load_speed: f64,
    /// Current of the blocked motor at that voltage, A.
    pub stall_current: f64,
    /// Rotor turns per turn of the output shaft.
    pub gear_ratio: f64,
    /// Time to 63 % of the final speed, s. 0.05 is typical of small geared motors.
    pub mechanical_time_constant: f64,
    /// H.
    pub inductance: f64,
}

impl Nameplate {
    /// Textbook guesses: R from the stall, Kb from the no-load speed, Km = Kb, 5 % of the shaft's inertia and
    /// damping on the load side, damping such that 2 % of the no-load voltage drives friction.
    #[must_use]
    pub fn first_guess(&self) -> PaperMotor {
        let resistance = self.voltage / self.stall_current;
        let rotor_speed = self.no_load_speed * self.gear_ratio;
        let back_emf_constant = 0.98 * self.voltage / rotor_speed;
        let torque_constant = back_emf_constant;
        // Total damping and inertia as the rotor sees them.
        let damping = 0.02 * self.voltage / rotor_speed * torque_constant / resistance;
        let inertia =
            self.mechanical_time_constant * (torque_constant * back_emf_constant / resistance + damping);
        let ratio2 = self.gear_ratio * self.gear_ratio;
        PaperMotor {
            torque_constant,
            back_emf_constant,
            inductance: self.inductance,
            resistance,
            shaft_inertia: 0.05 * inertia * ratio2,
            rotor_inertia: 0.95 * inertia,
            rotor_damping: 0.95 * damping,
            shaft_damping: 0.05 * damping * ratio2,
            gear_ratio: self.gear_ratio,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Combinations, Nameplate, PaperMotor};

    /// Small 12 V motor of 1:104.
    const MOTOR: PaperMotor =
        PaperMotor::from_genes([0.0105, 0.0105, 2.1e-3, 3.2, 2e-3, 1.1e-6, 1.5e-6, 2e-3], 104.0);

    /// Laplace transforms of the paper's first equations at a real s, solved without the closed form.
    fn angle_per_volt(m: &PaperMotor, s: f64) -> f64 {
        // Unknown shaft speed w for V = 1: i = (1 - Kb Kg w) / (L s + R); Km i Kg = (J s + B) w.
        let admittance = 1.0 / (m.inductance * s + m.resistance);
        let drive = m.torque_constant * m.gear_ratio * admittance;
        let rotor = (m.rotor_inertia * s + m.rotor_damping) * m.gear_ratio * m.gear_ratio;
        let shaft = m.shaft_inertia * s + m.shaft_damping;
        drive / (rotor + shaft + drive * m.back_emf_constant * m.gear_ratio) / s
    }

    #[test]
    fn transfer_function_solves_the_equations_of_the_motor() {
        for motor in [MOTOR, PaperMotor::printed_table_1()] {
            let g = motor.transfer_function();
            for s in [0.1, 3.0, 50.0, 4000.0] {
                let closed = g.b / (s * (s * (g.a1 * s + g.a2) + g.a3));
                let solved = angle_per_volt(&motor, s);
                assert!((closed / solved - 1.0).abs() < 1e-12, "s = {s}: {closed} {solved}");
            }
        }
    }

    #[test]
    fn different_parameters_can_have_the_same_combinations() {
        let other = PaperMotor { rotor_inertia: 1.3e-6, inductance: 1.7e-3, shaft_damping: 1e-3, ..MOTOR };
        let truth = MOTOR.combinations();
        let twin = truth.realised_near(&other).expect("a positive set exists");
        let same = twin.combinations();
        assert!((same.b_over_a1 / truth.b_over_a1 - 1.0).abs() < 1e-12);
        assert!((same.a2_over_a1 / truth.a2_over_a1 - 1.0).abs() < 1e-12);
        assert!((same.a3_over_a1 / truth.a3_over_a1 - 1.0).abs() < 1e-12);
        assert!((twin.resistance / MOTOR.resistance - 1.0).abs() > 0.05);
    }

    #[test]
    fn time_constants_are_the_inverse_decay_rates() {
        let (slow, fast) =
            Combinations::from_gain_and_rates(0.9, 20.0, 1500.0).time_constants().expect("real poles");
        assert!((slow - 0.05).abs() < 1e-12);
        assert!((fast - 1.0 / 1500.0).abs() < 1e-12);
        let ringing = Combinations { b_over_a1: 1.0, a2_over_a1: 1.0, a3_over_a1: 9.0 };
        assert_eq!(ringing.time_constants(), None);
    }

    #[test]
    fn nameplate_guess_has_the_nameplate_speed_and_time_constant() {
        let plate = Nameplate {
            voltage: 12.0,
            no_load_speed: 9.0,
            stall_current: 2.5,
            gear_ratio: 104.0,
            mechanical_time_constant: 0.05,
            inductance: 1e-3,
        };
        let guess = plate.first_guess().combinations();
        assert!((guess.gain() - 9.0 / 12.0).abs() < 1e-9);
        let (mechanical, _) = guess.time_constants().expect("real poles");
        assert!((mechanical - 0.05).abs() < 0.001, "{mechanical}");
    }
}
