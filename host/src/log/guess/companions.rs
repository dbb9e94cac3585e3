//! Names that only the columns beside them explain: the error of a quantity, its integral, an index that all columns share.
//!
//! A letter by itself is a weak word: `i` is a current in `t,u,i`, the integral of an angle in `psi,epsi,psi_i` and a subscript in
//! `theta_i,omega_i,u_i`.

use super::words::{self, Said};
use crate::log::units::Quantity;

/// So many columns that end with one letter have it as an index.
const SHARED: usize = 3;
/// Letters that say something of their own: an error, the axes of a field-oriented drive, units.
const NO_INDEX: [&str; 7] = ["e", "d", "q", "s", "m", "v", "a"];
/// What is added up over time ends with one of these, ...
const INTEGRALS: [&str; 2] = ["i", "int"];
/// ... but for what belongs to a thing and not to its motion: `motor_i` is its current.
const THINGS: [&str; 12] =
    ["motor", "mot", "m", "wheel", "joint", "axis", "shaft", "servo", "left", "right", "l", "r"];
/// Quantities by which an error is called: `epos`, `etheta`, `ex`.
const ERRORS_OF: [&str; 13] =
    ["x", "y", "z", "pos", "position", "theta", "phi", "psi", "angle", "omega", "vel", "speed", "velocity"];
/// Electrical turns begin with the letter of an error.
const NO_ERRORS: [&str; 1] = ["erpm"];

/// Corrects what names say by the names beside them.
pub(super) fn tell(said: &mut [Said], names: &[String]) {
    let bare: Vec<(Vec<String>, Option<String>)> = names
        .iter()
        .map(|name| {
            let (name, unit) = words::bracketed(name);
            (words::of(&name), unit)
        })
        .collect();
    let words: Vec<&[String]> = bare.iter().map(|(words, _)| words.as_slice()).collect();
    let indexed: Vec<bool> = (0..names.len()).map(|k| has_index(&words, k)).collect();
    for k in (0..names.len()).filter(|k| indexed[*k]) {
        let (words, unit) = &bare[k];
        let stem = words[..words.len() - 1].join("_");
        said[k] = words::said(&unit.as_ref().map_or(stem.clone(), |unit| format!("{stem} [{unit}]")));
    }
    let moves = |said: &Said| {
        said.wanted || said.quantity.is_some_and(|(q, _)| [Quantity::Angle, Quantity::Speed].contains(&q))
    };
    for k in (0..names.len()).filter(|k| !indexed[*k]) {
        if is_error(&words, k) || integral_of(&words, k).is_some_and(|of| moves(&said[of])) {
            said[k] = Said { wanted: true, ..Said::default() };
        }
    }
}

/// Whether the last letter of column `k` is one that several columns share, one of them a motion.
fn has_index(words: &[&[String]], k: usize) -> bool {
    let Some((own, _)) = index(words[k]).filter(|(own, _)| !NO_INDEX.contains(own)) else { return false };
    let of_all = words.iter().filter_map(|words| index(words));
    let mut stems: Vec<String> = of_all.filter(|(last, _)| *last == own).map(|(_, stem)| stem).collect();
    stems.sort();
    stems.dedup();
    let is_motion = |stem: &String| {
        words::said(stem).quantity.is_some_and(|(q, _)| [Quantity::Angle, Quantity::Speed].contains(&q))
    };
    stems.len() >= SHARED && stems.iter().any(is_motion)
}

/// The single letter that ends a name of several words, and what stands before it.
fn index(words: &[String]) -> Option<(&str, String)> {
    let (last, stem) = words.split_last()?;
    (last.chars().count() == 1 && !stem.is_empty()).then(|| (last.as_str(), stem.join("_")))
}

/// Whether column `k` is called the error of a quantity, or what such an error changes by: `ex` and `dex` beside each other, `epsi` beside
/// `psi`.
fn is_error(words: &[&[String]], k: usize) -> bool {
    let [own, ..] = words[k] else { return false };
    let is_column = |name: &str| {
        words.iter().enumerate().any(|(other, words)| other != k && words.first().is_some_and(|w| w == name))
    };
    let of_error = |own: &str| {
        !NO_ERRORS.contains(&own)
            && own.strip_prefix('e').is_some_and(|of| {
                // `et` is rather a time, `ex_signal` an excitation.
                let is_known = ERRORS_OF.contains(&of) && (words[k].len() == 1 || of.chars().count() > 1);
                is_known || of.chars().count() > 1 && is_column(of)
            })
    };
    of_error(own) || own.strip_prefix('d').is_some_and(|error| of_error(error) && is_column(error))
}

/// The column that column `k` is the integral of, by its name.
fn integral_of(words: &[&[String]], k: usize) -> Option<usize> {
    let (last, stem) = words[k].split_last()?;
    let is_thing = stem.len() == 1 && THINGS.contains(&stem[0].as_str());
    if !INTEGRALS.contains(&last.as_str()) || stem.is_empty() || is_thing {
        return None;
    }
    (0..words.len()).find(|other| *other != k && words[*other] == stem)
}

#[cfg(test)]
mod tests {
    use super::super::propose;
    use super::*;

    fn names(text: &str) -> Vec<String> {
        text.split(',').map(str::to_owned).collect()
    }

    fn told(text: &str) -> Vec<Said> {
        let names = names(text);
        let mut said: Vec<Said> = names.iter().map(|name| words::said(name)).collect();
        tell(&mut said, &names);
        said
    }

    #[test]
    fn a_unit_that_columns_share_is_no_index() {
        let table = "time_s,commanded_deg_s,angle_deg,feedback_deg_s";
        let units: Vec<_> = told(table).iter().map(|said| said.unit).collect();
        assert_eq!(units, [Some("s"), Some("deg/s"), Some("deg"), Some("deg/s")]);
    }

    #[test]
    fn errors_and_integrals_are_no_measurements() {
        for (table, last_is_wanted) in [
            ("psi[rad],epsi[rad],psi_i", true),
            ("t,ex[mm]", true),
            ("t,ex[mm],dex[mm/s]", true),
            ("speed,speed_int", true),
            ("rpm,erpm", false),
            ("t,u,i", false),
            ("motor [rpm],motor_i", false),
            ("t,enc", false),
            ("time(t),ex_signal(u)", false),
        ] {
            assert_eq!(told(table).last().unwrap().wanted, last_is_wanted, "{table}");
        }
    }

    #[test]
    fn a_letter_that_all_share_is_an_index() {
        let quantity =
            |table: &str| told(table).iter().map(|said| said.quantity.map(|q| q.0)).collect::<Vec<_>>();
        let wanted = [Quantity::Time, Quantity::Angle, Quantity::Speed, Quantity::Voltage].map(Some);
        assert_eq!(quantity("t,theta_i,omega_i,u_i"), wanted);
        assert_eq!(quantity("t,u_i")[1], Some(Quantity::Current));
    }

    /// A robot of three wheels: its pose and the errors of that are nobody's, the first command turns the first wheel.
    #[test]
    fn a_numbered_command_turns_the_wheel_of_its_number() {
        let table =
            "time[s],ex[mm],dex[mm/s],psi[rad],epsi[rad],psi_i,omega[rad/s],cmd1,cmd2,vwh1[mm/s],vwh2[mm/s]";
        let map = propose(&names(table), &[]).unwrap().map;
        assert!(
            map.starts_with("time=time[s]:s,duty=cmd1:") && map.ends_with(",speed=vwh1[mm/s]:mm/s"),
            "{map}"
        );
    }
}
