//! Counts of one turn of an encoder, as the speed beside them tells: those of a usual encoder where the figure cannot tell them apart.

use super::columns::Part;
use crate::log::sample::numbers;
use crate::log::units::Quantity;
use crate::log::wraps;

/// Lines of usual encoders, each of which makes four counts; besides, what magnetic ones resolve.
const LINES: [f64; 15] = [
    100.0, 200.0, 250.0, 256.0, 300.0, 360.0, 400.0, 500.0, 512.0, 600.0, 1000.0, 1024.0, 2000.0, 2048.0,
    2500.0,
];
const EDGES: f64 = 4.0;
const MAGNETIC: [f64; 2] = [4096.0, 16_384.0];
/// Geared encoders have any count: one that is further off than this is another, however uncertain the figure is.
const NEAREST: f64 = 0.01;

/// The counts of a turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// As the speed tells.
    pub measured: f64,
    /// Those that are proposed.
    pub taken: f64,
}

impl Turn {
    /// A figure that is certain to this share of it.
    pub fn of(measured: f64, uncertainty: f64) -> Self {
        let near = uncertainty.min(NEAREST);
        let usual = LINES.into_iter().map(|lines| EDGES * lines).chain(MAGNETIC);
        let mut within = usual.filter(|counts| (measured / counts - 1.0).abs() <= near);
        // Of two that it may be neither is taken.
        let first = within.next();
        let taken = first.filter(|first| within.all(|other| other == *first)).unwrap_or(measured);
        Self { measured, taken }
    }

    /// What is said of it.
    pub fn said(self) -> String {
        let (measured, taken) = (self.measured.round(), self.taken.round());
        if measured == taken {
            return format!(
                "by the speed beside them {taken} counts are a turn, if both are of one shaft and its unit is right"
            );
        }
        format!(
            "by the speed beside them about {measured} counts are a turn, if both are of one shaft and its unit is right; {taken} is a usual encoder's within that"
        )
    }
}

/// The counts of a turn that a proposal assumes where neither a speed nor a wrap tells them, for a person to put the right ones in their place:
/// an encoder of 11 lines behind a gear of 30, the most usual of small geared motors.
pub(crate) const ASSUMED_COUNTS: f64 = 1320.0;

/// Widths at which magnetic encoders begin anew with every turn: 10 to 14 bits (AS5600, AS5048, MA730).
const WIDTHS: [f64; 5] = [1024.0, 2048.0, 4096.0, 8192.0, 16_384.0];
/// Rows in which a wrap is sought.
const ROWS: usize = 2000;

/// The counts of a turn of a counter that begins anew with each, as magnetic encoders do; a counter of 16 bits tells nothing of a turn.
pub(super) fn of_wrap(part: &Part, rows: &[Vec<f64>]) -> Option<f64> {
    if part.quantity != Quantity::Angle || part.unit != "counts" {
        return None;
    }
    let values: Vec<f64> = numbers(rows, part.index).take(ROWS).collect();
    let turn = wraps::turn_of(&values)?;
    WIDTHS.into_iter().find(|width| (turn / width - 1.0).abs() < WRAP_NEAR)
}

/// A wrap is known to this share of it.
const WRAP_NEAR: f64 = 0.02;

/// What is said of it.
pub(super) fn said_of_wrap(turn: f64) -> String {
    format!(
        "the counter begins anew at {turn}, as magnetic encoders do once a turn: {turn} counts are taken for a turn of the shaft that it sits on; if \
         that is the motor's, multiply by the gear ratio"
    )
}

#[cfg(test)]
mod tests {
    use super::super::propose;
    use super::*;

    #[test]
    fn a_magnetic_encoder_tells_its_turn_by_where_it_begins_anew() {
        let names = ["micros", "duty", "raw_angle"].map(str::to_owned);
        let rows = |width: f64| -> Vec<Vec<f64>> {
            let swing = |k: f64| 5.0 * width * (0.01 * k).sin();
            let row = |k: f64| vec![1e4 * k, (0.01 * k).cos(), swing(k).floor().rem_euclid(width)];
            (0..600).map(|k| row(f64::from(k))).collect()
        };
        let counts = |width: f64| propose(&names, &rows(width)).unwrap().counts_per_rev;
        assert_eq!(counts(4096.0).as_deref(), Some("4096"));
        assert_eq!(counts(65_536.0).as_deref(), Some("1320"));
    }

    #[test]
    fn a_usual_count_is_taken_where_the_figure_cannot_tell_it_from_another() {
        for (measured, uncertainty, taken) in [
            (2403.0, 0.004, 2400.0),
            (2409.0, 0.05, 2400.0),
            (4093.0, 0.002, 4096.0),
            // Surely another, that of a gear, and one that may be either of two.
            (2403.0, 1e-4, 2403.0),
            (1320.0, 0.02, 1320.0),
            (979.6, 0.03, 979.6),
        ] {
            assert_eq!(Turn::of(measured, uncertainty).taken, taken, "{measured} {uncertainty}");
        }
        assert!(Turn::of(2403.0, 0.01).said().contains("about 2403"));
    }
}
