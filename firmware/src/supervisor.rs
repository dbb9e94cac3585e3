//! What ends a run before its programme does, at a sampling instant. The emergency contact and a supply that is pumped up do not wait for
//! one: [`crate::control::Control::between`].

use motorlens_shared::link::{Cause, Setup};

/// Consecutive samples over the current limit that end a run: a single one may be noise of the switching.
const OVER_CURRENT_SAMPLES: u8 = 3;
/// Consecutive samples with a supply out of its bounds that end a run.
const BAD_SUPPLY_SAMPLES: u8 = 3;
/// Counts within which the motor stands: an encoder may flicker at an edge.
const STANDING_COUNTS: u32 = 2;

/// What the supervisor looks at, at each sampling instant.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// Since the run began, us.
    pub elapsed_us: u32,
    /// Since the host was last heard, us.
    pub silence_us: u32,
    /// Since the run began.
    pub count: i32,
    /// Applied up to this instant, mV.
    pub voltage_mv: i32,
    /// Whether the supply, where it is measured, is within its bounds.
    pub supply_good: bool,
    /// mA, where measured.
    pub current_ma: Option<i16>,
}

/// The state of supervising one run.
#[derive(Debug, Clone, Copy, Default)]
pub struct Supervisor {
    over_current: u8,
    bad_supply: u8,
    stall_count: i32,
    stall_since_us: u32,
}

impl Supervisor {
    /// Whether the run must end here, and why. The gravest cause is named when there are several.
    pub fn check(&mut self, setup: &Setup, look: &Look) -> Option<Cause> {
        self.bad_supply = if look.supply_good { 0 } else { self.bad_supply.saturating_add(1) };
        if self.bad_supply >= BAD_SUPPLY_SAMPLES {
            return Some(Cause::Supply);
        }
        if self.over_current(setup, look) {
            return Some(Cause::OverCurrent);
        }
        if self.stalled(setup, look) {
            return Some(Cause::Stall);
        }
        if look.silence_us >= u32::from(setup.link_timeout_ms) * 1000 {
            return Some(Cause::LinkLoss);
        }
        (look.elapsed_us / 1000 >= setup.run_limit_ms).then_some(Cause::RunLimit)
    }

    fn over_current(&mut self, setup: &Setup, look: &Look) -> bool {
        let over = setup.current_limit_ma > 0
            && look.current_ma.is_some_and(|current| current.unsigned_abs() > setup.current_limit_ma);
        self.over_current = if over { self.over_current.saturating_add(1) } else { 0 };
        self.over_current >= OVER_CURRENT_SAMPLES
    }

    fn stalled(&mut self, setup: &Setup, look: &Look) -> bool {
        let driven = look.voltage_mv.unsigned_abs() >= setup.stall_mv.into();
        let stands = look.count.abs_diff(self.stall_count) <= STANDING_COUNTS;
        if setup.stall_ms == 0 || !driven || !stands {
            (self.stall_count, self.stall_since_us) = (look.count, look.elapsed_us);
        }
        look.elapsed_us - self.stall_since_us >= u32::from(setup.stall_ms) * 1000 && setup.stall_ms > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOVING: Look = Look {
        elapsed_us: 0,
        silence_us: 0,
        count: 0,
        voltage_mv: 6000,
        supply_good: true,
        current_ma: None,
    };

    /// The cause and the millisecond at which a run made of these looks ends.
    fn ends(setup: Setup, look: impl Fn(u32) -> Look) -> Option<(Cause, u32)> {
        let mut supervisor = Supervisor::default();
        (0..10_000).find_map(|ms| {
            let look = Look { elapsed_us: ms * 1000, ..look(ms) };
            supervisor.check(&setup, &look).map(|cause| (cause, ms))
        })
    }

    #[test]
    fn a_healthy_run_goes_on() {
        assert_eq!(ends(Setup::default(), |ms| Look { count: ms as i32, ..MOVING }), None);
    }

    #[test]
    fn voltage_without_motion_is_a_stall_after_its_time() {
        let stuck =
            |ms: u32| Look { count: if ms < 1000 { ms as i32 } else { 1000 + (ms % 2) as i32 }, ..MOVING };
        let (cause, ms) = ends(Setup::default(), stuck).unwrap();
        assert_eq!(cause, Cause::Stall);
        assert!((1490..1510).contains(&ms), "after {ms} ms");
        // Below the voltage that should move it, standing is no fault.
        assert_eq!(ends(Setup::default(), |ms| Look { voltage_mv: 3999, ..stuck(ms) }), None);
        assert_eq!(ends(Setup { stall_ms: 0, ..Setup::default() }, stuck), None);
    }

    #[test]
    fn current_ends_the_run_only_when_it_stays() {
        let setup = Setup { current_limit_ma: 2000, ..Setup::default() };
        let spike = |ms: u32| Look {
            current_ma: Some(if ms.is_multiple_of(3) { 100 } else { -2500 }),
            count: ms as i32,
            ..MOVING
        };
        assert_eq!(ends(setup, spike), None);
        let stays = |ms: u32| Look {
            current_ma: Some(if ms < 50 { 1999 } else { 2001 }),
            count: ms as i32,
            ..MOVING
        };
        assert_eq!(ends(setup, stays), Some((Cause::OverCurrent, 52)));
    }

    #[test]
    fn a_supply_out_of_bounds_ends_the_run_only_when_it_stays() {
        let setup = Setup::default();
        let look = |ms: u32, good: bool| Look { count: ms as i32, supply_good: good, ..MOVING };
        assert_eq!(ends(setup, |ms| look(ms, ms % 4 > 1)), None);
        assert_eq!(ends(setup, |ms| look(ms, ms < 30)), Some((Cause::Supply, 32)));
    }

    #[test]
    fn silence_and_time_end_the_run() {
        let moving = |ms: u32| Look { count: ms as i32, ..MOVING };
        let silent = |ms: u32| Look { silence_us: ms.saturating_sub(200) * 1000, ..moving(ms) };
        assert_eq!(ends(Setup::default(), silent), Some((Cause::LinkLoss, 700)));
        let short = Setup { run_limit_ms: 300, ..Setup::default() };
        assert_eq!(ends(short, moving), Some((Cause::RunLimit, 300)));
    }
}
