//! Fused product and sum, for platforms where the compiler calls the C library for it.
//!
//! mingw's function rounds twice: a fifth of random operands are wrong in the last bit. The program's own function is linked first.

/// `x * y + z` as C names it.
// SAFETY: name and types equal the C library's function, which this one replaces.
#[unsafe(no_mangle)]
extern "C" fn fma(x: f64, y: f64, z: f64) -> f64 {
    libm::fma(x, y, z)
}
