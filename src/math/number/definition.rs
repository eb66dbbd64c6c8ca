//! Traits of numbers, masks of lanes and constants per lane; implementation for a single number.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use pulp::{Arch, WithSimd};

/// Mask of lanes.
pub trait Mask: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// The same for all lanes.
    fn splat(value: bool) -> Self;
    /// Whether it holds for a lane.
    fn lane(self, lane: usize) -> bool;
    /// Sets a lane.
    fn put(&mut self, lane: usize, value: bool);
    /// Whether it holds for any lane.
    fn any(self) -> bool;
    /// Lanes in which both hold.
    #[must_use]
    fn and(self, other: Self) -> Self;
    /// Lanes in which at least one holds.
    #[must_use]
    fn or(self, other: Self) -> Self;
}

/// Holds one value per lane, or values of which each does.
pub trait Lanes {
    /// Type for a single row.
    type Alone;
    /// Sets a lane.
    fn put(&mut self, lane: usize, alone: &Self::Alone);
}

/// One number or several side by side; in memory the numbers of the lanes one after the other.
pub trait Number:
    bytemuck::Pod
    + Debug
    + Default
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Lanes<Alone = f64>
{
    /// Number of lanes.
    const LANES: usize;
    /// Result of comparisons.
    type Mask: Mask;

    /// Runs a computation over such numbers, inlined whole into code for the processor's widest registers that hold them.
    fn dispatch<O: WithSimd>(op: O) -> O::Output;
    /// The same number in all lanes.
    fn splat(value: f64) -> Self;
    /// The number in a lane.
    fn lane(self, lane: usize) -> f64;
    /// `self * factor + addend`, rounded once. Where it is inlined into code for a processor that has it, one instruction; a call of a
    /// library elsewhere, with the same result: for the kernels that are dispatched to the widest registers, and only there.
    #[must_use]
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Absolute value.
    #[must_use]
    fn abs(self) -> Self;
    /// Absolute value with the sign of `sign`.
    #[must_use]
    fn copysign(self, sign: Self) -> Self;
    /// Whether less; not for a NaN, as all comparisons.
    fn less(self, other: Self) -> Self::Mask;
    /// Whether less or equal.
    fn less_equal(self, other: Self) -> Self::Mask;
    /// `yes` where the mask holds, else `no`.
    #[must_use]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// `2^k` of whole numbers `k` from -1022 to 1023.
    #[must_use]
    fn power_of_two(self) -> Self;
    /// Mantissa in [1, 2) and exponent of positive normal numbers.
    #[must_use]
    fn mantissa_and_exponent(self) -> (Self, Self);

    /// Whether greater.
    #[inline(always)]
    fn greater(self, other: Self) -> Self::Mask {
        other.less(self)
    }

    /// Whether greater or equal.
    #[inline(always)]
    fn greater_equal(self, other: Self) -> Self::Mask {
        other.less_equal(self)
    }

    /// The lesser of both; `other` where one is a NaN.
    #[must_use]
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        Self::select(self.less(other), self, other)
    }

    /// The greater of both; `other` where one is a NaN.
    #[must_use]
    #[inline(always)]
    fn greatest(self, other: Self) -> Self {
        Self::select(self.greater(other), self, other)
    }
}

impl Mask for bool {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        value
    }

    #[inline(always)]
    fn lane(self, _: usize) -> bool {
        self
    }

    #[inline(always)]
    fn put(&mut self, _: usize, value: bool) {
        *self = value;
    }

    #[inline(always)]
    fn any(self) -> bool {
        self
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self & other
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self | other
    }
}

impl Lanes for f64 {
    type Alone = f64;

    #[inline(always)]
    fn put(&mut self, _: usize, alone: &f64) {
        *self = *alone;
    }
}

impl<T: Lanes, const N: usize> Lanes for [T; N] {
    type Alone = [T::Alone; N];

    fn put(&mut self, lane: usize, alone: &Self::Alone) {
        for (own, alone) in self.iter_mut().zip(alone) {
            own.put(lane, alone);
        }
    }
}

impl Number for f64 {
    const LANES: usize = 1;
    type Mask = bool;

    #[inline(always)]
    fn dispatch<O: WithSimd>(op: O) -> O::Output {
        Arch::new().dispatch(op)
    }

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self::mul_add(self, factor, addend)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.copysign(sign)
    }

    #[inline(always)]
    fn less(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn less_equal(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        // 1.5 * 2^52 + 1023 + k holds k + 1023 in its lowest bits.
        const SHIFT: f64 = 6_755_399_441_055_744.0 + 1023.0;
        Self::from_bits((self + SHIFT).to_bits() << 52)
    }

    #[inline(always)]
    fn mantissa_and_exponent(self) -> (Self, Self) {
        const ONE: u64 = 1023 << 52;
        const MANTISSA: u64 = (1 << 52) - 1;
        /// Bits of 2^52: a small whole number in its place makes 2^52 plus that number.
        const WHOLE: u64 = (1023 + 52) << 52;
        let bits = self.to_bits();
        let exponent = Self::from_bits(WHOLE | bits >> 52) - (4_503_599_627_370_496.0 + 1023.0);
        (Self::from_bits(bits & MANTISSA | ONE), exponent)
    }
}

/// The same constants in all lanes of `R`.
pub fn in_lanes<R: Number, T: Lanes + bytemuck::Zeroable>(alone: &T::Alone) -> T {
    let mut lanes = T::zeroed();
    (0..R::LANES).for_each(|lane| lanes.put(lane, alone));
    lanes
}

/// Declares constants of which each lane has its own: the struct over [`Number`] and its [`Lanes`].
#[macro_export]
macro_rules! per_lane {
    ($(#[$attribute:meta])* $visibility:vis struct $name:ident<$number:ident> {
        $($(#[$field_attribute:meta])* $field_visibility:vis $field:ident: $type:ty,)+
    }) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, bytemuck::Zeroable)]
        $visibility struct $name<$number> {
            $($(#[$field_attribute])* $field_visibility $field: $type,)+
        }

        impl<$number: $crate::number::Number> $crate::number::Lanes for $name<$number> {
            type Alone = $name<f64>;

            fn put(&mut self, lane: usize, alone: &Self::Alone) {
                $($crate::number::Lanes::put(&mut self.$field, lane, &alone.$field);)+
            }
        }
    };
}

pub use per_lane;
