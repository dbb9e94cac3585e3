//! Faults of the data that only a fit shows.

use motorlens_shared::effects::Kind;

use crate::fit::uncertainty::Estimate;
use crate::log::Warning;

/// Those that the `parameters` and the accepted `effects` of a model show.
pub fn faults(parameters: &[Estimate], effects: &[Kind]) -> Vec<Warning> {
    too_little_excitation(parameters)
        .into_iter()
        .chain(effects.iter().filter_map(|kind| of_the_sensor(*kind)))
        .collect()
}

/// Records from which even the plain motor cannot be had.
pub fn too_little_excitation(parameters: &[Estimate]) -> Option<Warning> {
    let open: Vec<&str> = parameters
        .iter()
        .filter(|p| matches!(p.name.as_str(), "gain" | "tau_m") && !p.identifiable)
        .map(|p| p.name.as_str())
        .collect();
    (!open.is_empty()).then(|| Warning {
        place: "all records together".into(),
        what: format!("too_little_excitation: they do not determine {}", open.join(" and ")),
        fix:
            "record a programme that accelerates, brakes and holds several speeds (motorlens plan writes one)"
                .into(),
    })
}

/// Effects that are faults of the measurement, and how to end them instead of modelling them.
fn of_the_sensor(kind: Kind) -> Option<Warning> {
    let (what, fix) = match kind {
        Kind::LostCounts => (
            "lost_counts: the angle falls behind at speed as if edges were missed",
            "read the encoder by hardware or faster, check its cable and filter, and log again",
        ),
        Kind::SensorLag => (
            "stale_samples: the reading trails the motion as if it were filtered or old",
            "log the raw reading at the instant of the voltage; else keep the effect",
        ),
        Kind::Delay => (
            "shifted_samples: the motion follows the logged voltage late",
            "check that the columns of a row belong to one instant; if the drive is that slow, keep the effect",
        ),
        _ => return None,
    };
    Some(Warning { place: "all records together".into(), what: what.into(), fix: fix.into() })
}
