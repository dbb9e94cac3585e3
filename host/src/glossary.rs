//! Every parameter of the model, explained: symbol, unit, meaning and the equation in which it stands.
//!
//! `motorlens effects`, the page's glossary and its tooltips all tell what stands here. Parameters of effects explain themselves in
//! the registry; here are those of the base model, which has no row there.

use motorlens_shared::effects::Kind;
use serde::Serialize;

/// The base model, one equation a line, in the symbols of `BASE`.
pub const BASE_EQUATIONS: [&str; 4] = [
    "tau_e du/dt = v - k_e w - u                                   u = R i: current as a voltage, V",
    "dw/dt = (gain / tau_m) (u + f) - (viscous_share / tau_m) w    f = T R / (n K_t): torque as a voltage, V",
    "dx/dt = w                                                     w, x: speed (rad/s) and angle (rad) of the output shaft",
    "k_e = (1 - viscous_share) / gain                              back-EMF constant at the output shaft, V s/rad",
];

/// A parameter, explained.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Term {
    /// As tables print it: `gain`, or `coulomb.level`.
    pub name: String,
    /// As the equation writes it.
    pub symbol: String,
    /// Its unit.
    pub unit: String,
    /// In one line.
    pub meaning: String,
    /// Where it stands.
    pub equation: String,
}

const TRANSFER: &str = "x / v = b / (a1 s^3 + a2 s^2 + a3 s)";

/// Name, symbol, unit, meaning and equation of what the base model is described by.
const BASE: [[&str; 5]; 8] = [
    [
        "gain",
        "gain",
        "rad/(V s)",
        "steady speed of the output shaft per volt, without friction or load",
        "w = gain v in steady state",
    ],
    [
        "tau_m",
        "tau_m",
        "s",
        "mechanical time constant: after it the speed has come 63 % of the way to a new voltage",
        "dw/dt = (gain / tau_m) (u + f) - (viscous_share / tau_m) w",
    ],
    [
        "tau_e",
        "tau_e",
        "s",
        "electrical time constant of the winding, inductance over resistance",
        "tau_e du/dt = v - k_e w - u",
    ],
    [
        "viscous_share",
        "viscous_share",
        "1",
        "part of the damping that is viscous friction; the rest is back-EMF. Without a current sensor records hardly show it",
        "k_e = (1 - viscous_share) / gain",
    ],
    ["b/a3", "b/a3", "rad/(V s)", "gain of the transfer function, the same as gain", TRANSFER],
    [
        "b/a1",
        "b/a1",
        "rad/(V s^3)",
        "gain over the product of both time constants: how sharply the motion begins",
        TRANSFER,
    ],
    [
        "a2/a1",
        "a2/a1",
        "1/s",
        "1 / tau_e + viscous_share / tau_m: how fast current and speed die away together",
        TRANSFER,
    ],
    ["a3/a1", "a3/a1", "1/s^2", "1 / (tau_m tau_e): the product of both rates", TRANSFER],
];

/// What stands in the equations and is no parameter, nor explained beside them.
pub const SYMBOLS: &str = "v: voltage at the motor, v_log: as it was logged, supply: of the driver, nominal: the rated one, all in V; \
                           T: torque; n: gear ratio; K_t: torque constant; R: winding resistance";

/// Words of the verdict, the plots and the equations, each with its meaning.
pub const WORDS: [[&str; 2]; 10] = [
    [
        "noise level",
        "the rms noise of the readings: from a repeated record where there is one, else from the encoder's counts",
    ],
    ["x the noise", "an error in multiples of the noise level; about 1 x is all that can be had"],
    ["simulation error", "measured minus simulated, where only the start is taken from the measurement"],
    [
        "share explained",
        "the part of the base model's error above the noise level that the effects take away",
    ],
    [
        "residual torque",
        "what would have to be added to the model, as a voltage, to turn its simulation into the measurement",
    ],
    ["validation record", "a record that no fit and no choice of an effect sees; errors are told on it"],
    [
        "likelihood gain, nats",
        "the logarithm of how much more probable an effect makes blocks that its fit did not see; below two of its standard errors it may be chance",
    ],
    [
        "indistinguishable",
        "models that explain these records equally well; any of them may be the true one, and the simplest is named",
    ],
    [
        "kS-kV-kA",
        "the usual model of robot teams: v = kS sign(w) + kV w + kA dw/dt, fitted to the same records",
    ],
    ["symbols of the equations", SYMBOLS],
];

/// The parameters of the base model and of `kinds`.
pub fn terms(kinds: &[Kind]) -> Vec<Term> {
    let base = BASE.iter().map(|[name, symbol, unit, meaning, equation]| Term {
        name: (*name).into(),
        symbol: (*symbol).into(),
        unit: (*unit).into(),
        meaning: (*meaning).into(),
        equation: (*equation).into(),
    });
    let own = kinds.iter().flat_map(|kind| {
        let spec = kind.spec();
        spec.parameters.iter().map(|p| Term {
            name: format!("{}.{}", spec.name, p.name),
            symbol: p.name.into(),
            unit: p.unit.into(),
            meaning: p.meaning.into(),
            equation: spec.equation.into(),
        })
    });
    base.chain(own).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_of_every_effect_is_explained() {
        let all = terms(Kind::ALL);
        for kind in Kind::ALL {
            for p in kind.spec().parameters {
                let name = format!("{}.{}", kind.name(), p.name);
                let term = all.iter().find(|t| t.name == name).expect("a term");
                assert!(
                    term.meaning.len() > 5 && !term.unit.is_empty() && !term.equation.is_empty(),
                    "{name}"
                );
            }
        }
        assert!(all.iter().any(|t| t.name == "viscous_share" && t.meaning.contains("back-EMF")));
    }

    /// The page has them below a slider: what follows a colon, comma or semicolon stands in its tooltip.
    #[test]
    fn the_first_words_of_a_meaning_tell_the_parameters_of_an_effect_apart() {
        for kind in Kind::ALL {
            let first =
                |meaning: &'static str| meaning.split([':', ';', ',', '.']).next().unwrap_or_default();
            let all: Vec<&str> = kind.spec().parameters.iter().map(|p| first(p.meaning)).collect();
            let says =
                |k: usize| all[k].contains(' ') && !all[k].starts_with("of ") && !all[..k].contains(&all[k]);
            assert!((0..all.len()).all(says), "{kind}: {all:?}");
        }
    }

    #[test]
    fn the_names_of_the_base_parameters_are_those_of_the_fit() {
        for name in ["gain", "tau_m", "tau_e", "viscous_share"] {
            assert!(BASE.iter().any(|row| row[0] == name));
        }
    }
}
