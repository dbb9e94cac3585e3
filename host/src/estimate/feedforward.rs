//! The usual model of robotics: v = kS sign(w) + kV w + kA w', by ordinary least squares on the logged motion.
//!
//! It is what WPILib's SysId and its relatives fit, and the one to beat on unseen records. The motion's derivatives
//! are taken under a smooth bump of a tenth of a second, which is kinder to it than differences.

use motorlens_shared::effects::Kind;
use nalgebra::{Matrix3, Vector3};

use super::Searched;
use crate::error::{BadInput, Result};
use crate::fit::layout::{BaseValues, Values};
use crate::fit::search::Problem;
use crate::log::{Record, weak::Weak};

/// Fits the three numbers to all records.
///
/// # Errors
/// Records that are too short, or that no such motor explains.
pub(crate) fn search(problem: &Problem, records: &[Record]) -> Result<Searched> {
    let (mut h, mut g) = (Matrix3::zeros(), Vector3::zeros());
    for ([w, a, sign, _], v) in records.iter().filter_map(Weak::new).flat_map(|weak| weak.rows()) {
        let row = Vector3::new(sign, w, a);
        h += row * row.transpose();
        g += row * v;
    }
    let found = h.cholesky().map(|factor| factor.solve(&g)).filter(|k| k[1] > 0.0 && k[2] > 0.0);
    let Some(k) = found else {
        let path = records.first().map(|r| r.path.clone()).unwrap_or_default();
        let why = "kS, kV and kA cannot be fitted: speed and acceleration do not explain the voltage";
        return Err(
            BadInput::new(&path, why, "use --method fast, or log a programme that accelerates").into()
        );
    };
    let base = BaseValues {
        gain: 1.0 / k[1],
        tau_m: k[2] / k[1],
        // It knows no winding: the shortest time constant that the model takes.
        tau_e: problem.prior.tau_e.0 * (-3.0 * problem.prior.tau_e.1).exp(),
        viscous_share: problem.prior.viscous_share.0,
    };
    let effects = vec![(Kind::Coulomb, vec![k[0].max(0.0)])];
    Ok(Searched { values: Values { base, effects }, history: Vec::new(), evaluations: 0 })
}
