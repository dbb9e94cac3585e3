//! The loop compiled for each small set of effects, and the choice among them.
//!
//! With the set known to the compiler a step has no branches and the motion stays in registers: 3 to 4 times
//! faster than a loop that asks each effect for its kind. Sets of three and more take that loop; what most motors and logs have (a delay,
//! dry friction, a filter) does not count, it is there or not while the program runs ([`Between`]).

#![allow(unsafe_code, reason = "compiled for vector units that are asked for before they are used")]

use core::marker::PhantomData;

use motorlens_shared::base::Base;
use motorlens_shared::effects::between::{Between, is_common};
use motorlens_shared::effects::together::{Effects, Nothing, Several, With};
use motorlens_shared::effects::{Kind, Named, Rig, Setting, Visit};
use motorlens_shared::simulator::{Chosen, Prepared, Simulator};

use crate::{Block, Course, Sink, Wide, has_wide, run};

/// [`run`] with AVX2 and fused multiply-add, by the loop made for these effects where there is one.
///
/// # Panics
/// Where the processor has them not ([`has_wide`]), or `effects` are not in the registry's order.
pub fn run_wide(
    base: &Base<Wide>,
    effects: &[Chosen<Wide>],
    rig: &Rig,
    course: &Course<Wide>,
    sink: &mut dyn Sink<Block>,
) {
    assert!(has_wide(), "this processor lacks AVX2 or fused multiply-add");
    // SAFETY: it has them, and everything that is unsafe below is reached from here only.
    let prepared = unsafe { prepare(base, effects, rig) };
    let (common, between) = common_apart(effects);
    let work = Work { prepared, effects, common: &common, between: &between, course, sink };
    match between.as_slice() {
        _ if common.len() + between.len() < effects.len() => work.run_several(),
        [] => work.run(|_| Nothing),
        [(kind, _)] => kind.with(work),
        [(kind, _), _] => kind.with(First(work)),
        _ => work.run_many(),
    }
}

/// Some effects with their parameters.
type Set<'a> = Vec<Chosen<'a, Wide>>;

/// Of `effects` those that are common, and the others. Some are in neither where the order of the registry would be lost: of two frictions, and
/// where a formula reads what a filter has left.
fn common_apart<'a>(effects: &[Chosen<'a, Wide>]) -> (Set<'a>, Set<'a>) {
    let (mut common, mut between) = (Set::new(), Set::new());
    for (k, chosen) in effects.iter().enumerate() {
        let (kind, _) = chosen;
        let of_a_port = |other: &Chosen<Wide>| is_common(other.0) && other.0.spec().port == kind.spec().port;
        let is_second = common.iter().any(of_a_port);
        let is_read = *kind == Kind::SensorLag && k + 1 < effects.len();
        if !is_common(*kind) {
            between.push(*chosen);
        } else if !is_second && !is_read {
            common.push(*chosen);
        }
    }
    (common, between)
}

#[target_feature(enable = "avx2,fma")]
fn prepare(base: &Base<Wide>, effects: &[Chosen<Wide>], rig: &Rig) -> Prepared<Wide> {
    Prepared::new(base, effects, rig)
}

#[target_feature(enable = "avx2,fma")]
fn with_common<E: Effects<Wide>>(
    common: &[Chosen<Wide>],
    between: E,
    setting: &Setting<Wide>,
) -> Between<Wide, E> {
    Between::new(common, between, setting)
}

#[target_feature(enable = "avx2,fma")]
fn run_set<E: Effects<Wide>>(
    simulator: &Simulator<Wide, E>,
    course: &Course<Wide>,
    sink: &mut dyn Sink<Block>,
) {
    run(simulator, course, sink);
}

/// What is to be run, while its set of effects becomes known.
struct Work<'a> {
    prepared: Prepared<Wide>,
    effects: &'a [Chosen<'a, Wide>],
    /// Those that are common, and the others.
    common: &'a [Chosen<'a, Wide>],
    between: &'a [Chosen<'a, Wide>],
    course: &'a Course<'a, Wide>,
    sink: &'a mut dyn Sink<Block>,
}

impl Work<'_> {
    fn run<E: Effects<Wide>>(self, between: impl FnOnce(&Self) -> E) {
        let between = between(&self);
        // SAFETY: see run_wide.
        let effects = unsafe { with_common(self.common, between, &self.prepared.setting) };
        self.run_all(effects);
    }

    /// Any set, as far as what is common can be taken apart from it.
    fn run_many(self) {
        self.run(|work| Several::new(work.between, &work.prepared.setting));
    }

    fn run_several(self) {
        let effects = Several::new(self.effects, &self.prepared.setting);
        self.run_all(effects);
    }

    fn run_all<E: Effects<Wide>>(self, effects: E) {
        // SAFETY: see run_wide.
        unsafe { run_set(&Simulator::with(self.prepared, effects), self.course, self.sink) };
    }
}

impl Visit<Wide> for Work<'_> {
    type Output = ();
    fn formula(self) {
        self.run_several();
    }
    fn visit<A: Named<Wide>>(self) {
        if const { is_common(Kind::ALL[A::INDEX]) } {
            unreachable!("taken apart from the others");
        } else {
            self.run(|work| With(A::named(work.between[0].1, &work.prepared.setting), Nothing));
        }
    }
}

/// The first of two effects is still to be named.
struct First<'a>(Work<'a>);
/// The first is known.
struct Second<'a, A>(Work<'a>, PhantomData<A>);

impl Visit<Wide> for First<'_> {
    type Output = ();
    fn formula(self) {
        self.0.run_several();
    }
    fn visit<A: Named<Wide>>(self) {
        if const { is_common(Kind::ALL[A::INDEX]) } {
            unreachable!("taken apart from the others");
        } else {
            let second = self.0.between[1].0;
            second.with(Second::<A>(self.0, PhantomData));
        }
    }
}

impl<A: Named<Wide>> Visit<Wide> for Second<'_, A> {
    type Output = ();
    fn formula(self) {
        self.0.run_several();
    }
    fn visit<B: Named<Wide>>(self) {
        // Half of all pairs need not be compiled.
        if const { A::INDEX < B::INDEX && !is_common(Kind::ALL[B::INDEX]) } {
            self.0.run(|work| {
                let setting = &work.prepared.setting;
                let second = With(B::named(work.between[1].1, setting), Nothing);
                With(A::named(work.between[0].1, setting), second)
            });
        } else {
            unreachable!("effects out of the registry's order");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motorlens_shared::lanes::Lanes;
    use motorlens_shared::step::State;

    use crate::{LANES, Reading};

    const RIG: Rig = Rig {
        step_s: 2e-3,
        gear_ratio: 50.0,
        encoder_on_motor: true,
        nominal_v: 12.0,
        supply_v: 12.0,
        reference_speed: 9.6,
        count_rad: 0.002,
    };

    impl Sink<Block> for Vec<Reading<Block>> {
        fn begin(&mut self, reading: Reading<Block>) {
            self.push(reading);
        }
        fn take(&mut self, _first: usize, readings: &[Reading<Block>]) {
            self.extend_from_slice(readings);
        }
    }

    fn wide(value: impl Fn(usize) -> f64) -> Wide {
        Wide::from_block(&Lanes(std::array::from_fn(value)))
    }

    /// Readings of a model with `kinds` by the loop made for them, and by the one that asks each effect for its kind.
    fn both(kinds: &[Kind]) -> [Vec<Reading<Block>>; 2] {
        let base = Base {
            gain: wide(|_| 0.9),
            tau_m: wide(|lane| 0.04 + 0.01 * lane as f64),
            tau_e: wide(|_| 6e-4),
            viscous_share: wide(|_| 0.1),
        };
        let sizes = |kind: &Kind| -> Vec<Wide> {
            let spread = |x: f64| wide(move |lane| x * (1.0 + 0.1 * lane as f64 / LANES as f64));
            kind.spec().typical(&RIG).map(spread).collect()
        };
        let parameters: Vec<_> = kinds.iter().map(sizes).collect();
        let effects: Vec<Chosen<Wide>> =
            kinds.iter().copied().zip(parameters.iter().map(Vec::as_slice)).collect();
        let voltages: Vec<f64> = (0..200).map(|k| if k / 40 % 2 == 0 { 7.0 } else { -3.0 }).collect();
        let start = State { speed: wide(|_| 2.0), load_speed: wide(|_| 2.0), ..State::rest() };
        let course = Course {
            start,
            voltages: &voltages,
            cells: 190,
            reading_age_s: 0.0,
            encoder_on_motor: true,
            guide: &[],
            seen: &[],
            count: 0.0,
        };
        let [mut made, mut asked] = [Vec::new(), Vec::new()];
        run_wide(&base, &effects, &RIG, &course, &mut made);
        // SAFETY: run_wide has asked for them.
        let prepared = unsafe { prepare(&base, &effects, &RIG) };
        let work = Work {
            prepared,
            effects: &effects,
            common: &[],
            between: &[],
            course: &course,
            sink: &mut asked,
        };
        work.run_several();
        [made, asked]
    }

    #[test]
    fn the_loop_made_for_a_set_gives_what_the_loop_for_any_set_gives_to_the_last_bit() {
        if !has_wide() {
            return;
        }
        let between: Vec<Kind> = Kind::ALL.iter().copied().filter(|kind| !is_common(*kind)).collect();
        let mut sets = vec![Vec::new()];
        for (k, one) in between.iter().enumerate() {
            sets.push(vec![*one]);
            let others =
                between[k + 1..].iter().filter(|other| !(one.is_transmission() && other.is_transmission()));
            sets.extend(others.map(|other| vec![*one, *other]));
        }
        let frictions = [None, Some(Kind::Coulomb), Some(Kind::CoulombAsymmetric)];
        for (set, friction) in sets.iter().flat_map(|set| frictions.map(|friction| (set, friction))) {
            for (delayed, filtered) in [(false, false), (true, false), (false, true), (true, true)] {
                let mut kinds = set.clone();
                kinds.extend(friction);
                kinds.extend(delayed.then_some(Kind::Delay));
                kinds.extend(filtered.then_some(Kind::SensorLag));
                kinds.sort_unstable();
                let [made, asked] = both(&kinds);
                assert_eq!(made, asked, "{kinds:?}");
            }
        }
    }

    #[test]
    fn what_would_lose_its_place_in_the_order_is_run_by_the_loop_for_any_set() {
        if has_wide() {
            let [made, asked] = both(&[Kind::Coulomb, Kind::CoulombAsymmetric, Kind::Gravity]);
            assert_eq!(made, asked);
        }
    }
}
