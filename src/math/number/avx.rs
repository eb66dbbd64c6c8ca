//! Four numbers in one vector register of a processor with AVX2 and FMA.
//!
//! The same operations as [`Four`]'s, each by its instruction: how well the compiler finds them by itself depends on the size of
//! the function around them.

use std::arch::x86_64::{
    __m256d, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_pd, _mm256_and_pd, _mm256_andnot_pd, _mm256_blendv_pd,
    _mm256_castpd_si256, _mm256_castsi256_pd, _mm256_cmp_pd, _mm256_div_pd, _mm256_fmadd_pd, _mm256_movemask_pd,
    _mm256_mul_pd, _mm256_or_pd, _mm256_set1_pd, _mm256_slli_epi64, _mm256_sqrt_pd, _mm256_srli_epi64, _mm256_sub_pd,
    _mm256_xor_pd,
};
use std::fmt;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use bytemuck::{Pod, Zeroable};
use pulp::x86::V3;
use pulp::{Simd, WithSimd};

use super::definition::{Lanes, Mask, Number};

/// Four numbers in one register. Computing with them takes a processor for which [`is_available`] holds: within the
/// program alone, which asks.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
pub struct FourAvx(__m256d);

/// Mask of four lanes: all bits set or none.
#[derive(Clone, Copy)]
pub struct FourAvxMask(__m256d);

/// Whether this processor has the instructions.
pub fn is_available() -> bool {
    V3::is_available()
}

impl FourAvx {
    #[inline(always)]
    fn array(self) -> [f64; 4] {
        bytemuck::cast(self)
    }
}

impl FourAvxMask {
    #[inline(always)]
    fn array(self) -> [u64; 4] {
        bytemuck::cast(self.0)
    }
}

/// An intrinsic. Sound as numbers in registers are computed with only where the processor has them.
macro_rules! intrinsic {
    ($call:expr) => {
        // SAFETY: the processor has the instruction.
        unsafe { $call }
    };
}

pub(super) use intrinsic;

impl Mask for FourAvxMask {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self(bytemuck::cast([if value { u64::MAX } else { 0 }; 4]))
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        self.array()[lane] != 0
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, value: bool) {
        let array: &mut [u64; 4] = bytemuck::cast_mut(&mut self.0);
        array[lane] = if value { u64::MAX } else { 0 };
    }

    #[inline(always)]
    fn any(self) -> bool {
        intrinsic!(_mm256_movemask_pd(self.0)) != 0
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(intrinsic!(_mm256_and_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(intrinsic!(_mm256_or_pd(self.0, other.0)))
    }
}

impl Default for FourAvxMask {
    fn default() -> Self {
        Self::splat(false)
    }
}

impl PartialEq for FourAvxMask {
    fn eq(&self, other: &Self) -> bool {
        self.array() == other.array()
    }
}

impl fmt::Debug for FourAvxMask {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.array().map(|bits| bits != 0).fmt(f)
    }
}

impl Default for FourAvx {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl PartialEq for FourAvx {
    fn eq(&self, other: &Self) -> bool {
        self.array() == other.array()
    }
}

impl fmt::Debug for FourAvx {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.array().fmt(f)
    }
}

impl Lanes for FourAvx {
    type Alone = f64;

    #[inline(always)]
    fn put(&mut self, lane: usize, alone: &f64) {
        let array: &mut [f64; 4] = bytemuck::cast_mut(self);
        array[lane] = *alone;
    }
}

/// Operations by their instructions.
macro_rules! instructions {
    ($number:ident: $($trait:ident::$method:ident by $instruction:ident),+; $($assign:ident::$assigned:ident by $by:ident),+) => {
        $(impl $trait for $number {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(intrinsic!($instruction(self.0, other.0)))
            }
        })+
        $(impl $assign for $number {
            #[inline(always)]
            fn $assigned(&mut self, other: Self) {
                *self = self.$by(other);
            }
        })+
    };
}

pub(super) use instructions;

instructions!(
    FourAvx:
    Add::add by _mm256_add_pd, Sub::sub by _mm256_sub_pd, Mul::mul by _mm256_mul_pd, Div::div by _mm256_div_pd;
    AddAssign::add_assign by add, SubAssign::sub_assign by sub
);

impl Neg for FourAvx {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(intrinsic!(_mm256_xor_pd(self.0, _mm256_set1_pd(-0.0))))
    }
}

impl Number for FourAvx {
    const LANES: usize = 4;
    type Mask = FourAvxMask;

    #[inline(always)]
    fn dispatch<O: WithSimd>(op: O) -> O::Output {
        // SAFETY: these numbers are computed with only where this holds.
        Simd::vectorize(unsafe { V3::new_unchecked() }, op)
    }

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(intrinsic!(_mm256_set1_pd(value)))
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.array()[lane]
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self(intrinsic!(_mm256_fmadd_pd(self.0, factor.0, addend.0)))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(intrinsic!(_mm256_sqrt_pd(self.0)))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(intrinsic!(_mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0)))
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self(intrinsic!(_mm256_or_pd(self.abs().0, _mm256_and_pd(_mm256_set1_pd(-0.0), sign.0))))
    }

    #[inline(always)]
    fn less(self, other: Self) -> FourAvxMask {
        FourAvxMask(intrinsic!(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0)))
    }

    #[inline(always)]
    fn less_equal(self, other: Self) -> FourAvxMask {
        FourAvxMask(intrinsic!(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0)))
    }

    #[inline(always)]
    fn select(mask: FourAvxMask, yes: Self, no: Self) -> Self {
        Self(intrinsic!(_mm256_blendv_pd(no.0, yes.0, mask.0)))
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        // As for a number alone.
        let shifted = self + Self::splat(6_755_399_441_055_744.0 + 1023.0);
        Self(intrinsic!(_mm256_castsi256_pd(_mm256_slli_epi64::<52>(_mm256_castpd_si256(shifted.0)))))
    }

    #[inline(always)]
    fn mantissa_and_exponent(self) -> (Self, Self) {
        let one = Self::splat(1.0);
        let fraction = Self::splat(f64::from_bits((1 << 52) - 1));
        let mantissa = intrinsic!(_mm256_or_pd(_mm256_and_pd(self.0, fraction.0), one.0));
        let exponent = intrinsic!(_mm256_castsi256_pd(_mm256_srli_epi64::<52>(_mm256_castpd_si256(self.0))));
        // A small whole number in place of 2^52's last bits makes 2^52 plus that number.
        let whole = Self(intrinsic!(_mm256_or_pd(exponent, _mm256_set1_pd(4_503_599_627_370_496.0))));
        (Self(mantissa), whole - Self::splat(4_503_599_627_370_496.0 + 1023.0))
    }
}
