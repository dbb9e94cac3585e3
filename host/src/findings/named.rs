//! Effects as a sentence names them.

use motorlens_shared::effects::Kind;

use super::verdict::spoken;
use crate::fit::uncertainty::Estimate;
use crate::report::figure::in_words;

/// What the records cannot show, said beside what they do.
pub(super) fn not_shown(hidden: &[Kind]) -> String {
    match hidden {
        [] => String::new(),
        [one] => format!("; they cannot confirm {}", spoken(*one)),
        [first, second] => format!("; they cannot confirm {} or {}", spoken(*first), spoken(*second)),
        [first, second, rest @ ..] => {
            format!("; they cannot confirm {}, {} and {} more", spoken(*first), spoken(*second), rest.len())
        }
    }
}

/// The effects as a sentence names them: each with its size, where it has one with a unit.
pub fn named(effects: &[Kind], parameters: &[Estimate]) -> Vec<String> {
    let size = |kind: &Kind| {
        let of = |name: &str| {
            let whole = format!("{}.{name}", kind.name());
            parameters.iter().find(|e| e.name == whole)
        };
        let strength = kind.spec().parameters.iter().find(|p| p.strength && p.unit != "1")?;
        let first = of(strength.name)?;
        // A ripple or an unbalance is the length of its two components, and of its larger harmonic.
        let wave = |names: [&str; 2]| Some(of(names[0])?.value.hypot(of(names[1])?.value));
        let length = [["sine", "cosine"], ["sine2", "cosine2"]].into_iter().filter_map(wave).reduce(f64::max);
        let length = length.unwrap_or(first.value.abs());
        if length > 0.0 {
            return Some(in_words(length, &first.unit));
        }
        // Without its size an effect would be read as one that is there.
        (!first.identifiable).then(|| "size not determined".to_owned())
    };
    effects
        .iter()
        .map(|kind| (spoken(*kind), size(kind)))
        .map(|(name, size)| size.map_or_else(|| name.clone(), |size| format!("{name} ({size})")))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_are_named_with_their_sizes() {
        let of = |name: &str, value: f64, unit: &str| Estimate {
            name: name.into(),
            value,
            unit: unit.into(),
            low: 0.0,
            high: 1.0,
            identifiable: true,
        };
        let all =
            [of("coulomb.level", 0.4, "V"), of("gravity.sine", 0.3, "V"), of("gravity.cosine", -0.4, "V")];
        let told = named(&[Kind::Coulomb, Kind::Gravity, Kind::Delay], &all);
        assert_eq!(told, ["coulomb (0.4 V)", "gravity (0.5 V)", "delay"]);
        let open = Estimate { identifiable: false, ..of("dead_zone.width", 0.0, "V") };
        assert_eq!(named(&[Kind::DeadZone], &[open]), ["dead zone (size not determined)"]);
        assert_eq!(named(&[Kind::DeadZone], &[of("dead_zone.width", 0.0, "V")]), ["dead zone"]);
        let names = ["cogging.sine", "cogging.cosine", "cogging.sine2", "cogging.cosine2"];
        let teeth: Vec<Estimate> =
            names.into_iter().zip([0.3, 0.0, 0.0, -1.2]).map(|(name, value)| of(name, value, "V")).collect();
        assert_eq!(
            named(&[Kind::Cogging], &teeth),
            ["cogging (1.2 V)"],
            "the second harmonic is the larger one"
        );
    }
}
