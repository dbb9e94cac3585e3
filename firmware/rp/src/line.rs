//! The serial line over USB: a CDC class device, which every system knows without a driver.

use core::convert::Infallible;

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use usb_device::class_prelude::UsbBusAllocator;
use usb_device::device::{StringDescriptors, UsbDevice, UsbDeviceBuilder, UsbVidPid};
use usbd_serial::{SerialPort, USB_CLASS_CDC};

use crate::hal::usb::UsbBus;

/// Test identifiers of pid.codes, which anybody may use for a device that is not sold.
const ID: UsbVidPid = UsbVidPid(0x1209, 0x0001);
/// Bytes taken from the bus at once: a full-speed packet.
const PACKET: usize = 64;

/// The device on the bus. The bus is served whenever the line is asked anything.
pub struct UsbLine {
    device: UsbDevice<'static, UsbBus>,
    serial: SerialPort<'static, UsbBus>,
    packet: [u8; PACKET],
    read: usize,
    held: usize,
}

impl UsbLine {
    /// Puts the device on the bus.
    pub fn new(bus: &'static UsbBusAllocator<UsbBus>) -> Self {
        let serial = SerialPort::new(bus);
        let names = StringDescriptors::default().manufacturer("motorlens").product("motorlens board");
        // One packet for every descriptor: with smaller ones the RP2040 must answer within microseconds (see its HAL).
        let builder = UsbDeviceBuilder::new(bus, ID).device_class(USB_CLASS_CDC);
        let builder = builder.max_packet_size_0(64).expect("a size that the standard knows");
        let device = builder.strings(&[names]).expect("one language fits").build();
        Self { device, serial, packet: [0; PACKET], read: 0, held: 0 }
    }

    fn serve(&mut self) {
        self.device.poll(&mut [&mut self.serial]);
        // What did not fit into the last packet.
        let _ = self.serial.flush();
        if self.read == self.held {
            self.read = 0;
            self.held = self.serial.read(&mut self.packet).unwrap_or(0);
        }
    }
}

impl ErrorType for UsbLine {
    /// A bus that fails is one that takes nothing.
    type Error = Infallible;
}

impl ReadReady for UsbLine {
    fn read_ready(&mut self) -> Result<bool, Self::Error> {
        self.serve();
        Ok(self.read < self.held)
    }
}

impl Read for UsbLine {
    fn read(&mut self, out: &mut [u8]) -> Result<usize, Self::Error> {
        let taken = out.len().min(self.held - self.read);
        out[..taken].copy_from_slice(&self.packet[self.read..self.read + taken]);
        self.read += taken;
        Ok(taken)
    }
}

impl WriteReady for UsbLine {
    /// A host that has not opened the port takes nothing: what is said to it is dropped, as on a wire.
    fn write_ready(&mut self) -> Result<bool, Self::Error> {
        self.serve();
        Ok(true)
    }
}

impl Write for UsbLine {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        if !self.serial.dtr() {
            return Ok(bytes.len());
        }
        Ok(self.serial.write(bytes).unwrap_or(0))
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
        // The last packet is taken within some turns of the bus, or never.
        for _ in 0..100_000 {
            self.serve();
            if self.serial.flush().is_ok() {
                break;
            }
        }
        Ok(())
    }
}
