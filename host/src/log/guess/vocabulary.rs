//! The words that people name their columns with, and what each says.

use super::super::units::Quantity;
use Quantity::{Angle, Current, Direction, Duty, Interval, Speed, Supply, Time, Voltage};

/// Words of the wild, as they stand alone in a name, with how plainly they say it and the unit that they imply.
pub(super) const WORDS: [(Quantity, u8, Option<&str>, &[&str]); 32] = [
    (
        Time,
        3,
        None,
        &[
            "time",
            "zeit",
            "timestamp",
            "ts",
            "tout",
            "temps",
            "tiempo",
            "tempo",
            "clock",
            "stamp",
            "uhrzeit",
            "tijd",
            "czas",
            "čas",
            "tid",
            "zaman",
            "cas",
            "waktu",
            "timp",
            "aika",
            "idő",
            "시간",
            "時間",
            "время",
            "时间",
            "timestep",
            "timesteps",
        ],
    ),
    (Time, 3, Some("ms"), &["millis", "milliseconds", "tms", "timems", "ms_today"]),
    (Time, 3, Some("us"), &["micros", "microseconds", "tus", "timeus"]),
    (Time, 2, None, &["t", "tick0", "secs", "seconds", "sec", "x_value"]),
    (Interval, 4, None, &["dt", "interval", "deltat", "looptime", "cycletime", "elapsed", "abtastzeit"]),
    (
        Duty,
        3,
        None,
        &[
            "pwm",
            "duty",
            "dutycycle",
            "tastgrad",
            "throttle",
            "pwmvalue",
            "rpwm",
            "lpwm",
            "pwmr",
            "pwml",
            "ain",
            "占空比",
            "шим",
            "darbe",
            "wypełnienie",
            "wypelnienie",
            "듀티",
        ],
    ),
    (
        Duty,
        2,
        None,
        &[
            "cmd",
            "command",
            "output",
            "out",
            "power",
            "drive",
            "control",
            "ctrl",
            "en",
            "ena",
            "enb",
            "esc",
            "pulse",
            "stellgroesse",
            "stellgröße",
        ],
    ),
    (
        Voltage,
        4,
        None,
        &[
            "voltage",
            "spannung",
            "motorspannung",
            "tension",
            "voltaje",
            "tensión",
            "tensione",
            "tensao",
            "tensão",
            "spanning",
            "spänning",
            "napięcie",
            "napiecie",
            "napětí",
            "gerilim",
            "napeti",
            "tegangan",
            "tensiune",
            "feszültség",
            "jännite",
            "전압",
            "電圧",
            "напряжение",
            "电压",
            "vmotor",
            "umotor",
            "motorvoltage",
            "appliedvolts",
        ],
    ),
    (Voltage, 3, Some("V"), &["volts", "volt"]),
    (Voltage, 2, None, &["u", "v", "vm", "um", "va", "input", "in"]),
    // The voltage along the q axis of a field-oriented drive is what turns its motor.
    (Voltage, 5, None, &["vq", "uq"]),
    // The supply's voltage is no motor's.
    (
        Supply,
        5,
        None,
        &["vbat", "vbatt", "battery", "supply", "vcc", "vin", "vbus", "bus", "vsupply", "batterie", "akku"],
    ),
    (
        Angle,
        4,
        None,
        &[
            "angle",
            "position",
            "pos",
            "theta",
            "θ",
            "φ",
            "winkel",
            "phi",
            "lage",
            "posición",
            "posicion",
            "posizione",
            "posição",
            "posicao",
            "ángulo",
            "angulo",
            "ângulo",
            "angolo",
            "hoek",
            "kąt",
            "угол",
            "положение",
            "角度",
            "位置",
            "konum",
            "położenie",
            "polozenie",
            "pozycja",
            "açı",
            "poloha",
            "úhel",
            "uhel",
            "sudut",
            "posisi",
            "unghi",
            "poziție",
            "pozitie",
            "asento",
            "각도",
            "위치",
            "rotation",
            "shaft",
            "q",
        ],
    ),
    (
        Angle,
        3,
        Some("counts"),
        &[
            "enc",
            "encoder",
            "count",
            "counts",
            "ticks",
            "tick",
            "pulses",
            "edges",
            "cnt",
            "qei",
            "impulse",
            "inkremente",
            "pulsos",
            "impulsos",
            "impulsi",
            "impulsions",
            "codeur",
            "encodeur",
            "encodeurs",
            "impulsy",
            "энкодер",
            "编码器",
            "enkoder",
            "엔코더",
        ],
    ),
    (Angle, 3, Some("m"), &["distance", "displacement", "travel", "weg", "carriage"]),
    (Angle, 2, Some("deg"), &["deg", "degree", "degrees", "grad"]),
    (Angle, 2, Some("rad"), &["rad", "radians"]),
    (Angle, 2, Some("rev"), &["rev", "revs", "revolutions", "turns", "rotations"]),
    (
        Speed,
        5,
        None,
        &[
            "speed",
            "velocity",
            "vel",
            "omega",
            "ω",
            "geschwindigkeit",
            "drehgeschwindigkeit",
            "vitesse",
            "velocidad",
            "velocità",
            "velocita",
            "velocidade",
            "snelheid",
            "hastighet",
            "prędkość",
            "predkosc",
            "rychlost",
            "hız",
            "скорость",
            "速度",
            "hiz",
            "kecepatan",
            "viteză",
            "viteza",
            "sebesség",
            "nopeus",
            "rychlosť",
            "속도",
            "角速度",
            "qd",
            "dtheta",
            "thetadot",
            "posdot",
            "phidot",
            "qdot",
            "velo",
            "veloc",
            "spd",
            "vrot",
            "angvel",
            "angularvelocity",
            "angularspeed",
            "motorspeed",
            "wheelspeed",
            "shaftspeed",
            "rotspeed",
        ],
    ),
    (Speed, 2, None, &["w", "y"]),
    (Speed, 5, Some("rpm"), &["rpm", "rpms", "upm", "umin", "motorrpm", "wheelrpm"]),
    // Electrical turns: pole pairs times those of the shaft. A speed of a vehicle beside it is made of it.
    (Speed, 8, Some(ELECTRICAL), &["erpm"]),
    (Speed, 5, Some("rpm"), &TURNING),
    // RoboClaw's quadrature pulses a second.
    (Speed, 5, Some("counts/s"), &["qpps"]),
    // A gyroscope that turns with the shaft.
    (Speed, 1, None, &GYROSCOPE),
    (Speed, 4, Some("rev/s"), &["rps"]),
    (Speed, 4, Some("deg/s"), &["dps"]),
    (Speed, 4, Some("rad/s"), &["rads", "radps"]),
    (
        Direction,
        4,
        None,
        &["dir", "direction", "richtung", "drehrichtung", "motordir", "sens", "sentido", "direzione", "sign"],
    ),
    (
        Current,
        3,
        None,
        &[
            "current",
            "strom",
            "courant",
            "corriente",
            "corrente",
            "stroom",
            "prąd",
            "ток",
            "电流",
            "akım",
            "akim",
            "proud",
            "arus",
            "curent",
            "áram",
            "virta",
            "전류",
            "電流",
            "amps",
            "amp",
            "i",
            "imotor",
            "ia",
            "iq",
            "curr",
        ],
    ),
    (Current, 3, Some("mA"), &["ma"]),
    // VESC Tool's, in amperes.
    (Current, 4, Some("A"), &["current_motor", "avg_motor_current", "q_axis_current"]),
];

/// Words for the turns a minute of machines, which are kept in other units too.
pub(super) const TURNING: [&str; 13] = [
    "drehzahl",
    "toerental",
    "obroty",
    "otáčky",
    "otacky",
    "обороты",
    "转速",
    "devir",
    "turație",
    "turatie",
    "fordulatszám",
    "회전수",
    "回転数",
];

/// What the axes of a gyroscope are called.
pub(super) const GYROSCOPE: [&str; 10] =
    ["gyro", "gyr", "gx", "gy", "gz", "gyrox", "gyroy", "gyroz", "gyroscope", "gyrometer"];

/// The unit of electrical turns a minute, of a motor with as many pole pairs as most.
pub(super) const ELECTRICAL: &str = "rpm/7";

/// Drives that tell turns and turns a second where their names say nothing else (docs.odriverobotics.com, v6.docs.ctr-electronics.com,
/// github.com/mjbots/moteus), ...
pub(super) const TELL_TURNS: [&str; 5] = ["odrive", "phoenix", "talon", "cancoder", "moteus"];

/// ... and what ODrive's own values end with.
pub(super) const TURNS: [&str; 2] = ["pos_estimate", "vel_estimate"];

/// A motion with one of these was commanded: `cmd_vel`, `input_pos`.
pub(super) const COMMANDED: [&str; 4] = ["cmd", "command", "commands", "input"];

/// A name with one of these is that of a register of a servo, whose numbers are whole steps.
pub(super) const REGISTERS: [&str; 2] = ["present", "goal"];

/// A name with one of these is of where to go, ...
pub(super) const TARGETS: [&str; 19] = [
    "setpoint",
    "set",
    "sp",
    "target",
    "goal",
    "ref",
    "reference",
    "desired",
    "des",
    "soll",
    "sollwert",
    "commanded",
    "referencia",
    "referência",
    "riferimento",
    "consigna",
    "consigne",
    "objetivo",
    "alvo",
];

/// ... as is one with what robot learning calls it, which may be measured all the same; ...
pub(super) const ACTION: &str = "action";

/// ... and one with one of these is of what was wanted otherwise, or made of it.
pub(super) const WANTED: [&str; 13] = [
    "demand", "wanted", "e", "kp", "ki", "kd", "integral", "pid", "term", "terms", "pterm", "iterm", "dterm",
];

/// Words that end so are of errors: `error`, `poserror`, `spderr`, `Regelfehler`, `Regelabweichung`.
pub(super) const ERROR_ENDS: [&str; 6] = ["error", "err", "erro", "erreur", "fehler", "abweichung"];

/// A name with one of these is of one term of a controller, or of what was added up for it: alone none drives a motor.
pub(super) const TERMS: [&str; 11] = [
    "proportional",
    "integral",
    "integrator",
    "derivative",
    "term",
    "terms",
    "pterm",
    "iterm",
    "dterm",
    "errorsum",
    "errsum",
];

/// What sensors tell that are no motor's drive: accelerations, how a robot lies, temperatures.
pub(super) const SENSED: [&str; 11] = [
    "acceleration",
    "accel",
    "acc",
    "beschleunigung",
    "heading",
    "yaw",
    "pitch",
    "roll",
    "temp",
    "temperature",
    "temperatur",
];

/// A name with this or a torque says how hard a motor pushes, and neither its voltage nor its duty.
pub(super) const EFFORT: &str = "effort";

/// These say a torque wherever they stand; an effort is one in ROS alone.
pub(super) const TORQUES: [&str; 4] = ["torque", "drehmoment", "couple", "tau"];

/// Counts per one of these are those since the row before.
pub(super) const ROWS: [&str; 6] = ["loop", "sample", "cycle", "period", "interval", "row"];

/// What is counted by a program and no encoder: `sample_count`.
pub(super) const READINGS: [&str; 8] =
    ["loop", "loops", "sample", "samples", "reading", "readings", "row", "rows"];

/// What makes a speed of an angle's name.
pub(super) const RATES: [&str; 6] = ["dot", "rate", "derivative", "hz", "freq", "frequency"];

/// What makes a velocity of a `v`, which is a voltage by itself: `v_rot`.
pub(super) const OF_A_VELOCITY: [&str; 2] = ["rot", "ang"];

/// Counts of the program's own steps, or of a board's timer: `timestep`.
pub(super) const TIME_STEPS: [&str; 2] = ["timestep", "timesteps"];

/// Names with one of these may end in metres.
pub(super) const LINEAR: [&str; 9] =
    ["angle", "position", "pos", "x", "distance", "displacement", "travel", "weg", "carriage"];

/// Names with one of these may end in minutes, hours or hundredths of a second.
pub(super) const CLOCKS: [&str; 6] = ["t", "time", "zeit", "elapsed", "dt", "timestamp"];

/// Endings of the names of whole numbers that are multiples of what they tell, and what takes that away.
pub(super) const SCALES: [(&str, &str); 3] = [("x1000", "/1000"), ("x100", "/100"), ("x10", "/10")];
