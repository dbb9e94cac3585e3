//! One step of the motor: the exact linear map, then the equations that can only be met at the end of the step.
//!
//! Dry friction, a brush voltage drop and extra resistance are solved implicitly (each a soft threshold or a
//! quotient), so that a motor at rest is exactly at rest and no sign function has to be smoothed.

use crate::base::Coefficients;
use crate::friction;
use crate::loss;
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

    /// The same motion from another place, `by` rad further.
    #[inline(always)]
    #[must_use]
    pub fn turned(self, by: S) -> Self {
        Self { angle: self.angle + by, load_angle: self.load_angle + by, ..self }
    }
    /// At rest at angle zero.
    pub fn rest() -> Self {
        Self::moving(S::zero(), S::zero(), S::zero())
    }
}

/// What acts on the motor during one step. Effects write here; [`step`] resolves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive<S> {
    /// Voltage that the bridge is told to apply, V: late, and less a dead zone.
    pub asked: S,
    /// Voltage on the winding before the equations below, V.
    pub voltage: S,
    /// Torque on the rotor, positive drives forward, V.
    pub torque: S,
    /// The part of `torque` by which iron that saturates weakens the motor's own: the gear never passes it, V.
    pub weakening: S,
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
    /// Current, as a voltage, well above which all of `brush` is lost; more than 0, V.
    pub brush_knee: S,
    /// Resistance in series with the winding, as a share of the winding's.
    pub series: S,
}

impl<S: Scalar> Drive<S> {
    /// The plain motor under `voltage`.
    #[inline(always)]
    pub fn plain(voltage: S) -> Self {
        let zero = S::zero();
        Self {
            asked: voltage,
            voltage,
            torque: zero,
            weakening: zero,
            load_torque: zero,
            friction_forward: zero,
            friction_backward: zero,
            meshing: zero,
            meshing_knee: S::one(),
            drop: zero,
            brush: zero,
            brush_knee: S::one(),
            series: zero,
        }
    }
}

/// Which parts of [`Drive`] anything sets: the others cost nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Laws {
    /// Something sets [`Drive::torque`] or [`Drive::load_torque`].
    pub torque: bool,
    /// Something sets [`Drive::drop`].
    pub drop: bool,
    /// Something sets [`Drive::brush`].
    pub brush: bool,
    /// Something sets [`Drive::series`].
    pub series: bool,
    /// Something sets [`Drive::friction_forward`], [`Drive::friction_backward`] or [`Drive::meshing`].
    pub dry: bool,
    /// Something sets [`Drive::meshing`].
    pub meshing: bool,
    /// Parts in which a step is passed where rotor and load are two masses.
    pub parts: usize,
    /// Friction turns where within a step the speed passes through zero; else at the step's end, which leaves an
    /// error of first order at each reversal but needs no quotient.
    pub turning: bool,
}

impl Laws {
    /// What either needs.
    ///
    /// Asked at every step, and known when a set of effects is compiled: only where this is inlined, too, no step has to find it out.
    #[inline(always)]
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            torque: self.torque || other.torque,
            drop: self.drop || other.drop,
            brush: self.brush || other.brush,
            series: self.series || other.series,
            dry: self.dry || other.dry,
            meshing: self.meshing || other.meshing,
            parts: if self.parts > other.parts { self.parts } else { other.parts },
            turning: self.turning || other.turning,
        }
    }
}

/// Advances the rotor by one step under `drive`; the load is left to the transmission.
///
/// Order: linear map; series resistance and drops on the new current ([`loss`]); friction on the new speed. The friction
/// torque is the smallest that brings the new speed to zero, or the largest that the surface can give; see also
/// [`Laws::turning`].
#[inline(always)]
pub fn step<S: Scalar>(c: &Coefficients<S>, laws: Laws, s: &mut State<S>, drive: &Drive<S>) {
    let (u, w) = (s.current, s.speed);
    let (mut v, mut f) = (drive.voltage, drive.torque);
    let (mut from_v, mut w_from_v) = (c.uv * v, c.wv * v);
    if laws.torque {
        from_v = c.uf.mul_add(f, from_v);
        w_from_v = c.wf.mul_add(f, w_from_v);
    }
    let mut u2 = c.uu.mul_add(u, c.uw.mul_add(w, from_v));
    let mut w2 = c.wu.mul_add(u, c.ww.mul_add(w, w_from_v));

    if laws.drop || laws.brush || laws.series {
        // The current that friction will bring with it by holding the speed is lost as any other.
        let mut held = S::zero();
        if laws.dry {
            held = (-(w2 * c.inverse_wf)).clamp(-drive.friction_forward, drive.friction_backward);
            u2 = c.uf.mul_add(held, u2);
        }
        let (left, late) = loss::left(c, laws, [u, u2], [w, w2], drive);
        let dv = (left - u2) * c.inverse_uv;
        u2 = c.uf.mul_add(late - held, left);
        w2 = c.wv.mul_add(dv, c.wf.mul_add(late, w2));
        v += dv;
        f += late;
    }
    // Twice the mean speed of a step in which it changes evenly.
    let mut ends = w + w2;
    if laws.dry {
        let (mut forward, mut backward) = (drive.friction_forward, drive.friction_backward);
        if laws.meshing {
            // The motor's mean torque in the step is what the change of speed took, less the other torques.
            let others = drive.torque - drive.weakening;
            let mean = (w2 - w).mul_add(c.per_impulse, c.viscous * (w + w2)) - others;
            // Simpson's rule: a current that turns within the step is lost on both sides of zero.
            let knee = drive.meshing_knee;
            let half = S::lit(0.5) * (u2 - u);
            let outer = (mean - half).hypot(knee) + (mean + half).hypot(knee);
            let even = (outer + S::lit(4.0) * mean.hypot(knee)) * S::lit(1.0 / 6.0);
            let loss = drive.meshing * (even - drive.meshing_knee);
            (forward, backward) = (forward + loss, backward + loss);
        }
        let g = if laws.turning {
            let free = w2;
            (w2, ends) = friction::turn(c, [u, w], [v, f], free, [forward, backward]);
            (w2 - free) * c.inverse_wf
        } else {
            let g = (-(w2 * c.inverse_wf)).clamp(-forward, backward);
            w2 = c.wf.mul_add(g, w2);
            ends = w + w2;
            g
        };
        u2 = c.uf.mul_add(g, u2);
        f += g;
    }
    let mut curve = c.xu.mul_add(u, c.xw.mul_add(w, c.xv * v));
    if laws.torque || laws.dry || laws.brush || laws.series {
        curve = c.xf.mul_add(f, curve);
    }
    s.angle += c.half_step.mul_add(ends, curve);
    s.current = u2;
    s.speed = w2;
}
