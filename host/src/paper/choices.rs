//! What the paper leaves open, and what is taken here.

use motorlens_shared::ga;
use serde::Serialize;

/// A question that the paper does not answer.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Choice {
    /// What is open.
    pub question: &'static str,
    /// What this run does.
    pub taken: &'static str,
}

const OF_THE_RUN: [(&str, &str); 8] = [
    (
        "which of the three records is fitted",
        "the one of the smallest voltage (--fit all takes all): Table 2's own growth says so, an estimate \
         from all three would spread its error",
    ),
    (
        "eps of equations 14 and 15",
        "drawn once per chromosome, for all genes, whatever their units, from 0 to 1 as printed",
    ),
    (
        "genes that come out negative",
        "set to a thousandth of x_sm, and counted: the literal equation makes negative resistances and inertias",
    ),
    ("range of a gene, the unit of its mutation", "1 in the gene's own unit, the largest eps"),
    ("upper limits of the genes", "none"),
    (
        "the conventional solver's bounds and settings",
        "each parameter within a hundredth and a hundred times its start; MINPACK's tolerances",
    ),
    (
        "how the model is integrated",
        "exactly: a fixed step at the sample rate is unstable for plausible parameters (R/L near 1500 1/s)",
    ),
    ("the angle at the start of a record", "the first sample; the motor rests there"),
];

/// All of them.
pub fn choices() -> Vec<Choice> {
    OF_THE_RUN.iter().chain(ga::OPEN_CHOICES).map(|&(question, taken)| Choice { question, taken }).collect()
}
