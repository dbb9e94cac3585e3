//! One step of the motor: the exact linear map, then the laws that can only be met at the end of the step.
//!
//! Dry friction, a brush voltage drop and extra resistance are solved implicitly (each a soft threshold or a
//! quotient), so that a motor at rest is exactly at rest and no sign function has to be smoothed.

use crate::base::Coefficients;
use crate::scalar::Scalar;

/// State of motor and load; angle and speed are of the output shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<S> {
    /// Current times winding resistance, V.
    pub current: S,
    /// Speed of the rotor, seen through the gear, rad/s.
    pub speed: S,
    /// Angle of the rotor, seen through the gear, rad.
    pub angle: S,
    /// Speed of the load, rad/s; equals `speed` while gear and shaft are rigid.
    pub load_speed: S,
    /// Angle of the load, rad.
    pub load_angle: S,
}

impl<S: Scalar> State<S> {
    /// Everything moves together at `speed`, from `angle`, with `current` in the winding.
    pub fn moving(current: S, speed: S, angle: S) -> Self {
        Self { current, speed, angle, load_speed: speed, load_angle: angle }
    }
    /// At rest at angle zero.
    pub fn rest() -> Self {
        Self::moving(S::zero(), S::zero(), S::zero())
    }
}

/// What acts on the motor during one step. Effects write here; [`step`] resolves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive<S> {
    /// Voltage on the winding before the laws below, V.
    pub voltage: S,
    /// Torque on the rotor, positive drives forward, V.
    pub torque: S,
    /// Torque on the load, positive drives forward, V.
    pub load_torque: S,
    /// Dry friction against forward motion (0 or more), V.
    pub friction_forward: S,
    /// Dry friction against backward motion (0 or more), V.
    pub friction_backward: S,
    /// Share of the motor's own torque that dry friction takes (0 ..= 1), and the torque above which it does, V.
    pub meshing: S,
    /// See `meshing`; more than 0 where that is, V.
    pub meshing_knee: S,
    /// Voltage lost against the current's direction, whatever its size (0 or more), V.
    pub drop: S,
    /// Voltage lost against the direction of a current well above `brush_knee` (0 or more), V.
    pub brush: S,
    /// Current, as a voltage, at which two thirds of `brush` are lost; more than 0, V.
    pub brush_knee: S,
    /// Resistance in series with the winding, as a share of the winding's.
    pub series: S,
    /// Magnetic field as a share of the rated one: scales torque and back-EMF alike.
    pub field: S,
}

impl<S: Scalar> Drive<S> {
    /// The plain motor under `voltage`.
    #[inline(always)]
    pub fn plain(voltage: S) -> Self {
        let zero = S::zero();
        Self {
            voltage,
            torque: zero,
            load_torque: zero,
            friction_forward: zero,
            friction_backward: zero,
            meshing: zero,
            meshing_knee: S::one(),
            drop: zero,
            brush: zero,
            brush_knee: S::one(),
            series: zero,
            field: S::one(),
        }
    }
}

/// Which laws at the end of a step are needed at all: the others are skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Laws {
    /// Something sets [`Drive::drop`], [`Drive::brush`] or [`Drive::series`].
    pub resistive: bool,
    /// Something sets [`Drive::brush`].
    pub gradual: bool,
    /// Something sets [`Drive::friction_forward`], [`Drive::friction_backward`] or [`Drive::meshing`].
    pub dry: bool,
    /// Something sets [`Drive::meshing`].
    pub meshing: bool,
}

/// Share of its full size that a drop has at current `u`: an odd function that rises over `knee` and comes near 1
/// with the square of the current, divided by `u`.
#[inline(always)]
fn drop_per_current<S: Scalar>(u: S, knee: S) -> S {
    let size = u.abs();
    let sum = size + knee;
    sum / size.mul_add(sum, knee * knee)
}

/// Advances the rotor by one step under `drive`; the load is left to the transmission.
///
/// Order: linear map; series resistance and drop on the new current; friction on the new speed. The friction
/// torque is the smallest that brings the new speed to zero, or the largest that the surface can give.
#[inline(always)]
pub fn step<S: Scalar>(c: &Coefficients<S>, laws: Laws, s: &mut State<S>, drive: &Drive<S>) {
    let weakened = drive.field - S::one();
    let mut f = weakened.mul_add(s.current, drive.torque);
    let mut v = drive.voltage - weakened * c.back_emf * s.speed;
    let (u, w) = (s.current, s.speed);
    let mut u2 = c.uu.mul_add(u, c.uw.mul_add(w, c.uv.mul_add(v, c.uf * f)));
    let mut w2 = c.wu.mul_add(u, c.ww.mul_add(w, c.wv.mul_add(v, c.wf * f)));

    if laws.resistive {
        let lost = (-(u2 * c.inverse_uv)).clamp(-drive.drop, drive.drop);
        let after_drop = c.uv.mul_add(lost, u2);
        let mut resistance = drive.series;
        if laws.gradual {
            // Three rounds towards the current that its own drop leaves; the first guess has a sharp knee.
            let mut after = after_drop.shrink(c.uv * drive.brush);
            for _ in 0..3 {
                resistance = drive.brush.mul_add(drop_per_current(after, drive.brush_knee), drive.series);
                after = after_drop / resistance.mul_add(c.uv, S::one());
            }
        }
        let dv = lost - resistance * after_drop / resistance.mul_add(c.uv, S::one());
        u2 = c.uv.mul_add(dv, u2);
        w2 = c.wv.mul_add(dv, w2);
        v += dv;
    }
    if laws.dry {
        let (mut forward, mut backward) = (drive.friction_forward, drive.friction_backward);
        if laws.meshing {
            // The mean current of the step is what the change of speed took, less the other torques.
            let mean = (w2 - w).mul_add(c.per_impulse, c.viscous * (w + w2)) - f;
            let loss = drive.meshing * mean * mean / (mean.abs() + drive.meshing_knee);
            (forward, backward) = (forward + loss, backward + loss);
        }
        let g = (-(w2 * c.inverse_wf)).clamp(-forward, backward);
        u2 = c.uf.mul_add(g, u2);
        w2 = c.wf.mul_add(g, w2);
        f += g;
    }
    let curve = c.xu.mul_add(u, c.xw.mul_add(w, c.xv.mul_add(v, c.xf * f)));
    s.angle += c.half_step.mul_add(w + w2, curve);
    s.current = u2;
    s.speed = w2;
}
