//! Eight numbers in one vector register of a processor with AVX-512.
//!
//! As [`super::avx`], with registers twice as wide and masks of one bit per lane.

use std::arch::x86_64::{
    __m512d, __mmask8, _CMP_LE_OQ, _CMP_LT_OQ, _mm512_abs_pd, _mm512_add_pd, _mm512_and_pd, _mm512_castpd_si512,
    _mm512_castsi512_pd, _mm512_cmp_pd_mask, _mm512_div_pd, _mm512_fmadd_pd, _mm512_mask_blend_pd, _mm512_mul_pd,
    _mm512_or_pd, _mm512_set1_pd, _mm512_slli_epi64, _mm512_sqrt_pd, _mm512_srli_epi64, _mm512_sub_pd, _mm512_xor_pd,
};
use std::fmt;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use bytemuck::{Pod, Zeroable};
use pulp::WithSimd;

use super::avx::{instructions, intrinsic};
use super::definition::{Lanes, Mask, Number};

/// Eight numbers in one register. Computing with them takes a processor for which [`is_available`] holds: within the program alone,
/// which asks.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
pub struct EightAvx(__m512d);

/// Mask of eight lanes, one bit each.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EightAvxMask(__mmask8);

/// Whether this processor has the instructions.
pub fn is_available() -> bool {
    use std::arch::is_x86_feature_detected as has;
    has!("avx512f") && has!("avx512dq") && has!("avx512vl") && has!("avx2") && has!("fma")
}

/// Runs a computation in code for processors with AVX-512.
///
/// # Safety
/// [`is_available`] holds.
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) unsafe fn run<O: WithSimd>(op: O) -> O::Output {
    op.with_simd(pulp::Scalar::new())
}

impl EightAvx {
    #[inline(always)]
    fn array(self) -> [f64; 8] {
        bytemuck::cast(self)
    }
}

impl Mask for EightAvxMask {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self(if value { __mmask8::MAX } else { 0 })
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        self.0 >> lane & 1 != 0
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, value: bool) {
        self.0 = self.0 & !(1 << lane) | __mmask8::from(value) << lane;
    }

    #[inline(always)]
    fn any(self) -> bool {
        self.0 != 0
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Default for EightAvx {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl PartialEq for EightAvx {
    fn eq(&self, other: &Self) -> bool {
        self.array() == other.array()
    }
}

impl fmt::Debug for EightAvx {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.array().fmt(f)
    }
}

impl Lanes for EightAvx {
    type Alone = f64;

    #[inline(always)]
    fn put(&mut self, lane: usize, alone: &f64) {
        let array: &mut [f64; 8] = bytemuck::cast_mut(self);
        array[lane] = *alone;
    }
}

instructions!(
    EightAvx:
    Add::add by _mm512_add_pd, Sub::sub by _mm512_sub_pd, Mul::mul by _mm512_mul_pd, Div::div by _mm512_div_pd;
    AddAssign::add_assign by add, SubAssign::sub_assign by sub
);

impl Neg for EightAvx {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(intrinsic!(_mm512_xor_pd(self.0, _mm512_set1_pd(-0.0))))
    }
}

impl Number for EightAvx {
    const LANES: usize = 8;
    type Mask = EightAvxMask;

    #[inline(always)]
    fn dispatch<O: WithSimd>(op: O) -> O::Output {
        // SAFETY: these numbers are computed with only where this holds.
        unsafe { run(op) }
    }

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(intrinsic!(_mm512_set1_pd(value)))
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.array()[lane]
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self(intrinsic!(_mm512_fmadd_pd(self.0, factor.0, addend.0)))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(intrinsic!(_mm512_sqrt_pd(self.0)))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(intrinsic!(_mm512_abs_pd(self.0)))
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self(intrinsic!(_mm512_or_pd(self.abs().0, _mm512_and_pd(_mm512_set1_pd(-0.0), sign.0))))
    }

    #[inline(always)]
    fn less(self, other: Self) -> EightAvxMask {
        EightAvxMask(intrinsic!(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0)))
    }

    #[inline(always)]
    fn less_equal(self, other: Self) -> EightAvxMask {
        EightAvxMask(intrinsic!(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0)))
    }

    #[inline(always)]
    fn select(mask: EightAvxMask, yes: Self, no: Self) -> Self {
        Self(intrinsic!(_mm512_mask_blend_pd(mask.0, no.0, yes.0)))
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        // As for a number alone.
        let shifted = self + Self::splat(6_755_399_441_055_744.0 + 1023.0);
        Self(intrinsic!(_mm512_castsi512_pd(_mm512_slli_epi64::<52>(_mm512_castpd_si512(shifted.0)))))
    }

    #[inline(always)]
    fn mantissa_and_exponent(self) -> (Self, Self) {
        let one = Self::splat(1.0);
        let fraction = Self::splat(f64::from_bits((1 << 52) - 1));
        let mantissa = intrinsic!(_mm512_or_pd(_mm512_and_pd(self.0, fraction.0), one.0));
        let exponent = intrinsic!(_mm512_castsi512_pd(_mm512_srli_epi64::<52>(_mm512_castpd_si512(self.0))));
        // A small whole number in place of 2^52's last bits makes 2^52 plus that number.
        let whole = Self(intrinsic!(_mm512_or_pd(exponent, _mm512_set1_pd(4_503_599_627_370_496.0))));
        (Self(mantissa), whole - Self::splat(4_503_599_627_370_496.0 + 1023.0))
    }
}
