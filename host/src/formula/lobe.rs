//! An effect that the library does not have, for the tests here and for those that call the library from outside (`tests/library.rs`).

use super::{Written, WrittenParameter};

/// A torque of three lobes a turn, called `name`; two of different `typical` size (V) are different effects.
pub(super) fn lobe(name: &str, typical: f64) -> Written {
    let size = WrittenParameter {
        name: "size".into(),
        unit: "V".into(),
        meaning: String::new(),
        low: -6.0,
        typical,
        high: 6.0,
    };
    Written {
        name: name.into(),
        port: "torque".into(),
        formula: "-size * sin(3 * angle)".into(),
        title: String::new(),
        signature: String::new(),
        source: String::new(),
        parameters: vec![size],
    }
}
