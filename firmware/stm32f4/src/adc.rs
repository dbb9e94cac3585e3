//! Supply and current, where the board has them.

use motorlens_firmware::hardware::Analog;
use stm32f4xx_hal::adc::config::{AdcConfig, Clock, SampleTime};
use stm32f4xx_hal::adc::{Adc, Vref};
use stm32f4xx_hal::gpio::{Analog as AnalogPin, PA1, PA4};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::signature::VrefCal;

/// Full scale of the converter, counts.
const FULL: u32 = 4096;
/// The divider before the supply's input.
const DIVIDER: u32 = 11;
/// The current amplifier's slope, mV/A.
const AMPLIFIER_MV: i32 = 165;
/// The supply of the converter at which the maker has measured the internal reference, mV (RM0090 13.10 and the chips'
/// data sheets, "internal reference voltage calibration values"), and also what is taken where no such value is found.
const CALIBRATED_MV: u32 = 3300;
/// Between these a calibration value is one: the reference is 1.18 to 1.24 V of 3.3 V.
const CALIBRATION: core::ops::RangeInclusive<u16> = 1400..=1600;
/// The converter's supply must be one that the chip runs at, mV.
const POSSIBLE_MV: core::ops::RangeInclusive<u32> = 2400..=3600;

/// Channels of ADC1: PA4 and PA1.
const SUPPLY_CHANNEL: u8 = 4;
const CURRENT_CHANNEL: u8 = 1;
/// Looks at the end of a conversion, which is there after 27 cycles of 21 MHz: 108 of the core's.
const LOOKS: u32 = 200;

/// The converter and its two inputs.
pub struct Sense {
    _converter: Adc<pac::ADC1>,
    _inputs: (PA4<AnalogPin>, PA1<AnalogPin>),
    full_mv: u32,
}

impl Sense {
    /// Takes the converter.
    pub fn new(adc: pac::ADC1, supply: PA4<AnalogPin>, current: PA1<AnalogPin>, rcc: &mut Rcc) -> Self {
        // 84 MHz / 4: the data sheets allow 36 MHz at most (fADC), and the HAL's default would be 42.
        let config = AdcConfig::default().clock(Clock::Pclk2_div_4);
        let mut converter = Adc::new(adc, true, config, rcc);
        let full_mv = full_scale_mv(&mut converter);
        converter.enable();
        // SAFETY: the converter is this module's alone. One conversion at a time, of 15 cycles' sampling (RM0090 13.13.5, 13.13.9).
        unsafe {
            let registers = &*pac::ADC1::ptr();
            registers.sqr1().modify(|_, w| w.l().bits(0));
            registers.smpr2().modify(|r, w| w.bits(r.bits() & !SAMPLING_FIELDS | SAMPLING_15));
        }
        Sense { _converter: converter, _inputs: (supply, current), full_mv }
    }
}

/// The fields of both channels in SMPR2, of three bits each, and 15 cycles in them.
const SAMPLING_FIELDS: u32 = 0b111 << (3 * SUPPLY_CHANNEL) | 0b111 << (3 * CURRENT_CHANNEL);
const SAMPLING_15: u32 = 0b001 << (3 * SUPPLY_CHANNEL) | 0b001 << (3 * CURRENT_CHANNEL);

/// Converts once. The HAL's way panics where a conversion has not begun and waits for its end for ever; this runs in the sampling
/// interrupt, and a converter that does not answer reads 0, which as a supply ends the run and as a current is a large one.
fn convert(channel: u8) -> u16 {
    // SAFETY: the converter is this module's alone, and set up when there is a `Sense` to ask.
    unsafe {
        let registers = &*pac::ADC1::ptr();
        registers.sqr3().write(|w| w.bits(channel.into()));
        registers.sr().modify(|_, w| w.eoc().clear_bit());
        registers.cr2().modify(|_, w| w.swstart().set_bit());
        let done = (0..LOOKS).any(|_| registers.sr().read().eoc().bit_is_set());
        if done { registers.dr().read().bits() as u16 } else { 0 }
    }
}

impl Analog for Sense {
    const SUPPLY: bool = cfg!(feature = "supply-sense");
    const CURRENT: bool = cfg!(feature = "current-sense");

    fn supply_mv(&mut self) -> Option<u16> {
        Self::SUPPLY.then(|| {
            let raw = u32::from(convert(SUPPLY_CHANNEL));
            (raw * self.full_mv * DIVIDER / FULL) as u16
        })
    }

    fn current_ma(&mut self) -> Option<i16> {
        Self::CURRENT.then(|| {
            let raw = i32::from(convert(CURRENT_CHANNEL));
            let half = FULL as i32 / 2;
            let millivolts = (raw - half) * self.full_mv as i32 / FULL as i32;
            (millivolts * 1000 / AMPLIFIER_MV) as i16
        })
    }
}

/// The converter's full scale, mV: its own supply, which the internal reference of known voltage tells.
fn full_scale_mv(converter: &mut Adc<pac::ADC1>) -> u32 {
    let calibration = VrefCal::get().read();
    if !CALIBRATION.contains(&calibration) {
        return CALIBRATED_MV;
    }
    converter.enable_temperature_and_vref();
    // The reference wants 10 us to start and as long to be sampled: 480 cycles of 21 MHz are twice that.
    cortex_m::asm::delay(crate::CORE_HZ / 50_000);
    let reading = u32::from(converter.convert(&Vref, SampleTime::Cycles_480)).max(1);
    converter.disable_temperature_and_vref();
    let full_mv = CALIBRATED_MV * u32::from(calibration) / reading;
    if POSSIBLE_MV.contains(&full_mv) { full_mv } else { CALIBRATED_MV }
}
