//! The names under which SysId's routines and AdvantageKit's programs log a state, a motor and its quantities.

/// What stands behind `sysid-test-state-`, the name of the routine.
pub fn routine_of(entry: &str) -> String {
    let lower = entry.to_ascii_lowercase();
    lower.rsplit_once("sysid-test-state-").map_or_else(String::new, |(_, routine)| routine.to_owned())
}

/// Whether the routine's log names this motor: `left-drive` is of `drive`.
pub fn belongs(motor: &str, routine: &str) -> bool {
    let motor = motor.to_ascii_lowercase();
    motor == routine || motor.strip_suffix(routine).is_some_and(|rest| rest.ends_with('-'))
}

/// Whether an entry of this name holds the state of a routine.
pub fn is_state(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    name.contains("sysid-test-state") || name.ends_with("sysidteststate") || name.ends_with("sysidstate")
}

/// The test that a state names, in whatever case and with whatever between its words; none while idle.
pub fn state_of(value: &str) -> Option<&'static str> {
    const TESTS: [&str; 4] =
        ["quasistatic-forward", "quasistatic-reverse", "dynamic-forward", "dynamic-reverse"];
    let plain = |text: &str| -> String {
        text.chars().filter(char::is_ascii_alphabetic).collect::<String>().to_ascii_lowercase()
    };
    let value = plain(value);
    TESTS.into_iter().find(|test| plain(test) == value)
}

/// What AdvantageKit programs call the end of an entry, for each kind, with its unit.
const ENDINGS: [(&str, &str, &str); 7] = [
    ("voltage", "appliedvolts", "V"),
    ("voltage", "appliedvoltage", "V"),
    ("position", "positionrad", "rad"),
    ("position", "positionrads", "rad"),
    ("position", "positionrotations", "rev"),
    ("velocity", "velocityradpersec", "rad"),
    ("velocity", "velocityrotationspersec", "rev"),
];

/// `voltage-left-drive` and `NT:/x/voltage-left-drive` are of the motor `left-drive`; `/Drive/LeftAppliedVolts` of `left`.
pub fn motor_of(name: &str, kind: &str) -> Option<String> {
    Some(motor_and_unit(name, kind)?.0)
}

/// The motor whose `kind` the entry holds, and `rad` or `rev` (which SysId takes where the name does not say).
pub fn motor_and_unit(name: &str, kind: &str) -> Option<(String, &'static str)> {
    let last = name.rsplit(['/', ':']).next()?;
    if let Some(motor) = last.strip_prefix(kind).and_then(|rest| rest.strip_prefix('-')) {
        return Some((motor.to_owned(), "rev"));
    }
    let lower = last.to_ascii_lowercase();
    let (ending, unit) = ENDINGS
        .iter()
        .filter(|(of, ..)| *of == kind)
        .find_map(|(_, ending, unit)| lower.ends_with(ending).then_some((*ending, *unit)))?;
    let path = name[..name.len() - last.len()].trim_matches('/');
    let motor = lower[..lower.len() - ending.len()].trim_matches('-');
    Some((if motor.is_empty() { path.to_owned() } else { motor.to_owned() }, unit))
}

/// What an entry belongs to: the motor, by SysId's and AdvantageKit's names, or else all that stands before the last part of its name.
pub fn group_of(name: &str) -> String {
    let motor = ["voltage", "position", "velocity"].iter().find_map(|kind| motor_of(name, kind));
    let path = name.rsplit_once(['/', '.']).map_or("", |(path, _)| path);
    motor.map_or_else(|| path.to_owned(), |motor| format!("{path}/{motor}"))
}
