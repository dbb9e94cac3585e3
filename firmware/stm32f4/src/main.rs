//! The motorlens firmware for STM32F4 boards: pins, timers and the interrupt; the logic is `motorlens-firmware`.
//!
//! | pin | what | wire to |
//! |---|---|---|
//! | PA8 | PWM, 20 kHz or as asked (TIM1) | the driver's PWM (or phase input: locked anti-phase) |
//! | PA9 | second PWM (TIM1) | IN2 of a driver with two PWM inputs, whose IN1 is at PA8 |
//! | PB0, PB1 | direction forward, backward | the driver's IN1, IN2 |
//! | PB15 | enable, high while driven (TIM1_CH3N) | the driver's enable or standby, with a pull-down of 10 kOhm; a must for locked anti-phase |
//! | PA6, PA7 | encoder A, B (TIM3, every edge), pulled up, filtered | the encoder |
//! | PB12 | emergency input, pulled up (TIM1_BKIN) | a contact to ground that opens in an emergency; a jumper where there is none |
//! | PA4 | supply, read where a run's setup says by what it is divided | the divider |
//! | PA1 | current, around half of the converter's supply, read where the setup says how many mV an ampere makes | the amplifier |
//! | PA2, PA3 | serial line to the host, 921,600 baud (USART2) | the debugger's port or a USB adapter |
#![no_std]
#![no_main]

mod adc;
mod deadman;
mod line;
mod panic;
mod platform;
mod pwm;
mod timers;

use core::cell::{Cell, RefCell};
use core::mem::MaybeUninit;

use adc::Sense;
use cortex_m::peripheral::NVIC;
use cortex_m::singleton;
use cortex_m_rt::{entry, exception};
use critical_section::Mutex;
use defmt_rtt as _;
use motorlens_firmware::Shared;
use motorlens_firmware::board::Parts;
use motorlens_firmware::bridge::Bridge;
use motorlens_firmware::control::Control;
use motorlens_firmware::diagnostics::Diagnostics;
use motorlens_firmware::log::Log;
use motorlens_firmware::station::Station;
use motorlens_shared::link::{PWM_HZ, Reset};
use stm32f4xx_hal::gpio::{Output, PB0, PB1};
use stm32f4xx_hal::qei::Qei;
use stm32f4xx_hal::serial::{Serial, config::Config as SerialConfig, config::DmaConfig};
use stm32f4xx_hal::{interrupt, pac, prelude::*, rcc};
use timers::{Counter, Timers};

use crate::pwm::{Emergency, Enable, Pwm};

/// The crystal's frequency, Hz.
const CRYSTAL_HZ: u32 = if cfg!(feature = "blackpill-f411") { 25_000_000 } else { 8_000_000 };
/// The core's frequency, Hz.
const CORE_HZ: u32 = 84_000_000;
/// The serial line's speed.
const BAUD: u32 = 921_600;

type Hardware = Parts<Pwm, PB0<Output>, PB1<Output>, Enable, Counter, Sense, Emergency, Timers>;

/// What the sampling interrupt works on, once it is there.
static CONTROL: Mutex<Cell<Option<&'static Shared<Hardware>>>> = Mutex::new(Cell::new(None));

/// Not cleared at the start, so that a log survives the watchdog. Any bytes are a valid log.
#[unsafe(link_section = ".uninit.LOG")]
static mut LOG: MaybeUninit<Log> = MaybeUninit::uninit();

#[entry]
fn main() -> ! {
    platform::leave_for_bootloader_if_asked();
    let device = pac::Peripherals::take().expect("taken once");
    let mut core = cortex_m::Peripherals::take().expect("taken once");
    let reset = platform::reset_cause(&device.RCC);
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();

    let clocks = rcc::Config::hse(CRYSTAL_HZ.Hz()).sysclk(CORE_HZ.Hz()).pclk1(42.MHz()).pclk2(84.MHz());
    // The debugger on a Nucleo gives a clock, not a crystal.
    let clocks = if cfg!(feature = "nucleo-f446re") { clocks.bypass_hse_oscillator() } else { clocks };
    let mut rcc = device.RCC.freeze(clocks);
    platform::watch_clock_and_supply(&device.PWR);
    let a = device.GPIOA.split(&mut rcc);
    let b = device.GPIOB.split(&mut rcc);

    let (_, (first, second, ..)) = device.TIM1.pwm_hz(PWM_HZ.Hz(), &mut rcc);
    let emergency = Emergency::new(b.pb12.into_input());
    let pwm = Pwm::new(first.with(a.pa8), second.with(a.pa9), &emergency);
    let (forward, backward) = (b.pb0.into_push_pull_output(), b.pb1.into_push_pull_output());
    deadman::prepare(device.DMA2, &mut rcc);
    let bridge = Bridge::new(pwm, forward, backward, Enable::new(b.pb15.into_input()));
    let hardware = Parts {
        bridge,
        encoder: Counter::new(Qei::new(device.TIM3, (a.pa6, a.pa7), &mut rcc)),
        analog: Sense::new(device.ADC1, a.pa4.into_analog(), a.pa1.into_analog(), &mut rcc),
        emergency,
        pace: Timers::new(device.TIM4, device.TIM5, &mut rcc),
    };
    let serial = SerialConfig::default().baudrate(BAUD.bps()).dma(DmaConfig::TxRx);
    let serial = Serial::new(device.USART2, (a.pa2, a.pa3), serial, &mut rcc).expect("the baud rate divides");
    let mut line = line::DmaLine::new(serial, device.DMA1, &mut rcc);

    // SAFETY: the only reference ever made to LOG; it consists of integers, so whatever the RAM holds is a value.
    let log = unsafe { (*(&raw mut LOG)).assume_init_mut() };
    let control = Mutex::new(RefCell::new(Control::new(hardware, log, reset)));
    let control: &'static Shared<Hardware> = singleton!(: Shared<Hardware> = control).expect("made once");
    let station = singleton!(: Station = Station::new()).expect("made once");
    critical_section::with(|section| CONTROL.borrow(section).set(Some(control)));

    // The watchdog first: an interrupt that stops the program for good waits for it.
    let mut platform = platform::Board::new(device.IWDG, control);
    // SAFETY: everything that the interrupt uses is in place.
    unsafe { NVIC::unmask(pac::Interrupt::TIM4) };
    wake_twice_in_a_millisecond(&mut core.SYST);
    let mut diagnostics = Diagnostics::begin(reset, panic::last_place(), CORE_HZ);
    loop {
        station.poll(&mut line, control, &mut platform);
        diagnostics.look(control);
        cortex_m::asm::wfi();
    }
}

/// The main loop must turn also where samples are rare: where it does not, the sampling interrupt takes it for one that hangs. The chip's
/// supply is looked at as often.
fn wake_twice_in_a_millisecond(timer: &mut cortex_m::peripheral::SYST) {
    // Out of reset it counts an eighth of that clock.
    timer.set_clock_source(cortex_m::peripheral::syst::SystClkSource::Core);
    timer.set_reload(CORE_HZ / 2000 - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}

#[exception]
fn SysTick() {
    if platform::supply_sinks() {
        panic::stop_for_good(Reset::Supply);
    }
}

/// A sampling instant, or one of the interrupts between two that keep the bridge driven and look at what cannot wait for one.
#[interrupt]
fn TIM4() {
    pwm::interrupt_begins();
    let sampling = timers::acknowledge_sampling();
    if !sampling {
        pwm::renew_in_step();
    }
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
