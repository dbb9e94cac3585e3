//! A board for the page: the firmware's own logic driving a simulated motor, its serial line on a TCP port.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use motorlens_virtual_motor::{Bridge, Effect};

// The board that the firmware's own tests run on.
#[path = "../../../firmware/tests/bench/mod.rs"]
pub mod bench;

/// A board that runs in real time; ends with this value.
pub struct Board {
    /// What to connect to.
    pub address: String,
    ends: Arc<AtomicBool>,
    held: Arc<AtomicBool>,
    released: Arc<Mutex<Option<Instant>>>,
    thread: Option<JoinHandle<()>>,
}

impl Board {
    /// Starts a board whose motor has these effects.
    pub fn start(effects: &[&str]) -> Self {
        Self::begin(effects, true)
    }

    /// Starts a board whose shaft something else turns, until somebody holds it.
    pub fn turned() -> Self {
        Self::begin(&[], false)
    }

    /// Holds the shaft against what turns it.
    pub fn hold(&self) {
        self.held.store(true, Ordering::Relaxed);
    }

    fn begin(effects: &[&str], held: bool) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        listener.set_nonblocking(true).expect("a listener that does not wait");
        let address = format!("tcp://{}", listener.local_addr().expect("an address"));
        let ends = Arc::new(AtomicBool::new(false));
        let held = Arc::new(AtomicBool::new(held));
        let released = Arc::new(Mutex::new(None));
        let effects: Vec<Effect> = effects.iter().map(|e| Effect::parse(e).expect("an effect")).collect();
        let (end, hand, off) = (Arc::clone(&ends), Arc::clone(&held), Arc::clone(&released));
        let thread = std::thread::spawn(move || live(&listener, &effects, &end, &hand, &off));
        Self { address, ends, held, released, thread: Some(thread) }
    }

    /// When the bridge was last let go while it drove the motor.
    pub fn released(&self) -> Option<Instant> {
        *self.released.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// The board's clock stands still where the machine is this busy: the host would seem silent to it.
const MOST_BEHIND: Duration = Duration::from_millis(50);

fn live(
    listener: &TcpListener,
    effects: &[Effect],
    end: &AtomicBool,
    held: &AtomicBool,
    released: &Mutex<Option<Instant>>,
) {
    let mut bench = bench::Bench::new(effects);
    bench.control(|control| control.hardware_mut().cranked_until_us = u32::MAX);
    let mut client: Option<TcpStream> = None;
    let mut clock = Instant::now();
    let mut driven = false;
    while !end.load(Ordering::Relaxed) {
        if let Ok((new, _)) = listener.accept()
            && new.set_nonblocking(true).and_then(|()| new.set_nodelay(true)).is_ok()
        {
            client = Some(new);
        }
        let alive = client.as_mut().is_none_or(|client| exchange(client, &mut bench.cable));
        if !alive {
            client = None;
        }
        if held.load(Ordering::Relaxed) {
            bench.control(|control| {
                let rig = control.hardware_mut();
                rig.cranked_until_us = rig.cranked_until_us.min(rig.now_us);
            });
        }
        clock = clock.max(Instant::now() - MOST_BEHIND);
        while clock < Instant::now() {
            clock += step(&mut bench);
            let drives = bench.control(|control| matches!(control.hardware_mut().bridge, Bridge::Volts(_)));
            if driven && !drives {
                *released.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
            }
            driven = drives;
        }
        std::thread::sleep(Duration::from_micros(300));
    }
}

/// One sampling interrupt and one turn of the main loop; the time that they stand for.
fn step(bench: &mut bench::Bench) -> Duration {
    let period_us = bench.control(|control| {
        let period_us = 1_000_000 / u32::from(control.setup().rate_hz);
        let rig = control.hardware_mut();
        let bridge = rig.bridge;
        rig.motor.advance(f64::from(period_us) * 1e-6, bridge);
        rig.now_us = rig.now_us.wrapping_add(period_us);
        control.tick();
        period_us
    });
    bench.station.poll(&mut bench.cable, bench.control, &mut bench.rest);
    Duration::from_micros(period_us.into())
}

/// Carries bytes both ways; false once the other end has gone.
fn exchange(client: &mut TcpStream, cable: &mut bench::Cable) -> bool {
    let mut buffer = [0; 4096];
    match client.read(&mut buffer) {
        Ok(0) => return false,
        Ok(length) => cable.to_board.extend(&buffer[..length]),
        Err(error) if error.kind() == ErrorKind::WouldBlock => {}
        Err(_) => return false,
    }
    while !cable.to_host.is_empty() {
        match client.write(cable.to_host.as_slices().0) {
            Ok(length) => drop(cable.to_host.drain(..length)),
            Err(error) => return error.kind() == ErrorKind::WouldBlock,
        }
    }
    true
}
