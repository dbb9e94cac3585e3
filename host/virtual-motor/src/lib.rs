//! A virtual geared DC motor with its driver and encoder, for testing estimators on data whose truth is known.
//!
//! It is written independently of any fitter: physical SI states, `f64`, midpoint steps of at most 25 us, events for
//! sticking, and other functional forms than a fitter would use (exponential Stribeck curve of random exponent,
//! saturation by a hyperbolic tangent, backlash as a stiff contact, heat as a two-node network, a bridge that switches).
//!
//! ```
//! use motorlens_virtual_motor::{Bridge, Effect, Motor, VirtualMotor};
//! let effects = [Effect::parse("coulomb=0.3").unwrap()];
//! let mut plant = VirtualMotor::new(&Motor::paper(), &effects, 1);
//! for _ in 0..1000 {
//!     plant.advance(1e-3, Bridge::Volts(6.0));
//! }
//! assert!(plant.counts() > 0);
//! ```

mod effect;
mod law;
mod mechanics;
mod motor;
mod noise;
mod parts;
mod record;
mod table;
mod virtual_motor;

pub use effect::{Effect, EffectError};
pub use law::{Law, LawPort, Moment};
pub use motor::{EncoderShaft, Motor};
pub use record::{Recording, Run};
pub use table::{Kind, Parameter, Row};
pub use virtual_motor::{Bridge, VirtualMotor};
