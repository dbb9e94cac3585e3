//! How much better one model is than another on blocks that neither was fitted to, and how sure that is.
//!
//! Two models are scored under one noise, as the better of them leaves it: what both leave alike is noise as far as the records tell, however
//! much of it comes from a disturbance that lasts, and what only the worse one leaves is misfit (as the dispersion of a quasi-likelihood is
//! that of the richest model: D. Anderson, K. Burnham and G. White, *Ecology* 75, 1994). The paired differences of the blocks,
//! whose scatter, with its autocorrelation, say how sure the gain is.

/// One block speaks for at most so much more than the middle one, natural logarithms or standard deviations, when it is asked how sure a
/// gain is: a few blocks in which a wrong equation goes astray are no proof, and must not hide what all others say.
const MOST_OF_A_BLOCK: (f64, f64) = (5.0, 3.0);

/// How much better one model is than another on blocks that neither was fitted to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Sum of the differences, natural logarithms.
    pub total: f64,
    /// The same with every block's part bounded, over its standard error.
    pub sure: f64,
}

impl std::fmt::Display for Gain {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        // A loss too small to be told is not "-0".
        let [total, sure] = [self.total.round(), (10.0 * self.sure).round() / 10.0].map(|x| x + 0.0);
        write!(f, "{total:.0} nats, {sure:.1} standard errors")
    }
}

impl Gain {
    /// Of `new` over `old`, scores block by block.
    pub fn of(new: &[f64], old: &[f64]) -> Self {
        let differences: Vec<f64> = new.iter().zip(old).map(|(a, b)| a - b).collect();
        let n = differences.len() as f64;
        let centre = median(differences.clone());
        let scatter = median(differences.iter().map(|d| (d - centre).abs()).collect());
        // The scatter of a normal distribution is 1.48 times the median of what is off.
        let most = MOST_OF_A_BLOCK.0.max(MOST_OF_A_BLOCK.1 * 1.4826 * scatter);
        let bounded: Vec<f64> = differences.iter().map(|d| d.clamp(centre - most, centre + most)).collect();
        let sum = bounded.iter().sum::<f64>();
        let off: Vec<f64> = bounded.iter().map(|d| d - sum / n).collect();
        let free = (n - 1.0).max(1.0);
        let variance = off.iter().map(|d| d * d).sum::<f64>() / free;
        let lagged = off.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / free;
        // Where every block says the same, a block's own bound is all the doubt there is.
        let error = (n * (variance + 2.0 * lagged.max(0.0)).max(0.25)).sqrt();
        Self { total: differences.iter().sum(), sure: sum / error }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gain_that_every_block_shares_is_sure_and_one_of_a_single_block_is_not() {
        let old = vec![0.0; 40];
        let even: Vec<f64> = (0..40).map(|k| 1.0 + 0.1 * f64::from(k % 3)).collect();
        let mut single = vec![0.0; 40];
        single[7] = 44.0;
        let (even, single) = (Gain::of(&even, &old), Gain::of(&single, &old));
        assert!(even.total > 40.0 && even.sure > 10.0, "{even:?}");
        assert!(single.total > 40.0 && single.sure < 1.7, "{single:?}");
    }

    #[test]
    fn nothing_is_told_without_a_sign() {
        let told = Gain { total: -0.2, sure: -0.04 }.to_string();
        assert_eq!(told, "0 nats, 0.0 standard errors");
    }

    #[test]
    fn a_few_blocks_in_which_the_new_model_goes_astray_do_not_hide_what_all_others_say() {
        let mut new: Vec<f64> = (0..40).map(|k| 2.0 + 0.1 * f64::from(k % 3)).collect();
        (new[3], new[21]) = (-60.0, -40.0);
        assert!(Gain::of(&new, &[0.0; 40]).sure > 4.0);
    }

    #[test]
    fn blocks_that_go_along_with_their_neighbours_are_less_sure() {
        let apart: Vec<f64> = (0..40).map(|k| 0.5 + if k % 2 == 0 { 1.5 } else { -1.5 }).collect();
        let along: Vec<f64> = (0..40).map(|k| 0.5 + if k / 10 % 2 == 0 { 1.5 } else { -1.5 }).collect();
        let [apart, along] = [apart, along].map(|new| Gain::of(&new, &[0.0; 40]).sure);
        assert!(along < 0.7 * apart, "{along} {apart}");
    }
}
