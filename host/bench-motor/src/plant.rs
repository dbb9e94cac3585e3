//! The plant: current, one or two inertias, friction; explicit steps of 20 us.

use std::f64::consts::TAU;

use crate::disturbance::{Course, Disturbance};
use crate::driver::{Bridge, Driver};
use crate::motor::Motor;
use crate::{Rng, between};

/// Everything that a motor may have beyond [`Motor`]; zeros are its absence. Torques are at the motor shaft, N m.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Physics {
    /// Driver and supply.
    pub driver: Driver,
    /// Kinetic friction forwards and backwards.
    pub friction: [f64; 2],
    /// Breakaway above it, the motor speed over which it falls, rad/s, and whether it falls as a bell.
    pub stribeck: (f64, f64, bool),
    /// Presliding by LuGre's bristles: their breakaway angle at the motor shaft, rad; Karnopp's sticking where zero.
    pub bristle_rad: f64,
    /// Share of the motor's torque lost in the gear, and the torque from which on.
    pub load_friction: (f64, f64),
    /// Modulation of the friction over an output turn.
    pub uneven: f64,
    /// Viscous damping that grease adds when cold, as a multiple, and its time, s.
    pub grease: (f64, f64),
    /// Drag at the no-load speed.
    pub drag: f64,
    /// Constant torque against forward motion.
    pub load: f64,
    /// Unbalance and its angle, rad.
    pub gravity: (f64, f64),
    /// Torque per output turn.
    pub spring: f64,
    /// A cable that is dragged along: torque and the output angle over which it builds up, rad.
    pub cable: (f64, f64),
    /// Cogging of first and second order, periods per motor turn, phases.
    pub cogging: (f64, f64, f64, [f64; 2]),
    /// Whole gap at the output shaft, rad.
    pub gap: f64,
    /// Frequency of the load on its spring with the motor held, Hz, and damping ratio.
    pub spring_hz: (f64, f64),
    /// Rise of the resistance per second at stall, time constant to the housing, s.
    pub heating: (f64, f64),
    /// Current at which the flux has fallen to 0.71, A.
    pub saturation_a: f64,
}

/// What happened: angles at every millisecond quarter, and the commands.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Angle at the encoder, in output radians.
    pub encoder: Vec<f64>,
    /// Commands, one per sample, V.
    pub command: Vec<f64>,
}

/// One step, s.
const STEP_S: f64 = 2e-5;
/// Distance of the traced angles, s.
pub const TRACE_S: f64 = 2.5e-4;
/// Steps per traced angle.
const STEPS: usize = 12;
/// Own frequency of tooth contact with the motor held, Hz, and its damping ratio.
const CONTACT: (f64, f64) = (160.0, 0.35);

/// Drives the plant from rest at output angle `at` with commands that may depend on the encoder's angle; the sampling
/// instants are `times`.
pub fn run(
    motor: &Motor,
    law: &Physics,
    disturbance: Disturbance,
    at: f64,
    times: &[f64],
    command: &mut dyn FnMut(usize, f64) -> f64,
    rng: &mut Rng,
) -> Trace {
    let mut state = State::at(at * motor.gear, at, motor, law);
    let mut course = Course::new(disturbance, rng);
    let delay = (law.driver.delay_s / TRACE_S).round() as usize;
    let stall = motor.torque(motor.supply_v);
    let end = times.last().map_or(0.0, |t| t + 0.05);
    let total = (end / TRACE_S).ceil() as usize;
    let mut trace = Trace { encoder: Vec::with_capacity(total), command: Vec::with_capacity(times.len()) };
    let mut held = vec![0.0; delay + 1];
    let (mut k, mut asked, mut torque) = (0, 0.0, 0.0);
    let dt = TRACE_S / STEPS as f64;
    debug_assert!(dt <= STEP_S * 1.05);
    for n in 0..total {
        let t = n as f64 * TRACE_S;
        let angle = state.encoder(motor);
        trace.encoder.push(angle);
        if k < times.len() && times[k] <= t + 0.5 * TRACE_S {
            asked = command(k, angle);
            trace.command.push(asked);
            k += 1;
        }
        let place = n % held.len();
        held[place] = asked;
        let acts = held[(n + 1) % held.len()];
        if n % 4 == 0 {
            torque = stall * course.advance(4.0 * TRACE_S, rng);
        }
        for _ in 0..STEPS {
            state.step(motor, law, acts, torque, dt);
        }
    }
    // Samples beyond the last whole trace step.
    while trace.command.len() < times.len() {
        trace.command.push(asked);
    }
    trace
}

struct State {
    bridge: Bridge,
    i: f64,
    motor: f64,
    motor_speed: f64,
    load: f64,
    load_speed: f64,
    bristle: f64,
    cable: f64,
    heat: f64,
    seconds: f64,
}

impl State {
    fn at(motor: f64, load: f64, of: &Motor, law: &Physics) -> Self {
        // A servo hangs at rest where its weight lets it; others begin anywhere.
        let mut state = Self {
            bridge: Bridge::default(),
            i: 0.0,
            motor,
            motor_speed: 0.0,
            load,
            load_speed: 0.0,
            bristle: 0.0,
            cable: 0.0,
            heat: 0.0,
            seconds: 0.0,
        };
        // Let everything settle with the bridge braking.
        for _ in 0..(0.4 / STEP_S) as usize {
            state.step(of, law, 0.0, 0.0, STEP_S);
        }
        (state.bridge, state.heat, state.seconds) = (Bridge::default(), 0.0, 0.0);
        state
    }

    fn encoder(&self, motor: &Motor) -> f64 {
        if motor.encoder_on_output { self.load } else { self.motor / motor.gear }
    }

    fn step(&mut self, m: &Motor, p: &Physics, asked: f64, disturbance: f64, dt: f64) {
        self.seconds += dt;
        let terminals = self.bridge.step(&p.driver, asked, m.supply_v, self.i, dt);
        let flux =
            if p.saturation_a > 0.0 { 1.0 / (1.0 + (self.i / p.saturation_a).powi(2)).sqrt() } else { 1.0 };
        let k = m.constant * flux;
        let r = m.resistance * (1.0 + self.heat);
        let v = terminals.volts - k * self.motor_speed;
        if terminals.floating && self.i.abs() <= 1e-9 && v * terminals.diode <= 0.0 {
            self.i = 0.0;
        } else {
            let a = 0.5 * r * dt / m.inductance;
            let next = ((1.0 - a) * self.i + dt / m.inductance * v) / (1.0 + a);
            // Diodes block the return.
            self.i = if terminals.floating && next * self.i < 0.0 { 0.0 } else { next };
        }
        if p.driver.limit_a > 0.0 {
            self.i = self.i.clamp(-p.driver.limit_a, p.driver.limit_a);
        }
        if p.heating.0 > 0.0 {
            let load = self.i / m.stall_current();
            self.heat += dt * (p.heating.0 * load * load * (1.0 + self.heat) - self.heat / p.heating.1);
        }
        let drive = k * self.i;
        let mut torque = drive + disturbance;
        if p.cogging.0 > 0.0 {
            let a = p.cogging.2 * self.motor;
            torque -=
                p.cogging.0 * (a + p.cogging.3[0]).sin() + p.cogging.1 * (2.0 * a + p.cogging.3[1]).sin();
        }
        let grease =
            if p.grease.0 > 0.0 { 1.0 + p.grease.0 * (-self.seconds / p.grease.1).exp() } else { 1.0 };
        let damping = m.damping * grease;
        let level = self.friction_level(p, drive);
        if p.gap == 0.0 && p.spring_hz.0 == 0.0 {
            torque -= damping * self.motor_speed + self.load_torque(m, p, dt);
            let speed = self.rub(p, torque, level, m.inertia, dt);
            self.motor += 0.5 * dt * (self.motor_speed + speed);
            self.motor_speed = speed;
            (self.load, self.load_speed) = (self.motor / m.gear, speed / m.gear);
            return;
        }
        // Two inertias; the load in motor coordinates.
        let (rotor, load) = (m.inertia * (1.0 - m.load_share), m.inertia * m.load_share);
        let turn = self.motor - self.load * m.gear;
        let slip = self.motor_speed - self.load_speed * m.gear;
        let (hz, ratio) = if p.spring_hz.0 > 0.0 { p.spring_hz } else { CONTACT };
        let stiffness = load * (TAU * hz).powi(2);
        let loss = 2.0 * ratio * load * TAU * hz;
        let half = 0.5 * p.gap * m.gear;
        let deep = turn.abs() - half;
        let contact = if deep <= 0.0 && half > 0.0 {
            0.0
        } else {
            let side = turn.signum();
            let push = stiffness * deep * side + loss * slip;
            if half > 0.0 && push * side < 0.0 { 0.0 } else { push }
        };
        let resist = self.load_torque(m, p, dt);
        torque -= 0.7 * damping * self.motor_speed + contact;
        let speed = self.rub(p, torque, level, rotor, dt);
        let load_motor_speed = self.load_speed * m.gear;
        let load_next = load_motor_speed + dt / load * (contact - 0.3 * damping * load_motor_speed - resist);
        self.motor += 0.5 * dt * (self.motor_speed + speed);
        self.load += 0.5 * dt * (self.load_speed + load_next / m.gear);
        (self.motor_speed, self.load_speed) = (speed, load_next / m.gear);
    }

    /// What the load takes, at the motor shaft.
    fn load_torque(&mut self, m: &Motor, p: &Physics, dt: f64) -> f64 {
        let mut torque = p.load;
        if p.gravity.0 > 0.0 {
            torque += p.gravity.0 * (self.load + p.gravity.1).sin();
        }
        torque += p.spring * self.load / TAU;
        if p.drag > 0.0 {
            let share = self.load_speed / m.no_load_speed();
            torque += p.drag * share * share.abs();
        }
        if p.cable.0 > 0.0 {
            // Dahl's rate-independent hysteresis (1968).
            let moved = dt * self.load_speed / p.cable.1;
            self.cable = (self.cable + moved) / (1.0 + moved.abs());
            torque += p.cable.0 * self.cable;
        }
        torque
    }

    /// Friction that a sliding shaft meets, and what must be overcome at rest.
    fn friction_level(&self, p: &Physics, drive: f64) -> [f64; 2] {
        let lost = if p.load_friction.0 > 0.0 {
            p.load_friction.0 * drive.abs() * (drive.abs() / p.load_friction.1).tanh()
        } else {
            0.0
        };
        let wave = 1.0 + p.uneven * (self.load + 0.7).sin();
        let excess = if p.stribeck.0 > 0.0 {
            let x = (self.motor_speed / p.stribeck.1).powi(2);
            p.stribeck.0 * if p.stribeck.2 { (-x).exp() } else { 1.0 / (1.0 + x) }
        } else {
            0.0
        };
        p.friction.map(|level| level * wave + excess + lost)
    }

    /// The next motor speed under `torque` and friction of `level` in each direction.
    fn rub(&mut self, p: &Physics, torque: f64, level: [f64; 2], inertia: f64, dt: f64) -> f64 {
        let w = self.motor_speed;
        let of = |direction: f64| level[usize::from(direction < 0.0)];
        if p.bristle_rad > 0.0 {
            let most = of(if w == 0.0 { torque } else { w }).max(1e-12);
            let stiffness = most / p.bristle_rad;
            let before = self.bristle;
            self.bristle = (before + dt * w) / (1.0 + dt * w.abs() / p.bristle_rad);
            let damping = 0.6 * (stiffness * inertia).sqrt();
            let rate = (self.bristle - before) / dt;
            return w + dt / inertia * (torque - stiffness * self.bristle - damping * rate);
        }
        if w == 0.0 {
            let most = of(torque);
            return if torque.abs() <= most { 0.0 } else { dt / inertia * (torque - torque.signum() * most) };
        }
        let next = w + dt / inertia * (torque - w.signum() * of(w));
        let stops = next * w < 0.0 && torque.abs() <= of(torque);
        if stops { 0.0 } else { next }
    }
}

/// The angle from which a record begins, rad of the output shaft: no encoder starts on an edge.
pub fn anywhere(rng: &mut Rng, motor: &Motor) -> f64 {
    between(rng, -0.5, 0.5) * motor.count_rad()
}
