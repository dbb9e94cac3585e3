//! Which parameters a model has, and how the search sees them.
//!
//! The search works on numbers of order one: logarithms of gain and time constants, the viscous share as it is,
//! and each effect's parameters in their typical size.

use motorlens_shared::base::Base;
use motorlens_shared::effects::{Kind, Rig};
use serde::{Deserialize, Serialize};

/// Number of base parameters.
pub const BASE_PARAMETERS: usize = 4;

/// Base parameters in plain numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BaseValues {
    /// No-load speed of the output shaft per volt, rad/s per V.
    pub gain: f64,
    /// Mechanical time constant, s.
    pub tau_m: f64,
    /// Electrical time constant, s.
    pub tau_e: f64,
    /// Viscous share of the mechanical damping, 0 ..= 1.
    pub viscous_share: f64,
}

impl BaseValues {
    /// For the model.
    pub fn base(&self) -> Base<f64> {
        Base { gain: self.gain, tau_m: self.tau_m, tau_e: self.tau_e, viscous_share: self.viscous_share }
    }
}

/// Base and effects with their values.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    /// The motor.
    pub base: BaseValues,
    /// Effects in the order they were added, each with its parameters in the registry's order.
    pub effects: Vec<(Kind, Vec<f64>)>,
}

impl Values {
    /// Names of the effects.
    pub fn kinds(&self) -> Vec<Kind> {
        self.effects.iter().map(|e| e.0).collect()
    }
    /// The plain parameters of an effect, in its row's order; none where the model lacks it.
    pub fn parameters(&self, kind: Kind) -> Option<&[f64]> {
        self.effects.iter().find(|(own, _)| *own == kind).map(|(_, parameters)| parameters.as_slice())
    }
    /// The model with one more effect.
    #[must_use]
    pub fn with(&self, kind: Kind, parameters: Vec<f64>) -> Self {
        let mut more = self.clone();
        more.effects.push((kind, parameters));
        more
    }
    /// The model without an effect.
    #[must_use]
    pub fn without(&self, kind: Kind) -> Self {
        let mut fewer = self.clone();
        fewer.effects.retain(|e| e.0 != kind);
        fewer
    }
}

/// One number of the search.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Parameter name: `gain`, or `coulomb.level`.
    pub name: String,
    /// Unit of the plain value.
    pub unit: &'static str,
    /// Plain value of one search unit; 0 marks a logarithm.
    pub unit_value: f64,
    /// Bounds in search units.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
    /// Whether the lower and the upper bound are only where the search ends: nature goes on.
    pub ends: [bool; 2],
    /// Difference used for derivatives.
    pub delta: f64,
    /// Known and not fitted.
    pub fixed: bool,
    /// Prior centre and standard deviation in search units.
    pub prior: Option<(f64, f64)>,
}

impl Axis {
    /// How many standard deviations `x` is from what is believed, and the slope of that; none where nothing is believed.
    ///
    /// Of a logarithm below its centre it is the value itself that is believed: none at all, as of a winding without inductance or a current that is
    /// commanded, is as near as twice as much, and not infinitely far.
    pub fn doubt(&self, x: f64) -> Option<(f64, f64)> {
        let (centre, width) = self.prior?;
        let share = (x - centre).exp();
        let is_less = self.unit_value == 0.0 && share < 1.0;
        Some(if is_less {
            ((share - 1.0) / width, share / width)
        } else {
            ((x - centre) / width, 1.0 / width)
        })
    }
}

/// The search's view of a set of effects.
#[derive(Debug, Clone)]
pub struct Layout {
    /// Effects in order.
    pub kinds: Vec<Kind>,
    /// All numbers: base, then each effect's.
    pub axes: Vec<Axis>,
}

/// The electrical time constant is looked for up to so many standard deviations above what is believed of it: 2.7 ms where nothing is known. A
/// slower winding answers as a filter does, which is the likelier where nothing is known.
pub const REACH: f64 = 3.0;

/// The shortest electrical time constant, s: faster than any cell, it is none.
const SHORTEST_TAU_E_S: f64 = 2e-5;

/// So near to a bound, as a share of the whole axis, a value stands at it.
const END: f64 = 1e-3;

/// What is believed about the base before seeing data.
#[derive(Debug, Clone, Copy)]
pub struct Prior {
    /// Electrical time constant, s, and the standard deviation of its logarithm.
    pub tau_e: (f64, f64),
    /// Viscous share and its standard deviation.
    pub viscous_share: (f64, f64),
}

impl Layout {
    /// The axes of `kinds` on `rig`.
    pub fn new(kinds: &[Kind], rig: &Rig, prior: &Prior) -> Self {
        let log = |name: &str, unit, low: f64, high: f64| Axis {
            name: name.into(),
            unit,
            unit_value: 0.0,
            low: low.ln(),
            high: high.ln(),
            ends: [true; 2],
            delta: 1e-3,
            fixed: false,
            prior: None,
        };
        let centre = prior.tau_e.0.ln();
        let mut tau_e = log("tau_e", "s", 1.0, 1.0);
        let reach = REACH * prior.tau_e.1;
        (tau_e.low, tau_e.high) = (SHORTEST_TAU_E_S.ln().min(centre - reach), centre + reach);
        (tau_e.ends, tau_e.prior) = ([false; 2], Some((centre, prior.tau_e.1)));
        let share = Axis {
            name: "viscous_share".into(),
            unit: "1",
            unit_value: 1.0,
            low: 0.0,
            high: 0.6,
            ends: [false; 2],
            delta: 2e-3,
            fixed: false,
            prior: Some(prior.viscous_share),
        };
        let scale = rig.reference_speed / rig.nominal_v;
        let mut axes = vec![
            log("gain", "rad/s/V", scale * 1e-3, scale * 1e3),
            log("tau_m", "s", 5e-4, 50.0),
            tau_e,
            share,
        ];
        for kind in kinds {
            for p in kind.spec().parameters {
                let unit_value = p.typical * p.scale.unit(rig);
                let [low, high] = p.bounds(rig);
                axes.push(Axis {
                    name: format!("{kind}.{}", p.name),
                    unit: p.unit,
                    unit_value,
                    low: low / p.typical,
                    high: high / p.typical,
                    // A strength cannot be less than nothing, and a share not more than all.
                    ends: [p.strength && p.low != 0.0, p.strength && (p.unit, p.high) != ("1", 1.0)],
                    delta: 4e-3,
                    fixed: !p.searched,
                    prior: None,
                });
            }
        }
        Self { kinds: kinds.to_vec(), axes }
    }

    /// Number of axes.
    pub fn len(&self) -> usize {
        self.axes.len()
    }

    /// Axes that are searched.
    pub fn free(&self) -> Vec<usize> {
        (0..self.len()).filter(|k| !self.axes[*k].fixed).collect()
    }

    /// Never: a base is always there.
    pub fn is_empty(&self) -> bool {
        self.axes.is_empty()
    }

    /// Search numbers of plain values.
    pub fn pack(&self, values: &Values) -> Vec<f64> {
        let b = &values.base;
        let plain = [b.gain, b.tau_m, b.tau_e, b.viscous_share];
        let effects = values.effects.iter().flat_map(|e| e.1.iter().copied());
        let all = plain.into_iter().chain(effects);
        all.zip(&self.axes)
            .map(|(x, a)| if a.unit_value == 0.0 { x.ln() } else { x / a.unit_value })
            .zip(&self.axes)
            .map(|(x, a)| x.clamp(a.low, a.high))
            .collect()
    }

    /// Plain value of search number `x` on axis `k`.
    pub fn plain(&self, k: usize, x: f64) -> f64 {
        let a = &self.axes[k];
        if a.unit_value == 0.0 { x.exp() } else { x * a.unit_value }
    }

    /// Plain values of all axes, in their order.
    pub fn all_plain(&self, x: &[f64]) -> Vec<f64> {
        x.iter().enumerate().map(|(k, x)| self.plain(k, *x)).collect()
    }

    /// Plain values of search numbers.
    pub fn unpack(&self, x: &[f64]) -> Values {
        let at = |k: usize| self.plain(k, x[k]);
        let base = BaseValues { gain: at(0), tau_m: at(1), tau_e: at(2), viscous_share: at(3) };
        let mut next = BASE_PARAMETERS;
        let effects = self
            .kinds
            .iter()
            .map(|kind| {
                let n = kind.spec().parameters.len();
                let parameters = (next..next + n).map(at).collect();
                next += n;
                (*kind, parameters)
            })
            .collect();
        Values { base, effects }
    }

    /// The places of the axes on which `x` stands where the search ends though nature goes on: no minimum was found there.
    pub fn at_the_end(&self, x: &[f64]) -> Vec<usize> {
        let stands = |k: &usize| {
            let axis = &self.axes[*k];
            let near = END * (axis.high - axis.low);
            axis.ends[0] && x[*k] < axis.low + near || axis.ends[1] && x[*k] > axis.high - near
        };
        self.free().into_iter().filter(stands).collect()
    }

    /// Step for the derivative along axis `k` at `x`, turned inward at the upper bound.
    pub fn step(&self, k: usize, x: f64) -> f64 {
        let a = &self.axes[k];
        let d = if k < BASE_PARAMETERS { a.delta } else { a.delta.max(a.delta * 2.0 * x.abs()) };
        if x + d > a.high { -d } else { d }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIG: Rig = Rig {
        step_s: 1e-3,
        gear_ratio: 50.0,
        encoder_on_motor: true,
        nominal_v: 12.0,
        supply_v: 12.0,
        reference_speed: 10.0,
        count_rad: 1e-3,
    };
    const PRIOR: Prior = Prior { tau_e: (5e-4, 0.4), viscous_share: (0.08, 0.05) };

    #[test]
    fn packing_and_unpacking_are_inverse() {
        let values = Values {
            base: BaseValues { gain: 0.9, tau_m: 0.05, tau_e: 6e-4, viscous_share: 0.1 },
            effects: vec![(Kind::Stribeck, vec![0.3, 0.2, 0.15, 0.5]), (Kind::Delay, vec![0.004])],
        };
        let layout = Layout::new(&values.kinds(), &RIG, &PRIOR);
        let back = layout.unpack(&layout.pack(&values));
        for (a, b) in layout.pack(&values).iter().zip(layout.pack(&back)) {
            assert!((a - b).abs() < 1e-12);
        }
        assert_eq!(layout.axes[4].name, "stribeck.level");
    }

    #[test]
    fn a_size_ends_where_there_is_none_larger_whatever_a_count_comes_to() {
        let highest = |count_rad: f64| {
            let layout = Layout::new(&[Kind::Eccentricity], &Rig { count_rad, ..RIG }, &PRIOR);
            layout.plain(4, layout.axes[4].high)
        };
        assert!((highest(1e-4) - 60e-4).abs() < 1e-12, "60 counts");
        assert!((highest(0.1) - 0.5 / 50.0).abs() < 1e-12, "half a radian of the encoder's shaft");
    }

    #[test]
    fn a_value_at_the_end_of_its_search_is_named_and_one_at_an_end_of_nature_is_not() {
        let ends = |tau_m, viscous_share, share, level| {
            let base = BaseValues { gain: 0.9, tau_m, tau_e: 6e-4, viscous_share };
            let effects = vec![(Kind::Coulomb, vec![level]), (Kind::Coast, vec![share, 500.0])];
            let values = Values { base, effects };
            let layout = Layout::new(&values.kinds(), &RIG, &PRIOR);
            let x = layout.pack(&values);
            let names = layout.at_the_end(&x).into_iter().map(|k| layout.axes[k].name.clone());
            names.collect::<Vec<_>>()
        };
        assert!(ends(0.05, 0.1, 0.5, 0.3).is_empty());
        assert!(
            ends(0.05, 0.0, 1.0, 0.0).is_empty(),
            "no viscous friction, a driver that floats, no friction"
        );
        assert_eq!(ends(1e-5, 0.1, 0.5, 0.3), ["tau_m"]);
        assert_eq!(ends(80.0, 0.1, 0.5, 40.0), ["tau_m", "coulomb.level"]);
    }
}
