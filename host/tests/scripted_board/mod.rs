//! A board that is nothing but its answers: of any version of the link, with a shaft that something else turns.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use motorlens_shared::link::{
    Capabilities, Cause, Decoder, FromBoard, Hello, LOG_SAMPLES, LogBlock, MAX_ENCODED, Packet, Refusal,
    Reset, RunState, Sample, Scaling, Status, ToBoard, encode,
};

/// Samples of a run, all there as soon as it begins.
pub const SAMPLES: u32 = 5 * LOG_SAMPLES as u32;
/// Of these versions a board begins a run that it has waited with for long; from the next one on it ends it.
pub const BEGINS_TURNING: std::ops::RangeInclusive<u16> = 1..=4;
/// How often it says how things stand.
const STATUS: Duration = Duration::from_millis(100);

#[derive(Clone, Copy)]
enum Doing {
    Nothing,
    /// Waits for the shaft, since then.
    Waits(Duration),
    /// Drives the motor, since then.
    Runs(Duration),
}

/// The board.
pub struct Board {
    /// The newest version of the link that it speaks.
    newest: u16,
    /// How long it waits for the shaft, until when that turns, and how long a run takes.
    patience: Duration,
    turns_until: Duration,
    takes: Duration,
    /// How often it was asked for these.
    pub starts: u32,
    pub stops: u32,
    /// Whether a run has begun although the shaft turned.
    pub begun_turning: bool,
    decoder: Decoder,
    doing: Doing,
    status: Status,
    told: Duration,
}

impl Board {
    /// A board whose shaft turns until then, and that waits for it for as long as every board does; its runs are over at once.
    pub fn new(newest: u16, turns_until: Duration) -> Self {
        let status = Status {
            state: RunState::Idle,
            run: 0,
            oldest: 0,
            next: 0,
            missed: 0,
            kept: 0,
            damaged: 0,
            reset: Reset::PowerOn,
            worst_cycles: 0,
        };
        Self {
            newest,
            patience: Duration::from_secs(6),
            turns_until,
            takes: Duration::ZERO,
            starts: 0,
            stops: 0,
            begun_turning: false,
            decoder: Decoder::new(),
            doing: Doing::Nothing,
            status,
            told: Duration::ZERO,
        }
    }

    /// The same, waiting for so long.
    pub fn waiting_for(self, patience: Duration) -> Self {
        Self { patience, ..self }
    }

    /// The same, whose runs take so long.
    pub fn running_for(self, takes: Duration) -> Self {
        Self { takes, ..self }
    }

    /// Takes what the host has sent, lets time pass, and says what there is to say.
    pub fn turn(&mut self, now: Duration, received: &[u8]) -> Vec<u8> {
        let mut said = Vec::new();
        for byte in received {
            if let Some(Ok(packet)) = self.decoder.push::<Packet<ToBoard>>(*byte) {
                self.answer(&packet, now, &mut said);
            }
        }
        self.go_on(now, &mut said);
        if now.saturating_sub(self.told) >= STATUS {
            self.told = now;
            say(0, FromBoard::Status(self.status), &mut said);
        }
        said
    }

    fn answer(&mut self, packet: &Packet<ToBoard>, now: Duration, said: &mut Vec<u8>) {
        let message = match &packet.message {
            ToBoard::KeepAlive => return,
            ToBoard::Hello { .. } => FromBoard::Hello(Hello {
                oldest: 1,
                newest: self.newest,
                firmware: [0, 1, 0],
                unique: [0; 12],
            }),
            ToBoard::Capabilities => FromBoard::Capabilities(capabilities()),
            ToBoard::Configure(_) | ToBoard::SetSegment { .. } => FromBoard::Done,
            ToBoard::Start { run, .. } => {
                // The same run asked for again is not begun again.
                if self.status.run != *run {
                    self.status = Status { state: RunState::Running, run: *run, next: 0, ..self.status };
                    self.doing = Doing::Waits(now);
                    self.starts += 1;
                }
                FromBoard::Done
            }
            ToBoard::Stop => {
                self.stops += 1;
                if self.status.state == RunState::Running {
                    self.end(Cause::Asked);
                }
                FromBoard::Done
            }
            ToBoard::Status => FromBoard::Status(self.status),
            _ => FromBoard::Refused(Refusal::NothingToFit),
        };
        say(packet.id, message, said);
    }

    fn go_on(&mut self, now: Duration, said: &mut Vec<u8>) {
        let turns = now < self.turns_until;
        match self.doing {
            Doing::Waits(since) if turns && now - since < self.patience => return,
            Doing::Waits(_) if turns && !BEGINS_TURNING.contains(&self.newest) => self.end(Cause::Turning),
            Doing::Waits(_) => {
                self.begun_turning |= turns;
                for first in (0..SAMPLES).step_by(LOG_SAMPLES) {
                    let samples = (first..first + LOG_SAMPLES as u32).map(sample).collect();
                    say(0, FromBoard::Log(LogBlock { run: self.status.run, first, samples }), said);
                }
                self.status.next = SAMPLES;
                self.doing = Doing::Runs(now);
            }
            Doing::Runs(since) if now - since >= self.takes => self.end(Cause::Finished),
            Doing::Runs(_) | Doing::Nothing => return,
        }
        say(0, FromBoard::Status(self.status), said);
    }

    fn end(&mut self, cause: Cause) {
        (self.status.state, self.doing) = (RunState::Stopped(cause), Doing::Nothing);
    }

    /// Waits for one caller at a TCP port, in real time until it hangs up; says where, and gives the board back.
    pub fn serve(self) -> (String, JoinHandle<Self>) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = format!("tcp://{}", listener.local_addr().expect("bound above"));
        let board = std::thread::spawn(move || {
            let (line, _) = listener.accept().expect("a caller");
            self.talk(line)
        });
        (address, board)
    }

    fn talk(mut self, mut line: TcpStream) -> Self {
        line.set_read_timeout(Some(Duration::from_millis(2))).expect("a socket");
        let (since, mut buffer) = (Instant::now(), [0; 4096]);
        loop {
            let received = match line.read(&mut buffer) {
                Ok(0) => return self,
                Ok(length) => length,
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
                Err(_) => return self,
            };
            let said = self.turn(since.elapsed(), &buffer[..received]);
            if line.write_all(&said).is_err() {
                return self;
            }
        }
    }
}

fn capabilities() -> Capabilities {
    Capabilities {
        effects: 22,
        segments: 16,
        log_samples: 1024,
        fit_samples: 2000,
        core_hz: 84_000_000,
        pwm_hz: 20_000,
        measures_supply: false,
        measures_current: false,
        scaling: Scaling { pwm_top: 4200, rate_hz: 1000 },
        converter: false,
    }
}

fn sample(index: u32) -> Sample {
    Sample { duty: 2100, count: index as i32, supply_mv: 12_000, current_ma: 0, late_us: 0 }
}

fn say(id: u16, message: FromBoard, said: &mut Vec<u8>) {
    let mut frame = [0; MAX_ENCODED];
    said.extend_from_slice(encode(&Packet { id, message }, &mut frame).expect("fits in a frame"));
}
