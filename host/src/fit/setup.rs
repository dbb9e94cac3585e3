//! From records and what is known of the motor to a [`Problem`] and a first base model.

use motorlens_shared::effects::Rig;

use super::cost::Objective;
use super::fixed::Fixed;
use super::grid::{Grid, Quantity};
use super::held::{date, held};
use super::instants::plainly_otherwise;
use super::layout::{BaseValues, Layout, Prior, Values};
use super::rig::rig;
use super::search::Problem;
use super::simulate::{Block, LANES, predict_block};
use crate::log::Record;
use crate::log::quantum::quantum as step_of;
use crate::motor_file::MotorFile;

/// Electrical time constant of small motors where nothing is known, s, and how sure that is.
const USUAL_TAU_E: (f64, f64) = (8e-4, 0.4);
/// Standard deviation of the logarithm of a time constant from a nameplate.
const NAMEPLATE_WIDTH: f64 = 0.4;
/// Viscous share of the damping of small geared motors, and its spread.
const USUAL_VISCOUS_SHARE: (f64, f64) = (0.08, 0.05);

/// Beliefs about the base.
pub fn prior(motor: &MotorFile) -> Prior {
    let n = &motor.nameplate;
    let from_parts = n.inductance_h.zip(n.resistance_ohm).map(|(l, r)| l / r);
    let tau_e = n.electrical_time_constant_s.or(from_parts);
    Prior { tau_e: tau_e.map_or(USUAL_TAU_E, |t| (t, NAMEPLATE_WIDTH)), viscous_share: USUAL_VISCOUS_SHARE }
}

/// The step of a record's main column: the encoder's count where it is known, else what the data show.
pub fn quantum(record: &Record, rig: &Rig, counts_known: bool) -> f64 {
    match (&record.angle_rad, &record.speed_rad_s) {
        (Some(_), _) if counts_known => rig.count_rad,
        (Some(angle), _) => step_of(angle).unwrap_or(0.0),
        (None, Some(speed)) => step_of(speed).unwrap_or(0.0),
        (None, None) => 0.0,
    }
}

/// The problem of fitting `records`, and a base model to start from.
///
/// The rig's reference speed is set from the data, so that bounds and sizes fit this motor.
pub fn problem(records: &[Record], motor: &MotorFile) -> (Problem, Values) {
    problem_of(records, motor, None)
}

/// [`problem`]; of records whose speeds are known to be `read` so, that is not asked again.
pub(crate) fn problem_of(records: &[Record], motor: &MotorFile, read: Option<Quantity>) -> (Problem, Values) {
    let mut rig = rig(records, motor);
    let counts_known =
        motor.counts_per_rev.is_some() || records.iter().any(|r| r.meta.counts_per_rev().is_some());
    let mut grids: Vec<Grid> = records.iter().map(|r| Grid::new(r, quantum(r, &rig, counts_known))).collect();
    let counted = grids.iter().find(|g| g.quantity == Quantity::MeanSpeed && !counts_known);
    if let Some(g) = counted {
        rig.count_rad = g.quantum * g.interval_s;
    }
    let prior = prior(motor);
    if let Some(read) = read {
        grids = grids.into_iter().map(|grid| grid.read_as(read)).collect();
    }
    let mut base = first_base(&grids, &rig, &prior);
    let otherwise = || plainly_otherwise(&grids, base, &rig, &prior);
    if let Some(otherwise) = read.is_none().then(otherwise).flatten() {
        grids = grids.into_iter().map(|grid| grid.read_as(otherwise)).collect();
        base = first_base(&grids, &rig, &prior);
    }
    rig.reference_speed = base.gain * rig.nominal_v;
    let fixed = motor.fixed.clone();
    let hold_s = held(&mut grids);
    let mut problem = Problem { fixed, hold_s, ..Problem::new(grids, rig, prior) };
    let mut start = Values { base, effects: Vec::new() };
    problem.find_moving_starts(&start);
    if problem.grids.iter().any(|grid| grid.quantity == Quantity::Angle && !grid.rests()) {
        start.base = first_base(&problem.grids, &problem.rig, &problem.prior);
        problem.rig.reference_speed = start.base.gain * problem.rig.nominal_v;
        problem.refine_starts(&start);
    }
    (problem, start)
}

/// A copy counts its passes from zero.
impl Clone for Problem {
    fn clone(&self) -> Self {
        self.on(self.grids.clone())
    }
}

impl Problem {
    /// Records of a rig of which nothing else is known.
    pub(super) fn new(grids: Vec<Grid>, rig: Rig, prior: Prior) -> Self {
        Self {
            grids,
            rig,
            prior,
            fixed: Fixed::default(),
            hold_s: None,
            simulations: std::cell::Cell::new(0),
        }
    }

    /// The same rig and noise, other records.
    #[must_use]
    pub fn on(&self, grids: Vec<Grid>) -> Self {
        Self { fixed: self.fixed.clone(), hold_s: self.hold_s, ..Self::new(grids, self.rig, self.prior) }
    }

    /// What the speeds are, those of one motor all alike; none where there are angles only.
    pub fn speeds(&self) -> Option<Quantity> {
        self.grids.iter().map(|grid| grid.quantity).find(|quantity| *quantity != Quantity::Angle)
    }

    /// Records kept out of the fit, laid on their grids; where readings are held, they are dated with the hold found here.
    pub fn lay_out(&self, records: &[Record], motor: &MotorFile) -> Vec<Grid> {
        let (mut other, _) = problem_of(records, motor, self.speeds());
        if let Some(time) = self.hold_s {
            date(&mut other.grids, time);
        }
        other.grids
    }

    /// Fits the base alone: the error itself first, then its 50 ms differences. Records that begin in motion do so from now on as it has them.
    pub fn fit_base(&mut self, start: &Values) -> (Layout, Vec<f64>) {
        let layout = self.layout(&[]);
        let x = layout.pack(start);
        let rough = self.settle(&layout, Objective::Position, &x, 8, 1e-4);
        let fine = self.settle(&layout, Objective::Increments, &rough, 12, 1e-5);
        (layout, fine)
    }
}

/// A record that begins in motion, without any voltage.
fn coasting(grid: &Grid) -> Option<Grid> {
    (!grid.rests()).then(|| {
        let mut coasting = grid.clone();
        coasting.voltages.fill(0.0);
        coasting
    })
}

/// Gain and time constant by scanning: what the voltage does is linear in the gain, so each time constant needs one pass; and a second where a
/// record begins in motion: what it does by itself is linear in its first speed, which is fitted too.
pub(super) fn first_base(grids: &[Grid], rig: &Rig, prior: &Prior) -> BaseValues {
    let unit = Rig { reference_speed: rig.nominal_v, ..*rig };
    let layout = Layout::new(&[], &unit, prior);
    let share = prior.viscous_share.0;
    let mut best =
        (f64::MAX, BaseValues { gain: 1.0, tau_m: 0.05, tau_e: prior.tau_e.0, viscous_share: share });
    let taus: Vec<f64> = (0..2 * LANES).map(|k| 0.004 * 1.45_f64.powi(k as i32)).collect();
    let [mut series, mut coasted] = [const { Vec::<Block>::new() }; 2];
    for chunk in taus.chunks(LANES) {
        let bases: Vec<BaseValues> = chunk
            .iter()
            .map(|tau| BaseValues { gain: 1.0, tau_m: *tau, tau_e: prior.tau_e.0, viscous_share: share })
            .collect();
        let xs: Vec<Vec<f64>> =
            bases.iter().map(|b| layout.pack(&Values { base: *b, effects: Vec::new() })).collect();
        let mut all = [Products::default(); LANES];
        for grid in grids {
            let mut still = grid.clone();
            still.begin_at(0.0, 0.0);
            predict_block(&layout, &xs, &unit, &still, &mut series);
            coasted.clear();
            if let Some(coasting) = coasting(grid) {
                predict_block(&layout, &xs, &unit, &coasting, &mut coasted);
            }
            let speed = grid.quantity != Quantity::Angle;
            let span = ((0.05 / grid.interval_s).round() as usize).max(1);
            let mut own = [Products::default(); LANES];
            for k in 0..series.len().saturating_sub(span) {
                let added = |of: &[Block], l: usize| match (of.get(k + span), speed) {
                    (Some(block), true) => block.0[l],
                    (Some(block), false) => block.0[l] - of[k].0[l],
                    (None, _) => 0.0,
                };
                let y = grid.measured[k + span] - if speed { 0.0 } else { grid.measured[k] };
                for (l, own) in own.iter_mut().enumerate() {
                    own.add([y, added(&series, l), added(&coasted, l)].map(|x| x / grid.sigma));
                }
            }
            for (all, own) in all.iter_mut().zip(own) {
                all.add_without_start(own);
            }
        }
        for (products, base) in all.iter().zip(bases) {
            let gain = products.yp / products.pp.max(1e-300);
            let left = products.yy - gain * products.yp;
            if gain > 0.0 && left < best.0 {
                best = (left, BaseValues { gain, ..base });
            }
        }
    }
    best.1
}

/// Sums of products of what was measured (y), what the voltage does (p) and what the first speed does (s).
#[derive(Clone, Copy, Default)]
struct Products {
    yy: f64,
    yp: f64,
    pp: f64,
    ys: f64,
    ps: f64,
    ss: f64,
}

impl Products {
    fn add(&mut self, [y, p, s]: [f64; 3]) {
        self.yy += y * y;
        self.yp += y * p;
        self.pp += p * p;
        self.ys += y * s;
        self.ps += p * s;
        self.ss += s * s;
    }

    /// Adds those of a record, less what its first speed may make up for.
    fn add_without_start(&mut self, own: Self) {
        let inverse = if own.ss > 0.0 { 1.0 / own.ss } else { 0.0 };
        self.yy += own.yy - own.ys * own.ys * inverse;
        self.yp += own.yp - own.ys * own.ps * inverse;
        self.pp += own.pp - own.ps * own.ps * inverse;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor of 1.5 rad/s/V and 0.75 s that a loop lets run down from 12.6 rad/s.
    #[test]
    fn the_first_base_of_a_record_of_speeds_that_begins_in_motion_begins_there() {
        let time_s: Vec<f64> = (0..300).map(|k| 0.01 * f64::from(k)).collect();
        let voltage_v: Vec<f64> = time_s.iter().map(|t| 6.0 * (-t).exp() - 0.5 * (3.0 * t).sin()).collect();
        let mut speed = 12.6;
        let run = voltage_v.iter().map(|v| {
            let now = speed;
            speed += 0.01 / 0.75 * (1.5 * v - speed);
            now
        });
        let speed_rad_s = Some(run.collect());
        let record = Record { time_s, voltage_v, speed_rad_s, ..Record::default() };
        let (_, start) = problem(&[record], &MotorFile::default());
        let BaseValues { gain, tau_m, .. } = start.base;
        assert!((gain / 1.5 - 1.0).abs() < 0.2 && (tau_m / 0.75 - 1.0).abs() < 0.3, "{gain} {tau_m}");
    }
}
