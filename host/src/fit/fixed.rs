//! Parameters that the motor file fixes: `[fixed]` with names as results print them.

use std::collections::BTreeMap;
use std::path::Path;

use motorlens_shared::effects::Kind;

use super::layout::Layout;
use crate::error::{BadInput, Result};
use crate::formula::Library;
use crate::nearest::nearest;

/// Values by the names of the axes.
pub type Fixed = BTreeMap<String, f64>;

const BASE: [&str; 4] = ["gain", "tau_m", "tau_e", "viscous_share"];

/// Holds every fixed parameter that `layout` has at its value.
pub fn hold(layout: &mut Layout, fixed: &Fixed) {
    let only: Vec<String> = layout.kinds.iter().filter_map(|kind| only_parameter(*kind)).collect();
    for axis in &mut layout.axes {
        let alone = axis.name.split('.').next().filter(|_| only.contains(&axis.name));
        let value = fixed.get(&axis.name).or_else(|| fixed.get(alone?));
        if let Some(value) = value {
            let x = if axis.unit_value == 0.0 { value.ln() } else { value / axis.unit_value };
            (axis.low, axis.high, axis.fixed, axis.prior) = (x, x, true, None);
        }
    }
}

/// Refuses names that no model of effects of `library` has, and values that no motor has.
///
/// # Errors
/// Bad input that names the nearest parameter.
pub fn check(path: &Path, fixed: &Fixed, library: &Library) -> Result<()> {
    let names = names(library);
    for (name, value) in fixed {
        let is_effect = library.by_name(name).and_then(only_parameter).is_some();
        if !is_effect && !names.contains(name) {
            let remedy = match nearest(name, names.iter().map(String::as_str)) {
                Some(known) => format!("did you mean {known}?"),
                None => {
                    "use gain, tau_m, tau_e, viscous_share, or EFFECT.PARAMETER from motorlens effects NAME"
                        .to_owned()
                }
            };
            return Err(BadInput::new(path, format!("[fixed] {name} is no parameter"), remedy).into());
        }
        if BASE[..3].contains(&name.as_str()) && *value <= 0.0 {
            let why = format!("[fixed] {name} = {value} is not positive");
            return Err(BadInput::new(path, why, "give the value in SI units").into());
        }
    }
    Ok(())
}

/// Every name that a layout can have.
fn names(library: &Library) -> Vec<String> {
    let of =
        |k: &Kind| k.spec().parameters.iter().map(|p| format!("{}.{}", k.name(), p.name)).collect::<Vec<_>>();
    BASE.iter().map(|b| (*b).to_owned()).chain(library.kinds().iter().flat_map(of)).collect()
}

/// The full name of the parameter of an effect that has one only: then the effect's name will do.
fn only_parameter(effect: Kind) -> Option<String> {
    match effect.spec().parameters {
        [one] => Some(format!("{effect}.{}", one.name)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(name: &str, value: f64) -> String {
        let fixed = Fixed::from([(name.to_owned(), value)]);
        check(Path::new("motor.toml"), &fixed, &Library::default()).unwrap_err().to_string()
    }

    #[test]
    fn names_are_those_of_results_and_a_slip_is_answered() {
        let good = [("tau_e", 1e-3), ("coulomb.level", 0.2), ("coulomb", 0.2), ("stribeck.excess", 0.1)];
        check(Path::new("m"), &good.map(|(n, v)| (n.to_owned(), v)).into(), &Library::default()).unwrap();
        assert!(refused("tau_mm", 1.0).contains("did you mean tau_m?"));
        assert!(refused("stribeck", 1.0).contains("is no parameter"));
        assert!(refused("gain", -1.0).contains("not positive"));
    }
}
