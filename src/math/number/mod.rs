//! One number, or several in the lanes of a vector: the type of a row's arithmetic.
//!
//! The equations of hammers, contacts, structure and integrator are written once over [`Number`]. With `f64` they advance one row, with
//! [`Four`] four rows in the lanes of a vector, each with its own numbers. No operation reads another lane. Each operation is an IEEE 754
//! sum, difference, product (or both fused), quotient or square root, a comparison, a choice, or an operation on bits. So a lane has the
//! same bits as a single number, on every processor and operating system. Functions of a platform's mathematical library are therefore not
//! used; `exp`, `ln`, `tanh` and powers are this module's own. Long sums of products are fused, which is exact on every processor and one
//! instruction on processors of the last ten years. Processors without it are slow. All other products and sums are rounded one by one.
//!
//! - `definition`: the traits, and a number alone
//! - `lanes`: [`Four`] and the operations on its lanes
//! - `avx`: the same in one register of a processor with AVX2 and FMA
//! - `avx512`: eight in one register of a processor with AVX-512
//! - `registers`: which of them a processor has
//! - `functions`: exponential function, logarithm, hyperbolic tangent, power
//! - `fused`: for systems whose library does not round fused products once

#[cfg(target_arch = "x86_64")]
mod avx;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod definition;
mod functions;
#[cfg(all(windows, target_env = "gnu"))]
mod fused;
mod lanes;
mod registers;

#[cfg(target_arch = "x86_64")]
pub use avx::FourAvx;
#[cfg(target_arch = "x86_64")]
pub use avx512::EightAvx;
pub use definition::per_lane;
pub use definition::{Lanes, Mask, Number, in_lanes};
pub use functions::{exp, ln, odd_power, tanh};
pub use lanes::{Four, FourMask};
pub use registers::Registers;
pub use registers::{OverArrays, in_widest, load, store};
