//! A board made of memory and the virtual motor, for the firmware's logic.

use core::cell::RefCell;
use core::convert::Infallible;
use critical_section::Mutex;
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use motorlens_firmware::Shared;
use motorlens_firmware::analog::{Means, Wiring};
use motorlens_firmware::beat::split;
use motorlens_firmware::control::Control;
use motorlens_firmware::hardware::{Analog, Hardware, Pace};
use motorlens_firmware::log::Log;
use motorlens_firmware::station::{Platform, Station};
use motorlens_shared::link::{Decoder, DriveMode, FromBoard, MAX_ENCODED, Packet, Reset, ToBoard, encode};
use motorlens_virtual_motor::{Bridge, Effect, Motor, VirtualMotor};
use std::collections::VecDeque;

pub const TOP: u16 = 4200;

/// The motor and what can go wrong with it.
pub struct Rig {
    pub motor: VirtualMotor,
    pub now_us: u32,
    pub rate_hz: u16,
    /// PWM ticks of full voltage; [`TOP`] unless another frequency is asked for.
    pub top: u16,
    pub bridge: Bridge,
    pub jammed: bool,
    /// Until then something else than the bridge turns the shaft, by two counts a millisecond.
    pub cranked_until_us: u32,
    pub emergency: bool,
    /// What the supply's input reads all through the present interval, mV, where it is not the motor's supply.
    pub floating_mv: Option<u16>,
    /// The mean of the current's input since the last interrupt, mA, where it is not the motor's current.
    pub short_ma: Option<i16>,
    pub wiring: Wiring,
}

impl Rig {
    fn supply_mv(&self) -> u16 {
        self.floating_mv.unwrap_or((self.motor.supply_v() * 1000.0).round() as u16)
    }
}

impl Analog for Rig {
    const CONVERTER: bool = true;
    fn wire(&mut self, wiring: Wiring) {
        self.wiring = wiring;
    }
    fn gather(&mut self) -> Means {
        self.means()
    }
    fn means(&mut self) -> Means {
        let supply_mv = self.supply_mv();
        let current_ma = self.short_ma.unwrap_or((self.motor.current_a() * 1000.0) as i16);
        Means {
            supply_mv: (self.wiring.divider > 0).then_some(supply_mv),
            current_ma: (self.wiring.amplifier > 0).then_some(current_ma),
        }
    }
}

impl Pace for Rig {
    fn now_us(&mut self) -> u32 {
        self.now_us
    }
    fn cycles(&mut self) -> u32 {
        0
    }
    fn set_rate(&mut self, rate_hz: u16, pwm_hz: u32) {
        (self.rate_hz, self.top) = (rate_hz, (Rest::CORE_HZ / pwm_hz) as u16);
    }
}

impl Hardware for Rig {
    type Analog = Self;
    fn count(&mut self) -> u16 {
        let cranked = (self.now_us.min(self.cranked_until_us) / 500) as u16;
        if self.jammed { 77 } else { (self.motor.counts() as u16).wrapping_add(cranked) }
    }
    fn apply(&mut self, _: DriveMode, duty: i16) -> i16 {
        self.bridge = Bridge::Volts(f64::from(duty) / f64::from(self.top) * self.motor.motor().nominal_v);
        duty
    }
    fn release(&mut self) {
        self.bridge = Bridge::Floating;
    }
    fn pwm_top(&self) -> u16 {
        self.top
    }
    fn analog(&mut self) -> &mut Self {
        self
    }
    fn emergency(&mut self) -> bool {
        self.emergency
    }
}

/// Both directions of a serial line, as bytes in memory.
pub struct Cable {
    pub to_board: VecDeque<u8>,
    pub to_host: VecDeque<u8>,
    /// The board may write while fewer bytes wait for the host, ...
    pub room: usize,
    /// ... and so many at once.
    pub at_once: usize,
}

impl Default for Cable {
    fn default() -> Self {
        Self { to_board: VecDeque::new(), to_host: VecDeque::new(), room: 100_000, at_once: usize::MAX }
    }
}

impl ErrorType for Cable {
    type Error = Infallible;
}
impl ReadReady for Cable {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.to_board.is_empty())
    }
}
impl Read for Cable {
    fn read(&mut self, out: &mut [u8]) -> Result<usize, Infallible> {
        Ok(std::io::Read::read(&mut self.to_board, out).expect("memory is always readable"))
    }
}
impl WriteReady for Cable {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.to_host.len() < self.room)
    }
}
impl Write for Cable {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let length = bytes.len().min(self.at_once);
        self.to_host.extend(&bytes[..length]);
        Ok(length)
    }
    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// The rest of a board.
#[derive(Default)]
pub struct Rest {
    pub alive: u32,
    pub left_for_bootloader: bool,
}

impl Platform for Rest {
    const CORE_HZ: u32 = 84_000_000;
    type Arithmetic = motorlens_shared::quickfit::Float;
    const VERSION: [u8; 3] = [0, 1, 0];
    fn unique(&self) -> [u8; 12] {
        *b"host-bench-1"
    }
    fn alive(&mut self) {
        self.alive += 1;
    }
    fn has_bootloader(&self) -> bool {
        true
    }
    fn enter_bootloader(&mut self) {
        self.left_for_bootloader = true;
    }
}

/// A board, its cable and a host's ear.
pub struct Bench<H: 'static = Rig> {
    pub control: &'static Shared<H>,
    pub station: Box<Station>,
    pub cable: Cable,
    pub rest: Rest,
    pub heard: Vec<Packet<FromBoard>>,
    ear: Decoder,
    pub id: u16,
}

impl Bench {
    pub fn new(effects: &[Effect]) -> Self {
        Self::started(effects, Box::leak(Box::new(Log::new())), Reset::PowerOn)
    }

    pub fn started(effects: &[Effect], log: &'static mut Log, reset: Reset) -> Self {
        let motor = VirtualMotor::new(&Motor::paper(), effects, 1);
        let rig = Rig {
            motor,
            now_us: 0,
            rate_hz: 0,
            top: TOP,
            bridge: Bridge::Floating,
            jammed: false,
            cranked_until_us: 0,
            emergency: false,
            floating_mv: None,
            short_ma: None,
            wiring: Wiring::default(),
        };
        Self::of(rig, log, reset)
    }

    /// Lets time pass: the motor moves, the interrupts come as a board's do, and the main loop turns after each.
    pub fn pass(&mut self, seconds: f64) {
        let rate = self.control(|control| control.setup().rate_hz);
        let (beats, apart_us) = split(1_000_000 / u32::from(rate));
        for _ in 0..(seconds * f64::from(rate)).round() as u32 {
            for beat in 1..=beats {
                self.run_on(apart_us);
                self.control(|control| if beat == beats { control.tick() } else { control.between() });
                self.poll();
            }
        }
    }

    /// The motor runs on under the bridge as it is.
    pub fn run_on(&mut self, micros: u32) {
        self.control(|control| {
            let rig = control.hardware_mut();
            let bridge = rig.bridge;
            rig.motor.advance(f64::from(micros) * 1e-6, bridge);
            rig.now_us = rig.now_us.wrapping_add(micros);
        });
    }
}

impl<H: Hardware> Bench<H> {
    /// A board made of this hardware.
    pub fn of(hardware: H, log: &'static mut Log, reset: Reset) -> Self {
        let control = Mutex::new(RefCell::new(Control::new(hardware, log, reset)));
        Self {
            control: Box::leak(Box::new(control)),
            station: Box::default(),
            cable: Cable::default(),
            rest: Rest::default(),
            heard: Vec::new(),
            ear: Decoder::new(),
            id: 0,
        }
    }

    /// Does something to the control, as the interrupt would.
    pub fn control<R>(&self, act: impl FnOnce(&mut Control<H>) -> R) -> R {
        critical_section::with(|section| act(&mut self.control.borrow_ref_mut(section)))
    }

    /// Sends a request and returns its number.
    pub fn send(&mut self, message: ToBoard) -> u16 {
        // As the host counts: 0 is what the board says unasked.
        self.id = self.id.wrapping_add(1).max(1);
        let mut frame = [0; MAX_ENCODED];
        self.cable.to_board.extend(encode(&Packet { id: self.id, message }, &mut frame).unwrap());
        self.id
    }

    /// Sends a request, lets the board answer, and returns the answer.
    pub fn ask(&mut self, message: ToBoard) -> FromBoard {
        let id = self.send(message);
        self.poll();
        self.heard
            .iter()
            .rev()
            .find(|packet| packet.id == id)
            .expect("every request is answered")
            .message
            .clone()
    }

    /// One turn of the main loop.
    pub fn poll(&mut self) {
        self.station.poll(&mut self.cable, self.control, &mut self.rest);
        for byte in self.cable.to_host.drain(..) {
            if let Some(packet) = self.ear.push(byte) {
                self.heard.push(packet.expect("the cable is sound"));
            }
        }
    }
}
