//! A model that runs: over a whole voltage, or step by step.

use motorlens_shared::effects::Kind;
use motorlens_shared::effects::together::Several;
use motorlens_shared::simulator::{Motion, Simulator};
use motorlens_shared::step::State;

use crate::api::{Measured, check, laid_out};
use crate::error::{Error, Result};
use crate::fit::grid::Grid;
use crate::fit::simulate::predict_one;
use crate::fit::start::held;
use crate::model_file::Model;

impl Model {
    /// Base and effects as one list, in the order of the effects.
    fn plain(&self) -> Vec<f64> {
        let values = self.values();
        let base = [values.base.gain, values.base.tau_m, values.base.tau_e, values.base.viscous_share];
        base.into_iter().chain(values.effects.into_iter().flat_map(|(_, p)| p)).collect()
    }

    /// The angle that the sensor shows at every time, rad, from rest at `angle_rad`.
    ///
    /// `compare` runs the same, but begins a record that is in motion at a speed that it finds for the model, and moves an angle within
    /// a count of the encoder.
    ///
    /// `time_s` rises, in s; `voltage_v` is held from each time to the next, in V. Without the sensor's counting.
    ///
    /// # Errors
    /// Slices of different length, numbers that are not finite, times that do not rise.
    ///
    /// ```
    /// # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json");
    /// let model = motorlens::Model::read(path.as_ref())?;
    /// let time: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-3).collect();
    /// let angle = model.simulate(&time, &[6.0; 1000], 0.0)?;
    /// println!("{} rad after a second of 6 V", angle[999]);
    /// assert!((4.0..5.0).contains(&angle[999]));
    /// # Ok::<(), motorlens::Error>(())
    /// ```
    pub fn simulate(&self, time_s: &[f64], voltage_v: &[f64], angle_rad: f64) -> Result<Vec<f64>> {
        self.simulate_moving(time_s, voltage_v, angle_rad, 0.0)
    }

    /// The same from `angle_rad` in motion, at `speed_rad_s`: that of [`crate::compare::free_run::FreeRun`] gives the run of `compare`.
    ///
    /// The motor is taken to have turned so for a while: its current, and a voltage that acts late, are those that hold the speed.
    ///
    /// # Errors
    /// As [`Model::simulate`]; a speed that is not finite.
    ///
    /// ```
    /// # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json");
    /// let model = motorlens::Model::read(path.as_ref())?;
    /// let time: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-3).collect();
    /// let coasting = model.simulate_moving(&time, &[0.0; 1000], 0.5, 3.0)?;
    /// assert!(coasting[0] == 0.5 && coasting[999] > 0.51);
    /// # Ok::<(), motorlens::Error>(())
    /// ```
    pub fn simulate_moving(
        &self,
        time_s: &[f64],
        voltage_v: &[f64],
        angle_rad: f64,
        speed_rad_s: f64,
    ) -> Result<Vec<f64>> {
        if !(angle_rad.is_finite() && speed_rad_s.is_finite()) {
            return Err(Error::usage(
                format!("a run cannot begin at {angle_rad} rad with {speed_rad_s} rad/s"),
                "give a first angle and a first speed that are numbers",
            ));
        }
        check("voltage", &[("time_s", time_s), ("voltage_v", voltage_v)])?;
        if time_s.len() < 2 {
            return Ok(vec![angle_rad; time_s.len()]);
        }
        let shown = vec![angle_rad; time_s.len()];
        let record = laid_out("voltage", time_s, voltage_v, Measured::Angle(&shown));
        let mut grid = Grid::new(&record, self.rig.count_rad);
        grid.begin_at(speed_rad_s, held(&self.rig(grid.step_s), speed_rad_s));
        let simulated = predict_one(&self.values().kinds(), &self.plain(), &self.rig(grid.step_s), &grid);
        if grid.len() == time_s.len() {
            return Ok(simulated);
        }
        // Times that are much closer together than a motor moves were thinned.
        Ok(time_s.iter().map(|t| between(&grid.time_s, &simulated, *t)).collect())
    }

    /// The model at rest at `angle_rad`, to be advanced in steps of `step_s` (s, at most 0.01).
    ///
    /// ```
    /// # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json");
    /// let model = motorlens::Model::read(path.as_ref())?;
    /// let mut motor = model.start(1e-3, 0.0);
    /// while motor.time_s() < 1.0 {
    ///     let error = 1.0 - motor.angle_rad();
    ///     motor.step(20.0 * error);
    /// }
    /// assert!((motor.angle_rad() - 1.0).abs() < 0.05);
    /// # Ok::<(), motorlens::Error>(())
    /// ```
    pub fn start(&self, step_s: f64, angle_rad: f64) -> Running {
        self.start_moving(step_s, angle_rad, 0.0)
    }

    /// The same in motion, at `speed_rad_s`; see [`Model::simulate_moving`].
    pub fn start_moving(&self, step_s: f64, angle_rad: f64, speed_rad_s: f64) -> Running {
        let values = self.values();
        let effects = values.effects.iter().map(|(kind, p)| (*kind, p.as_slice()));
        let (base, rig) = (values.base.base(), self.rig(step_s));
        let simulator = Simulator::new(&base, effects, &rig);
        let before = if speed_rad_s == 0.0 { 0.0 } else { held(&rig, speed_rad_s) };
        let current = before - base.back_emf() * speed_rad_s;
        let motion = simulator.start(State::moving(current, speed_rad_s, angle_rad));
        Running {
            simulator,
            motion,
            voltages: vec![before],
            steps: 0,
            keep: self.steps_looked_back(step_s),
            step_s,
        }
    }

    /// How many voltages before the present one a step may need; none where a user's formula counts all steps.
    fn steps_looked_back(&self, step_s: f64) -> Option<usize> {
        if self.effects.iter().any(|e| matches!(e.effect, Kind::Formula(_))) {
            return None;
        }
        let delay = self.effects.iter().find(|e| e.effect == Kind::Delay);
        let late_s = delay.and_then(|e| e.parameters.first()).map_or(0.0, |p| p.value.max(0.0));
        Some((late_s / step_s).ceil() as usize + 2)
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
    /// What was held before the start, then one a step: a late voltage looks back. The oldest go once nothing looks back so far.
    voltages: Vec<f64>,
    /// Taken so far.
    steps: u64,
    /// Voltages that are kept, where not all are.
    keep: Option<usize>,
    step_s: f64,
}

impl Running {
    /// Advances by a step under `voltage_v`, V; returns what the sensor shows, rad.
    pub fn step(&mut self, voltage_v: f64) -> f64 {
        // Seldom, and many at once: a controller may run for days.
        if let Some(keep) = self.keep
            && self.voltages.len() >= 2 * keep + 64
        {
            self.voltages.drain(..self.voltages.len() - keep);
        }
        self.steps += 1;
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
        self.steps as f64 * self.step_s
    }
}

#[cfg(test)]
mod tests {
    use motorlens_shared::effects::{Kind, Rig};

    use crate::fit::layout::{BaseValues, Prior, Values};
    use crate::model_file::{Model, Origin};

    /// A motor whose voltage acts 6.3 ms late.
    fn late() -> Model {
        let rig = Rig {
            step_s: 1e-3,
            gear_ratio: 30.0,
            encoder_on_motor: true,
            nominal_v: 12.0,
            supply_v: 12.0,
            reference_speed: 11.0,
            count_rad: 1e-3,
        };
        let base = BaseValues { gain: 0.9, tau_m: 0.05, tau_e: 6e-4, viscous_share: 0.1 };
        let values = Values { base, effects: vec![(Kind::Delay, vec![0.0063]), (Kind::Coulomb, vec![0.2])] };
        let prior = Prior { tau_e: (5e-4, 0.4), viscous_share: (0.08, 0.05) };
        Model::new(&values, &rig, &prior, Origin::default())
    }

    #[test]
    fn a_model_that_runs_for_long_keeps_few_voltages_and_every_bit_of_its_motion() {
        let mut motor = late().start(1e-3, 0.0);
        let mut whole = motor.clone();
        whole.keep = None;
        for k in 0..20_000_u32 {
            let volts = 9.0 * (f64::from(k) * 0.013).sin();
            assert_eq!(motor.step(volts).to_bits(), whole.step(volts).to_bits(), "step {k}");
        }
        assert!(motor.voltages.capacity() < 1000, "{}", motor.voltages.capacity());
        assert_eq!((motor.time_s(), whole.voltages.len()), (whole.time_s(), 20_001));
    }
}
