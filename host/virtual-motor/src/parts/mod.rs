//! What the effects are made of: one physical part a file, parameters immutable, state separate.

pub mod driver;
pub mod electric;
pub mod friction;
pub mod gear;
pub mod load;
pub mod sensor;

use crate::effect::Effect;
use crate::table::Kind;

/// The parameters of the last effect of this kind, if there is one.
fn find(effects: &[Effect], kind: Kind) -> Option<[f64; 4]> {
    effects.iter().rev().find(|effect| effect.kind() == kind).map(Effect::values)
}
