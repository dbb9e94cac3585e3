//! What a controller compares, among columns without names: where one column is exactly another less a third, it is the error, and neither
//! the set point nor what was measured of it drives the motor.

use super::MADE;
use crate::log::guess::leads::comes_before;
use crate::log::motion::span;

/// The places of the two columns that make the error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Compared {
    pub set_point: usize,
    pub measured: usize,
}

impl Compared {
    /// The two in `columns`: the error stands behind both and is what is left of them, so the smallest of the three.
    pub fn in_columns(columns: &[Vec<f64>]) -> Option<Compared> {
        let size: Vec<f64> = columns.iter().map(|values| values.iter().map(|x| x.abs()).sum()).collect();
        let changes: Vec<usize> = (0..columns.len()).filter(|k| span(&columns[*k]) > 0.0).collect();
        let is_error = |error: usize, one: usize, other: usize| {
            let near = MADE * span(&columns[error]);
            let both = columns[one].iter().zip(&columns[other]);
            size[error] < size[one].min(size[other])
                && both.zip(&columns[error]).all(|((one, other), error)| (one - other - error).abs() <= near)
        };
        for &error in &changes {
            let before = || changes.iter().copied().filter(move |k| *k < error);
            for one in before() {
                let Some(other) = before().find(|other| *other != one && is_error(error, one, *other)) else {
                    continue;
                };
                // Measured less set point is an error too.
                let is_turned = comes_before(&columns[other], &columns[one]);
                let (set_point, measured) = if is_turned { (other, one) } else { (one, other) };
                return Some(Compared { set_point, measured });
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::{columns, parts};
    use super::*;
    use crate::log::units::Quantity;

    /// A position loop in whole numbers, whose encoder is far coarser than its set point: set point, position, error, command.
    fn rows() -> Vec<Vec<f64>> {
        let (mut x, mut w) = (0.0_f64, 0.0_f64);
        let row = |k: u32| {
            let set_point = (120.0 * (0.02 * f64::from(k)).sin()).round();
            let position = (x / 20.0).round() * 20.0;
            let command = (1.5 * (set_point - position) - 4.0 * w).round();
            w += 0.2 * (0.1 * command - w);
            x += w;
            vec![set_point, position, set_point - position, command]
        };
        (0..600).map(row).collect()
    }

    #[test]
    fn the_set_point_and_what_was_measured_of_it_are_told_by_the_error() {
        let found = Compared::in_columns(&columns(&rows()));
        assert_eq!(found, Some(Compared { set_point: 0, measured: 1 }));
        let without: Vec<Vec<f64>> = rows().into_iter().map(|row| vec![row[0], row[1], row[3]]).collect();
        assert_eq!(Compared::in_columns(&columns(&without)), None);
    }

    #[test]
    fn a_coarse_position_that_is_compared_with_a_set_point_is_the_motion_and_no_drive() {
        let found = parts(&[], &rows());
        let drive = found.iter().find(|part| [Quantity::Voltage, Quantity::Duty].contains(&part.quantity));
        let motion = found.iter().find(|part| [Quantity::Angle, Quantity::Speed].contains(&part.quantity));
        assert_eq!(drive.map(|part| part.index), Some(3), "{found:?}");
        assert_eq!(motion.map(|part| part.index), Some(1), "{found:?}");
    }
}
