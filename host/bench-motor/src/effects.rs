//! What can be hidden: one row per effect, with sizes as people meet them.

use std::f64::consts::TAU;

use crate::motor::Motor;
use crate::plant::Physics;
use crate::sensor::Sensor;
use crate::{Rng, between, chance, geometric, pick};

/// Puts an effect into a bench, `scale` times as large as drawn, and says its size.
type Hide = fn(&mut Physics, &mut Sensor, &Motor, f64, &mut Rng) -> String;

/// An effect.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// The name that a diagnosis uses; of physics outside the library one of its own.
    pub name: &'static str,
    /// Effects of one family are not hidden together.
    pub family: &'static str,
    /// How it is put in.
    pub hide: Hide,
}

const fn row(name: &'static str, family: &'static str, hide: Hide) -> Row {
    Row { name, family, hide }
}

/// Effects that a library knows, by their public names.
pub const LIBRARY: &[Row] = &[
    row("coulomb", "friction", |p, _, m, s, r| {
        let volts = m.supply_v * (s * geometric(r, 0.012, 0.09)).min(0.25);
        p.friction = [m.torque(volts); 2];
        format!("coulomb {volts:.3} V")
    }),
    row("coulomb_asymmetric", "friction", |p, _, m, s, r| {
        let volts = m.supply_v * (s * geometric(r, 0.015, 0.08)).min(0.2);
        let excess = between(r, 0.25, 0.7) * pick(r, &[-1.0, 1.0]);
        p.friction = [m.torque(volts * (1.0 + excess)), m.torque(volts * (1.0 - excess))];
        format!("coulomb_asymmetric {volts:.3} V {excess:+.2}")
    }),
    row("stribeck", "friction", |p, _, m, s, r| {
        let volts = m.supply_v * geometric(r, 0.015, 0.06);
        let excess = m.supply_v * (s * geometric(r, 0.01, 0.05)).min(0.12);
        let speed = m.motor_speed() * geometric(r, 0.008, 0.05);
        p.friction = [m.torque(volts); 2];
        p.stribeck = (m.torque(excess), speed, chance(r, 0.5));
        format!("stribeck {volts:.3} + {excess:.3} V below {:.3} rad/s", speed / m.gear)
    }),
    row("load_friction", "load_friction", |p, _, m, s, r| {
        let share = (s * geometric(r, 0.06, 0.3)).min(0.5);
        p.load_friction = (share, m.torque(m.supply_v * geometric(r, 0.005, 0.04)));
        format!("load_friction {share:.3}")
    }),
    row("quadratic_drag", "drag", |p, _, m, s, r| {
        let volts = m.supply_v * (s * geometric(r, 0.03, 0.2)).min(0.6);
        p.drag = m.torque(volts);
        format!("quadratic_drag {volts:.3} V at full speed")
    }),
    row("gravity", "gravity", |p, _, m, s, r| {
        let volts = m.supply_v * (s * geometric(r, 0.01, 0.15)).min(0.4);
        p.gravity = (m.torque(volts), between(r, 0.0, TAU));
        format!("gravity {volts:.3} V")
    }),
    row("constant_load", "load", |p, _, m, s, r| {
        let volts = m.supply_v * (s * geometric(r, 0.01, 0.1)).min(0.3) * pick(r, &[-1.0, 1.0]);
        p.load = m.torque(volts);
        format!("constant_load {volts:.3} V")
    }),
    row("spring", "spring", |p, _, m, s, r| {
        let volts = (s * geometric(r, 0.004, 0.06)).min(0.3) * m.supply_v;
        p.spring = m.torque(volts);
        format!("spring {volts:.3} V/rev")
    }),
    row("cogging", "cogging", |p, _, m, s, r| {
        let volts = m.supply_v * (s * geometric(r, 0.01, 0.06)).min(0.15);
        let order = pick(r, &[3.0, 5.0, 6.0, 7.0, 10.0, 12.0]);
        let second = between(r, 0.0, 0.4);
        let phases = [between(r, 0.0, TAU), between(r, 0.0, TAU)];
        p.cogging = (m.torque(volts), m.torque(volts * second), order, phases);
        format!("cogging {volts:.3} V, {order} per turn, {second:.2} of the second harmonic")
    }),
    row("backlash", "gear", |p, _, _, s, r| {
        let degrees = (s * geometric(r, 0.4, 4.0)).min(10.0);
        p.gap = degrees.to_radians();
        format!("backlash {degrees:.2} deg")
    }),
    row("compliance", "gear", |p, _, _, s, r| {
        let hertz = (geometric(r, 4.0, 30.0) / s).max(2.5);
        p.spring_hz = (hertz, between(r, 0.03, 0.12));
        format!("compliance {hertz:.1} Hz")
    }),
    row("dead_zone", "dead_zone", |p, _, m, s, r| {
        let volts = m.supply_v * (s * geometric(r, 0.01, 0.12)).min(0.25);
        let apart = between(r, -0.15, 0.15);
        p.driver.dead_v = [volts * (1.0 + apart), volts * (1.0 - apart)];
        format!("dead_zone {volts:.3} V")
    }),
    row("voltage_drop", "drop", |p, _, m, s, r| {
        let volts = (s * geometric(r, 0.25, 1.8)).min(0.25 * m.supply_v);
        p.driver.drop = (volts, m.stall_current() * geometric(r, 0.01, 0.06));
        format!("voltage_drop {volts:.2} V")
    }),
    row("supply_sag", "supply", |p, _, m, s, r| {
        let share = (s * geometric(r, 0.06, 0.5)).min(0.9);
        p.driver.source = (share * m.resistance, geometric(r, 0.0005, 0.006));
        format!("supply_sag {share:.2} of the winding")
    }),
    row("coast", "coast", |p, _, _, s, r| {
        let share = (s * between(r, 0.5, 1.0)).min(1.0);
        let hertz = pick(r, &[245.0, 490.0, 976.0, 980.0]);
        p.driver.coast = (share, hertz);
        format!("coast {share:.2} at {hertz} Hz")
    }),
    row("freewheel", "coast", |p, _, _, _, r| {
        // It brakes or it does not.
        let hertz = pick(r, &[490.0, 980.0, 3900.0]);
        p.driver.freewheel = (hertz, between(r, 0.3, 0.8));
        format!("freewheel at {hertz} Hz, a diode of {:.2} V", p.driver.freewheel.1)
    }),
    row("winding_heating", "heat", |p, _, _, s, r| {
        p.heating = ((s * geometric(r, 0.03, 0.25)).min(0.6), geometric(r, 10.0, 60.0));
        format!("winding_heating {:.3} 1/s, {:.0} s", p.heating.0, p.heating.1)
    }),
    row("saturation", "saturation", |p, _, m, s, r| {
        let loss = (s * between(r, 0.12, 0.4)).min(0.55);
        // 1 / sqrt(1 + x^2) = 1 - loss at stall
        let x = (1.0 / (1.0 - loss).powi(2) - 1.0).sqrt();
        p.saturation_a = m.stall_current() / x;
        format!("saturation {loss:.2} of the torque at stall")
    }),
    row("delay", "late", |p, _, _, s, r| {
        let ms = (s * geometric(r, 2.0, 40.0)).min(120.0);
        p.driver.delay_s = 1e-3 * ms;
        format!("delay {ms:.1} ms")
    }),
    row("sensor_lag", "late", |_, sensor, _, s, r| {
        let ms = (s * geometric(r, 3.0, 30.0)).min(80.0);
        if chance(r, 0.6) {
            sensor.filter_s = 1e-3 * ms;
            format!("sensor_lag {ms:.1} ms filter")
        } else {
            sensor.hold_s = 1e-3 * ms;
            format!("sensor_lag {ms:.1} ms hold")
        }
    }),
    row("eccentricity", "disc", |_, sensor, m, s, r| {
        let counts = (s * geometric(r, 1.2, 6.0)).min(20.0);
        sensor.eccentric = (counts * m.count_rad(), between(r, 0.0, TAU));
        format!("eccentricity {counts:.1} counts")
    }),
    row("lost_counts", "lost", |_, sensor, m, s, r| {
        let share = (s * geometric(r, 0.004, 0.04)).min(0.1);
        sensor.lost = (share, m.no_load_speed() * between(r, 0.2, 0.45));
        format!("lost_counts {:.2} % above {:.2} rad/s", 100.0 * share, sensor.lost.1)
    }),
];

/// Physics that no library of these names has.
pub const OUTSIDE: &[Row] = &[
    row("uneven_friction", "friction", |p, _, m, s, r| {
        let volts = m.supply_v * (s * geometric(r, 0.02, 0.06)).min(0.15);
        p.friction = [m.torque(volts); 2];
        p.uneven = between(r, 0.5, 0.9);
        format!("friction {volts:.3} V that varies by {:.2} over a turn", p.uneven)
    }),
    row("warming_grease", "grease", |p, _, _, s, r| {
        p.grease = (s * geometric(r, 0.8, 4.0), geometric(r, 3.0, 20.0));
        format!("cold grease {:.1} x, {:.0} s", p.grease.0, p.grease.1)
    }),
    row("dragged_cable", "cable", |p, _, m, s, r| {
        let volts = m.supply_v * (s * geometric(r, 0.02, 0.08)).min(0.2);
        p.cable = (m.torque(volts), geometric(r, 0.2, 1.5));
        format!("cable hysteresis {volts:.3} V over {:.2} rad", p.cable.1)
    }),
    row("current_limit", "limit", |p, _, m, s, r| {
        let share = (geometric(r, 0.3, 0.6) / s).max(0.2);
        p.driver.limit_a = share * m.stall_current();
        format!("current limit at {share:.2} of stall")
    }),
    row("duty_curve", "curve", |p, _, _, s, r| {
        p.driver.curve = (1.0 - s * between(r, 0.2, 0.4)).max(0.4);
        format!("duty curve of exponent {:.2}", p.driver.curve)
    }),
];
