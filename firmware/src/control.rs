//! The sampling interrupt: read, supervise, play, log.

use crate::encoder::Extended;
use crate::hardware::{Analog, Hardware};
use crate::log::Log;
use crate::supervisor::{Look, Supervisor};
use motorlens_shared::excitation::Player;
use motorlens_shared::link::{Cause, Reset, RunState, Sample, Scaling, Setup, Status};

/// A run begins when the motor has stood still for so long, or has been waited for so long, us. The encoder's count goes
/// on from run to run, so that what depends on the shaft's position is the same in all of them.
const STANDING_US: u32 = 100_000;
const PATIENCE_US: u32 = 6_000_000;
/// Counts within which it stands.
const STANDING_COUNTS: u32 = 2;

/// Waiting for the motor to stand still.
#[derive(Debug, Clone, Copy)]
struct Wait {
    began_us: u32,
    count: i32,
    since_us: u32,
}

impl Wait {
    /// Whether the wait is over.
    fn look(&mut self, now: u32, count: i32) -> bool {
        if count.abs_diff(self.count) > STANDING_COUNTS {
            (self.count, self.since_us) = (count, now);
        }
        now.wrapping_sub(self.since_us) >= STANDING_US || now.wrapping_sub(self.began_us) >= PATIENCE_US
    }
}

/// The control of one motor.
pub struct Control<H: 'static> {
    hardware: H,
    log: &'static mut Log,
    setup: Setup,
    state: RunState,
    reset: Reset,
    player: Option<Player>,
    encoder: Extended,
    supervisor: Supervisor,
    wait: Wait,
    origin_us: Option<u32>,
    heard_us: u32,
    duty: i16,
    ticks: u32,
    worst_cycles: u32,
}

impl<H: Hardware> Control<H> {
    /// Takes the hardware, with the bridge off, and what an earlier start may have left in the log.
    pub fn new(mut hardware: H, log: &'static mut Log, reset: Reset) -> Self {
        hardware.release();
        let setup = Setup::default();
        hardware.set_rate(setup.rate_hz, setup.pwm_hz());
        let cut_short = log.recover(reset.lost_control());
        let state = if cut_short { RunState::Stopped(Cause::Watchdog) } else { RunState::Idle };
        Self {
            hardware,
            log,
            setup,
            state,
            reset,
            player: None,
            encoder: Extended::default(),
            supervisor: Supervisor::default(),
            wait: Wait { began_us: 0, count: 0, since_us: 0 },
            origin_us: None,
            heard_us: 0,
            duty: 0,
            ticks: 0,
            worst_cycles: 0,
        }
    }

    /// One sampling instant. To be called [`Setup::rate_hz`] times a second, run or no run.
    pub fn tick(&mut self) {
        let begin = self.hardware.cycles();
        self.sample();
        self.worst_cycles = self.worst_cycles.max(self.hardware.cycles().wrapping_sub(begin));
    }

    fn sample(&mut self) {
        // First, so that the instant of the count is the instant of the interrupt.
        let count = self.encoder.look(self.hardware.count());
        let now = self.hardware.now_us();
        self.ticks = self.ticks.wrapping_add(1);
        if self.state != RunState::Running {
            return;
        }
        let elapsed_us = self.origin_us.map_or(0, |origin| now.wrapping_sub(origin));
        let analog = self.hardware.analog();
        let measured_mv = analog.supply_mv();
        let supply_good = measured_mv.is_none_or(|supply_mv| self.setup.trusts(supply_mv));
        // What is out of bounds is no supply: until the supervisor ends the run over it the stated one holds.
        let supply_mv = measured_mv.filter(|_| supply_good).unwrap_or(self.setup.supply_mv);
        let current_ma = analog.current_ma();
        // Never zero, and the interrupt has no division that could panic.
        let top = self.hardware.pwm_top().max(1);
        let look = Look {
            elapsed_us,
            silence_us: now.wrapping_sub(self.heard_us),
            count,
            voltage_mv: i32::from(self.duty) * i32::from(supply_mv) / i32::from(top),
            supply_good,
            current_ma,
            emergency: self.hardware.emergency(),
        };
        if let Some(cause) = self.supervisor.check(&self.setup, &look) {
            return self.stop(cause);
        }
        if self.origin_us.is_none() {
            if !self.wait.look(now, count) {
                return;
            }
            self.origin_us = Some(now);
        }
        let late_us = self.skip_missed(elapsed_us);
        let Some(volts) = self.player.as_mut().and_then(Player::next) else {
            return self.stop(Cause::Finished);
        };
        let limit = i32::from(top) * i32::from(self.setup.duty_limit) / 1000;
        let duty = volts * 1000.0 / f32::from(supply_mv.max(1)) * f32::from(top);
        // `as` saturates, so any voltage ends within the limit.
        let duty = ((if duty < 0.0 { duty - 0.5 } else { duty + 0.5 }) as i32).clamp(-limit, limit);
        self.duty = self.hardware.apply(self.setup.drive, duty as i16);
        let current_ma = current_ma.unwrap_or(0);
        self.log.push(Sample { duty: self.duty, count, supply_mv, current_ma, late_us });
    }

    /// Marks the sampling instants that went by unused, and says how late this one is, us.
    fn skip_missed(&mut self, elapsed_us: u32) -> i16 {
        let rate = u64::from(self.setup.rate_hz.max(1));
        let due = |index: u32| u64::from(index) * 1_000_000 / rate;
        while due(self.log.next() + 1) <= u64::from(elapsed_us) {
            self.log.push(Sample::MISSED);
            // The programme goes on with the clock, not with the samples.
            if let Some(player) = &mut self.player {
                player.next();
            }
        }
        let late = i64::from(elapsed_us) - due(self.log.next()) as i64;
        late.clamp(i64::from(i16::MIN) + 1, i64::from(i16::MAX)) as i16
    }

    /// Begins a run of `player` with the present setup, once the motor stands still; it waits with the bridge off.
    pub fn start(&mut self, run: u32, player: Player) {
        self.log.begin(run, self.scaling());
        self.player = Some(player);
        self.supervisor = Supervisor::default();
        let now = self.hardware.now_us();
        let count = self.encoder.look(self.hardware.count());
        self.wait = Wait { began_us: now, count, since_us: now };
        self.heard_us = now;
        (self.origin_us, self.duty) = (None, 0);
        self.state = RunState::Running;
    }

    /// Takes the bridge off. A run that is under way ends with this cause; the log stays.
    pub fn stop(&mut self, cause: Cause) {
        self.hardware.release();
        self.duty = 0;
        if self.state == RunState::Running {
            self.state = RunState::Stopped(cause);
            self.player = None;
            self.log.end();
        }
    }

    /// Takes another setup. Only while nothing runs; the caller has checked it.
    pub fn configure(&mut self, setup: Setup) {
        self.setup = setup;
        self.hardware.set_rate(setup.rate_hz, setup.pwm_hz());
    }

    /// The host was heard.
    pub fn heard(&mut self) {
        self.heard_us = self.hardware.now_us();
    }

    /// What the control is doing, and what the log holds.
    pub fn status(&self) -> Status {
        Status {
            state: self.state,
            run: self.log.run(),
            oldest: self.log.oldest(),
            next: self.log.next(),
            missed: self.log.missed(),
            kept: 0,
            damaged: 0,
            reset: self.reset,
            worst_cycles: self.worst_cycles,
        }
    }

    /// What the raw numbers of a run begun now would mean.
    pub fn scaling(&self) -> Scaling {
        Scaling { pwm_top: self.hardware.pwm_top(), rate_hz: self.setup.rate_hz }
    }

    /// The present setup.
    pub fn setup(&self) -> Setup {
        self.setup
    }

    /// The log.
    pub fn log(&self) -> &Log {
        self.log
    }

    /// Sampling instants since the start: when this stands still, the interrupt is dead.
    pub fn ticks(&self) -> u32 {
        self.ticks
    }

    /// Whether the emergency input is open.
    pub fn emergency(&mut self) -> bool {
        self.hardware.emergency()
    }

    /// Whether supply and current are measured.
    pub fn measures(&self) -> (bool, bool) {
        (H::Analog::SUPPLY, H::Analog::CURRENT)
    }

    /// The hardware, for what only the board knows of it.
    pub fn hardware_mut(&mut self) -> &mut H {
        &mut self.hardware
    }

    /// The clock, us.
    pub fn now_us(&mut self) -> u32 {
        self.hardware.now_us()
    }
}
