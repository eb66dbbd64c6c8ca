//! Four numbers side by side that panic where one is compared that they do not bear.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use std::sync::atomic::{AtomicU64, Ordering};

use bytemuck::{Pod, Zeroable};
use decore_math::number::{Four, FourMask, Lanes, Number};
use pulp::WithSimd;

static BREAKING: AtomicU64 = AtomicU64::new(0);
static BROKE: AtomicU64 = AtomicU64::new(0);

/// As [`Four`], but for one number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Fragile(Four);

impl Fragile {
    /// The number that is not borne, which must not be 0.
    pub fn breaks_at(number: f64) {
        BREAKING.store(number.to_bits(), Ordering::SeqCst);
    }

    /// How often it was met.
    pub fn broke() -> u64 {
        BROKE.load(Ordering::SeqCst)
    }

    fn checked(self) -> Self {
        let breaking = BREAKING.load(Ordering::Relaxed);
        if breaking != 0 && (0..Self::LANES).any(|lane| self.lane(lane).to_bits() == breaking) {
            BROKE.fetch_add(1, Ordering::SeqCst);
            panic!("a number that is not borne");
        }
        self
    }
}

impl Lanes for Fragile {
    type Alone = f64;

    fn put(&mut self, lane: usize, alone: &f64) {
        self.0.put(lane, alone);
    }
}

/// Operations as those of the lanes.
macro_rules! as_lanes {
    ($($trait:ident::$method:ident),+; $($assign:ident::$assigned:ident),+) => {
        $(impl $trait for Fragile {
            type Output = Self;

            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        })+
        $(impl $assign for Fragile {
            fn $assigned(&mut self, other: Self) {
                self.0.$assigned(other.0);
            }
        })+
    };
}

as_lanes!(Add::add, Sub::sub, Mul::mul, Div::div; AddAssign::add_assign, SubAssign::sub_assign);

impl Neg for Fragile {
    type Output = Self;

    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Number for Fragile {
    const LANES: usize = Four::LANES;
    type Mask = FourMask;

    fn dispatch<O: WithSimd>(op: O) -> O::Output {
        Four::dispatch(op)
    }

    fn splat(value: f64) -> Self {
        Self(Four::splat(value))
    }

    fn lane(self, lane: usize) -> f64 {
        self.0.lane(lane)
    }

    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self(self.0.mul_add(factor.0, addend.0))
    }

    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    fn copysign(self, sign: Self) -> Self {
        Self(self.0.copysign(sign.0))
    }

    fn less(self, other: Self) -> FourMask {
        self.0.less(other.0)
    }

    fn less_equal(self, other: Self) -> FourMask {
        self.checked().0.less_equal(other.checked().0)
    }

    fn select(mask: FourMask, yes: Self, no: Self) -> Self {
        Self(Four::select(mask, yes.0, no.0))
    }

    fn power_of_two(self) -> Self {
        Self(self.0.power_of_two())
    }

    fn mantissa_and_exponent(self) -> (Self, Self) {
        let (mantissa, exponent) = self.0.mantissa_and_exponent();
        (Self(mantissa), Self(exponent))
    }
}
