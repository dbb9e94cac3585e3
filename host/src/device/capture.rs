//! One run: set up, played, and its log brought home.

use super::{Captured, Collector, Exchange, Fault};
use motorlens_shared::excitation::Programme;
use motorlens_shared::link::{
    Capabilities, Cause, FromBoard, NEWEST, OLDEST, Reset, RunState, Sample, Scaling, Setup, Status, ToBoard,
};
use std::collections::VecDeque;
use std::time::Duration;

/// While a run goes on the board is taken for gone after this silence.
const PATIENCE: Duration = Duration::from_secs(15);
/// A run whose shaft still turns is begun again until it has been waited for so long. Between the runs of a series a pendulum or a spring
/// swings for longer than the board waits, and a shaft that is not at rest by then is more likely driven.
const ROLL_OUT: Duration = Duration::from_secs(60);
/// A board of before version 5 of the link waits for six seconds, and then begins a run although the shaft still turns. It is stopped before:
/// a second is more than a request takes on any line that carries a log.
const BEFORE_IT_BEGINS: Duration = Duration::from_secs(5);

/// How far a run has come, as far as the board was told and has answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// The board is told what is to be run.
    SettingUp,
    /// It was told to begin, for the first time at `since` and for the last at `asked`.
    Starting { since: Duration, asked: Duration },
    /// It has said that it began: from then on another run's number tells that it no longer has this one.
    Running { since: Duration, asked: Duration },
    /// It has waited for a shaft that turns, and was told to stop before it would begin the run in spite of it.
    Withheld { since: Duration },
    /// It was told to stop a run of which it had told.
    Stopping,
    /// It was told to stop before it had told anything of the run, which may never have begun.
    Cancelling,
}

/// The state of capturing one run.
pub struct Capture {
    exchange: Exchange,
    script: VecDeque<ToBoard>,
    setup: Setup,
    run: u32,
    capabilities: Option<Capabilities>,
    collector: Collector,
    status: Option<Status>,
    stage: Stage,
    /// Why the board started that no longer has the run.
    lost: Option<Reset>,
    heard: Duration,
    /// Segments of the programme, which the board holds once they are set.
    segments: u8,
    /// How long a shaft that turns is waited for, and whether the run was begun again for it.
    roll_out: Duration,
    again: bool,
    /// Whether this board begins a run although the shaft still turns.
    begins_turning: bool,
    outcome: Option<Result<Captured, Fault>>,
}

impl Capture {
    /// Prepares a run. Its number must differ from that of the board's last run.
    pub fn new(setup: Setup, programme: &Programme, run: u32) -> Self {
        let mut script = VecDeque::from([
            ToBoard::Hello { oldest: OLDEST, newest: NEWEST },
            ToBoard::Configure(setup),
            ToBoard::Capabilities,
        ]);
        for (index, segment) in (0..).zip(&programme.segments) {
            script.push_back(ToBoard::SetSegment {
                index,
                name: programme.name.clone(),
                segment: segment.clone(),
            });
        }
        let segments = programme.segments.len() as u8;
        script.push_back(ToBoard::Start { run, segments });
        Self {
            exchange: Exchange::default(),
            script,
            setup,
            run,
            capabilities: None,
            collector: Collector::new(run),
            status: None,
            stage: Stage::SettingUp,
            lost: None,
            heard: Duration::ZERO,
            segments,
            roll_out: Duration::ZERO,
            again: false,
            begins_turning: false,
            outcome: None,
        }
    }

    /// The same, begun again for up to a minute where the shaft still turns, each time under the number after the last.
    pub fn patient(self) -> Self {
        Self { roll_out: ROLL_OUT, ..self }
    }

    /// The board's number of the run, the last one where it was begun again.
    pub fn run(&self) -> u32 {
        self.run
    }

    /// Whether the run was begun again, because the shaft still turned, and has no samples yet.
    pub fn waits(&self) -> bool {
        self.again && self.collector.is_empty()
    }

    /// How the run is set up.
    pub fn setup(&self) -> Setup {
        self.setup
    }

    /// Samples heard of so far.
    pub fn samples(&self) -> usize {
        self.collector.len()
    }

    /// Samples from number `from` on that have come without a gap.
    pub fn samples_from(&self, from: usize) -> Vec<(u32, Sample)> {
        self.collector.samples_from(from)
    }

    /// What the raw numbers mean, once the board has told it for this setup.
    pub fn scaling(&self) -> Option<Scaling> {
        self.capabilities.as_ref().map(|capabilities| capabilities.scaling)
    }

    /// Whether the board measures current, as far as it has told.
    pub fn measures_current(&self) -> bool {
        self.capabilities.is_some_and(|capabilities| capabilities.measures_current)
    }

    /// Frames that arrived damaged.
    pub fn damaged(&self) -> u64 {
        self.exchange.damaged()
    }

    /// Has the board end the run: it is told at once, whatever else it is being asked, and until it answers. The log so far
    /// still comes; a run that has not begun does not begin, and is not waited for any longer.
    pub fn stop(&mut self, now: Duration) {
        self.script.clear();
        self.stage = match self.status {
            Some(_) if self.stage != Stage::Cancelling => Stage::Stopping,
            _ => Stage::Cancelling,
        };
        self.exchange.ask(ToBoard::Stop, now);
    }

    /// What came of the run until now, as if the link had been lost here; what was under way is a hole. `None` when
    /// nothing has come yet.
    pub fn so_far(&self) -> Option<Captured> {
        let (samples, holes) = self.collector.finish();
        let (Some(capabilities), Some(status), false) = (self.capabilities, self.status, samples.is_empty())
        else {
            return None;
        };
        let scaling = capabilities.scaling;
        let cause = Cause::LinkLoss;
        Some(Captured { cause, samples, holes, scaling, capabilities, setup: self.setup, status })
    }

    /// The end of it, once.
    pub fn take_outcome(&mut self) -> Option<Result<Captured, Fault>> {
        self.outcome.take()
    }

    /// Takes bytes from the board.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        for packet in self.exchange.receive(bytes) {
            self.heard = now;
            match packet.message {
                FromBoard::Log(block) => self.collector.block(&block),
                FromBoard::NotHeld { first, count } => self.collector.not_held(first, count),
                FromBoard::Status(status) if status.run == self.run => self.status = Some(status),
                // It had told of the run: a board that was without power begins with none.
                FromBoard::Status(status)
                    if self.status.is_some() || matches!(self.stage, Stage::Running { .. }) =>
                {
                    self.lost = Some(status.reset)
                }
                FromBoard::Capabilities(capabilities) => self.capabilities = Some(capabilities),
                // A board that has no word for a shaft that goes on turning begins the run all the same.
                FromBoard::Hello(hello) => {
                    self.begins_turning = Cause::Turning.told_to(hello.newest) != Cause::Turning;
                }
                _ => {}
            }
        }
    }

    /// Lets time pass, and hands over what is to be sent.
    pub fn poll(&mut self, now: Duration, out: &mut Vec<u8>) {
        let answer = self.exchange.take_answer();
        if let (Stage::Starting { since, asked }, Some(Ok(FromBoard::Done))) = (self.stage, &answer) {
            self.stage = Stage::Running { since, asked };
        }
        match answer {
            Some(Err(fault)) => self.refuse(fault),
            Some(Ok(FromBoard::Hello(hello))) if hello.newest < self.setup.since() => {
                // What an old board cannot read it would not answer, and what it skips it would not do.
                self.refuse(Fault::Version(hello.oldest, hello.newest));
            }
            Some(Ok(FromBoard::Capabilities(can))) if has_built_in_sensors(&can) => {
                self.refuse(Fault::BuiltInSensors);
            }
            Some(Ok(FromBoard::Done)) if self.stage == Stage::Cancelling && self.status.is_none() => {
                // The board has stopped what it did, and whether that was this run, its next word on it tells.
                self.exchange.ask(ToBoard::Status, now);
            }
            Some(Ok(FromBoard::Status(status)))
                if self.stage == Stage::Cancelling && status.run != self.run =>
            {
                self.outcome = Some(Err(Fault::Stopped));
            }
            Some(Ok(_)) | None if self.exchange.busy() => {}
            _ => match self.script.pop_front() {
                Some(message) => {
                    self.heard = now;
                    if matches!(message, ToBoard::Start { .. }) {
                        let since = if let Stage::Starting { since, .. } = self.stage { since } else { now };
                        self.stage = Stage::Starting { since, asked: now };
                    }
                    self.exchange.ask(message, now);
                }
                None => self.follow(now),
            },
        }
        self.exchange.poll(now, out);
    }

    /// Ends it by `fault`, and asks for nothing more: a run that is refused does not begin, however often it is polled.
    fn refuse(&mut self, fault: Fault) {
        self.script.clear();
        self.outcome = Some(Err(fault));
    }

    /// Has the run, waited for `since` then, begun under another number: under its own the board would take it for begun.
    fn begin_again(&mut self, since: Duration, now: Duration) {
        self.run = self.run.wrapping_add(1);
        self.again = true;
        (self.collector, self.status) = (Collector::new(self.run), None);
        self.stage = Stage::Starting { since, asked: now };
        self.script.push_back(ToBoard::Start { run: self.run, segments: self.segments });
    }

    /// Whether the board has waited for the shaft for so long that it would soon begin the run in spite of it.
    fn must_withhold(&self, status: &Status, now: Duration) -> bool {
        let (Stage::Starting { asked, .. } | Stage::Running { asked, .. }) = self.stage else { return false };
        let waits = status.next == 0 && self.collector.is_empty();
        self.begins_turning && waits && now.saturating_sub(asked) >= BEFORE_IT_BEGINS
    }

    /// The run goes on, or is over and its log still comes.
    fn follow(&mut self, now: Duration) {
        if now.saturating_sub(self.heard) > PATIENCE {
            self.outcome = Some(Err(Fault::Silent));
            return;
        }
        if let Some(reset) = self.lost {
            self.outcome = Some(Err(Fault::Forgotten(reset)));
            return;
        }
        let (is_stopped, since) = match self.stage {
            Stage::SettingUp => (false, now),
            Stage::Starting { since, .. } | Stage::Running { since, .. } | Stage::Withheld { since } => {
                (false, since)
            }
            Stage::Stopping | Stage::Cancelling => (true, now),
        };
        let ended = match self.status.map(|status| (status.state, status)) {
            Some((RunState::Stopped(cause), status)) => {
                let is_withheld = matches!(self.stage, Stage::Withheld { .. });
                let cause = if is_withheld && cause == Cause::Asked { Cause::Turning } else { cause };
                if cause == Cause::Turning && is_stopped {
                    // It would not have begun again in any case.
                    self.outcome = Some(Err(Fault::Stopped));
                    return;
                }
                if cause == Cause::Turning && now.saturating_sub(since) < self.roll_out {
                    self.begin_again(since, now);
                    return;
                }
                self.collector.expect(status.next);
                Some((cause, status))
            }
            Some((RunState::Running, status)) if self.must_withhold(&status, now) => {
                self.stage = Stage::Withheld { since };
                self.exchange.ask(ToBoard::Stop, now);
                return;
            }
            _ => None,
        };
        for (first, count) in self.collector.requests(now) {
            self.exchange.tell(ToBoard::ReadLog { first, count });
        }
        let (Some((cause, status)), true) = (ended, self.collector.is_complete()) else { return };
        let Some(capabilities) = self.capabilities else {
            self.outcome = Some(Err(Fault::Confused));
            return;
        };
        let (samples, holes) = self.collector.finish();
        let scaling = capabilities.scaling;
        self.outcome =
            Some(Ok(Captured { cause, samples, holes, scaling, capabilities, setup: self.setup, status }));
    }
}

/// Whether a board measures without having been told what is wired: the images of before version 4 of the link did.
fn has_built_in_sensors(can: &Capabilities) -> bool {
    !can.converter && (can.measures_supply || can.measures_current)
}

#[cfg(test)]
mod tests {
    use super::*;
    use motorlens_shared::excitation::Shape;
    use motorlens_shared::link::{Decoder, Hello, MAX_ENCODED, Packet, encode};

    /// A board of the link's third version says that it measures, and not that it could be told what is wired: its inputs may float.
    #[test]
    fn a_board_that_reads_inputs_which_may_float_is_not_run() {
        let programme = Programme::single("step", Shape::Step { level_v: 1.0 }, 1.0);
        let outcome = |measures: bool, converter: bool| {
            let mut capture = Capture::new(Setup::default(), &programme, 1);
            let (mut decoder, mut started) = (Decoder::new(), false);
            for turn in 1..20 {
                let (now, mut out) = (Duration::from_millis(10 * turn), Vec::new());
                capture.poll(now, &mut out);
                for asked in out.iter().filter_map(|byte| decoder.push::<Packet<ToBoard>>(*byte)) {
                    let asked = asked.expect("whole");
                    let message = match asked.message {
                        ToBoard::Hello { .. } => FromBoard::Hello(Hello {
                            oldest: 1,
                            newest: 3,
                            firmware: [0, 1, 0],
                            unique: [0; 12],
                        }),
                        ToBoard::Capabilities => FromBoard::Capabilities(Capabilities {
                            effects: 22,
                            segments: 16,
                            log_samples: 1024,
                            fit_samples: 2000,
                            core_hz: 84_000_000,
                            pwm_hz: 20_000,
                            measures_supply: measures,
                            measures_current: measures,
                            scaling: Scaling { pwm_top: 4200, rate_hz: 1000 },
                            converter,
                        }),
                        ToBoard::Start { .. } => {
                            started = true;
                            FromBoard::Done
                        }
                        _ => FromBoard::Done,
                    };
                    let mut frame = [0; MAX_ENCODED];
                    capture
                        .receive(encode(&Packet { id: asked.id, message }, &mut frame).expect("fits"), now);
                }
            }
            (started, capture.take_outcome())
        };
        let (started, refused) = outcome(true, false);
        assert!(!started && matches!(refused, Some(Err(Fault::BuiltInSensors))), "{refused:?}");
        assert!(outcome(true, true).0 && outcome(false, false).0);
    }
}
