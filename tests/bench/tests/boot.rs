//! The image starts on the emulated chip, at both instruction rates, and touches nothing the chip has not.

use std::time::Duration as Time;

use motorlens::device::{Capture, Inquiry};
use motorlens_bench::bench::{self, Scene};
use motorlens_bench::cable::Cable;
use motorlens_bench::machine::{self, CORE_HZ, Machine};
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::Session as Conversation;
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, FromBoard, Setup, ToBoard};
use motorlens_virtual_motor::{Motor, VirtualMotor};
use rigless::emulator::{Driver, Host, Stop};
use rigless::session::Session;
use rigless::soc::stm32f427::generated::gpioa::Register as PortRegister;
use rigless::soc::stm32f427::generated::pwr::Register as PowerRegister;
use rigless::soc::stm32f427::generated::rcc::Register as ClockRegister;
use rigless::soc::stm32f427::generated::tim1::Register as TimerRegister;
use rigless::soc::stm32f427::generated::tim3::Register as GeneralRegister;
use rigless::time::VirtualNanos;

/// GPIOA among the ports, TIM3 and TIM5 among the general timers.
const PORT_A: usize = 0;
const TIMER_3: usize = 1;
const TIMER_5: usize = 3;

/// Lets the image run for a while, alone.
struct Wait(VirtualNanos);

impl Driver<Machine> for Wait {
    fn on_stop(&mut self, _: &mut Session<Machine>, stop: Stop, _: &mut dyn Host) -> Option<VirtualNanos> {
        (stop.at.0 < self.0.0).then_some(self.0)
    }
}

#[test]
fn the_image_starts_cleanly_and_the_watchdog_stays_fed() {
    for rate in [CORE_HZ, 47_000_000] {
        let finished = Machine::new(rate).run(
            &machine::image(),
            VirtualNanos(1_000_000),
            Wait(VirtualNanos(500_000_000)),
        );
        machine::assert_clean(&finished.session);
        assert!(finished.session.resets().is_empty(), "restarted: {:?}", finished.session.resets());
    }
}

/// What no emulator acts on, or not wholly: filters, pulls, what a break does to the outputs.
#[test]
fn registers_hold_what_the_reference_manual_asks_for() {
    let wait = Wait(VirtualNanos(20_000_000));
    let mut finished = Machine::new(CORE_HZ).run(&machine::image(), VirtualNanos(1_000_000), wait);
    let mcu = &mut finished.session.board_mut().mcu;
    // RM0090 17.4.18: a break takes the outputs away until the program gives them back (AOE clear); it is on and acts at a high level,
    // an open contact (BKE, BKP); outputs that are off rest low (OSSI, OSSR).
    let (_, timer) = mcu.advanced_timer(0);
    let outputs = timer.get(TimerRegister::Bdtr);
    assert_eq!(outputs >> 10 & 0x3f, 0b001111, "MOE, AOE, BKP, BKE, OSSR, OSSI: {outputs:#x}");
    // RM0090 17.4.2 and 17.4.9: the level at which an output that is off rests is low (OIS1 to OIS4), and an output that is on is high where the
    // PWM is (CCxP, CCxNP).
    assert_eq!(timer.get(TimerRegister::Cr2) >> 8 & 0x7f, 0);
    assert_eq!(timer.get(TimerRegister::Ccer) & 0x2aaa, 0);
    // RM0090 18.4.7: the encoder's channels are filtered over 8 looks at an eighth of the clock, and pulled up.
    let (_, encoder) = mcu.timer(TIMER_3);
    assert_eq!(encoder.get(GeneralRegister::Ccmr1Input) & 0xf0f0, 0x9090);
    let (_, port) = mcu.port(PORT_A);
    assert_eq!(port.get(PortRegister::Pupdr) >> 12 & 0xf, 0b0101, "PA6 and PA7 pull up");
    // RM0090 18.4.12: the clock counts every microsecond of 2^32.
    let (_, clock) = mcu.timer(TIMER_5);
    assert_eq!(clock.get(GeneralRegister::Arr), u64::from(u32::MAX));
    // RM0090 7.3.1 and 5.4.1: the crystal is watched (CSSON), and the supply, at the highest threshold (PLS, PVDE).
    let (_, clocks) = mcu.clocks();
    assert_eq!(clocks.get(ClockRegister::Cr) >> 19 & 1, 1);
    let (_, power) = mcu.power();
    assert_eq!(power.get(PowerRegister::Cr) >> 4 & 0xf, 0b1111);
}

/// The emulated chip is of their family, and has every register that they use.
#[test]
fn the_images_of_the_other_boards_capture_a_run_too() {
    for (image, crystal_hz) in machine::other_images() {
        let setup = Setup::default();
        let step = Programme::single("step", Shape::Step { level_v: 6.0 }, 0.5);
        let conversation =
            Conversation::new(Capture::new(setup, &step, 1), Time::from_secs(5), Box::new(|_, _, _| ()));
        let plant = Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), setup.drive);
        let chip = Machine::with_crystal(CORE_HZ, crystal_hz);
        let done = bench::run_on(chip, &image, plant, Cable::new(0.0, 1), conversation);
        machine::assert_clean(&done.session);
        let run = done.remote.run();
        assert_eq!((run.cause, run.samples.len(), run.holes.len()), (Cause::Finished, 500, 0));
        assert!(!run.capabilities.measures_supply && !run.capabilities.measures_current);
        assert_eq!(done.scene.remapped, None, "the program's own memory stays at address 0");
        let counts: Vec<i64> = run.samples.iter().map(|(_, sample)| i64::from(sample.count)).collect();
        assert_eq!(counts, done.scene.plant.run_counts(500), "{}", image.display());
    }
}

#[test]
fn the_boot_loader_is_entered_by_a_reset_after_the_whole_answer() {
    let step = Programme::single("step", Shape::Step { level_v: 6.0 }, 0.2);
    let capture = Capture::new(Setup::default(), &step, 1);
    // The emulated chip's boot loader is blank.
    let hand = Box::new(|_, _: &Capture, scene: &mut Scene| scene.led_astray = true);
    let conversation =
        Conversation::new(capture, Time::from_secs(5), hand).then(Inquiry::new([ToBoard::Bootloader]));
    let plant = Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), Setup::default().drive);
    let done = bench::run_at_full_rate(&machine::image(), plant, Cable::new(0.0, 1), conversation);
    let answers = done.remote.answers.expect("the board answers").expect("the board agrees");
    assert_eq!(answers.last(), Some(&FromBoard::Done));
    assert_eq!(done.session.resets().len(), 1, "{:?}", done.session.resets());
    assert!(!done.scene.plant.driven());
    // RM0090 9.2.1: MEM_MODE 01 has the loader's own vectors at address 0, as the boot pins would.
    assert_eq!(done.scene.remapped.map(|value| value & 0b111), Some(0b01));
    // It was jumped into: its stack, as the blank memory has it, lies at the end of all addresses.
    let unmapped = done.session.unmapped();
    assert!(
        !unmapped.is_empty() && unmapped.iter().all(|access| access.address > 0xffff_0000),
        "{unmapped:?}"
    );
}
