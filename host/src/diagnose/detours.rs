//! Ways up that the climb takes where the usual step, the next effect on the accepted model, does not lead on.

use motorlens_shared::effects::Kind;

use super::candidate::Candidate;
use super::evidence::Evidence;
use super::stage::Effort;
use super::step::{TO_THE_END, look, settled};
use super::way::{FAR, falls_short, is_far};
use super::worth::{EQUAL, simplest, worth};

/// Two effects are tried at once beside so many of the first ...
const LEAPS: usize = 2;
/// ... and, where nothing else leads on, beside so many.
const BESIDE: usize = 5;

/// Two effects at once, where neither helps on unseen records while the other is missing, but both lead to the floor.
pub(super) fn leap(
    evidence: &Evidence,
    base: &Candidate,
    first: &[Candidate],
    library: &[Kind],
    tick: &mut dyn FnMut(Kind),
) -> Option<Candidate> {
    if base.excess() < FAR {
        return None;
    }
    let beside = |first: &Candidate| look(evidence, first, library, Effort::LATER, tick);
    let mut pairs: Vec<Candidate> = first.iter().take(LEAPS).flat_map(beside).collect();
    pairs.retain(|pair| worth(pair, base) && !is_far(pair, base));
    simplest(&pairs).cloned()
}

/// Two effects that leave no more than noise, where the usual work found no way on from `model`: beside the best of those that led at
/// `first`, or beside more of them where `model` is still far off, with more starts and steps beside the best.
pub(super) fn deeper(
    evidence: &mut Evidence,
    base: &Candidate,
    model: &Candidate,
    first: &[Candidate],
    library: &[Kind],
    tick: &mut dyn FnMut(Kind),
) -> Option<Candidate> {
    let beside = if is_far(model, base) { BESIDE } else { 1 };
    for (place, first) in first.iter().take(beside).enumerate() {
        let effort = if place == 0 { Effort::DEEP } else { Effort::LATER };
        let mut pairs = look(evidence, first, library, effort, tick);
        pairs.retain(|pair| worth(pair, base) && !is_far(pair, base));
        let pair = simplest(&pairs).cloned().map(|pair| settled(evidence, pair, library));
        // What pulses whose times are not yet known leave drifts.
        let promises = |pair: &Candidate| pair.kinds().contains(&Kind::Coast) && !falls_short(pair, base);
        if let Some(pair) = pair.filter(|pair| pair.explains() || promises(pair)) {
            return Some(pair);
        }
    }
    None
}

/// What is better than the first of `model`'s two effects beside the second: the first was chosen alone, and may have stood
/// for something of both.
pub(super) fn swapped(
    evidence: &Evidence,
    model: &Candidate,
    library: &[Kind],
    tick: &mut dyn FnMut(Kind),
) -> Option<Candidate> {
    let [first, _] = model.kinds() else { return None };
    if model.explains() {
        return None;
    }
    let second = evidence.fit(&model.values().without(*first), TO_THE_END);
    let mut found = look(evidence, &second, library, Effort::LATER, tick);
    let better =
        |c: &Candidate| c.merit() < model.merit() - EQUAL && (c.size() <= model.size() || worth(c, model));
    found.retain(|c| worth(c, &second) && better(c) && c.foretold >= model.foretold);
    simplest(&found).cloned()
}
