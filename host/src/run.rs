//! A model that runs: over a whole voltage, or step by step.

use motorlens_shared::effects::together::Several;
use motorlens_shared::simulator::{Motion, Simulator};
use motorlens_shared::step::State;

use crate::api::{Measured, check, laid_out};
use crate::error::Result;
use crate::fit::grid::Grid;
use crate::fit::simulate::predict_one;
use crate::model_file::Model;

impl Model {
    /// Base and effects as one list, in the order of the effects.
    fn plain(&self) -> Vec<f64> {
        let values = self.values();
        let base = [values.base.gain, values.base.tau_m, values.base.tau_e, values.base.viscous_share];
        base.into_iter().chain(values.effects.into_iter().flat_map(|(_, p)| p)).collect()
    }

    /// The angle that the sensor shows at every time, rad, from rest at `angle_rad`: what `compare` runs.
    ///
    /// `time_s` rises, in s; `voltage_v` is held from each time to the next, in V. Without the sensor's counting.
    ///
    /// # Errors
    /// Slices of different length, numbers that are not finite, times that do not rise.
    ///
    /// ```no_run
    /// let model = motorlens::Model::read("model.json".as_ref())?;
    /// let time: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-3).collect();
    /// let angle = model.simulate(&time, &[6.0; 1000], 0.0)?;
    /// println!("{} rad after a second of 6 V", angle[999]);
    /// # Ok::<(), motorlens::Error>(())
    /// ```
    pub fn simulate(&self, time_s: &[f64], voltage_v: &[f64], angle_rad: f64) -> Result<Vec<f64>> {
        check("voltage", &[("time_s", time_s), ("voltage_v", voltage_v)])?;
        if time_s.len() < 2 {
            return Ok(vec![angle_rad; time_s.len()]);
        }
        let shown = vec![angle_rad; time_s.len()];
        let record = laid_out("voltage", time_s, voltage_v, Measured::Angle(&shown));
        let grid = Grid::new(&record, self.rig.count_rad);
        let simulated = predict_one(&self.values().kinds(), &self.plain(), &self.rig(grid.step_s), &grid);
        if grid.len() == time_s.len() {
            return Ok(simulated);
        }
        // Times that are much closer together than a motor moves were thinned.
        Ok(time_s.iter().map(|t| between(&grid.time_s, &simulated, *t)).collect())
    }

    /// The model at rest at `angle_rad`, to be advanced in steps of `step_s` (s, at most 0.01).
    ///
    /// ```no_run
    /// let model = motorlens::Model::read("model.json".as_ref())?;
    /// let mut motor = model.start(1e-3, 0.0);
    /// while motor.time_s() < 1.0 {
    ///     let error = 1.0 - motor.angle_rad();
    ///     motor.step(20.0 * error);
    /// }
    /// # Ok::<(), motorlens::Error>(())
    /// ```
    pub fn start(&self, step_s: f64, angle_rad: f64) -> Running {
        let values = self.values();
        let effects = values.effects.iter().map(|(kind, p)| (*kind, p.as_slice()));
        let simulator = Simulator::new(&values.base.base(), effects, &self.rig(step_s));
        let motion = simulator.start(State::moving(0.0, 0.0, angle_rad));
        Running { simulator, motion, voltages: vec![0.0], step_s }
    }
}

/// Linearly between the neighbours of `t`.
fn between(times: &[f64], values: &[f64], t: f64) -> f64 {
    let after = times.partition_point(|x| *x < t).clamp(1, times.len() - 1);
    let part = ((t - times[after - 1]) / (times[after] - times[after - 1])).clamp(0.0, 1.0);
    values[after - 1] + part * (values[after] - values[after - 1])
}

/// A model on its way; see [`Model::start`].
#[derive(Debug, Clone)]
pub struct Running {
    simulator: Simulator<f64, Several<f64>>,
    motion: Motion<f64>,
    /// None before the start, then one a step: a late voltage looks back.
    voltages: Vec<f64>,
    step_s: f64,
}

impl Running {
    /// Advances by a step under `voltage_v`, V; returns what the sensor shows, rad.
    pub fn step(&mut self, voltage_v: f64) -> f64 {
        self.voltages.push(voltage_v);
        let cell = self.voltages.len() - 1;
        self.simulator.advance(&mut self.motion, &self.voltages, cell);
        self.angle_rad()
    }
    /// What the sensor shows, rad of the output shaft.
    pub fn angle_rad(&self) -> f64 {
        self.simulator.read(&self.motion)
    }
    /// Speed of the output shaft, rad/s.
    pub fn speed_rad_s(&self) -> f64 {
        self.motion.state.load_speed
    }
    /// Current times winding resistance, V.
    pub fn current_v(&self) -> f64 {
        self.motion.state.current
    }
    /// Time since the start, s.
    pub fn time_s(&self) -> f64 {
        (self.voltages.len() - 1) as f64 * self.step_s
    }
}
