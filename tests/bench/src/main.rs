//! A bench for a person without hardware: the firmware on the emulated board, its serial line on a TCP port.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::{Parser, ValueEnum};
use motorlens_bench::bench::{self, Remote, Scene};
use motorlens_bench::cable::Cable;
use motorlens_bench::machine::CORE_HZ;
use motorlens_bench::plant::Plant;
use motorlens_shared::link::DriveMode;
use motorlens_virtual_motor::{Effect, EncoderShaft, Motor, VirtualMotor};

/// The driver that is wired up.
#[derive(Clone, Copy, ValueEnum)]
enum Wired {
    Brake,
    Coast,
    AntiPhase,
}

/// Run the firmware image on the virtual bench and offer its serial line on a TCP port.
#[derive(Parser)]
struct Options {
    /// The firmware's ELF
    #[arg(long)]
    image: PathBuf,
    /// Port on the loopback interface; 0 takes any
    #[arg(long, default_value_t = 4700)]
    port: u16,
    /// Let this number pick effects and tell nobody
    #[arg(long, value_name = "SEED", conflicts_with = "effects")]
    hidden: Option<u64>,
    /// Tell what the number of --hidden hides, and end
    #[arg(long, requires = "hidden")]
    reveal: bool,
    /// An effect of the motor, for example coulomb=0.3; repeatable
    #[arg(long = "effect", value_name = "NAME[=SIZE]", value_parser = Effect::parse)]
    effects: Vec<Effect>,
    /// The driver; give capture the same --drive
    #[arg(long, value_enum, default_value = "brake")]
    drive: Wired,
    /// Share of the line's bytes to spoil
    #[arg(long, default_value_t = 0.0)]
    spoil: f64,
    /// Virtual seconds in a second at most
    #[arg(long, default_value_t = 1.0)]
    speed: f64,
}

/// Further behind the clock on the wall than this the bench does not hurry after it: the host's program, which speaks by that clock, would say
/// nothing for longer than the board waits.
const BEHIND: Duration = Duration::from_millis(20);

/// Whoever is connected, in step with the clock on the wall.
struct Server {
    listener: TcpListener,
    client: Option<TcpStream>,
    start: Instant,
    speed: f64,
}

impl Remote for Server {
    fn turn(&mut self, now: Duration, received: &[u8], send: &mut Vec<u8>, _: &mut Scene) -> bool {
        let (due, elapsed) = (now.div_f64(self.speed), self.start.elapsed());
        if let Some(early) = due.checked_sub(elapsed) {
            std::thread::sleep(early);
        } else if elapsed - due > BEHIND {
            self.start += elapsed - due;
        }
        if let Ok((client, _)) = self.listener.accept()
            && client.set_nonblocking(true).and_then(|()| client.set_nodelay(true)).is_ok()
        {
            self.client = Some(client);
        }
        let Some(client) = &mut self.client else { return true };
        let mut buffer = [0; 1024];
        // A client that does not read loses bytes, as on a serial line.
        let lost = |error: std::io::Error| error.kind() == ErrorKind::WouldBlock;
        let mut alive = client.write_all(received).map_or_else(lost, |()| true);
        match client.read(&mut buffer) {
            Ok(0) => alive = false,
            Ok(length) => send.extend_from_slice(&buffer[..length]),
            Err(error) => alive &= error.kind() == ErrorKind::WouldBlock,
        }
        if !alive {
            self.client = None;
        }
        true
    }
}

fn main() -> std::io::Result<()> {
    let options = Options::parse();
    let motor = Motor::paper();
    let effects = match options.hidden {
        Some(seed) => motorlens::simulate::hidden(seed, &motor),
        None => options.effects,
    };
    if options.reveal {
        let names: Vec<String> = effects.iter().map(ToString::to_string).collect();
        println!("{}", if names.is_empty() { "nothing is hidden".to_owned() } else { names.join("  ") });
        if names.iter().any(|name| name.starts_with("supply_sag")) {
            println!(
                "(supply_sag is no riddle with --divider 11: the board measures its supply, so the logged voltage holds it)"
            );
        }
        return Ok(());
    }
    let driver = match options.drive {
        Wired::Brake => DriveMode::SignMagnitudeBrake,
        Wired::Coast => DriveMode::SignMagnitudeCoast,
        Wired::AntiPhase => DriveMode::LockedAntiPhase,
    };
    let listener = TcpListener::bind(("127.0.0.1", options.port))?;
    listener.set_nonblocking(true)?;
    let turns = if motor.encoder_shaft == EncoderShaft::Motor { motor.gear_ratio } else { 1.0 };
    println!(
        "the board answers at tcp://{}; --counts-per-rev {}",
        listener.local_addr()?,
        motor.encoder_counts * turns
    );
    std::io::stdout().flush()?;
    let plant = Plant::new(VirtualMotor::new(&motor, &effects, options.hidden.unwrap_or(1)), driver);
    let server = Server { listener, client: None, start: Instant::now(), speed: options.speed };
    bench::run(&options.image, CORE_HZ, plant, Cable::new(options.spoil, 1), server);
    Ok(())
}
