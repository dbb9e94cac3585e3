//! Supply and current: the converter goes round its inputs by itself, and the DMA keeps what it finds.
//!
//! A round is the supply, the current and the internal reference, one after the other and again, all the time. The sampling
//! interrupt adds up the rounds of an interval, which holds whole PWM periods, and how long a round takes is chosen so that
//! rounds fall evenly on those periods ([`most_even`]): neither the ripple nor the pulses of the bridge bias the mean. The reference of each
//! interval says what the converter's own supply was in it.

use core::sync::atomic::{AtomicU32, Ordering};

use motorlens_firmware::analog::{Means, Sums, Wiring, full_scale_mv, most_even};
use motorlens_firmware::hardware::Analog;
use stm32f4xx_hal::adc::config::{AdcConfig, Clock};
use stm32f4xx_hal::adc::Adc;
use stm32f4xx_hal::gpio::{Analog as AnalogPin, PA1, PA4};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::signature::VrefCal;

/// Channels of ADC1: PA4, PA1, and the reference.
const SUPPLY_CHANNEL: u32 = 4;
const CURRENT_CHANNEL: u32 = 1;
const REFERENCE_CHANNEL: u32 = 17;
/// The core's ticks in one of the converter's: 14 MHz, of which the data sheets allow 36 at most.
const DIVISION: u32 = 6;
/// The fields SMPx that supply and current may have, and the cycles that they stand for; the reference has 144, which are the 10 us that
/// it wants at least (RM0090 13.13.4, data sheets: TS_vrefint).
const SAMPLINGS: [(u32, u32); 5] = [(0b001, 15), (0b010, 28), (0b011, 56), (0b100, 84), (0b101, 112)];
const REFERENCE_SAMPLING: (u32, u32) = (0b110, 144);
/// Cycles of a conversion after its sampling.
const CONVERSION: u32 = 12;

/// ADC1 is this stream of DMA2, on this channel (RM0090 table 44, RM0390 table 29, RM0383 table 28).
const STREAM: usize = 0;
const CHANNEL: u8 = 0;
/// Inputs of a round.
const INPUTS: usize = 3;
/// Rounds that are kept: the fastest takes 15 us, so they last for two of the sampling timer's interrupts, which are a millisecond
/// apart at most.
const ROUNDS: usize = 134;
const LENGTH: usize = ROUNDS * INPUTS;

/// Where the stream writes, two readings to a word.
static READINGS: [AtomicU32; LENGTH / 2] = [const { AtomicU32::new(0) }; LENGTH / 2];

/// The core's ticks of a round with this sampling of supply and current, cycles.
const fn round_ticks(sampling: u32) -> u32 {
    (2 * (sampling + CONVERSION) + REFERENCE_SAMPLING.1 + CONVERSION) * DIVISION
}

/// The converter and its two inputs.
pub struct Sense {
    _converter: Adc<pac::ADC1>,
    _inputs: (PA4<AnalogPin>, PA1<AnalogPin>),
    wiring: Wiring,
    sums: Sums,
    read: usize,
}

impl Sense {
    /// Takes the converter; DMA2 is clocked by then.
    pub fn new(adc: pac::ADC1, supply: PA4<AnalogPin>, current: PA1<AnalogPin>, rcc: &mut Rcc) -> Self {
        let config = AdcConfig::default().clock(Clock::Pclk2_div_6);
        let mut converter = Adc::new(adc, true, config, rcc);
        converter.enable_temperature_and_vref();
        converter.enable();
        // SAFETY: the converter and the stream are this module's alone; the stream writes inside READINGS only, as halfwords.
        unsafe {
            let registers = &*pac::ADC1::ptr();
            registers.sqr1().modify(|_, w| w.l().bits(INPUTS as u8 - 1));
            registers.sqr3().write(|w| w.bits(SUPPLY_CHANNEL | CURRENT_CHANNEL << 5 | REFERENCE_CHANNEL << 10));
            registers.smpr1().write(|w| w.bits(REFERENCE_SAMPLING.0 << (3 * (REFERENCE_CHANNEL - 10))));
            registers.cr1().modify(|_, w| w.scan().set_bit());
            let stream = (*pac::DMA2::ptr()).st(STREAM);
            stream.par().write(|w| w.bits(registers.dr().as_ptr() as u32));
            stream.m0ar().write(|w| w.bits(READINGS.as_ptr() as u32));
        }
        set_round(SAMPLINGS[0].0);
        Sense {
            _converter: converter,
            _inputs: (supply, current),
            wiring: Wiring::default(),
            sums: Sums::new(),
            read: 0,
        }
    }
}

/// Chooses the round for `interval` ticks of the core, which hold whole PWM periods of `period` ticks.
pub fn fit_round(period: u32, interval: u32) {
    let ticks = most_even(period, interval, SAMPLINGS.iter().map(|(_, cycles)| round_ticks(*cycles)));
    let chosen = SAMPLINGS.iter().find(|(_, cycles)| round_ticks(*cycles) == ticks);
    set_round(chosen.map_or(SAMPLINGS[0].0, |(field, _)| *field));
}

/// Starts the rounds, with this field SMPx for supply and current.
fn set_round(sampling: u32) {
    // SAFETY: as in `Sense::new`. The converter is off while its times change, and the stream while it is set up. Requests go on after the
    // last transfer (DDS), and the stream begins again by itself (RM0090 13.8.1, 10.3.8).
    unsafe {
        let registers = &*pac::ADC1::ptr();
        registers.cr2().modify(|_, w| w.adon().clear_bit().dma().clear_bit());
        registers.smpr2().write(|w| w.bits(sampling << (3 * SUPPLY_CHANNEL) | sampling << (3 * CURRENT_CHANNEL)));
        let dma = &*pac::DMA2::ptr();
        let stream = dma.st(STREAM);
        stream.cr().modify(|_, w| w.en().clear_bit());
        // A transfer that is under way ends within some cycles.
        let _ = (0..100).any(|_| stream.cr().read().en().bit_is_clear());
        dma.lifcr().write(|w| w.bits(0x3d));
        stream.ndtr().write(|w| w.bits(LENGTH as u32));
        stream.cr().write(|w| {
            w.chsel().bits(CHANNEL).psize().bits16().msize().bits16();
            w.minc().set_bit().circ().set_bit().pl().high().en().set_bit()
        });
        registers.sr().modify(|_, w| w.ovr().clear_bit());
        registers.cr2().modify(|_, w| w.cont().set_bit().dma().set_bit().dds().set_bit().adon().set_bit());
        // It wants 3 us to be stable (data sheets: t_STAB).
        cortex_m::asm::delay(crate::CORE_HZ / 200_000);
        registers.cr2().modify(|_, w| w.swstart().set_bit());
    }
}

impl Analog for Sense {
    const CONVERTER: bool = true;

    fn wire(&mut self, wiring: Wiring) {
        self.wiring = wiring;
    }

    fn gather(&mut self) {
        // SAFETY: a read of a counter, which runs down and begins anew.
        let left = unsafe { (*pac::DMA2::ptr()).st(STREAM).ndtr().read().bits() } as usize;
        // The round that is under way is left for the next time.
        let end = LENGTH.saturating_sub(left) / INPUTS;
        let end = if end >= ROUNDS { 0 } else { end };
        let reading = |place: usize| {
            let word = READINGS.get(place / 2).map_or(0, |word| word.load(Ordering::Relaxed));
            (word >> (16 * (place % 2))) as u16
        };
        while self.read != end {
            let place = self.read * INPUTS;
            self.sums.add(reading(place), reading(place + 1), reading(place + 2));
            self.read = if self.read + 1 >= ROUNDS { 0 } else { self.read + 1 };
        }
    }

    fn means(&mut self) -> Means {
        self.gather();
        self.sums.take(self.wiring, |sum, count| full_scale_mv(VrefCal::get().read(), sum, count))
    }
}
