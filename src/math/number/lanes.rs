//! Four numbers side by side.
//!
//! Plain arrays: the compiler puts each operation on all lanes into vector registers where it is inlined into code for a
//! processor that has them.

use std::array::from_fn;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use bytemuck::{Pod, Zeroable};
use pulp::WithSimd;

use super::definition::{Lanes, Mask, Number};

/// Lanes of [`Four`].
const LANES: usize = 4;

/// Four numbers side by side.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Four([f64; LANES]);

/// Mask of four lanes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FourMask([bool; LANES]);

impl Mask for FourMask {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        self.0[lane]
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, value: bool) {
        self.0[lane] = value;
    }

    #[inline(always)]
    fn any(self) -> bool {
        self.0[0] | self.0[1] | self.0[2] | self.0[3]
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(from_fn(|lane| self.0[lane] & other.0[lane]))
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(from_fn(|lane| self.0[lane] | other.0[lane]))
    }
}

impl Lanes for Four {
    type Alone = f64;

    #[inline(always)]
    fn put(&mut self, lane: usize, alone: &f64) {
        self.0[lane] = *alone;
    }
}

/// Operations on each lane.
macro_rules! lanewise {
    ($($trait:ident::$method:ident),+; $($assign:ident::$assigned:ident by $by:ident),+) => {
        $(impl $trait for Four {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(from_fn(|lane| $trait::$method(self.0[lane], other.0[lane])))
            }
        })+
        $(impl $assign for Four {
            #[inline(always)]
            fn $assigned(&mut self, other: Self) {
                *self = self.$by(other);
            }
        })+
    };
}

lanewise!(Add::add, Sub::sub, Mul::mul, Div::div; AddAssign::add_assign by add, SubAssign::sub_assign by sub);

impl Neg for Four {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|value| -value))
    }
}

impl Number for Four {
    const LANES: usize = LANES;
    type Mask = FourMask;

    /// In code for any processor of the platform: those with wider registers have numbers of their own.
    #[inline(always)]
    fn dispatch<O: WithSimd>(op: O) -> O::Output {
        op.with_simd(pulp::Scalar::new())
    }

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        let mut fused = addend;
        for lane in 0..LANES {
            fused.0[lane] = self.0[lane].mul_add(factor.0[lane], addend.0[lane]);
        }
        fused
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self(from_fn(|lane| self.0[lane].copysign(sign.0[lane])))
    }

    #[inline(always)]
    fn less(self, other: Self) -> FourMask {
        FourMask(from_fn(|lane| self.0[lane] < other.0[lane]))
    }

    #[inline(always)]
    fn less_equal(self, other: Self) -> FourMask {
        FourMask(from_fn(|lane| self.0[lane] <= other.0[lane]))
    }

    #[inline(always)]
    fn select(mask: FourMask, yes: Self, no: Self) -> Self {
        Self(from_fn(|lane| if mask.0[lane] { yes.0[lane] } else { no.0[lane] }))
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        Self(self.0.map(Number::power_of_two))
    }

    #[inline(always)]
    fn mantissa_and_exponent(self) -> (Self, Self) {
        let both = self.0.map(Number::mantissa_and_exponent);
        (Self(both.map(|both| both.0)), Self(both.map(|both| both.1)))
    }
}
