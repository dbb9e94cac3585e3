//! The motorlens firmware for Raspberry Pi Pico (RP2040) and Pico 2 (RP2350); the logic is `motorlens-firmware`.
//!
//! | pin | what | wire to |
//! |---|---|---|
//! | GP2, GP3 | encoder A, B, pulled up (PIO 0, every edge) | the encoder |
//! | GP6 | PWM, 20 kHz or as asked | the driver's PWM (or phase input: locked anti-phase) |
//! | GP7 | second PWM | IN2 of a driver with two PWM inputs, whose IN1 is at GP6 |
//! | GP8, GP11 | direction forward, backward | the driver's IN1, IN2 |
//! | GP9 | enable, high while driven | the driver's enable or standby, with a pull-down of 4.7 kOhm |
//! | GP26 | supply, read where a run's setup says by what it is divided | the divider |
//! | GP27 | current, around half of the converter's supply, read where the setup says how many mV an ampere makes | the amplifier |
//! | GP10 | emergency input, pulled up | a contact to ground that opens in an emergency; a jumper where there is none |
//! | USB | serial line to the host, any speed | the host |
//!
//! The encoder's supply is 3.3 V, or its lines go through a divider: the pins do not stand 5 V.
#![no_std]
#![no_main]

mod adc;
mod chip;
mod crystal;
mod guard;
mod line;
mod panic;
mod platform;
mod pwm;
mod quadrature;
mod timers;

use core::cell::{Cell, RefCell};
use core::mem::MaybeUninit;

use cortex_m::peripheral::NVIC;
use cortex_m::singleton;
use critical_section::Mutex;
use defmt_rtt as _;
use hal::gpio::bank0::{Gpio8, Gpio11};
use hal::gpio::{FunctionPwm, FunctionSioOutput, Pin, PullDown, PullNone};
use hal::pac::{self, interrupt};
use hal::{Sio, Watchdog};
use motorlens_firmware::Shared;
use motorlens_firmware::board::Parts;
use motorlens_firmware::bridge::Bridge;
use motorlens_firmware::control::Control;
use motorlens_firmware::diagnostics::Diagnostics;
use motorlens_firmware::log::Log;
use motorlens_firmware::station::Station;
use motorlens_shared::link::Reset;
use usb_device::class_prelude::UsbBusAllocator;

#[cfg(feature = "pico2")]
use rp235x_hal as hal;
#[cfg(feature = "pico")]
use rp2040_hal as hal;

type Output<I> = Pin<I, FunctionSioOutput, PullDown>;
type Hardware = Parts<
    pwm::Pwm,
    Output<Gpio8>,
    Output<Gpio11>,
    guard::Enable,
    quadrature::Counter,
    adc::Sense,
    guard::Emergency,
    timers::Timers,
>;

/// What the sampling interrupt works on, once it is there.
static CONTROL: Mutex<Cell<Option<&'static Shared<Hardware>>>> = Mutex::new(Cell::new(None));

/// Not cleared at the start, so that a log survives the watchdog. Any bytes are a valid log.
#[unsafe(link_section = ".uninit.LOG")]
static mut LOG: MaybeUninit<Log> = MaybeUninit::uninit();

#[hal::entry]
fn main() -> ! {
    chip::close_stack();
    let mut device = pac::Peripherals::take().expect("taken once");
    let mut core = cortex_m::Peripherals::take().expect("taken once");
    let reset = platform::reset_cause(&device.WATCHDOG);
    let mut watchdog = Watchdog::new(device.WATCHDOG);
    let sio = Sio::new(device.SIO);
    let pins = hal::gpio::Pins::new(device.IO_BANK0, device.PADS_BANK0, sio.gpio_bank0, &mut device.RESETS);
    // The bridge first: its pins are low from the start, before anything that takes time.
    let (forward, backward) = (pins.gpio8.into_push_pull_output(), pins.gpio11.into_push_pull_output());
    let enable = guard::Enable::new(pins.gpio9.into_push_pull_output());
    let clocks = hal::clocks::init_clocks_and_plls(
        chip::CRYSTAL_HZ,
        device.XOSC,
        device.CLOCKS,
        device.PLL_SYS,
        device.PLL_USB,
        &mut device.RESETS,
        &mut watchdog,
    )
    .ok()
    .expect("the crystal swings");
    chip::start_cycle_counter();

    #[cfg(feature = "pico")]
    let (timer, usb, usb_memory) = (device.TIMER, device.USBCTRL_REGS, device.USBCTRL_DPRAM);
    #[cfg(feature = "pico2")]
    let (timer, usb, usb_memory) = (device.TIMER0, device.USB, device.USB_DPRAM);
    let slices = hal::pwm::Slices::new(device.PWM, &mut device.RESETS);
    let pwm = pwm::Pwm::new(
        slices.pwm3,
        pins.gpio6.into_function::<FunctionPwm>().into_pull_type::<PullNone>(),
        pins.gpio7.into_function::<FunctionPwm>().into_pull_type::<PullNone>(),
    );
    let (a, b) = (pins.gpio2.into_pull_up_input(), pins.gpio3.into_pull_up_input());
    let hardware = Parts {
        bridge: Bridge::new(pwm, forward, backward, enable),
        encoder: quadrature::Counter::new(device.PIO0, &mut device.RESETS, a, b),
        analog: adc::Sense::new(
            device.ADC,
            device.DMA,
            &mut device.RESETS,
            pins.gpio26.into_function().into_pull_type(),
            pins.gpio27.into_function().into_pull_type(),
        ),
        emergency: guard::Emergency::new(pins.gpio10.into_pull_up_input()),
        pace: timers::Timers::new(chip::clock(timer, &mut device.RESETS, &clocks)),
    };
    guard::prepare(&mut device.RESETS);
    let bus = chip::usb(usb, usb_memory, clocks.usb_clock, &mut device.RESETS);
    let bus = singleton!(: UsbBusAllocator<hal::usb::UsbBus> = UsbBusAllocator::new(bus)).expect("made once");
    let mut line = line::UsbLine::new(bus);

    // SAFETY: the only reference ever made to LOG; it consists of integers, so whatever the RAM holds is a value.
    let log = unsafe { (*(&raw mut LOG)).assume_init_mut() };
    let control = Mutex::new(RefCell::new(Control::new(hardware, log, reset)));
    let control: &'static Shared<Hardware> = singleton!(: Shared<Hardware> = control).expect("made once");
    let station = singleton!(: Station = Station::new()).expect("made once");
    critical_section::with(|section| CONTROL.borrow(section).set(Some(control)));

    // SAFETY: everything that the interrupt uses is in place.
    unsafe { NVIC::unmask(chip::SAMPLING) };
    crystal::watch(&mut core.SYST);
    let mut platform = platform::Board::new(watchdog, control);
    let mut diagnostics = Diagnostics::begin(reset, None, chip::CORE_HZ);
    loop {
        // No sleep: the bus is served from here, and has to be at any time.
        station.poll(&mut line, control, &mut platform);
        diagnostics.look(control);
    }
}

/// A sampling instant, or one of the interrupts between two that keep the bridge driven and look at what cannot wait for one.
fn sample() {
    let sampling = timers::acknowledge_sampling();
    critical_section::with(|section| {
        let Some(control) = CONTROL.borrow(section).get() else { return };
        match control.borrow(section).try_borrow_mut() {
            Ok(mut control) => {
                if let Some(reason) = control.interrupt(sampling) {
                    panic::stop_for_good(reason);
                }
            }
            // The main loop holds it only with this interrupt held off: the memory is damaged.
            Err(_) => panic::stop_for_good(Reset::Panic),
        }
    });
}

#[cfg(feature = "pico")]
#[interrupt]
fn TIMER_IRQ_0() {
    sample();
}

#[cfg(feature = "pico2")]
#[interrupt]
fn TIMER0_IRQ_0() {
    sample();
}
