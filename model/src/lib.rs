//! The model of motorlens by itself: a geared DC motor and its physical effects, step by step, without std and without heap.
//!
//! It is the very code that the fits run, for firmware observers, simulators and controllers. Parameters come from a model file
//! (`motorlens discover --out model.json`): `base`, `rig`, and each effect's numbers in order.
//!
//! ```
//! use motorlens_model::{Base, Kind, Rig, Simulator, State};
//!
//! let base = Base { gain: 0.9, tau_m: 0.05, tau_e: 6e-4, viscous_share: 0.1 };
//! let rig = Rig {
//!     step_s: 1e-3,
//!     gear_ratio: 30.0,
//!     encoder_on_motor: true,
//!     nominal_v: 12.0,
//!     supply_v: 12.0,
//!     reference_speed: 11.0,
//!     count_rad: 1e-3,
//! };
//! let friction: (Kind, &[f64]) = (Kind::Coulomb, &[0.5]);
//! let motor = Simulator::new(&base, [friction], &rig);
//! let mut motion = motor.start(State::rest());
//! // The voltage held before the start, then that of the step.
//! for _ in 0..1000 {
//!     motor.advance(&mut motion, &[0.0, 6.0], 1);
//! }
//! // Friction takes half a volt of six.
//! assert!((motion.state.load_speed - 0.9 * 5.5).abs() < 1e-3);
//! ```
#![no_std]

pub use motorlens_shared::base::Base;
pub use motorlens_shared::effects::{Kind, Rig};
pub use motorlens_shared::scalar::Scalar;
pub use motorlens_shared::simulator::{MAX_EFFECTS, Motion, Simulator};
pub use motorlens_shared::step::State;
