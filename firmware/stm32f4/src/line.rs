//! The serial line by DMA, so that no interrupt disturbs the sampling and no byte is lost while one is held off.

use core::convert::Infallible;
use core::sync::atomic::{Ordering, compiler_fence};

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};
use stm32f4xx_hal::serial::Serial;

/// Bytes that may arrive between two turns of the main loop: 5 ms of line at 921,600 baud; the host sends far less.
const RECEIVE: usize = 512;
/// Bytes given to the line at once: more than the line takes in a millisecond, the longest wait for the next.
const SEND: usize = 256;
/// USART2's streams of DMA1, and their channel.
const RECEIVE_STREAM: usize = 5;
const SEND_STREAM: usize = 6;
const CHANNEL: u8 = 4;

static mut RECEIVED: [u8; RECEIVE] = [0; RECEIVE];
static mut SENDING: [u8; SEND] = [0; SEND];

/// USART2 with a circular receiving and a one-shot sending stream.
pub struct DmaLine {
    dma: pac::DMA1,
    read: usize,
    _serial: Serial<pac::USART2>,
}

impl DmaLine {
    /// Starts receiving.
    pub fn new(serial: Serial<pac::USART2>, dma: pac::DMA1, rcc: &mut Rcc) -> Self {
        pac::DMA1::enable(rcc);
        pac::DMA1::reset(rcc);
        // SAFETY: the address of a register, not an access.
        let data = unsafe { (*pac::USART2::ptr()).dr().as_ptr() } as u32;
        let stream = dma.st(RECEIVE_STREAM);
        // SAFETY: the stream writes only inside RECEIVED, which nothing else writes, and runs for ever.
        unsafe {
            stream.par().write(|w| w.bits(data));
            stream.m0ar().write(|w| w.bits(&raw mut RECEIVED as u32));
            stream.ndtr().write(|w| w.bits(RECEIVE as u32));
            stream.cr().write(|w| w.chsel().bits(CHANNEL).minc().set_bit().circ().set_bit().en().set_bit());
            dma.st(SEND_STREAM).par().write(|w| w.bits(data));
        }
        DmaLine { dma, read: 0, _serial: serial }
    }

    /// Where the receiving stream will write next.
    fn write_place(&self) -> usize {
        (RECEIVE - self.dma.st(RECEIVE_STREAM).ndtr().read().bits() as usize) % RECEIVE
    }

    fn sending(&self) -> bool {
        self.dma.st(SEND_STREAM).cr().read().en().bit_is_set()
    }
}

impl ErrorType for DmaLine {
    type Error = Infallible;
}

impl ReadReady for DmaLine {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.read != self.write_place())
    }
}

impl Read for DmaLine {
    fn read(&mut self, out: &mut [u8]) -> Result<usize, Infallible> {
        let mut taken = 0;
        let end = self.write_place();
        compiler_fence(Ordering::Acquire);
        while taken < out.len() && self.read != end {
            // SAFETY: in bounds, and the stream writes elsewhere now; volatile because it did write here.
            out[taken] = unsafe { (&raw const RECEIVED).cast::<u8>().add(self.read).read_volatile() };
            self.read = (self.read + 1) % RECEIVE;
            taken += 1;
        }
        Ok(taken)
    }
}

impl WriteReady for DmaLine {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.sending())
    }
}

impl Write for DmaLine {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        while self.sending() {}
        let length = bytes.len().min(SEND);
        // SAFETY: the stream is at rest, so the buffer is this function's alone; then the stream only reads it.
        unsafe {
            core::ptr::copy_nonoverlapping(bytes.as_ptr(), (&raw mut SENDING).cast(), length);
            compiler_fence(Ordering::Release);
            self.dma.hifcr().write(|w| w.bits(0x3d << 16)); // every flag of stream 6
            // Transmission complete: a stream's writes do not clear it, and `flush` waits for it.
            (*pac::USART2::ptr()).sr().write(|w| w.bits(!(1 << 6)));
            let stream = self.dma.st(SEND_STREAM);
            stream.m0ar().write(|w| w.bits(&raw const SENDING as u32));
            stream.ndtr().write(|w| w.bits(length as u32));
            stream.cr().write(|w| {
                w.chsel().bits(CHANNEL).minc().set_bit().dir().memory_to_peripheral().en().set_bit()
            });
        }
        Ok(length)
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        while self.sending() {}
        // SAFETY: a read of a status register; the last byte leaves after the stream is done.
        while unsafe { (*pac::USART2::ptr()).sr().read().tc().bit_is_clear() } {}
        Ok(())
    }
}
