//! Rotor and load as two bodies of MuJoCo, with the shaft of `compliance` or the gear contact of `backlash` between them.

use motorlens_shared::effects::Kind;

use super::hook::contact_grid;
use super::transmission;

/// The joint of the load where nobody names it, and that of the rotor.
pub(super) const OUTPUT: &str = "output";
pub(super) const ROTOR: &str = "rotor";

/// What lies between rotor and load.
pub(super) struct Between {
    pub kind: Kind,
    /// The load's shares of inertia and of viscous friction.
    pub share: f64,
    pub damping: f64,
    lies: Lies,
}

enum Lies {
    /// Natural frequency (rad/s) and damping ratio of the load while the rotor is held.
    Shaft([f64; 2]),
    /// Time between two looks at the contact, s.
    Gap(f64),
}

impl Between {
    /// The first transmission among `effects`.
    pub fn of(effects: &[(Kind, Vec<f64>)]) -> Option<Self> {
        let (kind, p) = transmission(effects)?;
        let spec = kind.spec();
        let lies = match kind {
            Kind::Compliance => Lies::Shaft([std::f64::consts::TAU * p[0], p[2]]),
            _ => Lies::Gap(contact_grid(effects)?),
        };
        Some(Self { kind: *kind, share: p[spec.load_share()?], damping: p[spec.load_damping()?], lies })
    }

    /// The step that a gear contact wants, s: the torque that meets it is to be short beside what happens between two looks at it.
    pub fn usual_step_s(&self) -> Option<f64> {
        match self.lies {
            Lies::Shaft(_) => None,
            Lies::Gap(grid_s) => Some(0.2 * grid_s),
        }
    }

    /// The longest step with which MuJoCo follows it, s.
    pub fn longest_step_s(&self) -> f64 {
        match self.lies {
            // Spring and damper act from where the bodies were before the step.
            Lies::Shaft([rate, ratio]) => {
                let rotor = 1.0 - self.share;
                0.5 / (2.0 * ratio * rate / rotor + rate / rotor.sqrt())
            }
            Lies::Gap(grid_s) => grid_s,
        }
    }

    /// The tendon that turns with the rotor against the load's joint `output`; its spring and damper act on the load's `inertia`, kg m^2.
    pub fn tendon(&self, output: &str, inertia: f64) -> String {
        let Lies::Shaft([rate, ratio]) = self.lies else { return String::new() };
        format!(
            r#"
  <tendon>
    <fixed name="transmission" stiffness="{:e}" damping="{:e}" springlength="0">
      <joint joint="{ROTOR}" coef="1"/>
      <joint joint="{output}" coef="-1"/>
    </fixed>
  </tendon>"#,
            inertia * rate * rate,
            2.0 * inertia * ratio * rate
        )
    }
}
