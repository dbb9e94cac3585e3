//! The rigs: one row each. What their owners know comes from the SOURCE.md beside the logs.

/// A rig.
pub struct Case {
    /// Name in the table.
    pub name: &'static str,
    /// Folder of its logs.
    pub folder: &'static str,
    /// Logs to learn from.
    pub train: &'static [&'static str],
    /// Logs kept out.
    pub unseen: &'static [&'static str],
    /// How to read them.
    pub reading: &'static [&'static str],
    /// What its owners know, in words.
    pub owners: &'static str,
    /// The same by names: of each group one must be found.
    pub knows: &'static [&'static [&'static str]],
    /// Parameters and what owners or papers say of them.
    pub figures: &'static [(&'static str, &'static str)],
    /// A slide: "angles" are metres.
    pub metres: bool,
}

const PLAIN: Case = Case {
    name: "",
    folder: "",
    train: &[],
    unseen: &[],
    reading: &[],
    owners: "",
    knows: &[],
    figures: &[],
    metres: false,
};

/// All rigs.
pub const CASES: [Case; 10] = [
    Case {
        name: "emps",
        folder: "emps",
        train: &["train.csv"],
        unseen: &["val.csv"],
        owners: "dry friction, an offset",
        knows: &[&["coulomb", "coulomb_asymmetric", "stribeck", "load_friction"]],
        // Janot, Gautier, Brunot 2019: M 95.11 kg, Fv 203.5 N s/m, Fc 20.39 N, offset -3.16 N; drive 35.15 N/V.
        figures: &[
            ("gain", "0.173 (m/s)/V: 35.15 N/V over 203.5 N s/m"),
            ("tau_m", "0.467 s: 95.11 kg over 203.5 N s/m"),
            ("coulomb.level", "0.580 V: 20.39 N"),
            ("coulomb_asymmetric.level", "0.580 V: 20.39 N"),
            ("stribeck.level", "0.580 V: 20.39 N"),
            ("constant_load.level", "-0.090 V: -3.16 N"),
        ],
        metres: true,
        ..PLAIN
    },
    Case {
        name: "bam-sts3250",
        folder: "bam-sts3250",
        train: &["2024-10-26_12h23m27.json", "2024-10-26_12h23m42.json", "2024-10-26_12h24m55.json"],
        unseen: &["2024-10-26_12h27m27.json"],
        reading: &["--format", "bam-json"],
        owners: "a pendulum, gear friction",
        knows: &[&["gravity"], &["coulomb", "coulomb_asymmetric", "stribeck", "load_friction"]],
        ..PLAIN
    },
    Case {
        name: "fra233-motor",
        folder: "fra233-motor",
        train: &["train/ramp.csv", "train/sine_2.5hz.csv", "train/stair_1hz.csv"],
        unseen: &[
            "validation/chirp.csv",
            "validation/sine_0.5hz.csv",
            "validation/stair_0.5hz.csv",
            "validation/step_60.csv",
        ],
        owners: "dry friction and hardly anything else",
        knows: &[&["coulomb", "coulomb_asymmetric", "stribeck", "dead_zone"]],
        figures: &[("coulomb.level", "0.6 to 0.86 V"), ("stribeck.level", "0.6 to 0.86 V")],
        ..PLAIN
    },
    Case {
        name: "frc-romi-left",
        folder: "frc-romi-left",
        train: &["train/fast-backward.csv", "train/slow-backward.csv", "train/slow-forward.csv"],
        unseen: &["validation/fast-forward.csv"],
        owners: "66 to 85 ms late, renewed every 50 ms",
        knows: &[&["delay", "sensor_lag"]],
        figures: &[("delay.time", "0.066 to 0.085 s to the first motion")],
        ..PLAIN
    },
    Case {
        name: "frc-romi-right",
        folder: "frc-romi-right",
        train: &["train/fast-backward.csv", "train/slow-backward.csv", "train/slow-forward.csv"],
        unseen: &["validation/fast-forward.csv"],
        owners: "66 to 85 ms late, renewed every 50 ms",
        knows: &[&["delay", "sensor_lag"]],
        figures: &[("delay.time", "0.066 to 0.085 s to the first motion")],
        ..PLAIN
    },
    Case {
        name: "l298n-deadzone",
        folder: "l298n-deadzone",
        train: &["train/part_1.csv", "train/part_3.csv", "train/part_5.csv"],
        unseen: &["validation/part_2.csv", "validation/part_4.csv"],
        owners: "the driver's dead zone, unlike by direction",
        knows: &[&["dead_zone"]],
        figures: &[
            ("dead_zone.width", "3.5 to 4.5 V to break away; 1.7 V in motion"),
            ("gain", "3.4 to 3.6 rad/s/V: 32 to 34 rpm/V"),
            ("tau_m", "0.20 to 0.24 s"),
        ],
        ..PLAIN
    },
    Case {
        name: "micromouse, left wheel",
        folder: "micromouse",
        train: &[
            "controllerDelayImpact1ms.csv",
            "controllerDelayImpact2ms.csv",
            "controllerDelayImpact10ms.csv",
        ],
        unseen: &["controllerDelayImpact5ms.csv"],
        reading: &["--map", "time=time:ms,duty=leftCommand:255,speed=leftSpeed:rpm", "--supply-volts", "7.9"],
        owners: "a dead band, a bent curve of speed over duty, a sagging battery",
        knows: &[
            &["dead_zone", "coulomb", "stribeck", "voltage_drop", "coast"],
            &["coast", "supply_sag", "quadratic_drag", "saturation", "voltage_drop"],
        ],
        ..PLAIN
    },
    Case {
        name: "undcmotor-angle",
        folder: "undcmotor-angle",
        train: &["train/profile.csv", "train/stairs.csv"],
        unseen: &["validation/step.csv"],
        owners: "a dead zone of 0.28 V, speed far from proportional to duty",
        knows: &[&["dead_zone", "coulomb", "stribeck", "coast"]],
        figures: &[("dead_zone.width", "0.28 V")],
        ..PLAIN
    },
    Case {
        name: "undcmotor-jl, steps unseen",
        folder: "undcmotor-jl",
        train: &["DCmotor_prbs_open_exp.csv"],
        unseen: &["DCmotor_step_open_exp.csv"],
        reading: &["--map", "time=t,voltage=u,speed=y:deg/s"],
        owners: "two samples late (40 ms), a dead zone of 0.20 V that this test hardly shows",
        knows: &[&["delay", "sensor_lag"]],
        figures: &[("delay.time", "0.040 s: two samples"), ("dead_zone.width", "0.20 V")],
        ..PLAIN
    },
    Case {
        name: "undcmotor-speed",
        folder: "undcmotor-speed",
        train: &["train/prbs_1.csv", "train/prbs_2.csv", "train/prbs_3.csv"],
        unseen: &["validation/prbs_4.csv"],
        owners: "a sample late (20 ms), a dead zone of 0.28 V, speed far from proportional to duty",
        knows: &[&["delay", "sensor_lag"], &["dead_zone", "coast", "coulomb", "stribeck", "voltage_drop"]],
        figures: &[("delay.time", "0.020 s: one sample"), ("dead_zone.width", "0.28 V")],
        ..PLAIN
    },
];
