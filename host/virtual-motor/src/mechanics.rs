//! Current and motion: the differential equations, the midpoint step and the event of sticking.

use crate::effect::Effect;
use crate::motor::Motor;
use crate::parts::electric::Electric;
use crate::parts::friction::Friction;
use crate::parts::gear::{self, Coupling};
use crate::parts::load::Load;

/// Forward voltage of the two diodes that a floating winding's current passes, V.
const DIODES_V: f64 = 1.4;

/// What moves. Load side: output shaft.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Motion {
    /// A.
    pub current: f64,
    /// rad/s.
    pub motor_speed: f64,
    /// rad.
    pub motor_angle: f64,
    /// rad/s.
    pub load_speed: f64,
    /// rad.
    pub load_angle: f64,
}

/// Whether dry friction holds the rotor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contact {
    /// There is no dry friction.
    Free,
    /// The rotor stands, held by friction.
    Stuck,
    /// The rotor slides in this direction (1 or -1).
    Sliding(f64),
}

/// What the winding is connected to during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Terminal {
    /// An applied voltage, V.
    Driven(f64),
    /// Nothing but diodes to a bus of this voltage, V.
    Floating(f64),
    /// A diode across it, which lets the current through one `way` (1 or -1); the other way it returns to a bus of this voltage, V.
    Freewheeling { way: f64, bus_v: f64 },
}

impl Terminal {
    /// Whether diodes end the current on its way from `before` to `after` at zero.
    fn stops(self, before: f64, after: f64) -> bool {
        match self {
            Self::Driven(_) => false,
            Self::Floating(_) => before * after <= 0.0,
            Self::Freewheeling { way, .. } => before * after < 0.0 || before == 0.0 && after * way < 0.0,
        }
    }
}

/// What acts from outside during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surroundings {
    pub terminal: Terminal,
    /// Of the winding as warm as it is, ohm.
    pub resistance: f64,
    /// Disturbance at the motor shaft, N m against forward motion.
    pub torque: f64,
    /// Torque at the output shaft, N m against forward motion.
    pub load_torque: f64,
    /// Dry friction at the motor shaft beside the motor's own, N m.
    pub friction: f64,
    /// Voltage lost against the current beside the motor's own, V.
    pub drop: f64,
}

/// The immutable equations of motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Mechanics {
    per_inductance: f64,
    torque_constant: f64,
    back_emf_constant: f64,
    rotor_inertia: f64,
    load_inertia: f64,
    rotor_damping: f64,
    load_damping: f64,
    gear_ratio: f64,
    coupling: Coupling,
    friction: Friction,
    load: Load,
    pub electric: Electric,
}

impl Mechanics {
    pub fn new(motor: &Motor, effects: &[Effect]) -> Self {
        let (coupling, rotor_inertia, load_inertia) = gear::coupling(motor, effects);
        Self {
            per_inductance: 1.0 / motor.inductance_h,
            torque_constant: motor.torque_constant,
            back_emf_constant: motor.back_emf_constant,
            rotor_inertia,
            load_inertia,
            rotor_damping: motor.rotor_damping,
            load_damping: motor.load_damping,
            gear_ratio: motor.gear_ratio,
            coupling,
            friction: Friction::new(motor, effects),
            load: Load::new(motor, effects),
            electric: Electric::new(motor, effects),
        }
    }

    /// Whether the rotor is stuck or free when it stands.
    pub fn contact_at_rest(&self) -> Contact {
        if self.friction.sticks() { Contact::Stuck } else { Contact::Free }
    }

    /// Time derivatives of the motion; the friction's direction stays that of `contact`.
    #[inline]
    fn slopes(&self, m: &Motion, contact: Contact, outside: &Surroundings) -> Motion {
        let field = self.electric.field(m.current);
        let emf = self.back_emf_constant * field * m.motor_speed;
        let push = match outside.terminal {
            Terminal::Driven(volts) => volts,
            Terminal::Floating(_) if m.current == 0.0 => emf,
            Terminal::Floating(bus) => -(bus + DIODES_V).copysign(m.current),
            Terminal::Freewheeling { way, .. } if m.current * way > 0.0 => 0.0,
            Terminal::Freewheeling { way, bus_v } if m.current * way < 0.0 => (bus_v + DIODES_V) * way,
            // Without a current the back-EMF makes one if the diode lets it.
            Terminal::Freewheeling { way, .. } => (emf * way).max(0.0) * way,
        };
        let voltage = push
            - outside.resistance * m.current
            - emf
            - self.electric.drop(m.current)
            - outside.drop * self.electric.direction(m.current);
        let motor_torque = self.torque_constant * field * m.current;
        let mut torque = motor_torque
            - self.rotor_damping * m.motor_speed
            - self.load.at_motor(m.motor_angle, m.motor_speed)
            - outside.torque;
        let on_load =
            self.load.at_output(m.load_angle) + self.load_damping * m.load_speed + outside.load_torque;
        let mut inertia = self.rotor_inertia;
        let mut load_acceleration = 0.0;
        match self.coupling {
            Coupling::Rigid => {
                torque -= on_load / self.gear_ratio;
                inertia += self.load_inertia / (self.gear_ratio * self.gear_ratio);
            }
            Coupling::Elastic { half_gap, stiffness, damping } => {
                let twist = m.motor_angle / self.gear_ratio - m.load_angle;
                let rate = m.motor_speed / self.gear_ratio - m.load_speed;
                let passed = gear::torque(half_gap, stiffness, damping, twist, rate);
                torque -= passed / self.gear_ratio;
                load_acceleration = (passed - on_load) / self.load_inertia;
            }
        }
        let acceleration = match contact {
            Contact::Free => torque / inertia,
            Contact::Stuck => 0.0,
            Contact::Sliding(direction) => {
                let level = self.friction.level(direction, m.motor_speed, motor_torque) + outside.friction;
                (torque - direction * level) / inertia
            }
        };
        if self.coupling == Coupling::Rigid {
            load_acceleration = acceleration / self.gear_ratio;
        }
        Motion {
            current: voltage * self.per_inductance,
            motor_speed: acceleration,
            motor_angle: m.motor_speed,
            load_speed: load_acceleration,
            load_angle: m.load_speed,
        }
    }

    /// One step of `dt` seconds by the midpoint rule, ending early and going on in the other state where the rotor
    /// stops.
    #[inline]
    pub fn step(&self, m: &mut Motion, contact: &mut Contact, outside: &Surroundings, dt: f64) {
        if *contact == Contact::Stuck {
            self.release(m, contact, outside);
        }
        let before = *m;
        *m = self.midpoint(&before, *contact, outside, dt);
        if let Contact::Sliding(direction) = *contact
            && m.motor_speed * direction <= 0.0
        {
            // The rotor stopped on the way: go there, stick, and see whether it stays.
            let change = before.motor_speed - m.motor_speed;
            let part = if change == 0.0 { 0.0 } else { (before.motor_speed / change).clamp(0.0, 1.0) };
            *m = before.blend(m, part);
            m.motor_speed = 0.0;
            if self.coupling == Coupling::Rigid {
                m.load_speed = 0.0;
            }
            *contact = Contact::Stuck;
            if part > 0.0 {
                self.release(m, contact, outside);
            }
            *m = self.midpoint(m, *contact, outside, dt * (1.0 - part));
        }
        if outside.terminal.stops(before.current, m.current) {
            m.current = 0.0;
        }
    }

    /// A stuck rotor slides where the other torques exceed the breakaway torque.
    fn release(&self, m: &Motion, contact: &mut Contact, outside: &Surroundings) {
        let torque = self.slopes(m, Contact::Free, outside).motor_speed * self.moved_inertia();
        let motor_torque = self.torque_constant * self.electric.field(m.current) * m.current;
        let direction = 1f64.copysign(torque);
        if torque.abs() > self.friction.level(direction, 0.0, motor_torque) + outside.friction {
            *contact = Contact::Sliding(direction);
        }
    }

    fn moved_inertia(&self) -> f64 {
        match self.coupling {
            Coupling::Rigid => self.rotor_inertia + self.load_inertia / (self.gear_ratio * self.gear_ratio),
            Coupling::Elastic { .. } => self.rotor_inertia,
        }
    }

    #[inline]
    fn midpoint(&self, m: &Motion, contact: Contact, outside: &Surroundings, dt: f64) -> Motion {
        let first = self.slopes(m, contact, outside);
        let mut middle = m.plus(&first, 0.5 * dt);
        // Diodes do not turn around within a step: the current that runs out in it ends at zero.
        if outside.terminal.stops(m.current, middle.current) && m.current != 0.0 {
            middle.current = f64::MIN_POSITIVE.copysign(m.current);
        }
        let second = self.slopes(&middle, contact, outside);
        m.plus(&second, dt)
    }
}

impl Motion {
    #[inline]
    fn plus(&self, slope: &Self, dt: f64) -> Self {
        Self {
            current: self.current + dt * slope.current,
            motor_speed: self.motor_speed + dt * slope.motor_speed,
            motor_angle: self.motor_angle + dt * slope.motor_angle,
            load_speed: self.load_speed + dt * slope.load_speed,
            load_angle: self.load_angle + dt * slope.load_angle,
        }
    }

    /// The state a share `part` of the way to `after`.
    fn blend(&self, after: &Self, part: f64) -> Self {
        let mix = |a: f64, b: f64| a + part * (b - a);
        Self {
            current: mix(self.current, after.current),
            motor_speed: mix(self.motor_speed, after.motor_speed),
            motor_angle: mix(self.motor_angle, after.motor_angle),
            load_speed: mix(self.load_speed, after.load_speed),
            load_angle: mix(self.load_angle, after.load_angle),
        }
    }
}
