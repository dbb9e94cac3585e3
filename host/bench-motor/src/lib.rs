//! Realistic test benches around a second plant, as the yardstick of a diagnosis.
//!
//! The plant shares neither code nor functional forms with the fit or with the other virtual motor: explicit steps of
//! 20 us, a rational or Gaussian Stribeck curve with Karnopp's or LuGre's sticking (Karnopp 1985; Canudas de Wit et al.
//! 1995), contact between two inertias, a switched bridge, an armature whose flux falls with the current, a battery.
//! A bench adds what people have: a programme, a driver, a sensor with its window, filter, latency, hold and rounding,
//! a disturbance torque, small friction, and the file with what is known of the motor.
//!
//! ```
//! use motorlens_bench_motor::{Bench, Case};
//! let case = Case::new(Bench::FewDecimals, 1, &|_, _| Vec::new());
//! assert!(case.training.iter().all(|log| log.time_s.len() == log.voltage_v.len()));
//! ```

mod bench;
mod case;
mod disturbance;
mod driver;
mod effects;
mod motor;
mod plant;
mod programme;
mod sensor;
mod visibility;

pub use bench::Bench;
pub use case::{Case, Group, Hidden, Known, Log};
pub use effects::{LIBRARY, OUTSIDE, Row};

/// The random numbers of a case.
type Rng = rand::rngs::ChaCha8Rng;

/// A value between `low` and `high`.
fn between(rng: &mut Rng, low: f64, high: f64) -> f64 {
    use rand::RngExt;
    low + (high - low) * rng.random::<f64>()
}

/// A value between two positive ones, evenly by its logarithm.
fn geometric(rng: &mut Rng, low: f64, high: f64) -> f64 {
    between(rng, low.ln(), high.ln()).exp()
}

/// One of `values`.
fn pick<T: Copy>(rng: &mut Rng, values: &[T]) -> T {
    use rand::RngExt;
    values[rng.random_range(0..values.len())]
}

/// True with this chance.
fn chance(rng: &mut Rng, share: f64) -> bool {
    between(rng, 0.0, 1.0) < share
}

/// A normal deviate (Box and Muller 1958).
fn gaussian(rng: &mut Rng) -> f64 {
    let (u, v) = (between(rng, 1e-12, 1.0), between(rng, 0.0, std::f64::consts::TAU));
    (-2.0 * u.ln()).sqrt() * v.cos()
}
