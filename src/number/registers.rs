//! Which vector registers rows side by side are computed in.

use pulp::{Arch, WithSimd};

/// Vector registers that numbers of several rows stand in. All give the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Registers {
    /// Those of any processor of the platform: four rows, but on x86-64, whose code for any processor has no fused products and calls
    /// a library for each, rows one by one.
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

    /// How many rows.
    pub fn lanes(self) -> usize {
        match self {
            Self::Any if cfg!(target_arch = "x86_64") => 1,
            Self::Any | Self::Avx2 => 4,
            Self::Avx512 => 8,
        }
    }

    /// Those for a number of rows: half of the widest ones empty are slower than narrower ones.
    pub fn for_rows(self, rows: usize) -> Self {
        if self == Self::Avx512 && rows <= Self::Avx2.lanes() { Self::Avx2 } else { self }
    }

    /// The widest that this processor has.
    pub fn widest() -> Self {
        Self::ALL.into_iter().rfind(|registers| registers.are_available()).unwrap_or(Self::Any)
    }
}

/// Runs a computation over arrays of numbers in code for the widest registers that the processor has. The order of sums is that of
/// the computation, and so the result is the same with all.
pub fn on_widest<O: WithSimd>(op: O) -> O::Output {
    #[cfg(target_arch = "x86_64")]
    if super::avx512::is_available() {
        // SAFETY: just asked.
        return unsafe { super::avx512::run(op) };
    }
    Arch::new().dispatch(op)
}
