//! Choice of the vector registers for rows in lanes.

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};

use super::definition::Number;

/// Vector registers that numbers of several rows stand in. All give the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Registers {
    /// Registers that every processor of the platform has: four rows. On x86-64 row by row, because code for every processor has no fused
    /// products, and calls a library for each.
    Any,
    /// Four rows, in the registers of AVX2 with fused products.
    Avx2,
    /// Eight rows, in the registers of AVX-512.
    Avx512,
}

impl Registers {
    /// All, the widest last.
    pub const ALL: [Self; 3] = [Self::Any, Self::Avx2, Self::Avx512];

    /// Whether this processor has them.
    pub fn are_available(self) -> bool {
        match self {
            Self::Any => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => super::avx::is_available(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => super::avx512::is_available(),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// Number of rows.
    pub fn lanes(self) -> usize {
        match self {
            Self::Any if cfg!(target_arch = "x86_64") => 1,
            Self::Any | Self::Avx2 => 4,
            Self::Avx512 => 8,
        }
    }

    /// Chooses registers for a number of rows: half-empty wide registers are slower than narrower ones.
    pub fn for_rows(self, rows: usize) -> Self {
        if self == Self::Avx512 && rows <= Self::Avx2.lanes() { Self::Avx2 } else { self }
    }

    /// The widest that this processor has.
    pub fn widest() -> Self {
        Self::ALL.into_iter().rfind(|registers| registers.are_available()).unwrap_or(Self::Any)
    }
}

/// A computation over arrays of numbers in registers: `W` the widest of the processor, `Q` with at most four numbers. Both give the same
/// bits if each number of a register is computed separately.
pub trait OverArrays {
    /// Result type.
    type Output;
    /// The computation, to be inlined whole into code for these registers.
    fn compute<W: Number, Q: Number>(self) -> Self::Output;
}

/// Runs a computation over arrays in the registers that the processor has.
pub fn in_widest<C: OverArrays>(computation: C) -> C::Output {
    #[cfg(target_arch = "x86_64")]
    match Registers::widest() {
        Registers::Avx512 => {
            super::EightAvx::dispatch(Within::<C, super::EightAvx, super::FourAvx>(computation, PhantomData))
        }
        Registers::Avx2 => {
            super::FourAvx::dispatch(Within::<C, super::FourAvx, super::FourAvx>(computation, PhantomData))
        }
        Registers::Any => computation.compute::<f64, f64>(),
    }
    #[cfg(not(target_arch = "x86_64"))]
    super::Four::dispatch(Within::<C, super::Four, super::Four>(computation, PhantomData))
}

/// A computation in registers of some kind.
struct Within<C, W, Q>(C, PhantomData<(W, Q)>);

impl<C: OverArrays, W: Number, Q: Number> WithSimd for Within<C, W, Q> {
    type Output = C::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> C::Output {
        self.0.compute::<W, Q>()
    }
}

/// As many numbers of an array as a register holds, from `first` on.
#[inline(always)]
pub fn load<R: Number>(numbers: &[f64], first: usize) -> R {
    bytemuck::pod_read_unaligned(bytemuck::cast_slice(&numbers[first..first + R::LANES]))
}

/// Puts the numbers of a register into an array, from `first` on.
#[inline(always)]
pub fn store<R: Number>(register: R, numbers: &mut [f64], first: usize) {
    let own: &mut [u8] = bytemuck::cast_slice_mut(&mut numbers[first..first + R::LANES]);
    own.copy_from_slice(bytemuck::bytes_of(&register));
}
