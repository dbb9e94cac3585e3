//! A bridge that coasts, pulse by pulse: what it brings in every cell beyond the mean of a PWM period.
//!
//! Where the period is not much shorter than what follows it, a jump of the command finds the PWM anywhere in its period, and what
//! it makes of the jump depends on where. The laws of the three states are those of [`motorlens_shared::effects::Coast`].

use motorlens_shared::base::Base;
use motorlens_shared::effects::{Active, Coast, DIODES_V, Effect, Kind, Memory, Now, Rig, Setting};
use motorlens_shared::step::{Drive, State};

use crate::fit::grid::Grid;
use crate::fit::layout::Values;

/// A bridge that coasts, at work on one record.
pub(super) struct Bridge {
    coast: Coast<f64>,
    share: f64,
    supply_v: f64,
    /// The current's time constant, in periods of the PWM.
    rise: f64,
    step_s: f64,
    /// What the PWM is told in every cell, by the log's clock, V; the first was held before the start.
    commands: Vec<f64>,
    /// So long after the log, s.
    late_s: f64,
    /// Back-EMF at the start and at the end of every cell, V.
    emf: Vec<f64>,
    /// Mean voltage that the law gives every cell, V.
    laws: Vec<f64>,
    /// How much more it gives for a back-EMF that is higher by one volt.
    pub(super) slopes: Vec<f64>,
}

/// A period of the PWM: driven with so many `volts` to the share `driven`, shorted to `braked`, floating to its end.
struct Pulse {
    volts: f64,
    driven: f64,
    braked: f64,
}

impl Bridge {
    /// The bridge of `values`, whose rotor turns at `speeds` (rad/s, at the start and at the end of every cell of `grid`); none
    /// without one.
    pub(super) fn new(values: &Values, rig: &Rig, grid: &Grid, speeds: &[f64]) -> Option<Self> {
        let of = |kind: Kind| values.effects.iter().find(|(k, _)| *k == kind).map(|(_, p)| p);
        let [share, frequency] = of(Kind::Coast)?[..] else { return None };
        let base: Base<f64> = values.base.base();
        let setting = Setting::new(&base, &Rig { step_s: grid.step_s, ..*rig }, 1);
        let dead = of(Kind::DeadZone).map(|p| Active::new(Kind::DeadZone, p, &setting));
        let told = |v: &f64| {
            let mut drive = Drive::plain(*v);
            if let Some(dead) = &dead {
                let now = Now { command: *v, state: State::rest(), voltages: &[], index: 0, pulses: 0.0 };
                dead.drive(&now, &Memory::empty(0.0), &mut drive);
            }
            drive.voltage
        };
        let mut bridge = Self {
            coast: Coast::new(&[share, frequency], &setting),
            share,
            supply_v: rig.supply_v,
            rise: base.tau_e * frequency,
            step_s: grid.step_s,
            commands: grid.voltages.iter().map(told).collect(),
            late_s: of(Kind::Delay).map_or(0.0, |p| p[0]),
            emf: speeds.iter().map(|w| w * base.back_emf()).collect(),
            laws: Vec::new(),
            slopes: Vec::new(),
        };
        bridge.laws = (0..bridge.cells()).map(|n| bridge.law(n, bridge.emf(n))).collect();
        bridge.slopes = (0..bridge.cells()).map(|n| bridge.slope(n)).collect();
        Some(bridge)
    }

    pub(super) fn cells(&self) -> usize {
        self.emf.len() - 1
    }

    /// Mean back-EMF of cell `n`, from 0, V.
    fn emf(&self, n: usize) -> f64 {
        0.5 * (self.emf[n] + self.emf[n + 1])
    }

    /// Mean of what it is told in cell `n`, from 0, V.
    fn mean_command(&self, n: usize) -> f64 {
        let late = self.late_s / self.step_s;
        let (whole, part) = (late.floor(), late.fract());
        let at = |back: f64| {
            self.commands[((n as f64 + 1.0 - back).max(0.0) as usize).min(self.commands.len() - 1)]
        };
        at(whole) * (1.0 - part) + at(whole + 1.0) * part
    }

    /// Mean voltage that the law gives cell `n` against `emf`, V.
    fn law(&self, n: usize, emf: f64) -> f64 {
        let command = self.mean_command(n);
        let way = 1.0_f64.copysign(command);
        way * self.coast.mean(way * command, way * emf)
    }

    fn slope(&self, n: usize) -> f64 {
        let delta = 0.01 * self.supply_v;
        let emf = self.emf(n);
        (self.law(n, emf + delta) - self.law(n, emf - delta)) / (2.0 * delta)
    }

    /// A period of `command`.
    fn pulse(&self, command: f64) -> Pulse {
        let driven = (command.abs() / self.supply_v).min(1.0);
        Pulse {
            volts: self.supply_v.copysign(command),
            driven,
            braked: driven + (1.0 - driven) * (1.0 - self.share),
        }
    }

    /// What the pulses of `frequency`, Hz, that stand at `phase` of a period when the record begins bring in every cell beyond the
    /// law's mean, V; one number before the first.
    pub(super) fn beyond(&self, frequency: f64, phase: f64) -> Vec<f64> {
        let (h, period, tau_e) = (self.step_s, 1.0 / frequency, self.rise / frequency);
        // Edges that are nearer than this are one.
        let moment = 1e-6 * h;
        // The cell whose command acts now, and when the next does.
        let mut told = -((self.late_s / h).ceil() as isize) + 1;
        let mut next_told = self.late_s + told as f64 * h;
        let command = |told: isize| self.commands[(told.max(0) as usize).min(self.commands.len() - 1)];
        let mut pulse = self.pulse(command(told));
        let mut began = -phase.rem_euclid(1.0) * period;
        let (mut now, mut current) = (0.0, 0.0);
        let mut beyond: Vec<f64> = Vec::with_capacity(self.cells() + 1);
        beyond.push(0.0);
        for (n, law) in self.laws.iter().enumerate() {
            let (end, emf) = ((n as f64 + 1.0) * h, self.emf(n));
            let mut sum = 0.0;
            while now < end - moment {
                if now > next_told - moment {
                    told += 1;
                    next_told += h;
                    pulse = self.pulse(command(told));
                }
                if now > began + period - moment {
                    began += period;
                }
                let (volts, edge) = match now - began + moment {
                    t if t < pulse.driven * period => (pulse.volts, pulse.driven),
                    t if t < pulse.braked * period => (0.0, pulse.braked),
                    _ if current == 0.0 => (emf, 1.0),
                    _ => (-(self.supply_v + DIODES_V).copysign(current), 1.0),
                };
                let floats = edge == 1.0 && pulse.braked < 1.0;
                let until = (began + edge * period).min(end).min(next_told);
                let span = until - now;
                now = until;
                let target = volts - emf;
                let left = target + (current - target) * (-span / tau_e).exp();
                if floats && (current == 0.0 || left * current <= 0.0) {
                    // The diodes let nothing through the other way.
                    let over = if current == 0.0 { 0.0 } else { tau_e * (-current / target).ln_1p() };
                    sum += volts * over + emf * (span - over);
                    current = 0.0;
                } else {
                    sum += volts * span;
                    current = left;
                }
            }
            beyond.push(sum / h - law);
        }
        beyond
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::grid::tests::record;
    use crate::fit::layout::BaseValues;

    const RIG: Rig = Rig {
        step_s: 1e-3,
        gear_ratio: 30.0,
        encoder_on_motor: true,
        nominal_v: 12.0,
        supply_v: 12.0,
        reference_speed: 12.0,
        count_rad: 1e-3,
    };

    fn values(frequency: f64, late_s: f64) -> Values {
        Values {
            base: BaseValues { gain: 1.0, tau_m: 0.05, tau_e: 8e-4, viscous_share: 0.1 },
            effects: vec![(Kind::Delay, vec![late_s]), (Kind::Coast, vec![0.7, frequency])],
        }
    }

    /// A grid of 2 s under steps of voltage.
    fn grid() -> Grid {
        let times: Vec<f64> = (0..2000).map(|k| f64::from(k) * 1e-3).collect();
        let volts = (0..2000).map(|k| if k / 50 % 3 == 1 { -7.0 } else { 4.0 }).collect();
        Grid::new(&record(times, volts), 0.01)
    }

    fn rms(x: &[f64]) -> f64 {
        (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt()
    }

    /// Over all phases a period's mean is what the law says.
    #[test]
    fn over_all_phases_pulses_bring_nothing_beyond_the_mean() {
        let grid = grid();
        let speeds = vec![1.5; 2001];
        for frequency in [180.0, 437.0, 800.0] {
            let values = values(frequency, 0.0);
            let bridge = Bridge::new(&values, &RIG, &grid, &speeds).expect("it coasts");
            let all: Vec<Vec<f64>> = (0..40).map(|k| bridge.beyond(frequency, f64::from(k) / 40.0)).collect();
            // Cells in which the command has been the same for a while.
            let settled = (1..2000).filter(|n| n % 50 > 30);
            let mean = |n: usize| all.iter().map(|beyond| beyond[n]).sum::<f64>() / 40.0;
            let means: Vec<f64> = settled.map(mean).collect();
            assert!(rms(&means) < 0.05, "{frequency} Hz: {} V", rms(&means));
            assert!(rms(&all[0]) > 1.0, "{} V: the pulses are not small", rms(&all[0]));
        }
    }

    #[test]
    fn a_delay_of_whole_periods_shifts_the_pulses_with_the_commands() {
        let grid = grid();
        let speeds = vec![1.5; 2001];
        // Four periods and ten cells are the same time.
        let of = |late_s: f64| {
            let values = values(400.0, late_s);
            Bridge::new(&values, &RIG, &grid, &speeds).expect("it coasts").beyond(400.0, 0.3)
        };
        let (prompt, late) = (of(0.0), of(0.01));
        let apart: Vec<f64> = prompt[100..1900].iter().zip(&late[110..1910]).map(|(a, b)| a - b).collect();
        assert!(rms(&apart) < 1e-6, "{} V", rms(&apart));
    }
}
