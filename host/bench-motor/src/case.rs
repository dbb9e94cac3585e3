//! A case of the examination: records, what the user knows, and the truth.

use rand::SeedableRng;

use crate::bench::{Bench, Protocol, Setup};
use crate::effects::{LIBRARY, OUTSIDE, Row};
use crate::plant::{self, Physics};
use crate::programme::Programme;
use crate::sensor;
use crate::visibility::visibility;
use crate::{Rng, between, chance, gaussian, pick};

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    /// One effect is hidden, beside what belongs to the bench.
    Single,
    /// Two.
    Pair,
    /// None.
    Nothing,
    /// One that no library has.
    Outside,
}

/// One log.
#[derive(Debug, Clone, Default)]
pub struct Log {
    /// Name.
    pub name: String,
    /// Stamps, s.
    pub time_s: Vec<f64>,
    /// Voltage as logged: measured or only commanded, V.
    pub voltage_v: Vec<f64>,
    /// Angle of the output shaft, rad.
    pub angle_rad: Option<Vec<f64>>,
    /// Speed of the output shaft, rad/s.
    pub speed_rad_s: Option<Vec<f64>>,
}

impl Log {
    /// The column that is compared.
    pub fn reading(&self) -> &[f64] {
        self.angle_rad.as_deref().or(self.speed_rad_s.as_deref()).unwrap_or(&[])
    }
}

/// An effect that is there.
#[derive(Debug, Clone, PartialEq)]
pub struct Hidden {
    /// Its name.
    pub name: &'static str,
    /// Its size in words.
    pub size: String,
    /// What it changes beyond what the motor's own parameters take over, in multiples of the noise; none where that is not
    /// to be had, because it is part of something else.
    pub visibility: Option<f64>,
    /// An answer without it is wrong: it was hidden on purpose, or belongs to the bench and shows.
    pub asked: bool,
}

/// What the user knows; nothing is exact.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Known {
    /// Motor turns per output turn.
    pub gear_ratio: Option<f64>,
    /// Counts per output turn.
    pub counts_per_rev: Option<f64>,
    /// Whether the encoder is on the output shaft.
    pub encoder_on_output: Option<bool>,
    /// Rated voltage, V.
    pub voltage_v: Option<f64>,
    /// Output speed there, rad/s.
    pub no_load_speed_rad_s: Option<f64>,
    /// Stall current there, A.
    pub stall_current_a: Option<f64>,
    /// Winding, ohm.
    pub resistance_ohm: Option<f64>,
}

/// A case.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its bench.
    pub bench: Bench,
    /// Its seed.
    pub seed: u64,
    /// What is asked.
    pub group: Group,
    /// What is there.
    pub hidden: Vec<Hidden>,
    /// Deviation of the disturbance torque over stall.
    pub disturbance: f64,
    /// Motor, sensor, disturbance in words.
    pub conditions: String,
    /// Logs to learn from.
    pub training: Vec<Log>,
    /// Logs to keep out.
    pub held_out: Vec<Log>,
    /// What is known.
    pub known: Known,
}

/// What belongs to a bench must change the records by so many times the noise to be asked for.
const SHOWS: f64 = 1.0;
/// What is hidden on purpose is made larger until it changes them by so many.
const HINTS: f64 = 0.5;
/// Draws of one effect before another is taken.
const DRAWS: usize = 3;

impl Case {
    /// Case `seed` of a bench. The same seed gives the same case.
    pub fn new(bench: Bench, seed: u64, protocol: Protocol) -> Self {
        let mut rng = Rng::seed_from_u64(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (bench as u64 + 1));
        let mut setup = Setup::draw(bench, protocol, &mut rng);
        let group = match between(&mut rng, 0.0, 1.0) {
            x if x < 0.5 => Group::Single,
            x if x < 0.7 => Group::Pair,
            x if x < 0.85 => Group::Nothing,
            _ => Group::Outside,
        };
        let mut hidden = Vec::new();
        let wanted = match group {
            Group::Single | Group::Outside => 1,
            Group::Pair => 2,
            Group::Nothing => 0,
        };
        let mut families: Vec<&str> = Vec::new();
        if bench == Bench::ServoPendulum {
            families.push("gravity");
        }
        let table = if group == Group::Outside { OUTSIDE } else { LIBRARY };
        for _ in 0..30 {
            if hidden.len() == wanted {
                break;
            }
            let row: Row = pick(&mut rng, table);
            if families.contains(&row.family) {
                continue;
            }
            if let Some(found) = hide(&mut setup, row, seed, bench != Bench::WeakSines, &mut rng) {
                families.push(row.family);
                hidden.push(found);
            }
        }
        hidden.extend(background(&setup, &families, seed));
        let conditions = format!(
            "{:.0} Hz, gear {:.1}, {:.0} counts, tau_m {:.0} ms, friction {:.3} V, disturbance {}, repeat {}, {:?}",
            setup.rate,
            setup.motor.gear,
            setup.motor.counts,
            1e3 * setup.motor.mechanical_s(),
            setup.physics.friction[0] / setup.motor.torque(1.0),
            if setup.disturbance.share > 0.0 { setup.disturbance.words() } else { "none".into() },
            if setup.programmes.iter().any(|p| p.name.ends_with(" again")) { "yes" } else { "no" },
            setup.sensor,
        );
        let logs = |all: &[Programme], base: u64| -> Vec<Log> {
            all.iter().enumerate().map(|(k, p)| record(&setup, p, seed ^ (base + k as u64), 7)).collect()
        };
        Self {
            bench,
            seed,
            group,
            hidden,
            disturbance: setup.disturbance.share,
            conditions,
            training: logs(&setup.programmes, 1000),
            held_out: logs(&setup.held_out, 2000),
            known: known(&setup, &mut rng),
        }
    }
}

/// Puts an effect into the bench, larger and larger until it shows; none where it does not.
fn hide(setup: &mut Setup, row: Row, seed: u64, must_show: bool, rng: &mut Rng) -> Option<Hidden> {
    let without = (setup.physics.clone(), setup.sensor.clone());
    for draw in 0..DRAWS {
        let scale = 1.6_f64.powi(draw as i32);
        (setup.physics, setup.sensor) = without.clone();
        let size = (row.hide)(&mut setup.physics, &mut setup.sensor, &setup.motor, scale, rng);
        let seen = visibility(setup, &without, seed);
        if seen >= HINTS || !must_show {
            return Some(Hidden { name: row.name, size, visibility: Some(seen), asked: seen >= HINTS });
        }
    }
    (setup.physics, setup.sensor) = without;
    None
}

/// What belongs to the bench itself: small friction, a battery, a pendulum, a late filtered sensor. It is asked for where it shows,
/// and right but not asked for where it hardly does. A sensor's filter is never asked for: it may be part of the measurement.
fn background(setup: &Setup, families: &[&str], seed: u64) -> Vec<Hidden> {
    let here = (&setup.physics, &setup.sensor);
    let mut found = Vec::new();
    let of = |name: &'static str, size: String, without: Physics| {
        let seen = visibility(setup, &(without, setup.sensor.clone()), seed);
        Hidden { name, size, visibility: Some(seen), asked: seen >= SHOWS }
    };
    let volts = |torque: f64| torque / setup.motor.torque(1.0);
    if setup.physics.uneven > 0.0 || setup.physics.cable.0 > 0.0 {
        // Friction is the honest name of what these do in the mean.
        let size = "mean friction".to_string();
        found.push(Hidden { name: "coulomb", size, visibility: None, asked: false });
    } else if here.0.friction[0] > 0.0 && !families.contains(&"friction") {
        let bare = Physics { friction: [0.0; 2], ..here.0.clone() };
        found.push(of("coulomb", format!("coulomb {:.3} V", volts(here.0.friction[0])), bare));
    }
    if here.0.driver.source.0 > 0.0 && !families.contains(&"supply") {
        let mut bare = here.0.clone();
        (bare.driver.source, bare.driver.discharge) = ((0.0, 0.0), 0.0);
        let share = here.0.driver.source.0 / setup.motor.resistance;
        found.push(of("supply_sag", format!("supply_sag {share:.2}"), bare));
    }
    if setup.bench == Bench::ServoPendulum {
        let bare = Physics { gravity: (0.0, 0.0), ..here.0.clone() };
        found.push(of("gravity", format!("gravity {:.2} V", volts(here.0.gravity.0)), bare));
    }
    if here.1.window_s > 0.0 && !families.contains(&"late") {
        for name in ["sensor_lag", "delay"] {
            let size = format!("{name} of the speed's window {:.0} ms", 1e3 * here.1.window_s);
            found.push(Hidden { name, size, visibility: None, asked: false });
        }
    }
    found
}

/// Plays one programme; `again` picks disturbance and noise of the run, `seed` what else is by chance.
pub fn record(setup: &Setup, programme: &Programme, seed: u64, again: u64) -> Log {
    let mut rng = Rng::seed_from_u64(seed.wrapping_mul(0x2545_f491_4f6c_dd1d).wrapping_add(again));
    let period = 1.0 / setup.rate;
    let jitter = |rng: &mut Rng| setup.jitter * period * gaussian(rng).clamp(-2.5, 2.5);
    let times: Vec<f64> = (0..programme.values.len())
        .map(|k| (k as f64 * period + if k == 0 { 0.0 } else { jitter(&mut rng) }).max(0.0))
        .collect();
    let at = plant::anywhere(&mut rng, &setup.motor);
    let count = setup.motor.count_rad();
    let mut command = |k: usize, angle: f64| {
        let asked = programme.values[k];
        let full = setup.motor.supply_v;
        let volts = if setup.loop_gain > 0.0 {
            let read = (angle / count).floor() * count;
            (setup.loop_gain * (asked - read)).clamp(-full, full)
        } else {
            asked
        };
        if setup.command_steps > 0.0 {
            (volts / full * setup.command_steps).round() * full / setup.command_steps
        } else {
            volts
        }
    };
    let trace =
        plant::run(&setup.motor, &setup.physics, setup.disturbance, at, &times, &mut command, &mut rng);
    let counter = sensor::counter(&setup.sensor, &setup.motor, &trace.encoder, &mut rng);
    let speed = (setup.sensor.window_s > 0.0).then(|| sensor::speeds(&setup.sensor, &counter, &times));
    let angle = speed.is_none().then(|| sensor::angles(&counter, &times));
    Log {
        name: programme.name.clone(),
        time_s: times,
        voltage_v: trace.command,
        angle_rad: angle,
        speed_rad_s: speed,
    }
}

fn known(setup: &Setup, rng: &mut Rng) -> Known {
    let m = &setup.motor;
    let gear = Known {
        gear_ratio: Some(m.gear),
        counts_per_rev: Some(m.counts),
        encoder_on_output: Some(m.encoder_on_output),
        ..Known::default()
    };
    let mut about = |x: f64| Some(x * between(rng, 0.85, 1.15));
    match setup.bench {
        Bench::Protocol => Known {
            voltage_v: Some(m.supply_v),
            no_load_speed_rad_s: about(m.no_load_speed()),
            stall_current_a: about(m.stall_current()),
            resistance_ohm: about(m.resistance),
            ..gear
        },
        Bench::DutyOnBattery | Bench::ServoPendulum | Bench::WeakSines => {
            Known { voltage_v: Some(m.supply_v), ..gear }
        }
        Bench::SysId if chance(rng, 0.5) => Known { voltage_v: Some(m.supply_v), ..Known::default() },
        Bench::SysId | Bench::FewDecimals => Known::default(),
    }
}

impl Setup {
    /// Step of the compared column.
    pub(crate) fn reading_step(&self) -> f64 {
        if self.sensor.window_s > 0.0 {
            (self.motor.count_rad() / self.sensor.window_s).max(self.sensor.speed_step)
        } else {
            self.motor.count_rad()
        }
    }
}
