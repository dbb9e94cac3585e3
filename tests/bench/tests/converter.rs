//! The converter: within its limits, and its means are those of whole PWM periods, whatever ripples. How the internal reference corrects
//! them is tested in the library (`firmware/src/analog.rs`): the emulated chip has no calibration value of its maker.

use std::time::Duration;

use motorlens::device::Capture;
use motorlens_bench::bench::{self, Done, Scene};
use motorlens_bench::cable::Cable;
use motorlens_bench::machine;
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::Session;
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{DriveMode, Setup};
use motorlens_virtual_motor::{Motor, VirtualMotor};
use rigless::soc::stm32f427::generated::adc1::Register as Converter;
use rigless::soc::stm32f427::generated::dma2::Register as Stream;

/// The converter's inputs are changed so often, ns: eighty times in a PWM period. Half as often, a look more or less at either end of an interval
/// of ten periods is 5 mV of the ripple, nearly half of what the mean voltage may be off: with one image it was called 0.11 % for 0.09 % off.
const LOOK_NS: u64 = 625;
/// The supply's ripple, V.
const RIPPLE_V: f64 = 1.0;
/// What the supply in the log may be off, V: a count of the converter and a millivolt of the emulated pin, both behind the divider by 11,
/// and of the ripple a twenty-fifth that conversions may miss of pulses (as the library's test of their evenness allows) and the
/// eightieth of a period to which the pin follows them. Conversions in step with the pulses would be off by half of the ripple and more.
const SUPPLY_OFF_V: f64 = 11.0 * (3.3 / 4095.0 + 1e-3) + RIPPLE_V * (0.04 + LOOK_NS as f64 / 50_000.0);
/// DMA2 among the controllers.
const DMA_2: usize = 1;

/// A third of a second of a triangle with a supply that swings by half a volt ten times a second and ripples by a volt in step with the
/// pulses.
fn captured(rate_hz: u16, drive: DriveMode) -> Done<Session> {
    let setup =
        Setup { rate_hz, drive, divider: 1100, amplifier: 1650, link_timeout_ms: 250, ..Setup::default() };
    let shape = Shape::Triangle { amplitude_v: 9.0, period_s: 0.3 };
    let capture = Capture::new(setup, &Programme::single("triangle", shape, 0.3), 1);
    let mut plant = Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), drive).sampled_at(rate_hz);
    (plant.ripple_v, plant.ripple_a, plant.swing_v) = (RIPPLE_V, 1.0, 0.5);
    let hand = Box::new(|_, _: &Capture, scene: &mut Scene| scene.stop_ns = LOOK_NS);
    let session = Session::new(capture, Duration::from_secs(5), hand);
    bench::run_at_full_rate(&machine::image(), plant, Cable::new(0.0, 1), session)
}

/// The largest errors of supply, V, mean voltage, shares of the nominal supply, and current, A.
fn errors(done: &Done<Session>, drive: DriveMode) -> (f64, f64, f64) {
    let run = done.remote.run();
    let (mut supply, mut voltage, mut current, mut seen) = (0.0_f64, 0.0_f64, 0.0_f64, 0);
    // In the first interval the driver is being enabled, the last has no end.
    for (index, sample) in &run.samples[1..run.samples.len() - 1] {
        let plant = &done.scene.plant;
        let (supply_v, current_a) = plant.sensed(*index as usize).expect("every interval was looked at");
        let share = plant.high_share(*index as usize).expect("every interval was seen");
        let sign = f64::from(sample.duty.signum());
        let share = if drive == DriveMode::LockedAntiPhase { 2.0 * share - 1.0 } else { sign * share };
        let said = f64::from(run.scaling.volts(sample));
        supply = supply.max((f64::from(sample.supply_mv) * 1e-3 - supply_v).abs());
        voltage = voltage.max((said - share * supply_v).abs() / 12.0);
        current = current.max((f64::from(sample.current_ma) * 1e-3 - current_a).abs());
        seen += 1;
    }
    assert!(seen + 2 >= usize::from(run.scaling.rate_hz) * 3 / 10, "{seen} intervals");
    (supply, voltage, current)
}

#[test]
fn the_log_says_the_mean_voltage_of_every_interval_while_the_supply_swings_and_ripples() {
    for rate_hz in [100, 625, 1000, 1600, 2000] {
        for drive in [DriveMode::SignMagnitudeBrake, DriveMode::LockedAntiPhase] {
            let done = captured(rate_hz, drive);
            machine::assert_clean(&done.session);
            let (supply, voltage, current) = errors(&done, drive);
            println!(
                "{rate_hz} Hz {drive:?}: {supply:.4} V, {:.3} % of 12 V, {current:.4} A",
                100.0 * voltage
            );
            assert!(voltage <= 1e-3, "{rate_hz} Hz, {drive:?}: {voltage} of the full voltage");
            assert!(supply <= SUPPLY_OFF_V, "{rate_hz} Hz, {drive:?}: the supply is {supply} V off");
        }
    }
}

/// RM0090 13.13 and 10.5, and the data sheets' limit of the converter's clock, 36 MHz.
#[test]
fn the_converters_registers_hold_what_manual_and_data_sheet_ask_for() {
    let mut done = captured(1000, DriveMode::SignMagnitudeBrake);
    let mcu = &mut done.session.board_mut().mcu;
    let (adc, converter) = mcu.converter(0);
    // ADCPRE: 84 MHz by 4.
    assert!(format!("{adc:?}").contains("clock_hz: 21000000"), "{adc:?}");
    // Two conversions: PA4, PA1.
    assert_eq!(converter.get(Converter::Sqr1) >> 20 & 0xf, 1);
    assert_eq!(converter.get(Converter::Sqr3) & 0x3ff, 4 | 1 << 5);
    // SMP17: 480 cycles of 21 MHz are more than the 10 us that the reference wants.
    assert_eq!(converter.get(Converter::Smpr1) >> 21 & 0b111, 0b111);
    // SCAN; CONT, DMA, DDS, ADON.
    assert_eq!(converter.get(Converter::Cr1) >> 8 & 1, 1);
    assert_eq!(converter.get(Converter::Cr2) & 0x303, 0x303);
    let (_, stream) = mcu.controller(DMA_2);
    // Channel 0, halfwords, memory counts up, round and round, from the data register.
    let control = stream.get(Stream::S0cr);
    assert_eq!(
        (control >> 25 & 7, control >> 11 & 0xf, control >> 8 & 0b101, control & 1),
        (0, 0b0101, 0b101, 1)
    );
    assert_eq!(stream.get(Stream::S0par), 0x4001_204c);
}
