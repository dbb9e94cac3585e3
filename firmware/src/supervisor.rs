//! What ends a run before its programme does. A silent link, a current over its limit and the longest run are looked at in every interrupt of
//! the sampling timer, which come at least every millisecond ([`crate::beat`]), so that the bridge is off within 2 ms at every rate; what has
//! to stay for some time anyway, a stall and a supply that sinks, at the sampling instants.

use motorlens_shared::link::{Cause, Setup};

/// The bridge is off so long after the current has risen over its limit, us.
const OFF_US: u32 = 2000;
/// What the means over the current limit must come to in a row for a run to end.
const OVER_CURRENT: u8 = 2;
/// Consecutive samples with a supply out of its bounds that end a run.
const BAD_SUPPLY_SAMPLES: u8 = 3;
/// Counts within which the motor stands: an encoder may flicker at an edge.
const STANDING_COUNTS: u32 = 2;

/// What the supervisor looks at, at each interrupt.
#[derive(Debug, Clone, Copy)]
pub struct Watch {
    /// Since the run began, us.
    pub elapsed_us: u32,
    /// Since the host was last heard, us.
    pub silence_us: u32,
    /// The mean since the last interrupt, mA, where one was measured.
    pub current_ma: Option<i16>,
}

/// What the supervisor looks at, at each sampling instant.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// Since the run began, us.
    pub elapsed_us: u32,
    /// Since the run began.
    pub count: i32,
    /// Applied up to this instant, mV.
    pub voltage_mv: i32,
    /// Whether the supply, where it is measured, is within its bounds.
    pub supply_good: bool,
}

/// The state of supervising one run.
#[derive(Debug, Clone, Copy)]
pub struct Supervisor {
    over_current: u8,
    /// What one mean over the current limit comes to.
    weight: u8,
    bad_supply: u8,
    stall_count: i32,
    stall_since_us: u32,
}

impl Supervisor {
    /// Begins to supervise a run, with interrupts `apart_us` apart.
    pub fn new(apart_us: u32) -> Self {
        // A current may rise right after an interrupt, too late for the mean up to the next one to be over the limit. Where there is time for
        // two whole means after that, one alone may be noise of the switching.
        let weight = if 3 * apart_us < OFF_US { 1 } else { OVER_CURRENT };
        Self { over_current: 0, weight, bad_supply: 0, stall_count: 0, stall_since_us: 0 }
    }

    /// Whether the run must end at this interrupt, and why. The gravest cause is named when there are several.
    pub fn watch(&mut self, setup: &Setup, watch: &Watch) -> Option<Cause> {
        if self.over_current(setup, watch.current_ma) {
            return Some(Cause::OverCurrent);
        }
        if watch.silence_us >= u32::from(setup.link_timeout_ms) * 1000 {
            return Some(Cause::LinkLoss);
        }
        (watch.elapsed_us / 1000 >= setup.run_limit_ms).then_some(Cause::RunLimit)
    }

    /// Whether the run must end at this sampling instant, and why.
    pub fn check(&mut self, setup: &Setup, look: &Look) -> Option<Cause> {
        self.bad_supply = if look.supply_good { 0 } else { self.bad_supply.saturating_add(1) };
        if self.bad_supply >= BAD_SUPPLY_SAMPLES {
            return Some(Cause::Supply);
        }
        self.stalled(setup, look).then_some(Cause::Stall)
    }

    fn over_current(&mut self, setup: &Setup, current_ma: Option<i16>) -> bool {
        let more = match current_ma {
            // A limit is one of a current that is measured: a converter that gives nothing twice in a row does not see it.
            None => 1,
            Some(current) if current.unsigned_abs() > setup.current_limit_ma => self.weight,
            Some(_) => 0,
        };
        let over = setup.current_limit_ma > 0 && more > 0;
        self.over_current = if over { self.over_current.saturating_add(more) } else { 0 };
        self.over_current >= OVER_CURRENT
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
    use crate::beat::split;

    const MOVING: Look = Look { elapsed_us: 0, count: 0, voltage_mv: 6000, supply_good: true };
    const QUIET: Watch = Watch { elapsed_us: 0, silence_us: 0, current_ma: None };

    /// The cause and the millisecond at which a run made of these looks ends.
    fn ends(setup: Setup, look: impl Fn(u32) -> Look) -> Option<(Cause, u32)> {
        let mut supervisor = Supervisor::new(1000);
        (0..10_000).find_map(|ms| {
            let look = Look { elapsed_us: ms * 1000, ..look(ms) };
            supervisor.check(&setup, &look).map(|cause| (cause, ms))
        })
    }

    /// The cause and the time, us, at which a run ends of which these are seen in interrupts `apart` us apart.
    fn ends_at(setup: Setup, apart: u32, watch: impl Fn(u32) -> Watch) -> Option<(Cause, u32)> {
        let mut supervisor = Supervisor::new(apart);
        (0..10_000_000).step_by(apart as usize).find_map(|now| {
            let watch = Watch { elapsed_us: now, ..watch(now) };
            supervisor.watch(&setup, &watch).map(|cause| (cause, now))
        })
    }

    /// The times between two interrupts that the rates of the link have, us.
    fn aparts() -> impl Iterator<Item = u32> {
        let rates = (100..=2000).filter(|rate| 1_000_000_u32.is_multiple_of(*rate));
        rates.map(|rate| split(1_000_000 / rate).1)
    }

    #[test]
    fn a_healthy_run_goes_on() {
        assert_eq!(ends(Setup::default(), |ms| Look { count: ms as i32, ..MOVING }), None);
        assert_eq!(ends_at(Setup::default(), 1000, |_| QUIET), None);
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
    fn current_ends_the_run_within_two_milliseconds_at_every_rate() {
        let setup = Setup { current_limit_ma: 2000, ..Setup::default() };
        for apart in aparts() {
            let mean = |ma: i16| Watch { current_ma: Some(ma), ..QUIET };
            for into in (0..apart).step_by(50) {
                let rises = 100 * apart + into;
                let current = |now: u32| {
                    // A mean of what was before and what is from then on.
                    let over = now.saturating_sub(rises).min(apart);
                    mean(-(1000 + 1001 * over as i32 / apart as i32) as i16)
                };
                let (cause, at) = ends_at(setup, apart, current).unwrap();
                assert_eq!(cause, Cause::OverCurrent);
                assert!((1..=OFF_US).contains(&(at - rises)), "{apart} us: after {} us", at - rises);
            }
            // The limit itself is none too much, and without one there is none.
            assert_eq!(ends_at(setup, apart, |_| mean(-2000)), None);
            assert_eq!(ends_at(Setup::default(), apart, |_| mean(i16::MIN)), None);
        }
    }

    #[test]
    fn where_there_is_time_for_two_means_a_single_one_over_the_limit_is_noise() {
        let setup = Setup { current_limit_ma: 2000, ..Setup::default() };
        for (apart, goes_on) in [(500, true), (625, true), (800, false), (1000, false)] {
            let spikes = |now: u32| {
                let current = if (now / apart).is_multiple_of(2) { 100 } else { 2500 };
                Watch { current_ma: Some(current), ..QUIET }
            };
            assert_eq!(ends_at(setup, apart, spikes).is_none(), goes_on, "{apart} us");
        }
    }

    #[test]
    fn a_limit_whose_current_is_not_measured_twice_in_a_row_ends_the_run() {
        let setup = Setup { current_limit_ma: 2000, ..Setup::default() };
        for apart in aparts() {
            let seen = |at: u32, goes: bool| Watch {
                current_ma: (at < 20 || at > 20 && goes).then_some(100),
                ..QUIET
            };
            assert_eq!(ends_at(setup, apart, |now| seen(now / apart, true)), None);
            let end = Some((Cause::OverCurrent, 21 * apart));
            assert_eq!(ends_at(setup, apart, |now| seen(now / apart, false)), end);
        }
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
        let silent = |now: u32| Watch { silence_us: now.saturating_sub(200_000), ..QUIET };
        assert_eq!(ends_at(Setup::default(), 1000, silent), Some((Cause::LinkLoss, 700_000)));
        let short = Setup { run_limit_ms: 300, ..Setup::default() };
        assert_eq!(ends_at(short, 1000, |_| QUIET), Some((Cause::RunLimit, 300_000)));
    }
}
