//! The whole bench, driven through virtual time.

use std::path::Path;
use std::time::Duration;

use rigless::emulator::{AccessKind, Driver, Error, Host, Settled, Stop};
use rigless::session::Session;
use rigless::soc::Width;
use rigless::soc::stm32f427::generated::dma2::Register as StreamRegister;
use rigless::soc::stm32f427::generated::tim1::Register as TimerRegister;
use rigless::time::VirtualNanos;

use crate::cable::{Cable, Socket};
use crate::machine::{self, CORE_HZ, Machine};
use crate::plant::Plant;
use crate::terminal::Terminal;
use crate::upset;
pub use crate::upset::Upset;

/// Registers whose writes mean something to the surroundings.
const TIM4_SR: u64 = 0x4000_0810;
const TIM1_EGR: u64 = 0x4001_0014;
const TIM1_BDTR: u64 = 0x4001_0044;
const GPIOB_ODR: u64 = 0x4002_0414;
const GPIOB_BSRR: u64 = 0x4002_0418;
const TIM1_DMAR: u64 = 0x4001_004c;
const SYSCFG_MEMRMP: u64 = 0x4001_3800;
/// TIM1_BDTR as a burst of one is told of it, in words from the first register.
const BDTR_INDEX: u64 = 0x44 / 4;
/// A stream's enable, direction, both sizes and channel, and what they are for words to a peripheral on channel 6.
const STREAM_FIELDS: u64 = 1 | 0b11 << 6 | 0b1111 << 11 | 0b111 << 25;
const STREAM_WANTED: u64 = 1 | 0b01 << 6 | 0b1010 << 11 | 6 << 25;
/// Where the converter's stream says how many readings are left.
const DMA2_S0NDTR: u64 = 0x4002_6414;
/// Where the supply detector is looked at, twice in a millisecond.
const PWR_CSR: u64 = 0x4000_7004;
/// USART2 and DMA1, which serves it.
const LINE: [std::ops::Range<u64>; 2] = [0x4000_4400..0x4000_4800, 0x4002_6000..0x4002_6400];
/// DMA2 among the controllers.
const DMA_2: usize = 1;
/// USART2 among the serial ports.
const USART2: usize = 1;
/// The line, the remote end and the converter's inputs are looked at so often, ns.
const STOP_NS: u64 = 500_000;

/// Who sits at the other end of the line.
pub trait Remote: Send + 'static {
    /// Half a millisecond has passed: bytes have come, bytes may go. False ends the run.
    fn turn(&mut self, now: Duration, received: &[u8], send: &mut Vec<u8>, scene: &mut Scene) -> bool;
}

/// What a remote end may meddle with.
pub struct Scene {
    /// Driver, motor, encoder.
    pub plant: Plant,
    /// The serial line.
    pub cable: Cable,
    /// Instructions of the longest sampling interrupt so far, from its first access of a register until the duty is set and the
    /// converter's readings are gathered; what follows touches no register.
    pub longest_interrupt: u64,
    /// An upset of the chip's memory, as radiation or a stray pointer would cause; it happens once.
    pub upset: Option<Upset>,
    /// Since when the main loop runs in a circle, or comes upon what is no instruction.
    pub circling: Option<Duration>,
    /// What the program has last written to the register that says which memory stands at address 0 (SYSCFG_MEMRMP, RM0090 9.2.1).
    pub remapped: Option<u64>,
    /// The program is asked to go where the emulated chip has nothing: then that is no fault of the image.
    pub led_astray: bool,
    /// The run has shown what it had to.
    pub enough: bool,
    /// Ctrl-C is pressed at the host; it happens once.
    pub interrupt: bool,
    /// What the board has said to the debugger (RTT), as its bytes.
    pub told: Vec<u8>,
    /// How often the surroundings are looked at, ns.
    pub stop_ns: u64,
}

/// Carries what TIM1's update asks DMA2 for. The emulated timer raises the request and the emulated controller has no wire to it
/// ("no stream serves a timer yet"): this is the wire, stream 5 on channel 6 (RM0090 table 44), and the one transfer that
/// the stream's own registers describe, if it is enabled.
fn serve_timer(served: &mut u64, machine: &mut Machine, host: &mut dyn Host) -> Result<(), Error> {
    let asked = machine.mcu.advanced_timer(0).0.dma_requests().update;
    if std::mem::replace(served, asked) == asked || asked == 0 {
        return Ok(());
    }
    let (_, stream) = machine.mcu.controller(DMA_2);
    let control = stream.get(StreamRegister::S5cr);
    // Enabled, on channel 6, from memory, a word; of one word, to the timer's burst register.
    let described = control & STREAM_FIELDS == STREAM_WANTED && stream.get(StreamRegister::S5ndtr) == 1;
    if !described || stream.get(StreamRegister::S5par) != TIM1_DMAR {
        return Ok(());
    }
    let from = stream.get(StreamRegister::S5m0ar);
    stream.set(StreamRegister::S5cr, control & !1);
    let word = host.read(from, Width::W32)?;
    let (_, timer) = machine.mcu.advanced_timer(0);
    if timer.get(TimerRegister::Dcr) == BDTR_INDEX {
        timer.set(TimerRegister::Bdtr, word);
    }
    Ok(())
}

struct Around<R> {
    scene: Scene,
    remote: R,
    interrupt_began: u64,
    sampling: bool,
    control: u64,
    sleep: u64,
    /// What the main loop is led to from its sleep.
    leads_to: Option<&'static [u64]>,
    terminal: Terminal,
    served: u64,
    stray: Option<String>,
}

impl<R: Remote> Driver<Machine> for Around<R> {
    fn on_settled(&mut self, session: &mut Session<Machine>, host: &mut dyn Host, settled: Settled) {
        let Settled::Access { access, .. } = settled else { return };
        let (machine, plant) = (session.board_mut(), &mut self.scene.plant);
        let at = access.virtual_time;
        // The last time counts: what an earlier sleep has left on the stack is found too.
        if let Some(program) = self.leads_to
            && [TIM4_SR, PWR_CSR].contains(&access.address)
            && upset::lead_to(program, self.sleep, host).expect("the stack is in memory")
        {
            self.scene.circling = Some(Duration::from_nanos(at.0));
        }
        // The serial line is the main loop's: what it sets at the timers after it has heard a command is no interrupt's work.
        self.sampling &= !LINE.iter().any(|registers| registers.contains(&access.address));
        if self.sampling {
            let length = access.instruction_count - self.interrupt_began;
            // The main loop's accesses follow after the interrupt's; these are the last of the interrupt's own.
            let written =
                access.kind == AccessKind::Write && [TIM1_EGR, GPIOB_BSRR].contains(&access.address);
            if written || (access.kind == AccessKind::Read && access.address == DMA2_S0NDTR) {
                self.scene.longest_interrupt = self.scene.longest_interrupt.max(length);
            }
        }
        if access.kind != AccessKind::Write {
            return;
        }
        match access.address {
            TIM4_SR => {
                (self.interrupt_began, self.sampling) = (access.instruction_count, true);
                plant.advance(at, machine);
                plant.sample(at, machine);
            }
            TIM1_EGR | TIM1_BDTR | GPIOB_ODR | GPIOB_BSRR => {
                plant.advance(at, machine);
                if access.address == TIM1_EGR {
                    plant.begin_period(at);
                }
                // The outputs are enabled in the period whose duty is there already.
                plant.look(machine, [TIM1_EGR, TIM1_BDTR].contains(&access.address));
            }
            SYSCFG_MEMRMP => self.scene.remapped = Some(access.value),
            _ => {}
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<Machine>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        self.stray = machine::stray(session);
        if self.stray.is_some() && !self.scene.led_astray {
            return None;
        }
        let machine = session.board_mut();
        let scene = &mut self.scene;
        scene.plant.advance(stop.at, machine);
        scene.plant.sense(stop.at, machine);
        if let Err(error) = self.terminal.drain(host, &mut scene.told) {
            self.stray = Some(format!("the terminal is not in memory: {error}"));
            return None;
        }
        if let Err(error) = serve_timer(&mut self.served, machine, host) {
            self.stray = Some(format!("the controller reached no memory: {error}"));
            return None;
        }
        // A reset of the chip lets go of the pins without a write.
        scene.plant.look(machine, false);
        let Some(socket) = machine.mcu.usart[USART2].chip_mut::<Socket>() else {
            self.stray = Some("the serial line came loose".to_owned());
            return None;
        };
        let received = scene.cable.carry(&std::mem::take(&mut socket.from_board));
        let mut send = Vec::new();
        let now = Duration::from_nanos(stop.at.0);
        let on = self.remote.turn(now, &received, &mut send, scene);
        let carried = scene.cable.carry(&send);
        if let Some(socket) = machine.mcu.usart[USART2].chip_mut::<Socket>() {
            socket.to_board.extend(carried);
        }
        scene.plant.wire_emergency(stop.at, machine);
        let upset = scene.upset.take();
        match upset {
            Some(Upset::Circle) => self.leads_to = Some(machine::CIRCLE),
            Some(Upset::Fault) => self.leads_to = Some(machine::UNDEFINED),
            Some(Upset::Nmi) => self.leads_to = Some(machine::ASK_FOR_NMI),
            Some(Upset::Straight) => self.leads_to = None,
            _ => {}
        }
        if let Some(upset) = upset
            && let Err(error) = upset.strike(stop.at, machine, host, self.control)
        {
            self.stray = Some(format!("the upset did not reach the memory: {error}"));
            return None;
        }
        on.then_some(VirtualNanos(stop.at.0 + scene.stop_ns))
    }
}

/// What a run leaves behind.
pub struct Done<R> {
    /// The chip and the emulator's findings.
    pub session: Session<Machine>,
    /// The surroundings.
    pub scene: Scene,
    /// The remote end.
    pub remote: R,
}

/// Runs an image on the bench at this rate of instructions until the remote end has enough.
///
/// # Panics
/// When the image cannot be read, touches what the chip has not, or the emulator gives up.
pub fn run<R: Remote>(
    image: &Path,
    instructions_per_second: u64,
    plant: Plant,
    cable: Cable,
    remote: R,
) -> Done<R> {
    run_on(Machine::new(instructions_per_second), image, plant, cable, remote)
}

/// [`run`] on a machine that is set up already.
///
/// # Panics
/// As [`run`].
pub fn run_on<R: Remote>(
    mut machine: Machine,
    image: &Path,
    plant: Plant,
    cable: Cable,
    remote: R,
) -> Done<R> {
    machine.mcu.usart[USART2].attach(Socket::default());
    for converter in &mut machine.mcu.adc {
        converter.set_reference(3300);
    }
    let scene = Scene {
        plant,
        cable,
        longest_interrupt: 0,
        upset: None,
        circling: None,
        remapped: None,
        led_astray: false,
        enough: false,
        interrupt: false,
        told: Vec::new(),
        stop_ns: STOP_NS,
    };
    let (control, sleep) = (machine::address_of(image, "CONTROL"), machine::sleep_of(image));
    let terminal = Terminal::of(image);
    let around = Around {
        scene,
        remote,
        interrupt_began: 0,
        sampling: false,
        control,
        sleep,
        leads_to: None,
        terminal,
        served: 0,
        stray: None,
    };
    let finished = machine.run(image, VirtualNanos(STOP_NS), around);
    let Around { scene, remote, stray, .. } = finished.driver;
    assert!(stray.is_none() || scene.led_astray, "{stray:?}");
    Done { session: finished.session, scene, remote }
}

/// [`run`] at the core's own rate.
pub fn run_at_full_rate<R: Remote>(image: &Path, plant: Plant, cable: Cable, remote: R) -> Done<R> {
    run(image, CORE_HZ, plant, cable, remote)
}
