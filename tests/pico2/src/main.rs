//! The emulated Pico 2 with what goes over its USB line on a TCP port: `motorlens-pico2 image.uf2 [fault [lines [driver]]]` prints the port, ends
//! when so many have called and gone, one unless more are said, and prints how the driver was then, which is `brake` or `in-in`. Between callers
//! time stands still.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread::sleep;
use std::time::{Duration, Instant};

use motorlens_pico2::board::{Board, STEP_S};

/// The line is looked at after so much time of the board, s.
const LOOK_S: f64 = 0.005;
/// The board runs for so long before the first caller, s.
const READY_S: f64 = 0.05;
/// The board's time goes as fast as the emulator runs, the caller's by the wall clock: on a busy machine the caller may get no turn for so long
/// that the board takes it for gone. Where a driven board has heard nothing for so long, s, its time stands still until it does.
const SILENCE_S: f64 = 0.15;
/// After so long a caller is gone indeed.
const LIMIT: Duration = Duration::from_secs(10);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let image = arguments.next().ok_or("motorlens-pico2 image.uf2 [fault [lines [driver]]]")?;
    let fault = arguments.next().as_deref().unwrap_or("none").parse()?;
    let lines: usize = arguments.next().as_deref().unwrap_or("1").parse()?;
    let driver = arguments.next().as_deref().unwrap_or("brake").parse()?;
    let mut board = Board::new(&std::fs::read(image)?, driver, fault);
    while board.chip.now() < READY_S {
        board.step();
    }
    let listener = TcpListener::bind(("127.0.0.1", 0))?;
    println!("port {}", listener.local_addr()?.port());
    for line in listener.incoming().take(lines) {
        serve(&mut board, line?)?;
    }
    let driver = if board.volts().is_none() { "off" } else { "driven" };
    let told = board.off_ms().map_or(String::new(), |off| format!(", off {off:.2} ms after the fault"));
    let (restarts, now) = (board.chip.restarts(), board.chip.now());
    println!("closed: driver {driver}{told}, {restarts} resets, {now} s");
    Ok(())
}

/// Carries bytes both ways until the caller has gone.
fn serve(board: &mut Board, mut line: TcpStream) -> std::io::Result<()> {
    line.set_nodelay(true)?;
    line.set_nonblocking(true)?;
    let mut bytes = [0; 4096];
    let (mut heard_s, mut waits) = (board.chip.now(), None);
    loop {
        match line.read(&mut bytes) {
            Ok(0) => return Ok(()),
            Ok(length) => {
                board.host.sending.extend(&bytes[..length]);
                (heard_s, waits) = (board.chip.now(), None);
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                let is_silent = board.volts().is_some() && board.chip.now() - heard_s >= SILENCE_S;
                if is_silent && waits.get_or_insert_with(Instant::now).elapsed() < LIMIT {
                    sleep(Duration::from_millis(1));
                    continue;
                }
            }
            // The caller has gone without a word.
            Err(error) if error.kind() == ErrorKind::ConnectionReset => return Ok(()),
            Err(error) => return Err(error),
        }
        for _ in 0..(LOOK_S / STEP_S) as usize {
            board.step();
        }
        let said = std::mem::take(&mut board.host.received);
        match line.write_all(&said) {
            Err(error) if matches!(error.kind(), ErrorKind::BrokenPipe | ErrorKind::ConnectionReset) => {
                return Ok(());
            }
            written => written?,
        }
    }
}
