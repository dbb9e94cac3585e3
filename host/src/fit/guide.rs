//! What the search makes of a grid: only the samples that are judged, with the shaft as it was seen in between.

use super::cost::stride;
use super::grid::{Grid, Quantity};
use super::simulate::hermite;

impl Grid {
    /// The same for simulations at the measured angle: equations tied to an angle act where the shaft was seen, so that a drift of the model does
    /// not lose the phase of a cogging torque or of an unbalance. Records of speed stay free. Only the samples that are judged are
    /// left: the others guide.
    #[must_use]
    pub fn guided(mut self) -> Self {
        if self.quantity == Quantity::Angle {
            self.guide = self.at_cell_ends();
            self.seen = vec![false; self.guide.len()];
            for place in &self.places {
                let nearest = (place.cell as f64 + place.part).round() as usize;
                self.seen[nearest.min(self.guide.len() - 1)] = true;
            }
            let stride = stride(self.interval_s);
            let judged = |k: &usize| *k >= self.skip && (k - self.skip).is_multiple_of(stride);
            let kept: Vec<usize> = (0..self.len()).filter(judged).collect();
            self.time_s = kept.iter().map(|k| self.time_s[*k]).collect();
            self.places = kept.iter().map(|k| self.places[*k]).collect();
            self.measured = kept.iter().map(|k| self.measured[*k]).collect();
            self.interval_s *= stride as f64;
            self.skip = 0;
        }
        self
    }

    /// The measured column at the start and at every cell's end, by cubics through the samples.
    fn at_cell_ends(&self) -> Vec<f64> {
        let at: Vec<f64> = self.places.iter().map(|p| p.cell as f64 + p.part).collect();
        let y = &self.measured;
        let last = y.len() - 1;
        let mut k = 0;
        (0..self.voltages.len())
            .map(|end| {
                let x = end as f64;
                while k + 2 < last && at[k + 1] < x {
                    k += 1;
                }
                let (from, to) = (k, (k + 1).min(last));
                let span = (at[to] - at[from]).max(1e-9);
                let s = ((x - at[from]) / span).clamp(0.0, 1.0);
                let slope = |i: usize| {
                    let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
                    (y[b] - y[a]) / (at[b] - at[a]).max(1e-9)
                };
                hermite(s, span, &[y[from], slope(from)], &[y[to], slope(to)])
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::grid::tests::record;
    use crate::fit::rig::rig;
    use crate::fit::simulate::predict_one;
    use crate::motor_file::MotorFile;
    use motorlens_shared::effects::Kind;

    /// A spring held at every reading would be driven on and on by what the readings lack of a count.
    #[test]
    fn readings_short_of_the_shaft_by_half_a_count_do_not_drive_a_spring_away() {
        let times: Vec<f64> = (0..4000).map(|k| f64::from(k) * 1e-3).collect();
        let volts: Vec<f64> = times.iter().map(|t| 3.0 + 2.0 * (2.0 * t).sin()).collect();
        let record = record(times, volts);
        let mut grid = Grid::new(&record, 0.01);
        let rig = rig(&[record], &MotorFile::default());
        let parameters = [1.0, 0.05, 1e-3, 0.1, 0.5, 0.0];
        let run = |grid: &Grid| predict_one(&[Kind::Spring], &parameters, &rig, grid);
        let shaft = run(&grid);
        grid.measured = shaft.iter().map(|x| x - 0.005).collect();
        let guided = run(&grid.clone().guided());
        let free: Vec<f64> = shaft.iter().step_by(2).copied().collect();
        let most = guided.iter().zip(&free).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(guided.len() == free.len() && most < 1e-9, "{most} rad apart");
    }

    /// Ten milliseconds under steps of voltage are no cubic: a cogging torque held to one would push where the shaft never was.
    #[test]
    fn between_samples_the_teeth_act_where_the_model_moves_them() {
        let times: Vec<f64> = (0..800).map(|k| f64::from(k) * 1e-2).collect();
        let volts = (0..800_u32).map(|k| if (k / 5 * 7919) % 13 < 6 { 8.0 } else { -8.0 }).collect();
        let record = record(times, volts);
        let motor = MotorFile { gear_ratio: Some(30.0), ..MotorFile::default() };
        let rig = rig(std::slice::from_ref(&record), &motor);
        let mut grid = Grid::new(&record, 0.01);
        let parameters = [2.5, 0.013, 7e-4, 0.05, 0.1, 0.2, 0.0, 0.0, 10.0];
        let run = |grid: &Grid| predict_one(&[Kind::Cogging], &parameters, &rig, grid);
        let shaft = run(&grid);
        grid.quantum = 1e-3;
        grid.measured = shaft.iter().map(|x| (x / grid.quantum).floor() * grid.quantum).collect();
        let guided = grid.clone().guided();
        let most = |grid: &Grid| run(grid).iter().zip(&shaft).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(most(&guided) < 2.0 * grid.quantum, "{} rad away", most(&guided));
        let everywhere = Grid { seen: vec![true; guided.seen.len()], ..guided };
        assert!(
            most(&everywhere) > 2.0 * grid.quantum,
            "{} rad away: the case no longer shows it",
            most(&everywhere)
        );
    }

    /// Slots a little weaker than the true ones hold a standing shaft as well, somewhere else in the same count: held at the
    /// count's edge instead, their torque would drive the model on for as long as the shaft stands.
    #[test]
    fn within_a_count_a_standing_shaft_comes_to_rest_where_the_model_balances() {
        let times: Vec<f64> = (0..10_000).map(|k| f64::from(k) * 1e-3).collect();
        let volts = times.iter().map(|t| 2.0 - (t - 5.0).abs() * 0.4).collect();
        let record = record(times, volts);
        let motor = MotorFile { gear_ratio: Some(30.0), ..MotorFile::default() };
        let rig = rig(std::slice::from_ref(&record), &motor);
        let mut grid = Grid::new(&record, 0.01);
        let run = |grid: &Grid, teeth: f64| {
            predict_one(&[Kind::Cogging], &[2.5, 0.013, 7e-4, 0.05, teeth, 0.0, 0.0, 0.0, 10.0], &rig, grid)
        };
        let shaft = run(&grid, 1.0);
        grid.quantum = 0.007;
        grid.measured = shaft.iter().map(|x| (x / grid.quantum).floor() * grid.quantum).collect();
        let guided = run(&grid.guided(), 0.9);
        let off: Vec<f64> = guided.iter().zip(shaft.iter().step_by(2)).map(|(a, b)| a - b).collect();
        let increments: Vec<f64> = off.windows(26).map(|w| (w[25] - w[0]).powi(2)).collect();
        let rms = (increments.iter().sum::<f64>() / increments.len() as f64).sqrt();
        assert!(rms < 0.012, "{rms} rad in 50 ms");
    }

    #[test]
    fn guided_runs_keep_the_samples_that_count_and_their_errors() {
        use crate::fit::cost::{Objective, residuals};
        use crate::fit::simulate::{Block, LANES};
        use motorlens_shared::lanes::Lanes;
        let times: Vec<f64> = (0..1500).map(|k| f64::from(k) * 1e-3).collect();
        let whole = Grid::new(&record(times, vec![1.0; 1500]), 0.01).rest(0.1);
        let thin = whole.clone().guided();
        assert_eq!(thin.len(), (whole.len() - whole.skip).div_ceil(2));
        assert_eq!(thin.guide.len(), thin.voltages.len());
        let left = |grid: &Grid| {
            let at = |t: &f64| Lanes([(7.0 * t).sin(); LANES]);
            let mut series: Vec<Block> = grid.time_s.iter().map(at).collect();
            residuals(grid, Objective::Increments, &mut series);
            series.iter().map(|r| r.0[0]).collect::<Vec<f64>>()
        };
        assert_eq!(left(&thin), left(&whole));
    }
}
