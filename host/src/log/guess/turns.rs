//! Counts of one turn of an encoder, as the speed beside them tells: those of a usual encoder where the figure cannot tell them apart.

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

#[cfg(test)]
mod tests {
    use super::*;

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
