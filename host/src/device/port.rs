//! The line itself: a serial port, or a TCP connection that stands for one.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use serial2::SerialPort;

use crate::error::{Error, Result};

/// The board's speed, baud. TCP knows no speed.
const BAUD: u32 = 921_600;
/// How long a turn waits for bytes.
const TURN: Duration = Duration::from_millis(4);
/// How long a TCP connection may take.
const CONNECT: Duration = Duration::from_secs(5);

trait Line: Read + Write {}
impl<L: Read + Write> Line for L {}

/// An open line to a board.
pub struct Port {
    name: String,
    line: Box<dyn Line>,
}

impl Port {
    /// Opens `tcp://host:port`, or a serial device by its path or name.
    ///
    /// # Errors
    /// The device error, with what to check.
    pub fn open(name: &str) -> Result<Self> {
        let line = match name.strip_prefix("tcp://") {
            Some(address) => open_tcp(name, address)?,
            None => open_serial(name)?,
        };
        Ok(Self { name: name.to_owned(), line })
    }

    /// Turns the wheel of a conversation until `turn` has its answer: it is given the time since the start and what was
    /// received, and adds what is to be sent.
    ///
    /// # Errors
    /// When the line breaks.
    pub fn converse<T>(
        &mut self,
        mut turn: impl FnMut(Duration, &[u8], &mut Vec<u8>) -> Option<T>,
    ) -> Result<T> {
        let start = Instant::now();
        let mut buffer = [0; 4096];
        let mut send = Vec::new();
        loop {
            let received = match self.line.read(&mut buffer) {
                Ok(0) => return Err(self.broken("the other end closed the line")),
                Ok(received) => received,
                Err(error) if quiet(error.kind()) => 0,
                Err(error) => return Err(self.broken(&error.to_string())),
            };
            if let Some(answer) = turn(start.elapsed(), &buffer[..received], &mut send) {
                return Ok(answer);
            }
            if !send.is_empty() {
                self.line.write_all(&send).map_err(|error| self.broken(&error.to_string()))?;
                send.clear();
            }
        }
    }

    fn broken(&self, why: &str) -> Error {
        Error::device(
            format!("{}: {why}", self.name),
            "check the cable and that the board (or the bench) still runs",
        )
    }
}

/// Nothing to read within a turn.
fn quiet(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

fn open_tcp(name: &str, address: &str) -> Result<Box<dyn Line>> {
    let fault = |why: String| {
        Error::device(
            format!("{name}: {why}"),
            "start the bench (cargo xtask bench) or name the address it prints",
        )
    };
    let mut addresses = address.to_socket_addrs().map_err(|error| fault(error.to_string()))?;
    let first = addresses.next().ok_or_else(|| fault("the address leads nowhere".to_owned()))?;
    let stream = TcpStream::connect_timeout(&first, CONNECT).map_err(|error| fault(error.to_string()))?;
    stream
        .set_nodelay(true)
        .and_then(|()| stream.set_read_timeout(Some(TURN)))
        .map_err(|error| fault(error.to_string()))?;
    Ok(Box::new(stream))
}

fn open_serial(name: &str) -> Result<Box<dyn Line>> {
    let mut port = SerialPort::open(name, BAUD).map_err(|error| {
        let ports = SerialPort::available_ports().unwrap_or_default();
        let found: Vec<String> = ports.iter().map(|port| port.display().to_string()).collect();
        let found = if found.is_empty() { "none is there".to_owned() } else { found.join(", ") };
        Error::device(format!("{name}: {error}"), format!("name a serial port ({found}) or tcp://host:port"))
    })?;
    port.set_read_timeout(TURN)
        .map_err(|error| Error::device(format!("{name}: {error}"), "use another serial adapter"))?;
    // What an earlier program left in the line is not for this conversation.
    let _ = port.discard_buffers();
    Ok(Box::new(port))
}
