//! Nonlinear least squares within bounds, with numerical derivatives.
//!
//! Solver: the `levenberg-marquardt` crate, a port of MINPACK's `lmder`. It knows no bounds, so each parameter is the image of an
//! unbounded number z: ln x = ln start + ln(bound) sin z, which never leaves start / bound ..= start * bound (James and Roos, MINUIT,
//! 1975).

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra_lm::storage::Owned;
use nalgebra_lm::{DMatrix, DVector, Dyn};

/// Where a search begins and how it goes.
#[derive(Debug)]
pub struct Search<'a> {
    /// The parameters at the start, all of them positive.
    pub start: &'a [f64],
    /// Largest ratio between a parameter and its start.
    pub bound: f64,
    /// Step of the forward difference in z.
    pub difference: f64,
    /// The solver, with its tolerances.
    pub solver: LevenbergMarquardt<f64>,
}

/// What a search found.
#[derive(Debug)]
pub struct Minimum {
    /// The parameters.
    pub x: Vec<f64>,
    /// The sum of squares there.
    pub squares: f64,
    /// How the solver ended.
    pub ending: String,
}

impl Search<'_> {
    /// The parameters with the smallest sum of squares of `residuals` on the way down from the start.
    pub fn minimise(&self, residuals: impl Fn(&[f64]) -> Vec<f64>) -> Minimum {
        let z = DVector::zeros(self.start.len());
        let here = DVector::from_vec(residuals(self.start));
        let problem = Problem { search: self, residuals: &residuals, z, here };
        let (problem, report) = self.solver.minimize(problem);
        Minimum {
            x: self.plain(&problem.z),
            squares: problem.here.norm_squared(),
            ending: format!("{:?}", report.termination),
        }
    }

    /// The parameters that `z` stands for.
    fn plain(&self, z: &DVector<f64>) -> Vec<f64> {
        self.start.iter().zip(z.iter()).map(|(start, z)| start * (self.bound.ln() * z.sin()).exp()).collect()
    }
}

struct Problem<'a, F> {
    search: &'a Search<'a>,
    residuals: &'a F,
    z: DVector<f64>,
    /// The residuals at `z`.
    here: DVector<f64>,
}

impl<F: Fn(&[f64]) -> Vec<f64>> Problem<'_, F> {
    fn at(&self, z: &DVector<f64>) -> DVector<f64> {
        DVector::from_vec((self.residuals)(&self.search.plain(z)))
    }
}

impl<F: Fn(&[f64]) -> Vec<f64>> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_, F> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, z: &DVector<f64>) {
        self.z.copy_from(z);
        self.here = self.at(z);
    }

    fn params(&self) -> DVector<f64> {
        self.z.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.here.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let mut jacobian = DMatrix::zeros(self.here.len(), self.z.len());
        for k in 0..self.z.len() {
            let mut z = self.z.clone();
            z[k] += self.search.difference;
            jacobian.set_column(k, &((self.at(&z) - &self.here) / self.search.difference));
        }
        Some(jacobian)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decay_is_found_within_the_bounds_and_the_bound_beyond_them() {
        let seen: Vec<f64> = (0..50).map(|k| 3.0 * (-0.1 * f64::from(k)).exp()).collect();
        let errors = |x: &[f64]| {
            let of = |(k, y): (usize, &f64)| x[0] * (-x[1] * k as f64).exp() - y;
            seen.iter().enumerate().map(of).collect()
        };
        let search = |bound| Search {
            start: &[1.0, 0.02],
            bound,
            difference: 1e-6,
            solver: LevenbergMarquardt::new(),
        };
        let found = search(100.0).minimise(errors);
        assert!((found.x[0] - 3.0).abs() < 1e-6 && (found.x[1] - 0.1).abs() < 1e-6, "{found:?}");
        assert!(found.squares < 1e-9, "{found:?}");
        let near = search(2.0).minimise(errors);
        assert!(near.x[0] <= 2.0 && near.x[1] <= 0.04 && near.squares > 0.1, "{near:?}");
    }
}
