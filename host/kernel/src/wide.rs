//! Eight numbers in two AVX registers, with fused multiply-add.
//!
//! Plain arrays compile to the same machine code, but the compiler has to find the vectors again in eight times as
//! many instructions, for every set of effects: this takes a third of the time to build, and to run a fifth less.

#![allow(unsafe_code, reason = "compiled for vector units that are asked for before they are used")]

use core::arch::x86_64::*;
use core::fmt;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use motorlens_shared::lanes::Lanes;
use motorlens_shared::scalar::Scalar;

use crate::{Block, LANES, Shown};

/// Eight numbers.
///
/// Every operation needs AVX2 and fused multiply-add: values may be made and used only where [`crate::has_wide`] holds.
#[derive(Clone, Copy)]
pub struct Wide([__m256d; 2]);

impl Wide {
    /// The same numbers, one a lane.
    #[inline(always)]
    #[must_use]
    pub fn from_block(block: &Block) -> Self {
        let [a, b, c, d, e, f, g, h] = block.0;
        // SAFETY: see the type, here and in all that follows.
        unsafe { Self([_mm256_setr_pd(a, b, c, d), _mm256_setr_pd(e, f, g, h)]) }
    }

    #[inline(always)]
    fn numbers(self) -> [f64; LANES] {
        let mut numbers = [0.0; LANES];
        // SAFETY: there is room for four numbers at 0 and at 4.
        unsafe {
            _mm256_storeu_pd(numbers.as_mut_ptr(), self.0[0]);
            _mm256_storeu_pd(numbers.as_mut_ptr().add(4), self.0[1]);
        }
        numbers
    }
}

macro_rules! pairwise {
    ($instruction:ident, $a:expr, $b:expr) => {
        // SAFETY: see the type.
        unsafe { Self([$instruction($a.0[0], $b.0[0]), $instruction($a.0[1], $b.0[1])]) }
    };
}

macro_rules! operator {
    ($trait:ident $method:ident $instruction:ident) => {
        impl $trait for Wide {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                pairwise!($instruction, self, other)
            }
        }
    };
}
operator!(Add add _mm256_add_pd);
operator!(Sub sub _mm256_sub_pd);
operator!(Mul mul _mm256_mul_pd);
operator!(Div div _mm256_div_pd);

impl Neg for Wide {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let sign = Self::lit(-0.0);
        pairwise!(_mm256_xor_pd, self, sign)
    }
}
impl AddAssign for Wide {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl SubAssign for Wide {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
impl PartialEq for Wide {
    fn eq(&self, other: &Self) -> bool {
        self.numbers() == other.numbers()
    }
}
impl fmt::Debug for Wide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.numbers().fmt(f)
    }
}

/// Four places of `table`, each `back` before `index`. The table holds 1 ..= `i32::MAX` numbers.
#[inline(always)]
fn look_back(table: &[f64], index: usize, back: __m256d) -> __m256d {
    // SAFETY: see the type; every place is limited to those of the table.
    unsafe {
        let (first, last) = (_mm_setzero_si128(), _mm_set1_epi32(table.len() as i32 - 1));
        let whole = _mm256_cvttpd_epi32(back);
        let part = _mm256_sub_pd(back, _mm256_cvtepi32_pd(whole));
        let place = _mm_sub_epi32(_mm_set1_epi32(index as i32), whole);
        let before = _mm_sub_epi32(place, _mm_set1_epi32(1));
        let newer = _mm_min_epi32(_mm_max_epi32(place, first), last);
        let older = _mm_min_epi32(_mm_max_epi32(before, first), last);
        let newer = _mm256_i32gather_pd::<8>(table.as_ptr(), newer);
        let older = _mm256_i32gather_pd::<8>(table.as_ptr(), older);
        _mm256_fmadd_pd(part, _mm256_sub_pd(older, newer), newer)
    }
}

impl Scalar for Wide {
    type Element = f64;

    #[inline(always)]
    fn lit(x: f64) -> Self {
        // SAFETY: see the type.
        unsafe { Self([_mm256_set1_pd(x); 2]) }
    }
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self::lit(x)
    }
    #[inline(always)]
    fn mul_add(self, m: Self, a: Self) -> Self {
        // SAFETY: see the type.
        unsafe {
            Self([_mm256_fmadd_pd(self.0[0], m.0[0], a.0[0]), _mm256_fmadd_pd(self.0[1], m.0[1], a.0[1])])
        }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let sign = Self::lit(-0.0);
        pairwise!(_mm256_andnot_pd, sign, self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        pairwise!(_mm256_min_pd, self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        pairwise!(_mm256_max_pd, self, other)
    }
    #[inline(always)]
    fn any_gt(a: Self, b: Self) -> bool {
        // SAFETY: see the type.
        unsafe {
            let above = _mm256_or_pd(
                _mm256_cmp_pd::<_CMP_GT_OQ>(a.0[0], b.0[0]),
                _mm256_cmp_pd::<_CMP_GT_OQ>(a.0[1], b.0[1]),
            );
            _mm256_movemask_pd(above) != 0
        }
    }
    #[inline(always)]
    fn pick_gt(a: Self, b: Self, x: Self, y: Self) -> Self {
        let Self([a0, a1]) = a;
        let Self([b0, b1]) = b;
        // SAFETY: see the type.
        unsafe {
            Self([
                _mm256_blendv_pd(y.0[0], x.0[0], _mm256_cmp_pd::<_CMP_GT_OQ>(a0, b0)),
                _mm256_blendv_pd(y.0[1], x.0[1], _mm256_cmp_pd::<_CMP_GT_OQ>(a1, b1)),
            ])
        }
    }
    /// By the root that the processor has: four divisions less.
    #[inline(always)]
    fn hypot(self, other: Self) -> Self {
        let square = self.mul_add(self, other * other);
        // SAFETY: see the type.
        unsafe { Self([_mm256_sqrt_pd(square.0[0]), _mm256_sqrt_pd(square.0[1])]) }
    }
    #[inline(always)]
    fn round(self) -> Self {
        let magic = Self::lit(6_755_399_441_055_744.0);
        (self + magic) - magic
    }
    #[inline(always)]
    fn look_back(table: &[f64], index: usize, back: Self) -> Self {
        assert!(!table.is_empty() && table.len() < i32::MAX as usize, "a table of no or too many numbers");
        Self([look_back(table, index, back.0[0]), look_back(table, index, back.0[1])])
    }
    #[inline(always)]
    fn map(self, f: fn(f64) -> f64) -> Self {
        Self::from_block(&Lanes(self.numbers().map(f)))
    }
    #[inline(always)]
    fn map_with(self, other: Self, f: fn(f64, f64) -> f64) -> Self {
        let (a, b) = (self.numbers(), other.numbers());
        Self::from_block(&Lanes(core::array::from_fn(|l| f(a[l], b[l]))))
    }
}

impl Shown for Wide {
    type Plain = Block;
    #[inline(always)]
    fn plain(self) -> Block {
        Lanes(self.numbers())
    }
}

#[cfg(test)]
mod tests {
    use super::Wide;
    use crate::{Block, Shown, has_wide};
    use motorlens_shared::lanes::Lanes;
    use motorlens_shared::scalar::Scalar;

    /// The operations one after another, none of which rounds on these numbers, so that fusing makes no difference.
    fn all<S: Scalar<Element = f64>>(a: S, b: S) -> [S; 12] {
        let table: std::vec::Vec<f64> = (0..40).map(|k| f64::from(k * k)).collect();
        [
            a + b,
            a - b,
            a * b,
            a / S::lit(4.0),
            -a,
            a.abs(),
            a.min(b),
            a.max(b),
            S::pick_gt(a, b, S::splat(7.0), b),
            a.round(),
            a.mul_add(b, S::one()),
            S::look_back(&table, 12, a.abs()),
        ]
    }

    #[test]
    fn two_registers_compute_what_an_array_computes() {
        if !has_wide() {
            return;
        }
        let a: Block = Lanes([1.5, -2.0, 0.25, 9.0, -0.5, 100.0, 12.0, 11.5]);
        let b: Block = Lanes([0.5, 3.0, -4.0, 9.0, 8.0, -0.25, 2.0, -1.0]);
        let wide = all(Wide::from_block(&a), Wide::from_block(&b));
        for (k, (wide, array)) in wide.into_iter().zip(all(a, b)).enumerate() {
            assert_eq!(wide.plain(), array, "operation {k}");
        }
    }
}
