//! Supply and current, where the board has them.

use motorlens_firmware::hardware::Analog;
use stm32f4xx_hal::adc::Adc;
use stm32f4xx_hal::adc::config::{AdcConfig, SampleTime};
use stm32f4xx_hal::gpio::{Analog as AnalogPin, PA1, PA4};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::Rcc;

/// Full scale of the converter, counts.
const FULL: u32 = 4096;
/// Supply at full scale behind the divider 1:11, mV.
const SUPPLY_FULL_MV: u32 = 3300 * 11;
/// Current from half to full scale at 165 mV/A, mA.
const CURRENT_HALF_MA: i32 = 10_000;

/// The converter and its two inputs.
pub struct Sense {
    converter: Adc<pac::ADC1>,
    supply: PA4<AnalogPin>,
    current: PA1<AnalogPin>,
}

impl Sense {
    /// Takes the converter.
    pub fn new(adc: pac::ADC1, supply: PA4<AnalogPin>, current: PA1<AnalogPin>, rcc: &mut Rcc) -> Self {
        Sense { converter: Adc::new(adc, true, AdcConfig::default(), rcc), supply, current }
    }
}

impl Analog for Sense {
    const SUPPLY: bool = cfg!(feature = "supply-sense");
    const CURRENT: bool = cfg!(feature = "current-sense");

    fn supply_mv(&mut self) -> Option<u16> {
        Self::SUPPLY.then(|| {
            let raw = u32::from(self.converter.convert(&self.supply, SampleTime::Cycles_15));
            (raw * SUPPLY_FULL_MV / FULL) as u16
        })
    }

    fn current_ma(&mut self) -> Option<i16> {
        Self::CURRENT.then(|| {
            let raw = i32::from(self.converter.convert(&self.current, SampleTime::Cycles_15));
            let half = FULL as i32 / 2;
            ((raw - half) * CURRENT_HALF_MA / half) as i16
        })
    }
}
