//! The boards' own program on a board of memory: a run is asked for, played and logged, and fitted. The host makes the same.

use core::cell::RefCell;
use core::convert::Infallible;

use critical_section::Mutex;
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use motorlens_firmware::Shared;
use motorlens_firmware::control::Control;
use motorlens_firmware::hardware::{Hardware, NoAnalog, Pace};
use motorlens_firmware::log::Log;
use motorlens_firmware::station::{Platform, Station};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{
    Decoder, DriveMode, FromBoard, MAX_ENCODED, NEWEST, OLDEST, Packet, Reset, Setup, ToBoard, encode,
};
use motorlens_shared::quickfit::{Float, Request};

/// Length of the programme, s; as many samples as are kept for a fit.
const SECONDS: f32 = 2.0;
/// From its start until all of the log is sent, ms.
const LONGEST_MS: u32 = 2_600;
/// PWM ticks of full voltage: the Pico 2's at 20 kHz.
const TOP: u16 = 7500;
/// The motor at full voltage, counts/s, and its time constant, us; 1,320 counts a turn.
const FULL: i64 = 8000;
const TAU_US: i64 = 45_000;
const RAD_PER_COUNT: f32 = core::f32::consts::TAU / 1320.0;
/// Parts of a count, so that the motor moves in whole numbers on every machine.
const PARTS: i64 = 1 << 16;

/// What the board said, condensed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Captured {
    /// Samples of the log.
    pub samples: usize,
    /// Fits that found something.
    pub fits: usize,
    /// Bytes on the line.
    pub bytes: u32,
    /// All of them, in order.
    pub condensed: u32,
}

/// Hardware without hardware: a clock that is moved on, and a motor that follows its duty.
#[derive(Default)]
struct Memory {
    now_us: u32,
    duty: i64,
    speed: i64,
    angle: i64,
    analog: NoAnalog,
}

impl Memory {
    fn pass(&mut self, us: u32) {
        self.now_us = self.now_us.wrapping_add(us);
        let us = i64::from(us);
        self.speed += (self.duty * FULL * PARTS / i64::from(TOP) - self.speed) * us / TAU_US;
        self.angle += self.speed * us;
    }
}

impl Pace for Memory {
    fn now_us(&mut self) -> u32 {
        self.now_us
    }
    fn cycles(&mut self) -> u32 {
        0
    }
    fn set_rate(&mut self, _: u16, _: u32) {}
}

impl Hardware for Memory {
    type Analog = NoAnalog;
    fn count(&mut self) -> u16 {
        self.angle.div_euclid(1_000_000 * PARTS) as u16
    }
    fn apply(&mut self, _: DriveMode, duty: i16) -> i16 {
        self.duty = i64::from(duty);
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

/// The rest of a board, with the Pico 2's arithmetic.
struct Rest;

impl Platform for Rest {
    const CORE_HZ: u32 = 150_000_000;
    type Arithmetic = Float;
    const VERSION: [u8; 3] = [0, 1, 0];
    fn unique(&self) -> [u8; 12] {
        *b"made of RAM."
    }
    fn alive(&mut self) {}
    fn has_bootloader(&self) -> bool {
        false
    }
    fn enter_bootloader(&mut self) {}
}

/// The line: one frame of the host at a time, and what becomes of the board's words.
struct Line {
    frame: [u8; MAX_ENCODED],
    left: core::ops::Range<usize>,
    id: u16,
    ear: Decoder,
    heard: Captured,
}

impl Line {
    fn say(&mut self, message: ToBoard) {
        self.id += 1;
        let packet = Packet { id: self.id, message };
        self.left = 0..encode(&packet, &mut self.frame).map_or(0, |frame| frame.len());
    }
}

impl ErrorType for Line {
    type Error = Infallible;
}

impl ReadReady for Line {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.left.is_empty())
    }
}

impl Read for Line {
    fn read(&mut self, out: &mut [u8]) -> Result<usize, Infallible> {
        Ok(out.iter_mut().zip(&mut self.left).map(|(byte, at)| *byte = self.frame[at]).count())
    }
}

impl WriteReady for Line {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(true)
    }
}

impl Write for Line {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        for byte in bytes {
            self.heard.bytes += 1;
            self.heard.condensed = (self.heard.condensed ^ u32::from(*byte)).wrapping_mul(16_777_619);
            match self.ear.push::<Packet<FromBoard>>(*byte).and_then(Result::ok).map(|packet| packet.message)
            {
                Some(FromBoard::Log(block)) => self.heard.samples += block.samples.len(),
                Some(FromBoard::Fit(Some(_))) => self.heard.fits += 1,
                _ => {}
            }
        }
        Ok(bytes.len())
    }
    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Captures a multisine at 1000 samples a second and has it fitted, with its friction.
pub fn capture(log: &'static mut Log, station: &mut Station) -> Captured {
    let control: Shared<Memory> =
        Mutex::new(RefCell::new(Control::new(Memory::default(), log, Reset::PowerOn)));
    let heard = Captured { condensed: 2_166_136_261, ..Captured::default() };
    let mut line = Line { frame: [0; MAX_ENCODED], left: 0..0, id: 0, ear: Decoder::new(), heard };
    // A millisecond of the board: the main loop turns twice, the sampling interrupt comes between.
    let mut pass = |line: &mut Line| {
        for sampling in [false, true] {
            critical_section::with(|section| {
                let mut control = control.borrow_ref_mut(section);
                control.hardware_mut().pass(500);
                if sampling {
                    assert!(control.interrupt(true).is_none(), "the main loop turns");
                }
            });
            station.poll(line, &control, &mut Rest);
        }
    };
    let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 0.5, high_hz: 8.0, tones: 6, seed: 3 };
    let Programme { name, segments } = Programme::single("memory", shape, SECONDS);
    line.say(ToBoard::Hello { oldest: OLDEST, newest: NEWEST });
    pass(&mut line);
    line.say(ToBoard::Configure(Setup { keep_every: 1, ..Setup::default() }));
    pass(&mut line);
    for segment in segments {
        line.say(ToBoard::SetSegment { index: 0, name: name.clone(), segment });
        pass(&mut line);
    }
    line.say(ToBoard::Start { run: 1, segments: 1 });
    for ms in 1..LONGEST_MS {
        pass(&mut line);
        if ms.is_multiple_of(100) {
            line.say(ToBoard::KeepAlive);
        }
    }
    let request = Request { coulomb: true, rad_per_count: RAD_PER_COUNT, ..Request::default() };
    line.say(ToBoard::QuickFit(request));
    for _ in 0..20 {
        pass(&mut line);
    }
    line.heard
}
