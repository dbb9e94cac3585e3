//! Marks: what share of the answers is right.

use serde::Serialize;

use super::question::Group;
use super::trial::Answer;
use crate::findings::Verdict;

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Part {
    /// Of those ...
    pub of: usize,
    /// ... so many.
    pub number: usize,
}

impl Part {
    fn of<'a>(answers: impl Iterator<Item = &'a Answer>, is: impl Fn(&Answer) -> bool) -> Self {
        let mut part = Self::default();
        for answer in answers {
            part.of += 1;
            part.number += usize::from(is(answer));
        }
        part
    }

    /// In percent; none of nothing.
    pub fn percent(self) -> Option<f64> {
        (self.of > 0).then(|| 100.0 * self.number as f64 / self.of as f64)
    }
}

/// Marks of an examination.
#[derive(Debug, Clone, Serialize)]
pub struct Marks {
    /// Single effects without a torque disturbance: the right one first.
    pub first: Part,
    /// ... of those whose plain motor leaves more than noise.
    pub shown_first: Part,
    /// ... of those that the data tell.
    pub told_first: Part,
    /// ... among the first two.
    pub first_two: Part,
    /// ... exactly the right one accepted.
    pub exact: Part,
    /// Single effects under a disturbance: the right one first.
    pub disturbed_first: Part,
    /// ... exactly the right one accepted.
    pub disturbed_exact: Part,
    /// Nothing missing, yet something accepted.
    pub false_alarms: Part,
    /// Of the answers that claim to explain a motor by effects and name no rivals: every one of them is hidden there.
    pub claims_right: Part,
    /// ... where the library has what is hidden.
    pub claims_right_inside: Part,
    /// ... or the data do not tell what is hidden.
    pub claims_tenable: Part,
    /// Of those that name rivals which the data cannot exclude: the effects, or one of the rivals, are hidden there.
    pub open_claims_right: Part,
    /// Two effects without a torque disturbance: both and no other accepted.
    pub pairs: Part,
    /// ... of those that the data tell.
    pub told_pairs: Part,
    /// ... and under a disturbance.
    pub disturbed_pairs: Part,
    /// Physics outside the library: explained all the same, by effects that are not there.
    pub outside_explained: Part,
    /// ... although the data tell.
    pub outside_explained_told: Part,
    /// Such an effect accepted, in part.
    pub outside_partial: Part,
    /// ... or nothing found missing.
    pub outside_unseen: Part,
    /// Error on unseen records over the floor, after: median of the single effects that were found ...
    pub median_over_floor: f64,
    /// ... and its third quartile.
    pub third_quartile_over_floor: f64,
    /// Median time of one diagnosis: until the first effect was in the model, or there was none, s.
    pub median_first_seconds: f64,
    /// Median time of the whole loop, s.
    pub median_seconds: f64,
}

impl Marks {
    /// Marks `answers`.
    pub fn new(answers: &[Answer]) -> Self {
        let all = |group: Group| answers.iter().filter(move |a| a.group == group);
        let calm = |group| all(group).filter(|a| a.disturbance == 0.0);
        let disturbed = |group| all(group).filter(|a| a.disturbance > 0.0);
        let explained = |a: &Answer| a.verdict == Verdict::Explained;
        let claims = || answers.iter().filter(|a| explained(a) && !a.found.is_empty());
        let firm = || claims().filter(|a| a.rivals.is_empty());
        let after = sorted(all(Group::Single).filter(|a| a.exact()).map(|a| a.after));
        let seconds = sorted(answers.iter().map(|a| a.seconds));
        let first_seconds = sorted(answers.iter().map(|a| a.first_seconds));
        Self {
            first: Part::of(calm(Group::Single), |a| a.among_first(1)),
            shown_first: Part::of(calm(Group::Single).filter(|a| a.shows()), |a| a.among_first(1)),
            told_first: Part::of(calm(Group::Single).filter(|a| a.told), |a| a.among_first(1)),
            first_two: Part::of(calm(Group::Single), |a| a.among_first(2)),
            exact: Part::of(calm(Group::Single), Answer::exact),
            disturbed_first: Part::of(disturbed(Group::Single), |a| a.among_first(1)),
            disturbed_exact: Part::of(disturbed(Group::Single), Answer::exact),
            false_alarms: Part::of(all(Group::Nothing), |a| !a.found.is_empty()),
            claims_right: Part::of(firm(), |a| !a.names_a_stranger()),
            claims_right_inside: Part::of(firm().filter(|a| a.group != Group::Outside), |a| {
                !a.names_a_stranger()
            }),
            claims_tenable: Part::of(firm(), |a| !(a.names_a_stranger() && a.told)),
            open_claims_right: Part::of(claims().filter(|a| !a.rivals.is_empty()), |a| {
                !a.names_a_stranger() || a.names_the_truth_a_rival()
            }),
            pairs: Part::of(calm(Group::Pair), Answer::exact),
            told_pairs: Part::of(calm(Group::Pair).filter(|a| a.told), Answer::exact),
            disturbed_pairs: Part::of(disturbed(Group::Pair), Answer::exact),
            outside_explained: Part::of(all(Group::Outside), |a| explained(a) && a.names_a_stranger()),
            outside_explained_told: Part::of(all(Group::Outside), |a| {
                explained(a) && a.names_a_stranger() && a.told
            }),
            outside_partial: Part::of(all(Group::Outside), |a| !explained(a) && a.names_a_stranger()),
            outside_unseen: Part::of(all(Group::Outside), |a| explained(a) && a.found.is_empty()),
            median_over_floor: quantile(&after, 0.5),
            third_quartile_over_floor: quantile(&after, 0.75),
            median_first_seconds: quantile(&first_seconds, 0.5),
            median_seconds: quantile(&seconds, 0.5),
        }
    }
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The value that a share of the sorted `values` is below; NaN without any.
fn quantile(values: &[f64], share: f64) -> f64 {
    let k = (share * values.len() as f64) as usize;
    values.get(k.min(values.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
}
