//! The loop compiled for each small set of effects, and the choice among them.
//!
//! With the set known to the compiler a step has no branches and the motion stays in registers: 3 to 4 times
//! faster than a loop that asks each effect for its kind. Sets of three and more take that loop.

#![allow(unsafe_code, reason = "compiled for vector units that are asked for before they are used")]

use core::marker::PhantomData;

use motorlens_shared::base::Base;
use motorlens_shared::effects::together::{Effects, Nothing, Several, With};
use motorlens_shared::effects::{Named, Rig, Visit};
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
    let work = Work { prepared, effects, course, sink };
    match effects {
        [] => work.run(|_| Nothing),
        [(kind, _)] => kind.with(work),
        [(kind, _), _] => kind.with(First(work)),
        _ => work.run_several(),
    }
}

#[target_feature(enable = "avx2,fma")]
fn prepare(base: &Base<Wide>, effects: &[Chosen<Wide>], rig: &Rig) -> Prepared<Wide> {
    Prepared::new(base, effects, rig)
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
    course: &'a Course<'a, Wide>,
    sink: &'a mut dyn Sink<Block>,
}

impl Work<'_> {
    fn run<E: Effects<Wide>>(self, effects: impl FnOnce(&Self) -> E) {
        let effects = effects(&self);
        // SAFETY: see run_wide.
        unsafe { run_set(&Simulator::with(self.prepared, effects), self.course, self.sink) };
    }
}

impl Work<'_> {
    fn run_several(self) {
        self.run(|work| Several::new(work.effects, &work.prepared.setting));
    }
}

impl Visit<Wide> for Work<'_> {
    type Output = ();
    fn formula(self) {
        self.run_several();
    }
    fn visit<A: Named<Wide>>(self) {
        self.run(|work| With(A::named(work.effects[0].1, &work.prepared.setting), Nothing));
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
        let second = self.0.effects[1].0;
        second.with(Second::<A>(self.0, PhantomData));
    }
}

impl<A: Named<Wide>> Visit<Wide> for Second<'_, A> {
    type Output = ();
    fn formula(self) {
        self.0.run_several();
    }
    fn visit<B: Named<Wide>>(self) {
        // Half of all pairs need not be compiled.
        if const { A::INDEX < B::INDEX } {
            self.0.run(|work| {
                let setting = &work.prepared.setting;
                let second = With(B::named(work.effects[1].1, setting), Nothing);
                With(A::named(work.effects[0].1, setting), second)
            });
        } else {
            unreachable!("effects out of the registry's order");
        }
    }
}
