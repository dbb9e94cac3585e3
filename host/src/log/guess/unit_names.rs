//! What units are called in headers, and how `--map` writes them.

use super::super::units::Quantity;
use super::spelling::bracketed;

use Quantity::{Angle, Current, Duty, Speed, Time, Voltage};

/// Units as people write them, within brackets or behind an underscore, longest first.
pub(super) const UNITS: &[(&str, Quantity, &str)] = &[
    ("milliseconds", Time, "ms"),
    ("microseconds", Time, "us"),
    ("seconds", Time, "s"),
    ("second", Time, "s"),
    ("secs", Time, "s"),
    ("sec", Time, "s"),
    ("millis", Time, "ms"),
    ("msec", Time, "ms"),
    ("micros", Time, "us"),
    ("usec", Time, "us"),
    ("nanoseconds", Time, "ns"),
    ("ns", Time, "ns"),
    ("us", Time, "us"),
    ("µs", Time, "us"),
    ("μs", Time, "us"),
    ("ms", Time, "ms"),
    ("s", Time, "s"),
    ("mv", Voltage, "mV"),
    ("millivolts", Voltage, "mV"),
    ("volts", Voltage, "V"),
    ("volt", Voltage, "V"),
    ("v", Voltage, "V"),
    ("%", Duty, "100"),
    ("percent", Duty, "100"),
    ("pct", Duty, "100"),
    ("rad/s", Speed, "rad/s"),
    ("rads/s", Speed, "rad/s"),
    ("rad s-1", Speed, "rad/s"),
    ("rad_s", Speed, "rad/s"),
    ("rad·s⁻¹", Speed, "rad/s"),
    ("rad*s^-1", Speed, "rad/s"),
    ("rad s^-1", Speed, "rad/s"),
    ("rad s⁻¹", Speed, "rad/s"),
    ("radians/s", Speed, "rad/s"),
    ("radps", Speed, "rad/s"),
    ("deg/s", Speed, "deg/s"),
    ("°/s", Speed, "deg/s"),
    ("deg_s", Speed, "deg/s"),
    ("degrees/s", Speed, "deg/s"),
    ("dps", Speed, "deg/s"),
    ("rpm", Speed, "rpm"),
    ("1/min", Speed, "rpm"),
    ("u/min", Speed, "rpm"),
    ("r/min", Speed, "rpm"),
    ("rev/min", Speed, "rpm"),
    ("tr/min", Speed, "rpm"),
    ("giri/min", Speed, "rpm"),
    ("obr/min", Speed, "rpm"),
    ("ot/min", Speed, "rpm"),
    ("omw/min", Speed, "rpm"),
    ("varv/min", Speed, "rpm"),
    ("rot/min", Speed, "rpm"),
    ("об/мин", Speed, "rpm"),
    ("转/分", Speed, "rpm"),
    ("min-1", Speed, "rpm"),
    ("min^-1", Speed, "rpm"),
    ("min⁻¹", Speed, "rpm"),
    ("dev/dk", Speed, "rpm"),
    ("d/dk", Speed, "rpm"),
    ("回/分", Speed, "rpm"),
    ("rps", Speed, "rev/s"),
    ("rev/s", Speed, "rev/s"),
    ("r/s", Speed, "rev/s"),
    ("rot_s", Speed, "rev/s"),
    ("rot/s", Speed, "rev/s"),
    ("turns_s", Speed, "rev/s"),
    ("turns/s", Speed, "rev/s"),
    ("rotations/s", Speed, "rev/s"),
    ("krpm", Speed, "rpm*1000"),
    ("mrad/s", Speed, "rad/s*0.001"),
    ("mrad_s", Speed, "rad/s*0.001"),
    ("mrads", Speed, "rad/s*0.001"),
    ("degps", Speed, "deg/s"),
    ("degs", Speed, "deg/s"),
    ("rev_s", Speed, "rev/s"),
    ("revs_s", Speed, "rev/s"),
    ("revs/s", Speed, "rev/s"),
    ("revolutions/s", Speed, "rev/s"),
    ("cps", Speed, "counts/s"),
    ("pps", Speed, "counts/s"),
    ("mm_s", Speed, "mm/s"),
    ("cm_s", Speed, "cm/s"),
    ("m_s", Speed, "m/s"),
    ("mps", Speed, "m/s"),
    ("km/h", Speed, "m/s/3.6"),
    ("km_h", Speed, "m/s/3.6"),
    ("kmh", Speed, "m/s/3.6"),
    ("mph", Speed, "m/s*0.44704"),
    ("ft/s", Speed, "m/s*0.3048"),
    ("ft_s", Speed, "m/s*0.3048"),
    ("in/s", Speed, "m/s*0.0254"),
    ("in_s", Speed, "m/s*0.0254"),
    ("mrad", Angle, "rad*0.001"),
    ("urad", Angle, "rad*0.000001"),
    ("mdeg", Angle, "deg*0.001"),
    ("cdeg", Angle, "deg*0.01"),
    ("ddeg", Angle, "deg*0.1"),
    ("gon", Angle, "deg*0.9"),
    ("arcmin", Angle, "deg/60"),
    ("arcsec", Angle, "deg/3600"),
    ("dv", Voltage, "V*0.1"),
    ("cv", Voltage, "V*0.01"),
    ("minutes", Time, "s*60"),
    ("min", Time, "s*60"),
    ("h", Time, "s*3600"),
    ("hours", Time, "s*3600"),
    ("d", Time, "s*86400"),
    ("day", Time, "s*86400"),
    ("days", Time, "s*86400"),
    ("cs", Time, "ms*10"),
    ("10ms", Time, "ms*10"),
    ("100ms", Time, "ms*100"),
    ("10us", Time, "us*10"),
    ("100us", Time, "us*100"),
    ("20us", Time, "us*20"),
    ("50us", Time, "us*50"),
    ("100ns", Time, "ns*100"),
    ("counts/s", Speed, "counts/s"),
    ("counts_s", Speed, "counts/s"),
    ("counts/ms", Speed, "counts/s*1000"),
    ("counts/10ms", Speed, "counts/s*100"),
    ("counts/20ms", Speed, "counts/s*50"),
    ("counts/50ms", Speed, "counts/s*20"),
    ("counts/100ms", Speed, "counts/s*10"),
    ("counts/min", Speed, "counts/s/60"),
    ("rad", Angle, "rad"),
    ("radians", Angle, "rad"),
    ("deg", Angle, "deg"),
    ("degrees", Angle, "deg"),
    ("degree", Angle, "deg"),
    ("grad", Angle, "deg"),
    ("grados", Angle, "deg"),
    ("gradi", Angle, "deg"),
    ("graus", Angle, "deg"),
    ("degrés", Angle, "deg"),
    ("°", Angle, "deg"),
    ("rev", Angle, "rev"),
    ("revs", Angle, "rev"),
    ("rot", Angle, "rev"),
    ("rotations", Angle, "rev"),
    ("revolutions", Angle, "rev"),
    ("turns", Angle, "rev"),
    ("counts", Angle, "counts"),
    ("ticks", Angle, "counts"),
    ("m/s", Speed, "m/s"),
    ("meters/s", Speed, "m/s"),
    ("metres/s", Speed, "m/s"),
    ("mm/s", Speed, "mm/s"),
    ("cm/s", Speed, "cm/s"),
    ("mm", Angle, "mm"),
    ("cm", Angle, "cm"),
    ("m", Angle, "m"),
    ("meters", Angle, "m"),
    ("metres", Angle, "m"),
    ("ma", Current, "mA"),
    ("a", Current, "A"),
    ("с", Time, "s"),
    ("мс", Time, "ms"),
    ("мкс", Time, "us"),
    ("в", Voltage, "V"),
    ("мв", Voltage, "mV"),
    ("рад/с", Speed, "rad/s"),
    ("град/с", Speed, "deg/s"),
    ("об/с", Speed, "rev/s"),
    ("рад", Angle, "rad"),
    ("град", Angle, "deg"),
    ("об", Angle, "rev"),
    ("а", Current, "A"),
    ("ма", Current, "mA"),
    ("초", Time, "s"),
    ("밀리초", Time, "ms"),
    ("秒", Time, "s"),
    ("毫秒", Time, "ms"),
    ("ミリ秒", Time, "ms"),
    ("伏", Voltage, "V"),
    ("安", Current, "A"),
];

/// What people call the counts of an encoder before a stroke: `ticks/100ms`.
const COUNTS: [&str; 13] = [
    "counts", "count", "cnt", "ticks", "tick", "pulses", "pulse", "edges", "steps", "step", "units", "inc",
    "imp",
];

/// The quantity and the unit, as `--map` writes it, that a text such as `ms` or `1/min` names.
pub fn unit_named(text: &str) -> Option<(Quantity, &'static str)> {
    let lower = text.to_lowercase();
    let named = with_stroke(&lower).unwrap_or(lower);
    UNITS.iter().find(|(known, ..)| *known == named).map(|(_, quantity, unit)| (*quantity, *unit))
}

/// Whether a name, or what stands in its brackets, ends with the unit of an acceleration: `alpha_rad_s2`, `a [m/s^2]`.
pub(super) fn is_of_acceleration(name: &str) -> bool {
    const SECONDS: [&str; 4] = ["s2", "s^2", "s\u{b2}", "s-2"];
    let (bare, bracket) = bracketed(name);
    let text = bracket.unwrap_or(bare).to_lowercase();
    let of = |second: &str| text.strip_suffix(second)?.strip_suffix(['/', '_'])?.rsplit([' ', '_']).next();
    SECONDS.iter().filter_map(|second| of(second)).any(|of| ["rad", "deg", "\u{b0}", "m"].contains(&of))
}

/// The unit of what changes in a time with a stroke between, and the shortest word for a second: of `deg per sec`, `ticks / 100 ms`.
fn with_stroke(lower: &str) -> Option<String> {
    let (of, time) =
        lower.split_once(PER).or_else(|| lower.split_once(" per ")).or_else(|| lower.split_once('/'))?;
    let of = if COUNTS.contains(&of.trim()) { "counts" } else { of.trim() };
    let time = match time.replace(' ', "").as_str() {
        "sec" | "secs" | "second" | "seconds" => "s".to_owned(),
        "minute" | "minutes" => "min".to_owned(),
        time => time.to_owned(),
    };
    Some(format!("{of}/{time}"))
}

/// The unit of what changes in a time that ends a name in small letters: of `left_counts_per_second`.
pub(super) fn rate_in(name: &str) -> Option<(Quantity, &'static str)> {
    let name = name.replace([' ', '-', '.'], "_");
    let (before, time) = name.rsplit_once(PER)?;
    unit_named(&format!("{}/{time}", before.rsplit('_').next()?))
}

/// Behind it stands no unit of the column's own.
pub(super) const PER: &str = "_per_";

/// Whether a text is a unit of anything that a log holds, or a sign that there is none.
pub fn is_unit(text: &str) -> bool {
    const OTHERS: [&str; 14] =
        ["-", "1", "n", "nm", "n m", "w", "hz", "c", "°c", "k", "h:m:s", "hh:mm:ss", "bool", "none"];
    unit_named(text).is_some() || OTHERS.contains(&text.to_lowercase().as_str())
}
