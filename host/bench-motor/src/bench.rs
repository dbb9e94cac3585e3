//! The kinds of bench.

use crate::disturbance::Disturbance;
use crate::motor::Motor;
use crate::plant::Physics;
use crate::programme::{self, Programme};
use crate::sensor::Sensor;
use crate::{Rng, between, chance, geometric, pick};

/// A kind of bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Bench {
    /// The default protocol, angle by counts at 200 Hz or 1 kHz, with the nameplate.
    Protocol,
    /// SysId's ramps and steps at 20 ms, with filtered late speeds.
    SysId,
    /// 8-bit duty commanded on a sagging battery, 100 Hz; the voltage is what was commanded.
    DutyOnBattery,
    /// Closed-loop moves of a servo that carries a pendulum.
    ServoPendulum,
    /// Speeds written with few decimals at 100 Hz.
    FewDecimals,
    /// The paper's sines of 0.25 Hz: too weak to show most effects.
    WeakSines,
}

impl Bench {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Protocol,
        Self::SysId,
        Self::DutyOnBattery,
        Self::ServoPendulum,
        Self::FewDecimals,
        Self::WeakSines,
    ];

    /// Short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Protocol => "protocol",
            Self::SysId => "sysid",
            Self::DutyOnBattery => "duty-on-battery",
            Self::ServoPendulum => "servo-pendulum",
            Self::FewDecimals => "few-decimals",
            Self::WeakSines => "weak-sines",
        }
    }

    /// One sentence for a table.
    pub fn words(self) -> &'static str {
        match self {
            Self::Protocol => "default protocol, counts at 200 Hz or 1 kHz, nameplate",
            Self::SysId => "SysId's ramps and steps at 20 ms, filtered late speeds",
            Self::DutyOnBattery => "8-bit duty commanded on a sagging battery, 100 Hz",
            Self::ServoPendulum => "closed-loop servo moves with a pendulum, 50 to 100 Hz",
            Self::FewDecimals => "speeds with few decimals, 100 Hz",
            Self::WeakSines => "weak: sines of 0.25 Hz",
        }
    }

    /// Whether small dry friction belongs to this bench: the share of its cases.
    pub(crate) fn friction_share(self) -> f64 {
        match self {
            Self::Protocol | Self::WeakSines => 0.3,
            Self::FewDecimals => 0.5,
            _ => 0.75,
        }
    }
}

/// A bench with a motor on it.
#[derive(Debug, Clone)]
pub struct Setup {
    pub bench: Bench,
    pub motor: Motor,
    pub physics: Physics,
    pub sensor: Sensor,
    pub disturbance: Disturbance,
    pub rate: f64,
    /// Deviation of the sampling instants, as a share of the period.
    pub jitter: f64,
    pub programmes: Vec<Programme>,
    pub held_out: Vec<Programme>,
    /// Gain of the angle controller, V/rad; open loop where zero.
    pub loop_gain: f64,
    /// Steps of the command over the supply, or zero.
    pub command_steps: f64,
}

/// Programmes of the default protocol for a supply and a rate; the last is the one to keep out. Given by the caller, because
/// the protocol is not the plant's.
pub type Protocol<'a> = &'a dyn Fn(f64, f64) -> Vec<(String, Vec<f64>)>;

impl Setup {
    /// Draws a bench of this kind.
    pub fn draw(bench: Bench, protocol: Protocol, rng: &mut Rng) -> Self {
        let supplies: &[f64] = match bench {
            Bench::DutyOnBattery => &[6.0, 7.4, 9.0, 11.1, 12.0],
            Bench::ServoPendulum => &[7.4, 12.0],
            _ => &[6.0, 12.0, 24.0],
        };
        let mut motor = Motor::draw(rng, supplies);
        let v = motor.supply_v;
        let mut setup = Self {
            bench,
            physics: Physics::default(),
            sensor: Sensor::default(),
            disturbance: if chance(rng, 0.5) { Disturbance::draw(rng) } else { Disturbance::NONE },
            rate: 100.0,
            jitter: 0.0,
            programmes: Vec::new(),
            held_out: Vec::new(),
            loop_gain: 0.0,
            command_steps: 0.0,
            motor: motor.clone(),
        };
        match bench {
            Bench::Protocol => {
                setup.rate = pick(rng, &[200.0, 1000.0]);
                let named = |(name, values)| Programme { name, values };
                let mut all: Vec<Programme> = protocol(v, setup.rate).into_iter().map(named).collect();
                setup.held_out.extend(all.pop());
                setup.programmes = all;
            }
            Bench::SysId => {
                setup.rate = 50.0;
                motor.inertia *= geometric(rng, 1.0, 3.0);
                setup.sensor.window_s = pick(rng, &[0.02, 0.04, 0.1]);
                setup.sensor.speed_filter_s = pick(rng, &[0.0, 0.02]);
                setup.sensor.latency_s = pick(rng, &[0.0, 0.01, 0.02, 0.05]);
                setup.programmes = programme::sysid(rng, v, setup.rate, "");
                setup.held_out = vec![programme::drive(rng, "drive", 0.8 * v, 10.0, setup.rate)];
            }
            Bench::DutyOnBattery => {
                setup.command_steps = 255.0;
                let share = geometric(rng, 0.02, 0.25);
                setup.physics.driver.source = (share * motor.resistance, geometric(rng, 0.001, 0.01));
                setup.physics.driver.discharge = geometric(rng, 1e-5, 8e-4);
                setup.programmes = vec![
                    programme::levels(rng, "levels", v, 15.0, setup.rate),
                    programme::triangles("triangles", 0.8 * v, between(rng, 2.5, 5.0), 12.0, setup.rate),
                    programme::drive(rng, "drive", v, 12.0, setup.rate),
                ];
                setup.held_out = vec![programme::levels(rng, "levels-unseen", 0.9 * v, 10.0, setup.rate)];
            }
            Bench::ServoPendulum => {
                setup.rate = pick(rng, &[50.0, 100.0]);
                setup.jitter = pick(rng, &[0.0, 0.05, 0.15]);
                (motor.encoder_on_output, motor.counts) = (true, 4096.0);
                let volts = v * between(rng, 0.08, 0.45);
                setup.physics.gravity = (motor.torque(volts), 0.0);
                setup.loop_gain = v * between(rng, 2.0, 6.0);
                let make =
                    |rng: &mut Rng, name: &str, which| programme::moves(rng, name, which, 8.0, setup.rate);
                setup.programmes =
                    (0..3).map(|k| make(rng, ["sin-sin", "lift", "sin-square"][k], k)).collect();
                setup.held_out = vec![make(rng, "up-and-down", 3)];
            }
            Bench::FewDecimals => {
                setup.sensor.window_s = pick(rng, &[0.01, 0.02, 0.05]);
                setup.sensor.speed_filter_s = pick(rng, &[0.0, 0.0, 0.015, 0.04]);
                setup.sensor.speed_step = motor.no_load_speed() * pick(rng, &[2e-4, 1e-3, 4e-3]);
                setup.programmes = vec![
                    programme::levels(rng, "levels", 0.9 * v, 16.0, setup.rate),
                    programme::chirp("chirp", 0.7 * v, (0.1, 8.0), 12.0, setup.rate),
                    programme::triangles("triangles", 0.6 * v, 4.0, 12.0, setup.rate),
                ];
                setup.held_out = vec![programme::levels(rng, "levels-unseen", 0.8 * v, 10.0, setup.rate)];
            }
            Bench::WeakSines => {
                setup.rate = pick(rng, &[100.0, 500.0]);
                let tops = [0.5 * v, 0.8 * v];
                setup.programmes = tops
                    .iter()
                    .map(|top| programme::sine(&format!("sine {top:.0} V"), *top, 0.25, 12.0, setup.rate))
                    .collect();
                setup.held_out = vec![programme::sine("sine-unseen", 0.65 * v, 0.25, 8.0, setup.rate)];
            }
        }
        // A separate repeat of one programme, as careful people make.
        if chance(rng, 0.75) && !setup.programmes.is_empty() {
            let which = setup.programmes.len() / 2;
            let mut again = setup.programmes[which].clone();
            again.name += " again";
            setup.programmes.push(again);
        }
        if chance(rng, bench.friction_share()) {
            let volts = v * geometric(rng, 0.004, 0.025);
            setup.physics.friction = [motor.torque(volts); 2];
        }
        if chance(rng, 0.3) {
            setup.physics.bristle_rad = geometric(rng, 0.004, 0.03);
        }
        setup.motor = motor;
        setup
    }
}
