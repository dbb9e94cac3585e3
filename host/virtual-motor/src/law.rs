//! An equation from outside this crate: any function of the motion, at one of six places.

use std::fmt;

/// What an equation sees. Output side: the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Voltage at the motor's terminals, V; 0 while they float.
    pub voltage: f64,
    /// Current times the cold winding's resistance, V.
    pub current: f64,
    /// rad/s of the output shaft.
    pub speed: f64,
    /// rad of the output shaft.
    pub angle: f64,
    /// rad/s of the motor's shaft.
    pub motor_speed: f64,
    /// rad of the motor's shaft.
    pub motor_angle: f64,
    /// Since the last settling, s.
    pub time: f64,
}

/// What an equation's value is. Torques as volts: the voltage whose stall torque they equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LawPort {
    /// A torque that drives the output shaft forward, V.
    Torque,
    /// The size of a dry friction on the rotor, V.
    Friction,
    /// Added to a driven winding's voltage, V.
    Voltage,
    /// The size of a voltage lost against the current, V.
    Drop,
    /// In series with the winding, as a share of its resistance.
    Resistance,
    /// Added to what the encoder sees, rad of the output shaft.
    Sensor,
}

type Function = Box<dyn Fn(&Moment) -> f64 + Send + Sync>;

/// A function of the motion and where it acts; evaluated anew in every step of at most 25 us.
pub struct Law {
    /// Where.
    pub port: LawPort,
    /// What.
    pub value: Function,
}

impl fmt::Debug for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Law").field("port", &self.port).finish_non_exhaustive()
    }
}

/// The values of all equations at a moment, by port.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Sums {
    pub torque: f64,
    pub friction: f64,
    pub voltage: f64,
    pub drop: f64,
    pub resistance: f64,
}

pub(crate) fn sums(laws: &[Law], moment: &Moment) -> Sums {
    let mut sums = Sums::default();
    for law in laws {
        let value = || (law.value)(moment);
        match law.port {
            LawPort::Torque => sums.torque += value(),
            LawPort::Friction => sums.friction += value().max(0.0),
            LawPort::Voltage => sums.voltage += value(),
            LawPort::Drop => sums.drop += value().max(0.0),
            LawPort::Resistance => sums.resistance += value().max(0.0),
            LawPort::Sensor => {}
        }
    }
    sums
}

/// What the equations of the sensor add to the angle, rad of the output shaft.
pub(crate) fn sensed(laws: &[Law], moment: &Moment) -> f64 {
    laws.iter().filter(|law| law.port == LawPort::Sensor).map(|law| (law.value)(moment)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bridge, Effect, Motor, VirtualMotor};

    fn angle(effects: &[Effect], laws: Vec<Law>) -> f64 {
        let mut plant = VirtualMotor::new(&Motor::small(), effects, 1).with_laws(laws);
        for k in 0..40 {
            let volts = if k / 10 % 2 == 0 { 6.0 } else { -2.0 };
            plant.advance(0.05, Bridge::Volts(volts));
        }
        plant.true_angle_rad()
    }

    #[test]
    fn laws_equal_to_built_in_effects_move_the_motor_alike() {
        let law = |port, value: Function| vec![Law { port, value }];
        for (text, laws) in [
            ("coulomb=0.5", law(LawPort::Friction, Box::new(|_| 0.5))),
            ("constant_load=0.5", law(LawPort::Torque, Box::new(|_| -0.5))),
            ("voltage_drop=0.6", law(LawPort::Drop, Box::new(|_| 0.6))),
            ("gravity=0.5,phase=0", law(LawPort::Torque, Box::new(|m| -0.5 * m.angle.sin()))),
        ] {
            let truth = angle(&[Effect::parse(text).unwrap()], Vec::new());
            let own = angle(&[], laws);
            assert!((own - truth).abs() < 1e-3 * truth.abs().max(1.0), "{text}: {own} {truth}");
            assert!((own - angle(&[], Vec::new())).abs() > 0.01, "{text} does something");
        }
    }
}
