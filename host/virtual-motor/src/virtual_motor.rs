//! Motor, driver and encoder together, advanced in time.

use crate::effect::Effect;
use crate::law::{self, Law, LawPort, Moment};
use crate::mechanics::{Contact, Mechanics, Motion, Surroundings, Terminal};
use crate::motor::{EncoderShaft, Motor};
use crate::parts::driver::{Driver, DriverState};
use crate::parts::electric::Heat;
use crate::parts::sensor::{Sensor, SensorState};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// What the bridge is told to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bridge {
    /// Apply this voltage on average (0 V brakes), V: the duty times the nominal supply. The supply limits it.
    Volts(f64),
    /// All switches off: the current returns through the diodes, then the motor rolls.
    Floating,
    /// One side switched off: a diode across the winding lets the current go on in this direction (1 or -1), and none back.
    Freewheeling(f64),
}

/// Longest step of the integration, s.
const LONGEST_STEP_S: f64 = 25e-6;
/// Steps shorter than this are rounding of an edge's time, s.
const SHORTEST_STEP_S: f64 = 1e-11;

/// A motor with its driver, encoder and hidden effects.
#[derive(Debug)]
pub struct VirtualMotor {
    motor: Motor,
    mechanics: Mechanics,
    driver: Driver,
    sensor: Sensor,
    state: State,
    laws: Vec<Law>,
    pub(crate) rng: ChaCha8Rng,
}

#[derive(Debug, Clone)]
struct State {
    time_s: f64,
    motion: Motion,
    contact: Contact,
    heat: Heat,
    bridge: DriverState,
    encoder: SensorState,
    disturbance_nm: f64,
}

impl VirtualMotor {
    /// A motor at rest and cold. Of two effects of the same kind the last one counts. The seed decides where the
    /// encoder stands within a count, which edges are lost, and all noise.
    pub fn new(motor: &Motor, effects: &[Effect], seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mechanics = Mechanics::new(motor, effects);
        let driver = Driver::new(motor, effects);
        let sensor = Sensor::new(motor, effects);
        let state = State {
            time_s: 0.0,
            motion: Motion::default(),
            contact: mechanics.contact_at_rest(),
            heat: Heat::default(),
            bridge: driver.rest(&mut rng),
            encoder: sensor.rest(&mut rng),
            disturbance_nm: 0.0,
        };
        Self { motor: motor.clone(), mechanics, driver, sensor, state, laws: Vec::new(), rng }
    }

    /// The same motor under further equations; at rest.
    #[must_use]
    pub fn with_laws(mut self, laws: Vec<Law>) -> Self {
        self.laws = laws;
        self.state.contact = self.contact_at_rest();
        self
    }

    fn contact_at_rest(&self) -> Contact {
        let friction = self.laws.iter().any(|law| law.port == LawPort::Friction);
        if friction { Contact::Stuck } else { self.mechanics.contact_at_rest() }
    }

    /// Back to rest at angle zero with a full supply; the heat stays.
    pub fn settle(&mut self) {
        self.state = State {
            time_s: 0.0,
            motion: Motion::default(),
            contact: self.contact_at_rest(),
            heat: self.state.heat,
            bridge: self.driver.rest(&mut self.rng),
            encoder: self.sensor.rest(&mut self.rng),
            disturbance_nm: 0.0,
        };
    }

    /// Winding and housing as cold as the air.
    pub fn go_cold(&mut self) {
        self.state.heat = Heat::default();
    }

    /// Lets winding and housing cool for `seconds` without current.
    pub fn cool(&mut self, seconds: f64) {
        let steps = (seconds / 0.02).ceil().max(1.0);
        for _ in 0..steps as u64 {
            self.mechanics.electric.heat(&mut self.state.heat, 0.0, seconds / steps);
        }
    }

    /// Goes on for `dt` seconds with the bridge told to do `bridge`; any `dt`, split into steps of at most 25 us.
    pub fn advance(&mut self, dt: f64, bridge: Bridge) {
        self.driver.command(&mut self.state.bridge, self.state.time_s, bridge);
        let end = self.state.time_s + dt;
        while end - self.state.time_s > SHORTEST_STEP_S {
            let (output, until) = self.driver.output(&mut self.state.bridge, self.state.time_s, end);
            let span = until - self.state.time_s;
            if span <= SHORTEST_STEP_S {
                self.state.time_s = until + SHORTEST_STEP_S;
                continue;
            }
            let steps = (span / LONGEST_STEP_S - 1e-6).ceil().max(1.0);
            let step = span / steps;
            for _ in 0..steps as u64 {
                self.step(step, output);
            }
            self.state.time_s = until;
        }
        self.state.time_s = end;
    }

    /// One step during which the bridge's switches stay as they are.
    #[inline]
    fn step(&mut self, dt: f64, output: Bridge) {
        let bus_v = self.state.bridge.bus_v;
        let applied = match output {
            Bridge::Volts(volts) => volts * bus_v / self.driver.nominal_v(),
            Bridge::Floating | Bridge::Freewheeling(_) => 0.0,
        };
        let more = if self.laws.is_empty() {
            law::Sums::default()
        } else {
            law::sums(&self.laws, &self.moment(applied))
        };
        let volt = self.motor.torque_of_volts(1.0);
        let state = &mut self.state;
        let before = state.motion.current;
        let terminal = match output {
            Bridge::Volts(_) => Terminal::Driven(applied + more.voltage),
            Bridge::Floating => Terminal::Floating(bus_v),
            Bridge::Freewheeling(way) => Terminal::Freewheeling { way, bus_v },
        };
        let outside = Surroundings {
            terminal,
            resistance: self.motor.resistance_ohm * (1.0 + state.heat.winding + more.resistance),
            torque: state.disturbance_nm,
            load_torque: -more.torque * volt * self.motor.gear_ratio,
            friction: more.friction * volt,
            drop: more.drop,
        };
        self.mechanics.step(&mut state.motion, &mut state.contact, &outside, dt);
        let drawn = match output {
            Bridge::Volts(volts) => volts / self.driver.nominal_v() * before,
            Bridge::Floating => -before.abs(),
            Bridge::Freewheeling(way) => (before * way).min(0.0),
        };
        self.driver.draw(&mut state.bridge, drawn, dt);
        self.mechanics.electric.heat(&mut state.heat, state.motion.current, dt);
        let (angle, speed, per_output) = match self.sensor.shaft {
            EncoderShaft::Motor => {
                (state.motion.motor_angle, state.motion.motor_speed, self.motor.gear_ratio)
            }
            EncoderShaft::Output => (state.motion.load_angle, state.motion.load_speed, 1.0),
        };
        let error = if self.laws.is_empty() { 0.0 } else { law::sensed(&self.laws, &self.moment(applied)) };
        let angle = angle + error * per_output;
        self.sensor.look(&mut self.state.encoder, angle, speed, dt, &mut self.rng);
    }

    /// What the equations see while `voltage` is at the terminals.
    fn moment(&self, voltage: f64) -> Moment {
        let m = &self.state.motion;
        Moment {
            voltage,
            current: m.current * self.motor.resistance_ohm,
            speed: m.load_speed,
            angle: m.load_angle,
            motor_speed: m.motor_speed,
            motor_angle: m.motor_angle,
            time: self.state.time_s,
        }
    }

    /// A torque from outside, N m at the motor shaft against forward motion; it stays until the next call.
    pub fn disturb(&mut self, torque_nm: f64) {
        self.state.disturbance_nm = torque_nm;
    }

    /// The motor without effects.
    pub fn motor(&self) -> &Motor {
        &self.motor
    }

    /// The encoder's counter.
    pub fn counts(&self) -> i64 {
        self.state.encoder.counts
    }

    /// The encoder's reading as an angle of the output shaft, rad.
    pub fn angle_rad(&self) -> f64 {
        self.sensor.angle(&self.state.encoder)
    }

    /// Where the output shaft really stands, rad.
    pub fn true_angle_rad(&self) -> f64 {
        self.state.motion.load_angle
    }

    /// How fast the output shaft really turns, rad/s.
    pub fn true_speed_rad_s(&self) -> f64 {
        self.state.motion.load_speed
    }

    /// How fast the motor's shaft turns, rad/s.
    pub fn motor_speed_rad_s(&self) -> f64 {
        self.state.motion.motor_speed
    }

    /// Current in the winding, A.
    pub fn current_a(&self) -> f64 {
        self.state.motion.current
    }

    /// Voltage behind the bridge, V.
    pub fn supply_v(&self) -> f64 {
        self.state.bridge.bus_v
    }

    /// Resistance of the winding as warm as it is, ohm.
    pub fn resistance_ohm(&self) -> f64 {
        self.motor.resistance_ohm * (1.0 + self.state.heat.winding)
    }

    /// Time since the start or the last settling, s.
    pub fn time_s(&self) -> f64 {
        self.state.time_s
    }
}
