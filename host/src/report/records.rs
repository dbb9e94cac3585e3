//! Step 1, Compare: measurement and model over time, one figure a record.

use super::decimate::keep;
use super::figure::{Axis, Curve, Draw, Figure, Numbers, Panel};
use super::story::Shown;
use crate::compare::free_run::FreeRun;
use crate::findings::Yardstick;
use crate::fit::grid::Quantity;
use crate::log::timing::median_interval;

/// Points of a curve; a wide screen has about twice as many columns.
pub const POINTS: usize = 1200;
/// Half the span over which speeds are taken from angles, s.
const HALF_SPAN_S: f64 = 0.025;

/// A window of time, s.
pub type Window = (f64, f64);

/// Turns of the voltage that [`POINTS`] show apart, and the most points of a record that is drawn once and for all.
const TURNS: usize = 60;
const MOST_POINTS: usize = 10_000;
/// Turns that a screen shows apart, and how many of them a denser record begins with.
const DENSE: usize = 150;
const FIRST: usize = 50;
/// A turn of the voltage is one by this share of its reach.
const TURN: f64 = 0.1;

/// The figure of a whole record for a page that cannot ask for more of it: the denser, the more points, so that a part of it shows
/// its turns too.
pub fn whole(id: &str, shown: &Shown, floor: f64) -> Figure {
    let points = POINTS * turns(&shown.model.voltage_v).len().div_ceil(TURNS).max(1);
    drawn(id, shown, floor, None, points.min(MOST_POINTS))
}

/// The samples at which a voltage has turned round.
fn turns(volts: &[f64]) -> Vec<usize> {
    let (low, high) = volts.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    let reach = TURN * (high - low);
    let (mut way, mut last, mut at) = (0.0, volts.first().copied().unwrap_or(0.0), Vec::new());
    for (k, &v) in volts.iter().enumerate() {
        if way >= 0.0 && v < last - reach || way <= 0.0 && v > last + reach {
            (way, last) = ((v - last).signum(), v);
            at.push(k);
        } else if (v - last) * way > 0.0 {
            last = v;
        }
    }
    at
}

/// The part of a record that is looked at first; none where all of it can be seen at once.
fn first_part(run: &FreeRun) -> Option<[f64; 2]> {
    let at = turns(&run.voltage_v);
    (at.len() > DENSE).then(|| [run.time_s[0], run.time_s[at[FIRST]]])
}

/// The figure of one record: measured and simulated, speeds, residual and voltage over one time axis.
pub fn figure(id: &str, shown: &Shown, floor: f64, window: Option<Window>) -> Figure {
    drawn(id, shown, floor, window, POINTS)
}

fn drawn(id: &str, shown: &Shown, floor: f64, window: Option<Window>, points: usize) -> Figure {
    let [run, base] = &[&shown.model, &shown.base].map(|run| part(run, window));
    let unit = run.quantity.unit();
    let (left, base_left) = (residual(run), residual(base));
    let (from, to) = places_within(&run.time_s, window);
    let kept = keep(&[&run.measured, &run.simulated, &left, &run.voltage_v], from, to, points);
    let curve = |role, name: &str, column: &[f64]| Curve::line(role, name, 0, pick(column, &kept, 6));
    let mut columns = vec![pick(&run.time_s, &kept, 7)];
    let of_angle = run.quantity == Quantity::Angle;
    let panel = |title: String, height, curves| Panel { y: Axis::titled(title), height, curves, floor: None };
    let mut panels = vec![panel(
        format!("{} ({unit})", if of_angle { "Angle" } else { "Speed" }),
        if of_angle { 230 } else { 280 },
        vec![
            curve("measured", "measured", &run.measured),
            curve("base", &shown.against, &base.simulated),
            slid("run", curve("model", "model", &run.simulated)),
        ],
    )];
    if of_angle {
        let [measured, simulated] = [speed(run, &run.measured), speed(run, &run.simulated)];
        let kept = keep(&[&measured, &simulated], from, to, points);
        let base = speed(base, &base.simulated);
        columns.push(pick(&run.time_s, &kept, 7));
        let curve = |role, name: &str, column: &[f64]| Curve::line(role, name, 1, pick(column, &kept, 5));
        panels.push(panel(
            "Speed (rad/s)".into(),
            170,
            vec![
                curve("measured", "measured", &measured),
                curve("base", &shown.against, &base),
                slid("speed", curve("model", "model", &simulated)),
            ],
        ));
    }
    let residuals =
        vec![curve("base", &shown.against, &base_left), slid("left", curve("model", "model", &left))];
    let measures = shown.model.measures();
    let told = Yardstick::new(floor, &measures, unit);
    let [error, beside] = [measures.rmse, shown.base.measures().rmse].map(|rmse| told.words(rmse));
    let noise = Some([-2.0 * floor, 2.0 * floor]);
    panels.push(Panel { floor: noise, ..panel(format!("Residual ({unit})"), 170, residuals) });
    let volts = Curve { draw: Draw::Steps, ..curve("voltage", "voltage", &run.voltage_v) };
    panels.push(panel("Voltage (V)".into(), 130, vec![volts]));
    Figure {
        share_percent: None,
        first: first_part(&shown.model),
        id: id.into(),
        title: format!("{} ({})", run.record, if shown.unseen { "validation" } else { "fit" }),
        reading: format!(
            "{}: the error is {error} with the model and {} ({}); {}{}.",
            if shown.unseen { "Validation record" } else { "Record fitted" },
            if beside == error {
                "with the one beside it".to_owned()
            } else {
                format!("{beside} with the one beside it")
            },
            shown.against,
            told.noise_in_words(),
            run.quantity
                .speed_in_words()
                .map(|reading| format!("; each speed is {reading}"))
                .unwrap_or_default(),
        ),
        x: Axis { range: window.map(|(low, high)| [low, high]), ..Axis::titled("Time (s)") },
        columns,
        panels,
    }
}

/// The curves that a slider moves: what they are called, and their new points.
pub fn moved(run: &FreeRun, window: Option<Window>) -> Vec<(&'static str, [Numbers; 2])> {
    let run = &part(run, window);
    let left = residual(run);
    let (from, to) = places_within(&run.time_s, window);
    let kept = keep(&[&run.simulated, &left], from, to, POINTS / 2);
    let curve = |name, column: &[f64]| (name, [pick(&run.time_s, &kept, 7), pick(column, &kept, 6)]);
    let mut all = vec![curve("run", &run.simulated), curve("left", &left)];
    if run.quantity == Quantity::Angle {
        all.push(curve("speed", &speed(run, &run.simulated)));
    }
    all
}

/// What `window` shows of a run, with enough on either side for the speeds at its ends.
fn part(run: &FreeRun, window: Option<Window>) -> FreeRun {
    let Some((low, high)) = window else { return run.clone() };
    let (from, to) = places_within(&run.time_s, Some((low - HALF_SPAN_S, high + HALF_SPAN_S)));
    let cut = |column: &[f64]| column[from..to].to_vec();
    FreeRun {
        record: run.record.clone(),
        time_s: cut(&run.time_s),
        measured: cut(&run.measured),
        simulated: cut(&run.simulated),
        voltage_v: cut(&run.voltage_v),
        quantity: run.quantity,
        first_speed_rad_s: run.first_speed_rad_s,
    }
}

fn pick(column: &[f64], kept: &[usize], digits: i32) -> Numbers {
    Numbers::new(kept.iter().map(|k| column[*k]), digits)
}

/// Names a curve for the sliders of the live page, which replace its points.
fn slid(name: &'static str, curve: Curve) -> Curve {
    Curve { slide: Some(name), ..curve }
}

fn residual(run: &FreeRun) -> Vec<f64> {
    run.measured.iter().zip(&run.simulated).map(|(y, p)| y - p).collect()
}

/// Mean speed over 50 ms around each sample of an angle.
fn speed(run: &FreeRun, angle: &[f64]) -> Vec<f64> {
    let interval = median_interval(&run.time_s).max(1e-9);
    let beside = ((HALF_SPAN_S / interval).round() as usize).max(1);
    let last = angle.len().saturating_sub(1);
    let at = |k: usize| {
        let (a, b) = (k.saturating_sub(beside), (k + beside).min(last));
        (angle[b] - angle[a]) / (run.time_s[b] - run.time_s[a])
    };
    (0..angle.len()).map(at).collect()
}

/// Places of the samples within `window`, and one beside each end.
fn places_within(time_s: &[f64], window: Option<Window>) -> (usize, usize) {
    let Some((low, high)) = window else { return (0, time_s.len()) };
    let from = time_s.partition_point(|t| *t < low).saturating_sub(1);
    let to = (time_s.partition_point(|t| *t <= high) + 1).min(time_s.len());
    (from.min(to), to)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turning() -> Shown {
        let time_s: Vec<f64> = (0..100_000).map(|k| f64::from(k) * 1e-3).collect();
        let run = FreeRun {
            record: "r".into(),
            measured: time_s.iter().map(|t| 3.0 * t).collect(),
            simulated: time_s.iter().map(|t| 2.9 * t).collect(),
            voltage_v: vec![1.0; time_s.len()],
            time_s,
            quantity: Quantity::Angle,
            first_speed_rad_s: 0.0,
        };
        Shown { unseen: false, against: "base model".into(), base: run.clone(), model: run }
    }

    #[test]
    fn a_window_is_drawn_with_its_own_samples() {
        let shown = turning();
        let whole = serde_json::to_value(figure("r", &shown, 1e-3, None)).unwrap();
        let part = serde_json::to_value(figure("r", &shown, 1e-3, Some((40.0, 40.5)))).unwrap();
        let times = |f: &serde_json::Value| f["columns"][0].as_array().unwrap().clone();
        assert!(times(&whole).len() <= POINTS + 2);
        assert!(times(&part).len() >= 500 && times(&part)[1] == 40.0, "{:?}", times(&part)[1]);
        assert_eq!(part["x"]["range"], serde_json::json!([40.0, 40.5]));
    }

    #[test]
    fn how_speeds_are_read_is_told_of_all_of_a_record_and_of_a_window_of_it() {
        let mut shown = turning();
        (shown.model.quantity, shown.base.quantity) =
            (Quantity::WindowSpeed(0.1), Quantity::WindowSpeed(0.1));
        for window in [None, Some((40.0, 40.5))] {
            let reading = figure("r", &shown, 1e-3, window).reading;
            assert!(reading.contains("each speed is the mean over the last 100 ms"), "{reading}");
        }
    }

    #[test]
    fn a_dense_record_has_more_points_and_never_more_than_the_most() {
        let mut shown = turning();
        let points = |shown: &Shown| whole("r", shown, 1e-3).columns[0].values().len();
        let still = points(&shown);
        assert!(still <= POINTS + 2, "a voltage that never turns: {still}");
        assert_eq!(whole("r", &shown, 1e-3).first, None);
        let square =
            |every: usize| (0..100_000).map(|k| if (k / every) & 1 == 0 { 5.0 } else { -5.0 }).collect();
        for (every, count, more) in [(500, 199, 4), (20, 4999, 8)] {
            shown.model.voltage_v = square(every);
            assert_eq!(turns(&shown.model.voltage_v).len(), count);
            // The first turn is at the sample `every`.
            let until = shown.model.time_s[(FIRST + 1) * every];
            assert_eq!(whole("r", &shown, 1e-3).first, Some([shown.model.time_s[0], until]));
            assert!(
                (more * still..=MOST_POINTS + 2).contains(&points(&shown)),
                "{} of {still}",
                points(&shown)
            );
        }
    }

    #[test]
    fn a_window_beside_the_record_is_empty_and_one_at_its_edge_is_not() {
        let shown = turning();
        let points = |window| {
            let figure = serde_json::to_value(figure("r", &shown, 1e-3, Some(window))).unwrap();
            figure["columns"][0].as_array().unwrap().len()
        };
        assert!(points((200.0, 300.0)) <= 2 && points((-9.0, -8.0)) <= 2);
        assert!(points((99.9, 120.0)) >= 100);
    }

    #[test]
    fn speeds_are_those_of_the_angles_to_the_ends() {
        let shown = turning();
        let speed = speed(&shown.model, &shown.model.simulated);
        assert!(speed.iter().all(|w| (w - 2.9).abs() < 1e-6));
        let names: Vec<_> = moved(&shown.model, None).into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["run", "left", "speed"]);
    }
}
