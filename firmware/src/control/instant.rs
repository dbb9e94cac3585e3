//! The sampling interrupt: read, play, supervise, log, plan.
//!
//! The duty of each interval is worked out in the one before, so that it is there right after the count is read: the voltage changes
//! at the sampling instant and not when the programme's next value has been worked out. A sample is logged at the end of its
//! interval, when the means of supply and current over it are known.

use super::{Control, Next};
use crate::analog::Means;
use crate::hardware::{Analog, Hardware};
use crate::standing::Shaft;
use crate::supervisor::{Look, Watch};
use motorlens_shared::excitation::Player;
use motorlens_shared::link::{Cause, Reset, RunState, Sample};

impl<H: Hardware> Control<H> {
    /// An interrupt of the sampling timer, a sampling instant or one between two. Returns what the board must stop for good over: a main
    /// loop that hangs while the motor is driven.
    #[must_use]
    pub fn interrupt(&mut self, sampling: bool) -> Option<Reset> {
        if sampling {
            self.tick();
        } else {
            self.between();
        }
        // Last: what it takes is no part of the instant.
        let now = self.hardware.now_us();
        (self.state == RunState::Running && self.turns.hang(now)).then_some(Reset::Watchdog)
    }

    /// One sampling instant. To be called [`rate_hz`](motorlens_shared::link::Setup::rate_hz) times a second, run or no run.
    pub fn tick(&mut self) {
        let begin = self.hardware.cycles();
        self.sample();
        self.worst_cycles = self.worst_cycles.max(self.hardware.cycles().wrapping_sub(begin));
    }

    /// An interrupt between two sampling instants: what ends a run and cannot wait for the next one.
    pub fn between(&mut self) {
        if self.state != RunState::Running {
            // Where a run begins before the next interrupt, this is not of its time.
            let _ = self.hardware.analog().gather();
            return;
        }
        if self.hardware.emergency() {
            return self.stop(Cause::Emergency);
        }
        let recent = self.hardware.analog().gather();
        if self.is_pumped(&recent) {
            return self.stop(Cause::Supply);
        }
        let now = self.hardware.now_us();
        if let Some(cause) = self.watch(now, &recent) {
            self.stop(cause);
        }
    }

    /// Whether the supply since the last interrupt is above its bound. A braking motor charges the capacitors of a supply that cannot
    /// sink its current, which nothing but its end stops; a supply that sinks for some samples is a motor that starts.
    fn is_pumped(&self, recent: &Means) -> bool {
        let above = |supply_mv| supply_mv > self.setup.supply_mv && !self.setup.trusts(supply_mv);
        recent.supply_mv.is_some_and(above)
    }

    /// What the supervisor says at each interrupt, of the means since the last one.
    fn watch(&mut self, now: u32, recent: &Means) -> Option<Cause> {
        let (elapsed_us, silence_us) = (self.elapsed_us(now), now.wrapping_sub(self.heard_us));
        self.supervisor.watch(&self.setup, &Watch { elapsed_us, silence_us, current_ma: recent.current_ma })
    }

    /// Since the run's first sample, us.
    fn elapsed_us(&self, now: u32) -> u32 {
        self.origin_us.map_or(0, |origin| now.wrapping_sub(origin))
    }

    fn sample(&mut self) {
        // First, so that the instant of the count is the instant of the interrupt.
        let count = self.encoder.look(self.hardware.count());
        let now = self.hardware.now_us();
        self.ticks = self.ticks.wrapping_add(1);
        if self.state != RunState::Running {
            // What is converted while nothing runs belongs to no sample.
            let _ = self.hardware.analog().gather();
            let _ = self.hardware.analog().means();
            return;
        }
        if self.hardware.emergency() {
            return self.stop(Cause::Emergency);
        }
        let elapsed_us = self.elapsed_us(now);
        let duty = self.open.map_or(0, |sample| sample.duty);
        let on_time = self.origin_us.is_some() && !self.missed(elapsed_us);
        let applied = match self.planned {
            Some(Next::Duty(duty)) if on_time => Some(self.hardware.apply(self.setup.drive, duty)),
            _ => None,
        };
        // After the duty, for what it takes varies by a round of the converter. Here the interval ends: what comes of it may take its time.
        let recent = self.hardware.analog().gather();
        if self.is_pumped(&recent) {
            return self.stop(Cause::Supply);
        }
        let means = self.close();
        if let Some(cause) = self.watch(now, &recent) {
            return self.stop(cause);
        }
        let look = Look {
            elapsed_us,
            count,
            voltage_mv: i32::from(duty) * i32::from(self.supply_mv) / i32::from(self.top()),
            supply_good: means.supply_mv.is_none_or(|supply_mv| self.setup.trusts(supply_mv)),
        };
        if let Some(cause) = self.supervisor.check(&self.setup, &look) {
            return self.stop(cause);
        }
        if self.origin_us.is_none() {
            match self.wait.look(now, count) {
                Shaft::Still => {}
                Shaft::Awaited => return,
                Shaft::Turning => return self.stop(Cause::Turning),
            }
            self.origin_us = Some(now);
            self.plan();
        } else if !on_time {
            self.skip_missed(elapsed_us);
        }
        let applied = match (applied, self.planned) {
            (Some(applied), _) => applied,
            (None, Some(Next::Duty(duty))) => self.hardware.apply(self.setup.drive, duty),
            (None, _) => return self.stop(Cause::Finished),
        };
        let late_us = i64::from(elapsed_us) - self.due(self.log.next()) as i64;
        let late_us = late_us.clamp(i64::from(i16::MIN) + 1, i64::from(i16::MAX)) as i16;
        self.open = Some(Sample { duty: applied, count, supply_mv: self.supply_mv, current_ma: 0, late_us });
        self.plan();
    }

    /// Logs the sample whose interval ends, with the means over it, which are returned.
    fn close(&mut self) -> Means {
        let means = self.hardware.analog().means();
        // What is out of bounds is no supply: until the supervisor ends the run over it the stated one holds.
        let trusted = means.supply_mv.filter(|supply_mv| self.setup.trusts(*supply_mv));
        self.supply_mv = trusted.unwrap_or(self.setup.supply_mv);
        self.current_ma = means.current_ma.unwrap_or(0);
        self.push_open();
        means
    }

    pub(super) fn push_open(&mut self) {
        if let Some(sample) = self.open.take() {
            self.log.push(Sample { supply_mv: self.supply_mv, current_ma: self.current_ma, ..sample });
        }
    }

    /// Works out the next duty.
    fn plan(&mut self) {
        let top = self.top();
        let limit = i32::from(top) * i32::from(self.setup.duty_limit) / 1000;
        self.planned = Some(match self.player.as_mut().and_then(Player::next) {
            Some(volts) => {
                let duty = volts * 1000.0 / f32::from(self.supply_mv.max(1)) * f32::from(top);
                // `as` saturates, so any voltage ends within the limit.
                let duty = (if duty < 0.0 { duty - 0.5 } else { duty + 0.5 }) as i32;
                Next::Duty(duty.clamp(-limit, limit) as i16)
            }
            None => Next::End,
        });
    }

    /// Never zero: the interrupt has no division that could panic.
    fn top(&self) -> u16 {
        self.hardware.pwm_top().max(1)
    }

    /// When sample number `index` is due, us from the run's begin.
    fn due(&self, index: u32) -> u64 {
        u64::from(index) * 1_000_000 / u64::from(self.setup.rate_hz.max(1))
    }

    /// Whether the next sampling instant has gone by too, so that the planned duty comes too late.
    fn missed(&self, elapsed_us: u32) -> bool {
        let next = self.log.next() + u32::from(self.open.is_some());
        self.due(next + 1) <= u64::from(elapsed_us)
    }

    /// Marks the sampling instants that went by unused, and plans anew: the programme goes on with the clock, not with the samples.
    fn skip_missed(&mut self, elapsed_us: u32) {
        while self.due(self.log.next() + 1) <= u64::from(elapsed_us) {
            self.log.push(Sample::MISSED);
            self.plan();
        }
    }
}
