//! Phase in turns as a 32-bit fraction, and its sine without a maths library.
//!
//! A whole turn is 2^32, so wrapping is exact and phase never drifts. `libm::sinf` would compute in
//! `f64` inside and cost over a thousand instructions on a Cortex-M4F; this costs 16. micromath's, of an angle in rad, costs 22 and is
//! off by up to 1.1e-3 (`cargo xtask instructions --board`).

/// Phase per sample, as a fraction of a turn times 2^32, of a frequency at a sample rate.
/// Frequencies are rounded to `rate / 2^32` (0.23 uHz at 1 kHz).
pub fn turn_per_sample(frequency_hz: f64, rate_hz: u32) -> u32 {
    libm::round(frequency_hz / f64::from(rate_hz) * TURN) as u32
}

/// A whole turn.
pub const TURN: f64 = 4_294_967_296.0;

/// `sin(2 pi phase / 2^32)`, within 2.5e-7 of the exact sine, never beyond 1 in magnitude by more than that.
///
/// Odd polynomial of degree 9 on a quarter turn (Chebyshev nodes; 7e-9 before rounding to `f32`).
pub fn sine(phase: u32) -> f32 {
    const QUARTER: i32 = 1 << 30;
    let mut signed = phase as i32;
    if !(-QUARTER..=QUARTER).contains(&signed) {
        signed = i32::MIN.wrapping_sub(signed); // sin(pi - x) = sin(x)
    }
    let x = signed as f32 * (1.0 / TURN as f32);
    let z = x * x;
    x * (core::f32::consts::TAU + z * (-41.341_68 + z * (81.602_48 + z * (-76.581_17 + z * 39.759_827))))
}

/// `2^(y / 2^32)` for `y` below 24 octaves, relative error at most 2e-7.
///
/// Polynomial of degree 6 on one octave (Chebyshev nodes; 3e-9 before rounding to `f32`).
pub fn exp2(y: u64) -> f32 {
    let octave = (y >> 32).min(24) as u32;
    let x = y as u32 as f32 * (1.0 / TURN as f32);
    let mantissa = 1.0
        + x * (0.693_146_93
            + x * (0.240_230_45
                + x * (0.055_480_63 + x * (0.009_684_186 + x * (0.001_239_133_2 + x * 0.000_218_657_85)))));
    mantissa * (1u32 << octave) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn sine_agrees_with_f64_within_its_bound() {
        for step in 0..200_000u32 {
            let phase = step.wrapping_mul(2_654_435_769);
            let exact = (TAU * f64::from(phase) / TURN).sin();
            assert!((f64::from(sine(phase)) - exact).abs() < 2.5e-7, "{phase}");
        }
    }

    #[test]
    fn sine_is_exact_at_the_zeros_and_odd() {
        assert_eq!(sine(0), 0.0);
        assert_eq!(sine(1 << 31), 0.0);
        for phase in [1u32, 77, 1 << 29, 1 << 30, 3_000_000_000] {
            assert_eq!(sine(phase), -sine(phase.wrapping_neg()));
        }
    }

    #[test]
    fn exp2_agrees_with_f64_within_its_bound() {
        for step in 0..100_000u64 {
            let y = step * 1_000_003; // 0 to 23.3 octaves
            let exact = (y as f64 / TURN).exp2();
            assert!((f64::from(exp2(y)) / exact - 1.0).abs() < 2e-7, "{y}");
        }
    }

    #[test]
    fn a_frequency_becomes_its_share_of_a_turn() {
        assert_eq!(turn_per_sample(250.0, 1000), 1 << 30);
        assert_eq!(turn_per_sample(0.0, 1000), 0);
    }
}
