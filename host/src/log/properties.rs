//! Lines that tell a property of each column: `,Units: V,Units: rad/s` below the names, as Simulink's Data Inspector exports them, and
//! LabVIEW's `Y_Unit_Label` above them.

use super::guess::{unit_names, words};
use super::layout::Layout;

/// What the Data Inspector tells of a signal, in small letters.
const KEYS: [&str; 9] =
    ["type", "units", "unit", "interp", "blockpath", "block path", "portindex", "port index", "sample time"];
/// What a line of LabVIEW's header begins with that tells the units of its channels.
const LABVIEW_UNITS: &str = "Y_Unit_Label\t";

/// The layout that `of` tells of a table without the lines that tell a property of its columns, with the units that these tell; none where
/// there are no such lines.
pub(super) fn below_names(lines: &[&str], of: impl Fn(&[&str]) -> Layout) -> Option<Layout> {
    let (told, kept): (Vec<usize>, Vec<usize>) = (0..lines.len()).partition(|k| key(lines[*k]).is_some());
    if told.is_empty() {
        return None;
    }
    let at = |places: &[usize]| places.iter().map(|k| lines[*k]).collect::<Vec<_>>();
    let layout = of(&at(&kept));
    let place = |k: usize| kept.get(k).copied().unwrap_or(lines.len());
    let units = if layout.units.is_empty() { units(&at(&told)) } else { layout.units };
    Some(Layout { header: layout.header.map(place), rows: place(layout.rows), units, ..layout })
}

/// The property, in small letters, that every cell of a line tells, but for that of the time.
fn key(line: &str) -> Option<String> {
    // One alone is a remark.
    line.find(',')?;
    let mut cells = line.split(',').map(str::trim).filter(|cell| !cell.is_empty());
    let of = |cell: &str| Some(cell.split_once(':')?.0.trim().to_lowercase());
    let key = of(cells.next()?).filter(|key| KEYS.contains(&key.as_str()))?;
    cells.all(|cell| of(cell).as_ref() == Some(&key)).then_some(key)
}

/// The units of the columns, where one of these lines tells them; empty otherwise.
fn units(lines: &[&str]) -> Vec<String> {
    let line = lines.iter().find(|line| key(line).is_some_and(|key| key.starts_with("unit")));
    let unit = |cell: &str| cell.split_once(':').map_or(String::new(), |(_, unit)| unit.trim().to_owned());
    line.map(|line| line.split(',').map(unit).collect()).unwrap_or_default()
}

/// The units that LabVIEW tells before the `names` of the time and its channels; only such as a name does not contradict, for `Volts` is
/// what it calls what nobody gave a unit. Empty where it tells none.
pub(super) fn of_labview(before: &[&str], names: &[String]) -> Vec<String> {
    let line = before.iter().rev().find_map(|line| line.strip_prefix(LABVIEW_UNITS));
    let units: Vec<&str> = line.map(|line| line.trim_end().split('\t').collect()).unwrap_or_default();
    let named = names.iter().filter(|name| !name.is_empty() && !name.eq_ignore_ascii_case("comment")).count();
    if units.is_empty() || named != units.len() + 1 {
        return Vec::new();
    }
    let fits = |name: &String, unit: &str| {
        let called = words::said(name).quantity.map(|(of, _)| of);
        unit_names::unit_named(unit).is_some_and(|(of, _)| called.is_none_or(|called| called == of))
    };
    let told = names[1..].iter().zip(units).map(|(name, unit)| if fits(name, unit) { unit } else { "" });
    [""].into_iter().chain(told).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn properties_of_signals_below_their_names_are_no_names_and_tell_the_units() {
        let text = "time,Controller:1.u,Plant:1.omega\n,Type: double,Type: double\n,Units: V,Units: rad/s\n,Interp: zoh,Interp: linear";
        let rows: Vec<String> = (0..20).map(|k| format!("0.0{k},{k},1.5")).collect();
        let lines: Vec<&str> = text.lines().chain(rows.iter().map(String::as_str)).collect();
        let layout = Layout::of(&lines);
        assert_eq!((layout.header, layout.rows), (Some(0), 4));
        assert_eq!(layout.names, ["time", "Controller:1.u", "Plant:1.omega"]);
        assert_eq!(layout.units, ["", "V", "rad/s"]);
        for other in ["t:12,pwm:80", "Type: a,Units: b", "1,2", "", "state: ramp", "Units: V"] {
            assert_eq!(key(other), None, "{other}");
        }
    }

    #[test]
    fn labview_tells_units_where_the_names_do_not_contradict_them() {
        let names = |text: &str| text.split(';').map(str::to_owned).collect::<Vec<_>>();
        let before = ["Channels\t2", "Y_Unit_Label\tVolts\tRPM\t", "X0\t0\t0"];
        assert_eq!(of_labview(&before, &names("X_Value;Voltage;Speed;Comment")), ["", "Volts", "RPM"]);
        assert_eq!(of_labview(&before, &names("X_Value;Untitled;Position")), ["", "Volts", ""]);
        assert!(of_labview(&before, &names("X_Value;Speed")).is_empty());
        assert!(of_labview(&before[..1], &names("X_Value;Voltage;Speed")).is_empty());
    }
}
