//! Supply and current: the converter goes round its inputs by itself, and the DMA keeps what it finds.
//!
//! A round is the supply and the current, one after the other and again, all the time that anything is wired to them. The sampling interrupt
//! adds up the rounds of an interval, which holds whole PWM periods, and how long a round takes is chosen so that rounds fall evenly on those
//! periods ([`most_even`]): neither the ripple nor the pulses of the bridge bias the mean. What the converter's own supply is, the internal
//! reference says each time that a setup comes: in the rounds it would take four times as long as both inputs.

use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

use motorlens_firmware::analog::{CALIBRATED_MV, Means, Sums, Wiring, full_scale_mv, most_even};
use motorlens_firmware::hardware::Analog;
use stm32f4xx_hal::adc::Adc;
use stm32f4xx_hal::adc::config::{AdcConfig, Clock};
use stm32f4xx_hal::gpio::{Analog as AnalogPin, PA1, PA4};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::signature::VrefCal;

/// Channels of ADC1: PA4, PA1, and the reference.
const SUPPLY_CHANNEL: u32 = 4;
const CURRENT_CHANNEL: u32 = 1;
const REFERENCE_CHANNEL: u32 = 17;
/// The core's ticks in one of the converter's: 21 MHz, of which the data sheets allow 36 at most.
const DIVISION: u32 = 4;
/// The fields SMPx that supply and current may have, and the cycles that they stand for. The reference has 480, which are more than the
/// 10 us that it wants (RM0090 13.13.4, data sheets: TS_vrefint).
const SAMPLINGS: [[(u32, u32); 2]; 3] =
    [[(0b001, 15), (0b001, 15)], [(0b010, 28), (0b001, 15)], [(0b010, 28), (0b010, 28)]];
const REFERENCE_SAMPLING: u32 = 0b111;
/// Conversions of the reference that are added up, and looks at the end of each, which comes after 492 cycles: 1968 of the core's.
const REFERENCES: u32 = 16;
const LOOKS: u32 = 1000;
/// Cycles of a conversion after its sampling.
const CONVERSION: u32 = 12;

/// ADC1 is this stream of DMA2, on this channel (RM0090 table 44, RM0390 table 29, RM0383 table 28).
const STREAM: usize = 0;
const CHANNEL: u8 = 0;
/// Inputs of a round.
const INPUTS: usize = 2;
/// Rounds that are kept: the fastest takes 2.57 us, so they last for two of the sampling timer's interrupts, which are a millisecond
/// apart at most.
const ROUNDS: usize = 800;
const LENGTH: usize = ROUNDS * INPUTS;

/// Where the stream writes, a round to a word: the supply in its lower half.
static READINGS: [AtomicU32; ROUNDS] = [const { AtomicU32::new(0) }; ROUNDS];
/// The converter's own supply, mV.
static FULL_MV: AtomicU32 = AtomicU32::new(CALIBRATED_MV);
/// The samplings of a round, a place in [`SAMPLINGS`].
static ROUND: AtomicUsize = AtomicUsize::new(0);

/// The core's ticks of a round with these samplings of supply and current.
fn round_ticks(samplings: &[(u32, u32); 2]) -> u32 {
    samplings.iter().map(|(_, cycles)| (cycles + CONVERSION) * DIVISION).sum()
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
        let config = AdcConfig::default().clock(Clock::Pclk2_div_4);
        let mut converter = Adc::new(adc, true, config, rcc);
        converter.enable_temperature_and_vref();
        converter.enable();
        // SAFETY: the converter and the stream are this module's alone; the stream writes inside READINGS only, as halfwords.
        unsafe {
            let registers = &*pac::ADC1::ptr();
            registers.smpr1().write(|w| w.bits(REFERENCE_SAMPLING << (3 * (REFERENCE_CHANNEL - 10))));
            registers.cr1().modify(|_, w| w.scan().set_bit());
            let stream = (*pac::DMA2::ptr()).st(STREAM);
            stream.par().write(|w| w.bits(registers.dr().as_ptr() as u32));
            stream.m0ar().write(|w| w.bits(READINGS.as_ptr() as u32));
        }
        Sense {
            _converter: converter,
            _inputs: (supply, current),
            wiring: Wiring::default(),
            sums: Sums::new(),
            read: 0,
        }
    }
}

/// Chooses the round for `interval` ticks of the core, which hold whole PWM periods of `period` ticks. Rounds are so from the next time that
/// it is said what is wired.
pub fn fit_round(period: u32, interval: u32) {
    let ticks = most_even(period, interval, SAMPLINGS.iter().map(round_ticks));
    let round = SAMPLINGS.iter().position(|samplings| round_ticks(samplings) == ticks);
    ROUND.store(round.unwrap_or(0), Ordering::Relaxed);
}

/// Ends the rounds.
fn rest() {
    // SAFETY: as in `Sense::new`.
    unsafe {
        let registers = &*pac::ADC1::ptr();
        registers.cr2().modify(|_, w| w.adon().clear_bit().dma().clear_bit().cont().clear_bit());
        let stream = (*pac::DMA2::ptr()).st(STREAM);
        stream.cr().modify(|_, w| w.en().clear_bit());
        // A transfer that is under way ends within some cycles.
        let _ = (0..100).any(|_| stream.cr().read().en().bit_is_clear());
    }
}

/// Measures the reference some times, one conversion after the other. What does not answer reads 0, and is no reference.
fn measure_reference(registers: &pac::adc1::RegisterBlock) {
    // SAFETY: as in `Sense::new`; no conversion is under way.
    unsafe {
        registers.sqr1().modify(|_, w| w.l().bits(0));
        registers.sqr3().write(|w| w.bits(REFERENCE_CHANNEL));
        let mut sum = 0;
        for _ in 0..REFERENCES {
            registers.sr().modify(|_, w| w.eoc().clear_bit());
            registers.cr2().modify(|_, w| w.swstart().set_bit());
            if (0..LOOKS).any(|_| registers.sr().read().eoc().bit_is_set()) {
                sum += registers.dr().read().bits() & 0xfff;
            }
        }
        FULL_MV.store(full_scale_mv(VrefCal::get().read(), sum, REFERENCES), Ordering::Relaxed);
    }
}

/// Measures the reference and starts the rounds, with these fields SMPx for supply and current.
fn set_round(samplings: &[(u32, u32); 2]) {
    let [(supply, _), (current, _)] = *samplings;
    rest();
    // SAFETY: as in `Sense::new`. The converter is off while its times change, and the stream while it is set up. Requests go on after the
    // last transfer (DDS), and the stream begins again by itself (RM0090 13.8.1, 10.3.8).
    unsafe {
        let registers = &*pac::ADC1::ptr();
        registers
            .smpr2()
            .write(|w| w.bits(supply << (3 * SUPPLY_CHANNEL) | current << (3 * CURRENT_CHANNEL)));
        registers.cr2().modify(|_, w| w.adon().set_bit());
        // It wants 3 us to be stable (data sheets: t_STAB), and the reference 10 where it has just been switched on (t_START).
        cortex_m::asm::delay(crate::CORE_HZ / 80_000);
        measure_reference(registers);
        registers.cr2().modify(|_, w| w.adon().clear_bit());
        registers.sqr1().modify(|_, w| w.l().bits(INPUTS as u8 - 1));
        registers.sqr3().write(|w| w.bits(SUPPLY_CHANNEL | CURRENT_CHANNEL << 5));
        let dma = &*pac::DMA2::ptr();
        let stream = dma.st(STREAM);
        dma.lifcr().write(|w| w.bits(0x3d));
        stream.ndtr().write(|w| w.bits(LENGTH as u32));
        stream.cr().write(|w| {
            w.chsel().bits(CHANNEL).psize().bits16().msize().bits16();
            w.minc().set_bit().circ().set_bit().pl().high().en().set_bit()
        });
        registers.sr().modify(|_, w| w.ovr().clear_bit());
        registers.cr2().modify(|_, w| w.cont().set_bit().dma().set_bit().dds().set_bit().adon().set_bit());
        cortex_m::asm::delay(crate::CORE_HZ / 200_000);
        registers.cr2().modify(|_, w| w.swstart().set_bit());
    }
}

impl Analog for Sense {
    const CONVERTER: bool = true;

    fn wire(&mut self, wiring: Wiring) {
        self.wiring = wiring;
        if wiring == Wiring::default() {
            return rest();
        }
        set_round(SAMPLINGS.get(ROUND.load(Ordering::Relaxed)).unwrap_or(&SAMPLINGS[0]));
    }

    fn gather(&mut self) -> Means {
        let before = self.sums;
        // SAFETY: a read of a counter, which runs down and begins anew.
        let left = unsafe { (*pac::DMA2::ptr()).st(STREAM).ndtr().read().bits() } as usize;
        // The round that is under way is left for the next time.
        let end = LENGTH.saturating_sub(left) / INPUTS;
        let end = if end >= ROUNDS { 0 } else { end };
        self.sums.follow(&READINGS, self.read, end);
        self.read = end;
        self.sums.since(&before, self.wiring)
    }

    fn means(&mut self) -> Means {
        self.sums.take(self.wiring, FULL_MV.load(Ordering::Relaxed))
    }
}
