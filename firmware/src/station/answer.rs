//! Carries out the host's requests.

use super::{Line, Platform, Station, with, working};
use crate::Shared;
use crate::hardware::{Analog, Hardware};
use crate::log::LOG_LENGTH;
use crate::outbox::Outbox;
use motorlens_shared::effects::Kind;
use motorlens_shared::excitation::{MAX_SEGMENTS, Player, Programme, Segment};
use motorlens_shared::link::{
    Capabilities, Cause, FromBoard, Hello, NEWEST, OLDEST, Packet, Refusal, RunState, Setup, ToBoard, agree,
};
use motorlens_shared::quickfit::{self, FEWEST, KEPT, Request};

/// Progress of a fit is told every so many generations.
const PROGRESS_EVERY: u16 = 5;

impl Station {
    pub(super) fn answer<H: Hardware, P: Platform>(
        &mut self,
        packet: Packet<ToBoard>,
        line: &mut impl Line,
        control: &Shared<H>,
        platform: &mut P,
    ) {
        let id = packet.id;
        let done = |result: Result<(), Refusal>| match result {
            Ok(()) => FromBoard::Done,
            Err(refusal) => FromBoard::Refused(refusal),
        };
        let reply = match packet.message {
            ToBoard::Hello { oldest, newest } => {
                self.agreed = agree((oldest, newest), (OLDEST, NEWEST));
                // Another host counts its requests anew.
                self.fitted = None;
                let unique = platform.unique();
                FromBoard::Hello(Hello { oldest: OLDEST, newest: NEWEST, firmware: P::VERSION, unique })
            }
            _ if self.agreed.is_none() => FromBoard::Refused(Refusal::Version),
            ToBoard::Capabilities => FromBoard::Capabilities(capabilities::<H, P>(control)),
            ToBoard::EffectName { index } => match Kind::ALL.get(usize::from(index)) {
                Some(effect) => FromBoard::EffectName(effect.name().try_into().unwrap_or_default()),
                None => FromBoard::Refused(Refusal::NoSuchEffect),
            },
            ToBoard::Configure(setup) => done(configure(setup, control)),
            ToBoard::SetSegment { index, name, segment } => {
                self.name = name;
                done(self.set_segment(index, segment))
            }
            ToBoard::Start { run, segments } => done(self.start(run, segments, control, platform)),
            ToBoard::Stop => {
                with(control, |control| control.stop(Cause::Asked));
                FromBoard::Done
            }
            ToBoard::ReadLog { first, count } => {
                // Blocks under the request's number are the answer. When too many requests wait, the host asks again.
                self.stream.ask(id, first, count);
                return;
            }
            ToBoard::QuickFit(request) => return self.quick_fit(id, &request, line, control, platform),
            ToBoard::ReadResult => FromBoard::Fit(self.fit),
            ToBoard::Bootloader => {
                self.bootloader = platform.has_bootloader();
                with(control, |control| control.stop(Cause::Asked));
                done(if self.bootloader { Ok(()) } else { Err(Refusal::NoBootloader) })
            }
            ToBoard::KeepAlive => return,
            ToBoard::Status => {
                let mut status = with(control, |control| control.status());
                self.complete(&mut status);
                FromBoard::Status(status)
            }
        };
        // A full outbox loses the answer as a bad line would: the host asks again.
        self.outbox.post(id, reply, &mut working(control));
    }

    fn set_segment(&mut self, index: u8, segment: Segment) -> Result<(), Refusal> {
        let index = usize::from(index);
        if index == 0 {
            self.segments.clear();
        }
        if let Some(place) = self.segments.get_mut(index) {
            *place = segment;
        } else if index != self.segments.len() || self.segments.push(segment).is_err() {
            return Err(Refusal::SegmentOrder);
        }
        Ok(())
    }

    fn start<H: Hardware, P: Platform>(
        &mut self,
        run: u32,
        segments: u8,
        control: &Shared<H>,
        platform: &mut P,
    ) -> Result<(), Refusal> {
        let (status, setup, scaling, emergency) = with(control, |control| {
            (control.status(), control.setup(), control.scaling(), control.emergency())
        });
        if status.run == run && status.state != RunState::Idle {
            return Ok(());
        }
        if status.state == RunState::Running {
            return Err(Refusal::Running);
        }
        if emergency {
            return Err(Refusal::Emergency);
        }
        if self.segments.len() != usize::from(segments) {
            return Err(Refusal::SegmentOrder);
        }
        let programme = Programme { name: self.name.clone(), segments: self.segments.clone() };
        // A long crest to scan must not look like a program that hangs.
        let player = Player::with_progress(&programme, setup.rate_hz.into(), &mut || platform.alive())
            .map_err(Refusal::Programme)?;
        self.keeper.restart(scaling, setup.keep_every);
        self.stream.begin(run);
        (self.fit, self.fitted) = (None, None);
        with(control, |control| control.start(run, player));
        Ok(())
    }

    fn quick_fit<H: Hardware, P: Platform>(
        &mut self,
        id: u16,
        request: &Request,
        line: &mut impl Line,
        control: &Shared<H>,
        platform: &mut P,
    ) {
        let Self { keeper, outbox, fit, fitted, .. } = self;
        let post = |outbox: &mut Outbox, message| outbox.post(id, message, &mut working(control));
        if *fitted == Some((id, *request)) {
            post(outbox, FromBoard::Done);
            post(outbox, FromBoard::Fit(*fit));
            return;
        }
        let running = with(control, |control| control.status().state == RunState::Running);
        if running || keeper.samples().len() < FEWEST {
            let refusal = if running { Refusal::Running } else { Refusal::NothingToFit };
            post(outbox, FromBoard::Refused(refusal));
            return;
        }
        post(outbox, FromBoard::Done);
        *fitted = Some((id, *request));
        let now = || with(control, |control| control.now_us());
        let begin = now();
        let mut searched = None;
        let progress = |progress: quickfit::Progress| {
            if progress.generation == progress.generations {
                searched.get_or_insert_with(now);
            }
            if progress.generation.is_multiple_of(PROGRESS_EVERY) && outbox.has_room() {
                post(outbox, FromBoard::Progress(progress));
            }
            outbox.pump(line);
        };
        let found =
            quickfit::fit::<P::Arithmetic>(keeper.samples(), keeper.step_s(), request, progress, || {
                platform.alive()
            });
        let micros = now().wrapping_sub(begin);
        let micros_search = searched.map_or(0, |at| at.wrapping_sub(begin));
        *fit = found.map(|fit| quickfit::QuickFit { micros, micros_search, ..fit });
        post(outbox, FromBoard::Fit(*fit));
    }
}

fn configure<H: Hardware>(setup: Setup, control: &Shared<H>) -> Result<(), Refusal> {
    with(control, |control| {
        setup.check(LOG_LENGTH as u32, H::Analog::CONVERTER).map_err(Refusal::Setup)?;
        if control.status().state == RunState::Running {
            return Err(Refusal::Running);
        }
        control.configure(setup);
        Ok(())
    })
}

fn capabilities<H: Hardware, P: Platform>(control: &Shared<H>) -> Capabilities {
    let ((measures_supply, measures_current), scaling) =
        with(control, |control| (control.measures(), control.scaling()));
    Capabilities {
        effects: Kind::ALL.len() as u8,
        segments: MAX_SEGMENTS as u8,
        log_samples: LOG_LENGTH as u16,
        fit_samples: KEPT as u16,
        core_hz: P::CORE_HZ,
        pwm_hz: P::CORE_HZ / u32::from(scaling.pwm_top.max(1)),
        measures_supply,
        measures_current,
        scaling,
        converter: H::Analog::CONVERTER,
    }
}
