//! A dead man's handle of hardware alone: outputs that no program renews are taken away.
//!
//! TIM1 counts its PWM periods down (RCR, RM0090 17.3.3), and every new duty begins the count anew. Where none comes when
//! the sampling timer's next interrupt is half a millisecond late, because the program hangs, be it with its interrupts held off, or because the
//! sampling timer is dead, the count's end asks the DMA for one transfer, which clears MOE: PWM and enable fall together.

use core::sync::atomic::{AtomicU32, Ordering};

use motorlens_firmware::beat;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use crate::CORE_HZ;

/// TIM1's update is this stream of DMA2, on this channel (RM0090 table 43, RM0390 table 29, RM0383 table 28).
const STREAM: usize = 5;
const CHANNEL: u8 = 6;
/// TIM1_BDTR in words from TIM1_CR1, which the timer's own burst register writes (RM0090 17.4.19 and 20).
const BDTR: u8 = 0x44 / 4;
/// The repetition counter has 8 bits.
const MOST: u32 = 255;

/// What the transfer writes: the break register without MOE.
static OFF: AtomicU32 = AtomicU32::new(0);

/// Sets the stream up, at rest. Call it when the break register has its final value.
pub fn prepare(_: pac::DMA2, rcc: &mut Rcc) {
    pac::DMA2::enable(rcc);
    pac::DMA2::reset(rcc);
    // SAFETY: TIM1 and this stream are this program's alone; the stream reads one word and writes one register.
    unsafe {
        let timer = &*pac::TIM1::ptr();
        OFF.store(timer.bdtr().read().bits() & !(1 << 15), Ordering::Relaxed);
        // A restart by the program is no end of the count (URS).
        timer.cr1().modify(|_, w| w.urs().set_bit());
        timer.dcr().write(|w| w.dba().bits(BDTR).dbl().bits(0));
        let stream = (*pac::DMA2::ptr()).st(STREAM);
        stream.par().write(|w| w.bits(timer.dmar().as_ptr() as u32));
        stream.m0ar().write(|w| w.bits(OFF.as_ptr() as u32));
    }
}

/// Periods less one that make the time between two interrupts and the grace.
pub fn repetitions(apart_ticks: u32, period_ticks: u32) -> u32 {
    let grace = beat::GRACE_US * (CORE_HZ / 1_000_000);
    ((apart_ticks + grace) / period_ticks.max(1)).saturating_sub(1).min(MOST)
}

/// Begins to watch.
pub fn arm() {
    disarm();
    // SAFETY: as in `prepare`; the flags are those of the fifth stream, cleared by writing 1.
    unsafe {
        let dma = &*pac::DMA2::ptr();
        dma.hifcr().write(|w| w.bits(0x3d << 6));
        dma.st(STREAM).ndtr().write(|w| w.bits(1));
        dma.st(STREAM).cr().write(|w| {
            w.chsel().bits(CHANNEL).dir().memory_to_peripheral().msize().bits32().psize().bits32();
            w.pl().very_high().en().set_bit()
        });
        let timer = &*pac::TIM1::ptr();
        timer.egr().write(|w| w.ug().set_bit());
        timer.dier().modify(|_, w| w.ude().set_bit());
    }
}

/// Ends it, and takes a request back that waits.
pub fn disarm() {
    // SAFETY: as in `prepare`.
    unsafe {
        (*pac::TIM1::ptr()).dier().modify(|_, w| w.ude().clear_bit());
        (*pac::DMA2::ptr()).st(STREAM).cr().modify(|_, w| w.en().clear_bit());
    }
}
