//! How much better one model is than another on blocks that neither was fitted to, and how sure that is.
//!
//! Two models are scored under one noise, as the better of them leaves it: what both leave alike is noise as far as the records tell, however
//! much of it comes from a disturbance that lasts, and what only the worse one leaves is misfit (as the dispersion of a quasi-likelihood is
//! that of the richest model: D. Anderson, K. Burnham and G. White, *Ecology* 75, 1994). The paired differences of the blocks,
//! whose scatter, with its autocorrelation, say how sure the gain is.

/// One block speaks for at most so much more than the middle one of its record, natural logarithms or standard deviations, when it is asked
/// how sure a gain is: a few blocks in which a wrong law goes astray are no proof, and must not hide what all others say.
const MOST_OF_A_BLOCK: (f64, f64) = (5.0, 3.0);

/// Blocks of a record of which their own scatter can be told.
const FEWEST: usize = 4;

/// How much better one model is than another on blocks that neither was fitted to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Sum of the differences, natural logarithms.
    pub total: f64,
    /// The same with every block's part bounded, over its standard error.
    pub sure: f64,
}

impl Gain {
    /// Of `new` over `old`, scores block by block, of records that have so many `blocks` each.
    ///
    /// A programme decides what its record can show: the multisine may tell all about a delay and the slow triangle nothing. So the blocks
    /// of a record are compared with each other and not with those of other records (stratified sampling: W. Cochran, *Sampling
    /// Techniques*, 3rd ed., 1977, ch. 5). Short records are one stratum.
    pub fn of(new: &[f64], old: &[f64], blocks: &[usize]) -> Self {
        let differences: Vec<f64> = new.iter().zip(old).map(|(a, b)| a - b).collect();
        let mut strata = vec![Vec::new()];
        let mut rest = &differences[..];
        for count in blocks {
            let (own, behind) = rest.split_at((*count).min(rest.len()));
            if own.len() < FEWEST {
                strata[0].extend_from_slice(own)
            } else {
                strata.push(own.to_vec())
            }
            rest = behind;
        }
        let of = strata.iter().filter(|stratum| !stratum.is_empty()).map(|stratum| sum_and_variance(stratum));
        let (sum, variance) = of.fold((0.0, 0.0), |all, own| (all.0 + own.0, all.1 + own.1));
        Self { total: differences.iter().sum(), sure: sum / variance.max(1e-12).sqrt() }
    }
}

/// Sum of the bounded differences of a stratum, and the variance of that with their autocorrelation.
fn sum_and_variance(differences: &[f64]) -> (f64, f64) {
    let n = differences.len() as f64;
    let centre = median(differences.to_vec());
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
    (sum, n * (variance + 2.0 * lagged.max(0.0)).max(0.25))
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
        let (even, single) = (Gain::of(&even, &old, &[8; 5]), Gain::of(&single, &old, &[8; 5]));
        assert!(even.total > 40.0 && even.sure > 10.0, "{even:?}");
        assert!(single.total > 40.0 && single.sure < 1.7, "{single:?}");
    }

    #[test]
    fn a_gain_of_one_record_is_sure_where_all_of_its_blocks_share_it() {
        let mut new = vec![-0.2; 40];
        for (k, block) in new[24..32].iter_mut().enumerate() {
            *block = 9.0 + (k % 3) as f64;
        }
        let sure = Gain::of(&new, &[0.0; 40], &[8; 5]).sure;
        assert!(sure > 10.0, "{sure}");
        // Of a single record such blocks may be chance.
        let alone = Gain::of(&new, &[0.0; 40], &[40]).sure;
        assert!(alone < 3.0, "{alone}");
    }

    #[test]
    fn blocks_of_short_records_are_compared_with_each_other() {
        let new: Vec<f64> = (0..12).map(|k| if k % 2 == 0 { 3.0 } else { -2.0 }).collect();
        let sure = Gain::of(&new, &[0.0; 12], &[1; 12]).sure;
        assert!((0.1..2.0).contains(&sure), "{sure}");
    }
}
