//! A column that is called a speed and is what a count beside it changes by from row to row: the count is the motion.

use super::clocks::FEWEST_TICKS;
use super::words::Said;
use crate::log::units::Quantity;

/// Tells the counts whose change a speed is whose unit nothing tells: it says no more than they do, and is in no unit of a time.
pub(super) fn tell(said: &mut [Said], rows: &[Vec<f64>]) {
    if rows.len() < FEWEST_TICKS {
        return;
    }
    let of = |said: &Said, quantity: Quantity| said.quantity.is_some_and(|(of, _)| of == quantity);
    for speed in 0..said.len() {
        let is_open = of(&said[speed], Quantity::Speed) && said[speed].unit.is_none() && !said[speed].wanted;
        let may_count = |k: &usize| {
            let own = &said[*k];
            let is_free = own.quantity.is_none() || of(own, Quantity::Angle);
            *k != speed && is_free && !own.wanted && own.unit.is_none_or(|unit| unit == "counts")
        };
        let counts =
            (0..said.len()).filter(may_count).find(|count| is_open && is_change(rows, speed, *count));
        if let Some(count) = counts {
            (said[count].quantity, said[count].unit) = (Some((Quantity::Angle, 4)), Some("counts"));
            (said[speed].quantity, said[speed].since_before) = (None, true);
        }
    }
}

/// Whether `speed` is in every row what `count` changed by since the row before, both whole numbers, and not the same in all: rows are numbered.
fn is_change(rows: &[Vec<f64>], speed: usize, count: usize) -> bool {
    let at = |row: &[f64], k: usize| row.get(k).copied().unwrap_or(f64::NAN);
    let is_whole = |row: &Vec<f64>| at(row, speed).fract() == 0.0 && at(row, count).fract() == 0.0;
    let is_since = |pair: &[Vec<f64>]| at(&pair[1], speed) == at(&pair[1], count) - at(&pair[0], count);
    let changes = || rows.iter().any(|row| at(row, speed) != at(&rows[0], speed));
    rows.iter().all(is_whole) && rows.windows(2).all(is_since) && changes()
}

#[cfg(test)]
mod tests {
    use super::super::propose;

    /// `mVel` beside `mStep` was a speed in rad/s, and the counts were not used.
    #[test]
    fn a_speed_that_is_the_change_of_whole_numbers_beside_it_leaves_the_motion_to_them() {
        let map = |scale: f64| {
            let names = ["PWM", "mStep", "mVel", "mAcc"].map(str::to_owned);
            let mut rows: Vec<Vec<f64>> = Vec::new();
            let (mut steps, mut before) = (0.0, 0.0);
            for k in 0..80_u32 {
                let duty = [0.0, 255.0, -255.0, 0.0][k as usize / 20];
                let speed = f64::round(before + 0.3 * (duty / 3.0 - before));
                steps += speed;
                rows.push(vec![duty, steps, scale * speed, speed - before]);
                before = speed;
            }
            propose(&names, &rows).unwrap().map
        };
        assert_eq!(map(1.0), "duty=PWM:255,angle=mStep:counts");
        assert_eq!(map(0.5), "duty=PWM:255,speed=mVel:rad/s");
    }
}
