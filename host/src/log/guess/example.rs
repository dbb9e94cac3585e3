//! An example of a mapping, where nothing tells what the columns are.

use super::{column, quoted, words};
use crate::log::units::Quantity;

/// A mapping of the first columns, for an example where nothing tells what they are.
pub(in crate::log) fn example(names: &[String]) -> String {
    let part = |(quantity, unit): (Quantity, &str), index: usize| {
        let told = words::told(&names[index]).filter(|(of, _)| *of == quantity).map(|(_, unit)| unit);
        format!("{quantity}={}:{}", column(names, index), told.unwrap_or(unit))
    };
    let kinds = [(Quantity::Time, "s"), (Quantity::Voltage, "V"), (Quantity::Speed, "rad/s")];
    // The one that is called so, else the next; a column without a name is none, and what somebody wanted comes last.
    let mut columns: Vec<usize> = (0..names.len()).filter(|k| !names[*k].is_empty()).collect();
    columns.sort_by_key(|k| words::said(&names[*k]).wanted);
    let is_called = |k: usize, kind: Quantity| {
        let said = words::said(&names[k]);
        !said.wanted && said.quantity.is_some_and(|(of, _)| of == kind)
    };
    let named: Vec<Option<usize>> =
        kinds.iter().map(|(kind, _)| columns.iter().copied().find(|k| is_called(*k, *kind))).collect();
    columns.retain(|k| !named.contains(&Some(*k)));
    let mut others = columns.into_iter();
    let parts: Vec<String> = kinds
        .into_iter()
        .zip(named)
        .filter_map(|(kind, named)| Some(part(kind, named.or_else(|| others.next())?)))
        .collect();
    quoted(&parts.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_example_keeps_the_units_that_names_tell() {
        assert_eq!(
            example(&["czas_ms", "x", "y_rpm"].map(str::to_owned)),
            "time=czas_ms:ms,voltage=x:V,speed=y_rpm:rpm"
        );
    }
}
