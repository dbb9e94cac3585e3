//! The line itself: a serial port, or a TCP connection that stands for one.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use serial2::SerialPort;

use super::trouble;
use crate::error::{Error, Result};

/// The board's speed, baud. TCP knows no speed.
const BAUD: u32 = 921_600;
/// How long a turn waits for bytes.
const TURN: Duration = Duration::from_millis(4);
/// How long a TCP connection may take.
const CONNECT: Duration = Duration::from_secs(5);
/// A line that breaks (a USB plug pulled out) is opened again within this time, and tried so often.
const RETURN: Duration = Duration::from_secs(10);
const TRY_AGAIN: Duration = Duration::from_millis(100);

trait Line: Read + Write {}
impl<L: Read + Write> Line for L {}

/// An open line to a board.
pub struct Port {
    name: String,
    baud: u32,
    line: Result<Box<dyn Line>, Break>,
}

/// A line that is gone for the time being.
#[derive(Debug)]
struct Break {
    since: Instant,
    why: String,
}

impl Port {
    /// Opens `tcp://host:port`, or a serial device by its path or name.
    ///
    /// # Errors
    /// The device error, with what to check.
    pub fn open(name: &str) -> Result<Self> {
        Self::open_at(name, BAUD)
    }

    /// [`Self::open`] at another speed of the serial line.
    ///
    /// # Errors
    /// As there.
    pub fn open_at(name: &str, baud: u32) -> Result<Self> {
        Ok(Self { name: name.to_owned(), baud, line: Ok(open(name, baud)?) })
    }

    /// Turns the wheel of a conversation until `turn` has its answer: it is given the time since the start and what was
    /// received, and adds what is to be sent. The conversation goes on where the line breaks and comes back.
    ///
    /// # Errors
    /// When the line breaks and does not come back within ten seconds.
    pub fn converse<T>(
        &mut self,
        mut turn: impl FnMut(Duration, &[u8], &mut Vec<u8>) -> Option<T>,
    ) -> Result<T> {
        let start = Instant::now();
        let mut buffer = [0; 4096];
        let mut send = Vec::new();
        loop {
            let received = self.read(&mut buffer)?;
            if let Some(answer) = turn(start.elapsed(), &buffer[..received], &mut send) {
                return Ok(answer);
            }
            self.write(&send);
            send.clear();
        }
    }

    /// Bytes that came within a turn. None come while the line is broken.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let why = match &mut self.line {
            Ok(line) => match line.read(buffer) {
                Ok(0) => "the other end closed the line".to_owned(),
                Ok(received) => return Ok(received),
                Err(error) if quiet(error.kind()) => return Ok(0),
                Err(error) => error.to_string(),
            },
            Err(broken) if broken.since.elapsed() > RETURN => {
                return Err(Error::device(
                    format!("{}: {}, and it did not come back", self.name, broken.why),
                    "check the cable and that the board (or the bench) still runs",
                ));
            }
            Err(_) => {
                std::thread::sleep(TRY_AGAIN);
                if let Ok(line) = open(&self.name, self.baud) {
                    self.line = Ok(line);
                }
                return Ok(0);
            }
        };
        self.line = Err(Break { since: Instant::now(), why });
        Ok(0)
    }

    /// What does not reach the board is said again by whoever has to say it.
    fn write(&mut self, bytes: &[u8]) {
        if let Ok(line) = &mut self.line
            && let Err(error) = line.write_all(bytes)
        {
            self.line = Err(Break { since: Instant::now(), why: error.to_string() });
        }
    }
}

fn open(name: &str, baud: u32) -> Result<Box<dyn Line>> {
    match name.strip_prefix("tcp://") {
        Some(address) => open_tcp(name, address),
        None => open_serial(name, baud),
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

fn open_serial(name: &str, baud: u32) -> Result<Box<dyn Line>> {
    let mut port = SerialPort::open(name, baud).map_err(|error| trouble::cannot_open(name, &error))?;
    port.set_read_timeout(TURN)
        .map_err(|error| Error::device(format!("{name}: {error}"), "use another serial adapter"))?;
    // What an earlier program left in the line is not for this conversation.
    let _ = port.discard_buffers();
    Ok(Box::new(port))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    #[test]
    fn a_conversation_outlives_a_line_that_breaks_and_comes_back() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut port = Port::open(&format!("tcp://{}", listener.local_addr().unwrap())).unwrap();
        let board = std::thread::spawn(move || {
            let (mut first, _) = listener.accept().unwrap();
            first.write_all(b"one ").unwrap();
            drop(first);
            let (mut second, _) = listener.accept().unwrap();
            let mut said = [0; 4];
            second.read_exact(&mut said).unwrap();
            second.write_all(b"two").unwrap();
            said
        });
        let mut heard = Vec::new();
        port.converse(|_, received, send| {
            heard.extend_from_slice(received);
            if heard == b"one " {
                send.extend_from_slice(b"more");
            }
            heard.ends_with(b"two").then_some(())
        })
        .unwrap();
        assert_eq!((heard.as_slice(), &board.join().unwrap()), (b"one two".as_slice(), b"more"));
    }
}
