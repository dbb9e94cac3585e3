//! The unmodified image starts, samples, counts and comes back by its watchdog, with its bridge off throughout: nobody has asked for a run.

use motorlens_pico2::chip::{CIRCLE, Chip, UNDEFINED};
use motorlens_pico2::pins::{BRIDGE, GPIO_OE, IO_BANK0};

/// The image's watchdog, s, and how long it takes from a start until it samples.
const WATCHDOG_S: f64 = 0.5;
const START_S: f64 = 0.01;
/// Scratch register 0 of the watchdog, where the image notes why it waits to be started anew, and what it notes for a fault of the core
/// (`link::Reset::CoreFault`).
const NOTED: u32 = 0x0c;
const CORE_FAULT: u32 = motorlens_shared::link::Reset::CoreFault as u32;
/// PIO 0: which receive FIFOs are empty, and the first state machine's.
const FSTAT: u32 = 0x5020_0004;
const RXF0: u32 = 0x5020_0020;
/// TIMER0's low word, us.
const TIMERAWL: u32 = 0x400b_0028;

fn chip() -> Chip {
    let image = std::env::var("MOTORLENS_PICO2").expect("cargo xtask test says where the image is");
    Chip::new(&std::fs::read(image).expect("the image"))
}

/// Lets it run, with its bridge's pins looked at all the time.
fn run_at_rest(chip: &mut Chip, seconds: f64) {
    chip.run(seconds, |chip| {
        let now = chip.now();
        assert!(chip.bridge_off(), "the bridge is driven at {now} s");
    });
}

/// A word that the counter has put into its FIFO just now.
fn count(chip: &mut Chip) -> u16 {
    while chip.read(FSTAT) & 1 << 8 == 0 {
        chip.read(RXF0);
    }
    while chip.read(FSTAT) & 1 << 8 != 0 {
        chip.turn();
    }
    chip.read(RXF0) as u16
}

#[test]
fn it_starts_without_a_fault_samples_every_millisecond_and_feeds_its_watchdog() {
    let mut chip = chip();
    run_at_rest(&mut chip, START_S);
    assert!(chip.beside.usb.present(), "nothing shows itself on the bus");
    // From amid two of them, so that none falls on an end.
    let first = chip.beside.beats;
    while chip.beside.beats == first {
        chip.turn();
    }
    chip.run(0.5e-3, |_| ());
    let (beats, micros) = (chip.beside.beats, chip.read(TIMERAWL));
    chip.run(1.2 * WATCHDOG_S, |chip| assert!(!chip.at_fault(), "a fault at {} s", chip.now()));
    assert_eq!(chip.read(TIMERAWL) - micros, 600_000);
    assert_eq!(chip.beside.beats - beats, 600);
    assert!(chip.beside.watchdog.counts());
    assert_eq!(chip.restarts(), 0);
}

#[test]
fn the_bridge_is_the_images_and_low_within_the_first_milliseconds() {
    let mut chip = chip();
    run_at_rest(&mut chip, START_S);
    // PWM, PWM, and outputs of the port: not merely pins that nothing drives.
    for (pin, function) in BRIDGE.into_iter().zip([4, 4, 5, 5, 5]) {
        assert_eq!(chip.read(IO_BANK0 + 8 * pin) & 0x1f, function, "GP{pin}");
    }
    assert_eq!(chip.read(GPIO_OE) >> 8 & 0b1011, 0b1011, "GP8, GP9 and GP11 are outputs");
}

/// Not below zero: where the counter's X is 0, the emulator's `jmp x--` leaves it so (RP2350 data sheet 11.4.2: it is one less in any case).
/// What the program does there is shown on the emulated RP2040, which has the same.
#[test]
fn the_counter_follows_a_million_edges_a_second_both_ways() {
    let mut chip = chip();
    chip.run(START_S, |_| ());
    assert_eq!(count(&mut chip), 0);
    let mut shown = 0;
    for (edges, way) in [(7000, 1), (5000, -1), (1, -1), (2, 1)] {
        for _ in 0..edges {
            shown += way;
            chip.show_count(shown);
            // 160 cycles of 150 MHz.
            (0..5).for_each(|_| chip.turn());
        }
        assert_eq!(count(&mut chip), shown as u16, "after {edges} edges");
    }
}

#[test]
fn a_program_that_stands_is_started_anew_by_the_watchdog_with_the_bridge_off() {
    let mut chip = chip();
    chip.run(START_S, |_| ());
    chip.go_to(CIRCLE);
    chip.core().regs.primask = 1;
    run_at_rest(&mut chip, WATCHDOG_S - START_S);
    assert_eq!(chip.restarts(), 0, "before its time");
    run_at_rest(&mut chip, 3.0 * START_S);
    assert_eq!(chip.restarts(), 1);
    // It is back, and has forgotten nothing that it needs to be.
    assert!(chip.beside.usb.present() && chip.beside.beats > 0 && !chip.at_fault());
}

#[test]
fn a_fault_of_the_core_holds_the_bridge_is_noted_and_ends_by_the_watchdog() {
    let mut chip = chip();
    chip.run(START_S, |_| ());
    chip.go_to(UNDEFINED);
    run_at_rest(&mut chip, START_S);
    assert!(chip.at_fault());
    assert_eq!(chip.beside.watchdog.read(NOTED), CORE_FAULT);
    for pin in BRIDGE {
        assert_eq!(chip.read(IO_BANK0 + 8 * pin) >> 12 & 3, 2, "GP{pin} is held low, whatever drives it");
    }
    run_at_rest(&mut chip, WATCHDOG_S + START_S);
    assert_eq!(chip.restarts(), 1);
    assert!(chip.beside.beats > 0 && !chip.at_fault());
    assert_eq!(chip.beside.watchdog.read(NOTED), 0, "read, and cleared for the next time");
}
