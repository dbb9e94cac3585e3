//! A bridge whose two sides have a column each, `in1,in2` or `rpwm,lpwm`: its motor sees their difference.

use super::columns::Part;
use super::ranges::Range;
use super::{column, words};
use crate::log::units::Quantity;

/// What tells the two sides apart, the one that is taken for forwards first.
const SIDES: [(&str, &str); 16] = [
    ("1", "2"),
    ("0", "1"),
    ("a", "b"),
    ("r", "l"),
    ("right", "left"),
    ("rpwm", "lpwm"),
    ("pwmr", "pwml"),
    ("fwd", "rev"),
    ("forward", "reverse"),
    ("forward", "backward"),
    ("fwd", "bwd"),
    ("f", "r"),
    ("f", "b"),
    ("pos", "neg"),
    ("p", "n"),
    ("cw", "ccw"),
];
/// A side below this share of its peak drives nothing.
const AT_REST: f64 = 0.02;
/// Of two sides no more than this share of the rows drives both, and no less each.
const BOTH: f64 = 0.02;
/// So much more often, in shares of the rows, the motion goes against the difference where its sign is the other.
const AGAINST: f64 = 0.2;

/// Letters and numbers of a name, each by itself, in small letters.
fn tokens(name: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut before = ' ';
    for c in name.chars() {
        let goes_on =
            c.is_alphabetic() && before.is_alphabetic() && !(before.is_lowercase() && c.is_uppercase())
                || c.is_ascii_digit() && before.is_ascii_digit();
        match tokens.last_mut() {
            Some(token) if goes_on => token.extend(c.to_lowercase()),
            _ if c.is_alphanumeric() => tokens.push(c.to_lowercase().collect()),
            _ => {}
        }
        before = c;
    }
    tokens
}

/// Whether two names are those of two sides, and whether the first is that of forwards.
fn sides(one: &str, other: &str) -> Option<bool> {
    let (one, other) = (tokens(one), tokens(other));
    let mut differing = one.iter().zip(&other).filter(|(a, b)| a != b);
    let (a, b) = differing.next().filter(|_| one.len() == other.len() && differing.next().is_none())?;
    let is = |x: &String, y: &String| SIDES.iter().any(|(forth, back)| x == forth && y == back);
    is(a, b).then_some(true).or_else(|| is(b, a).then_some(false))
}

/// The column of the other side of what drives the motor by `part`, and whether `part` is that of forwards. None where each side has a
/// motion of its own: those are two motors.
fn other_side(names: &[String], rows: &[Vec<f64>], part: &Part) -> Option<(usize, bool)> {
    let is_motion = |name: &&String| {
        words::said(name).quantity.is_some_and(|(of, _)| matches!(of, Quantity::Angle | Quantity::Speed))
    };
    let motions: Vec<&String> = names.iter().filter(is_motion).collect();
    let paired = |one: &&String| motions.iter().any(|other| sides(one, other).is_some());
    if ![Quantity::Duty, Quantity::Voltage].contains(&part.quantity) || motions.iter().any(paired) {
        return None;
    }
    let range = |k: usize| Range::of(rows.iter().filter_map(move |row| row.get(k).copied()));
    let is_side = |k: usize| range(k).low >= 0.0 && range(k).peak() > 0.0;
    let found = (0..names.len()).filter(|k| *k != part.index && is_side(part.index) && is_side(*k));
    found.filter_map(|k| Some((k, sides(&names[part.index], &names[k])?))).next()
}

/// Share of the rows in which a side drives the motor, of both columns, and of both at once.
fn shares(rows: &[Vec<f64>], one: usize, other: usize) -> [f64; 3] {
    let peak = |k: usize| rows.iter().filter_map(|row| row.get(k)).fold(0.0_f64, |peak, v| peak.max(*v));
    let peaks = [one, other].map(peak);
    let drives = |row: &Vec<f64>, k: usize, peak: f64| row.get(k).is_some_and(|v| *v > AT_REST * peak);
    let mut counts = [0.0; 3];
    for row in rows {
        let [a, b] = [drives(row, one, peaks[0]), drives(row, other, peaks[1])];
        for (count, is) in counts.iter_mut().zip([a, b, a && b]) {
            *count += f64::from(u8::from(is));
        }
    }
    counts.map(|count| count / rows.len().max(1) as f64)
}

/// Whether the motion goes against what drives it, in more rows than with it: then forwards is the other side.
fn is_turned(rows: &[Vec<f64>], parts: &[Part], forth: usize, back: usize) -> bool {
    let of = |quantity: Quantity| parts.iter().find(|part| part.quantity == quantity).map(|part| part.index);
    let (speed, angle) = (of(Quantity::Speed), of(Quantity::Angle));
    let at = |row: &[f64], k: usize| row.get(k).copied().unwrap_or(f64::NAN);
    let with = rows.windows(2).map(|pair| {
        let drive = at(&pair[0], forth) - at(&pair[0], back);
        let motion = match (speed, angle) {
            (Some(speed), _) => at(&pair[0], speed),
            (None, Some(angle)) => at(&pair[1], angle) - at(&pair[0], angle),
            _ => 0.0,
        };
        let product = drive * motion;
        if product.is_finite() && product != 0.0 { product.signum() } else { 0.0 }
    });
    with.sum::<f64>() < -AGAINST * rows.len() as f64
}

/// Makes a difference of what drives the motor where it is one side of a bridge and never both sides are on.
pub(super) fn join(parts: &mut [Part], names: &[String], rows: &[Vec<f64>]) {
    for k in 0..parts.len() {
        let Some((other, is_forth)) = other_side(names, rows, &parts[k]) else { continue };
        let one = parts[k].index;
        let [drives, brakes, both] = shares(rows, one, other);
        if both <= BOTH && drives > BOTH && brakes > BOTH {
            let (forth, back) = if is_forth { (one, other) } else { (other, one) };
            let (forth, back) =
                if is_turned(rows, parts, forth, back) { (back, forth) } else { (forth, back) };
            (parts[k].index, parts[k].rest) = (forth, Some(back));
        }
    }
}

/// What is asked where what drives the motor may be one side of a bridge, and nothing tells.
pub(super) fn question(parts: &[Part], names: &[String], rows: &[Vec<f64>]) -> Option<String> {
    // The number of a column is no name that says a side.
    let is_named = |part: &&Part| part.rest.is_none() && names[part.index].parse::<u32>().is_err();
    parts.iter().filter(is_named).find_map(|part| {
        let is_free = |other: usize| parts.iter().all(|part| part.index != other);
        let (other, is_forth) = other_side(names, rows, part).filter(|(other, _)| is_free(*other))?;
        let (forth, back) = if is_forth { (part.index, other) } else { (other, part.index) };
        Some(format!(
            "{0} is taken alone; where {1} is the other side of the same bridge, write {2}={3}-{4}:{5}",
            names[part.index],
            names[other],
            part.quantity,
            column(names, forth),
            column(names, back),
            part.unit
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::super::propose;

    #[test]
    fn two_sides_of_a_bridge_are_a_difference_and_two_motors_are_not() {
        let rows = |both: f64| -> Vec<Vec<f64>> {
            let row = |k: i32| {
                let duty = (200.0 * (0.05 * f64::from(k)).sin()).round();
                vec![10.0 * f64::from(k), both + duty.max(0.0), both + (-duty).max(0.0), duty, 0.5 * duty]
            };
            (0..300).map(row).collect()
        };
        for (names, drive) in [
            ("t_ms,in1,in2,rpm", "duty=in1-in2:255"),
            ("t_ms,LPWM,RPWM,rpm", "duty=LPWM-RPWM:255"),
            ("t_ms,LPWM,RPWM,setpoint,rpm", "duty=LPWM-RPWM:255"),
            ("t_ms,pwm_fwd,pwm_rev,rpm", "duty=pwm_fwd-pwm_rev:255"),
            ("t_ms,AIN1,AIN2,rpm", "duty=AIN1-AIN2:255"),
            ("t_ms,pwm1,pwm2,rpm1,rpm2", "duty=pwm1:255"),
            ("t_ms,pwm_left,pwm_right,left_rpm,right_rpm", "duty=pwm_left:255"),
        ] {
            let names: Vec<String> = names.split(',').map(str::to_owned).collect();
            let proposal = propose(&names, &rows(0.0)).unwrap();
            assert!(proposal.map.contains(&format!(",{drive},")), "{}", proposal.map);
            let full = if drive.contains('-') { "-200 .. 200" } else { "0 .. 200" };
            assert!(proposal.preview[1].contains(full), "{:?}", proposal.preview);
        }
        let names = ["t_ms", "in1", "in2", "rpm"].map(String::from);
        let asked = propose(&names, &rows(20.0)).unwrap();
        assert!(asked.map.contains("duty=in1:255") && asked.assumptions().contains("duty=in1-in2:255"));
    }
}
