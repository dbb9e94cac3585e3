//! A day of virtual time: the clock of microseconds wraps twenty times, the counter of cycles seventeen hundred times, the
//! encoder's eleven thousand times, the requests' numbers six times, and the ring of the log is overwritten again and again.

use std::collections::VecDeque;

use motorlens_firmware::hardware::{Hardware, NoAnalog, Pace};
use motorlens_firmware::log::{LOG_LENGTH, Log};
use motorlens_shared::excitation::{Player, Programme, Shape};
use motorlens_shared::link::{Cause, DriveMode, FromBoard, Reset, RunState, Setup, Status, ToBoard};

use crate::bench::{Bench, TOP};

const RATE_HZ: u16 = 100;
const PERIOD_US: u32 = 10_000;
const HOUR: u32 = 3600 * RATE_HZ as u32;
/// A run, s, and its samples.
const SECONDS: f32 = 3450.0;
const SAMPLES: u32 = 3450 * RATE_HZ as u32;
/// The host says so often that it is there, samples.
const KEEP_ALIVE: u32 = 20;
/// What the interrupt costs by the counter of cycles, at 84 to the microsecond.
const COST: u32 = 1234;

/// A shaft that goes as far as the duty says, at once, and what the log must hold of it.
struct Shaft {
    now_us: u32,
    cycles: u32,
    count: i64,
    duty: i16,
    looked: i64,
    analog: NoAnalog,
    /// Counter at the sampling instant and duty from there on, for each sample not yet compared.
    expected: VecDeque<(i64, i16)>,
}

impl Pace for Shaft {
    fn now_us(&mut self) -> u32 {
        self.now_us
    }
    fn cycles(&mut self) -> u32 {
        // Read at the interrupt's begin and at its end.
        self.cycles = self.cycles.wrapping_add(COST);
        self.now_us.wrapping_mul(84).wrapping_add(self.cycles)
    }
    fn set_rate(&mut self, _: u16, _: u32) {}
}

impl Hardware for Shaft {
    type Analog = NoAnalog;
    fn count(&mut self) -> u16 {
        self.looked = self.count;
        self.count as u16
    }
    fn apply(&mut self, _: DriveMode, duty: i16) -> i16 {
        self.duty = duty;
        self.expected.push_back((self.looked, duty));
        duty
    }
    fn release(&mut self) {
        self.duty = 0;
    }
    fn pwm_top(&self) -> u16 {
        TOP
    }
    fn analog(&mut self) -> &mut NoAnalog {
        &mut self.analog
    }
    fn emergency(&mut self) -> bool {
        false
    }
}

impl Bench<Shaft> {
    /// One sampling period: shaft, interrupt, main loop.
    fn turn(&mut self) {
        self.control(|control| {
            let shaft = control.hardware_mut();
            shaft.now_us = shaft.now_us.wrapping_add(PERIOD_US);
            shaft.count += i64::from(shaft.duty / 4);
            control.tick();
        });
        self.poll();
    }

    fn status(&mut self) -> Status {
        match self.ask(ToBoard::Status) {
            FromBoard::Status(status) => status,
            other => panic!("{other:?}"),
        }
    }

    fn begin(&mut self, programme: &Programme, run: u32) {
        let segment = programme.segments[0].clone();
        self.ask(ToBoard::SetSegment { index: 0, name: programme.name.clone(), segment });
        assert_eq!(self.ask(ToBoard::Start { run, segments: 1 }), FromBoard::Done);
    }
}

/// What the host has heard of a run so far.
struct Heard {
    player: Player,
    samples: u32,
    reports: u32,
}

impl Heard {
    /// Takes what was heard since the last time and holds it against the shaft.
    fn take(&mut self, bench: &mut Bench<Shaft>, run: u32) {
        for packet in std::mem::take(&mut bench.heard) {
            match packet.message {
                FromBoard::Log(block) if packet.id == 0 => {
                    assert_eq!((block.run, block.first), (run, self.samples));
                    for sample in &block.samples {
                        let (count, duty) = bench
                            .control(|control| control.hardware_mut().expected.pop_front())
                            .expect("the shaft was driven");
                        let told = (sample.count, sample.duty, sample.late_us, sample.supply_mv);
                        assert_eq!(told, (count as i32, duty, 0, 12_000), "sample {} of {run}", self.samples);
                        // The programme of the first hour in the last one too.
                        let volts = self.player.next().expect("no more samples than the programme has");
                        let off = f32::from(duty) - volts / 12.0 * f32::from(TOP);
                        assert!(off.abs() <= 0.51, "sample {} of {run} is {off} ticks off", self.samples);
                        self.samples += 1;
                    }
                }
                FromBoard::Status(_) if packet.id == 0 => self.reports += 1,
                _ => {}
            }
        }
    }
}

#[test]
fn a_day_passes_without_drift_or_leak() {
    let setup = Setup { rate_hz: RATE_HZ, run_limit_ms: 3_600_000, ..Setup::default() };
    let shaft = Shaft {
        now_us: 0,
        cycles: 0,
        count: 0,
        duty: 0,
        looked: 0,
        analog: NoAnalog,
        expected: VecDeque::new(),
    };
    let mut bench = Bench::of(shaft, Box::leak(Box::new(Log::new())), Reset::PowerOn);
    bench.ask(ToBoard::Hello { oldest: 1, newest: 3 });
    assert_eq!(bench.ask(ToBoard::Configure(setup)), FromBoard::Done);
    // A mean that is not zero, so that the shaft goes ever on.
    let shape = Shape::Sine { amplitude_v: 6.0, frequency_hz: 0.37, offset_v: 1.0 };
    let programme = Programme::single("day", shape, SECONDS);
    for run in 1..=24 {
        bench.begin(&programme, run);
        let player = Player::new(&programme, RATE_HZ.into()).expect("the programme is sound");
        let mut heard = Heard { player, samples: 0, reports: 0 };
        for turn in 0..HOUR {
            if turn.is_multiple_of(KEEP_ALIVE) {
                bench.send(ToBoard::KeepAlive);
            }
            bench.turn();
            if turn % 1000 == 999 {
                heard.take(&mut bench, run);
                let status = bench.status();
                assert_eq!(status.next - status.oldest, status.next.min(LOG_LENGTH as u32));
                // Samples of long ago are no longer held, those of the ring are, under the request's own number.
                let first = status.oldest.max(3) - 3;
                let FromBoard::NotHeld { count, .. } = bench.ask(ToBoard::ReadLog { first, count: 3 }) else {
                    assert!(status.oldest == 0, "hour {run}: overwritten samples are sent");
                    continue;
                };
                assert_eq!(count, 3);
            }
        }
        heard.take(&mut bench, run);
        let status = bench.status();
        assert_eq!((status.state, status.run), (RunState::Stopped(Cause::Finished), run));
        assert_eq!((heard.samples, status.next, status.missed), (SAMPLES, SAMPLES, 0));
        assert_eq!((status.damaged, status.worst_cycles), (0, COST));
        // Ten a second, and one for each change of the state.
        assert!((36_000..=36_003).contains(&heard.reports), "{} reports in hour {run}", heard.reports);
        // Nothing waits on either side.
        let wait = bench.cable.to_board.len() + bench.cable.to_host.len();
        assert_eq!((wait, bench.control(|control| control.hardware_mut().expected.len())), (0, 0));
    }

    // Silence across the wrap of the clock is as long as any other.
    bench.control(|control| control.hardware_mut().now_us = u32::MAX - 450_000);
    bench.begin(&programme, 25);
    (0..300).for_each(|_| bench.turn());
    let status = bench.status();
    assert_eq!(status.state, RunState::Stopped(Cause::LinkLoss));
    // Half a second of silence, a tenth of which the motor was seen to stand.
    assert!((39..=40).contains(&status.next), "{} samples", status.next);
}
