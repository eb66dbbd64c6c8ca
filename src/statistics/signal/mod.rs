//! Comparison of measured with calculated signals: plain slices in, plain data out.
//!
//! - [`Spectrum`]: amplitudes of a signal's frequencies
//! - [`Butterworth`]: a low-pass, and filtering that shifts nothing in time
//! - [`welch`]: power spectral density
//! - [`spikes`]: samples that a vibrometer lost; they are marked, not changed
//! - [`offset`]: delay of a measurement, by cross-correlation
//! - [`relative_difference`], [`rms`], [`peak`], [`dominant_frequency_hz`]: compared figures
//!
//! Filter and density agree with `scipy.signal`. Crates that port them panic on bad input (sci-rs 0.4), or filter with the quotient of two
//! polynomials (butterworth 0.1), which loses digits at low cut-off frequencies.

mod butterworth;
mod compare;
mod error;
mod offset;
mod spectrum;
mod spikes;
mod transform;
mod welch;

pub use butterworth::Butterworth;
pub use compare::{dominant_frequency_hz, peak, relative_difference, rms};
pub use error::SignalError;
pub use offset::{Grid, Offset, Offsets, offset, resampled};
pub use spectrum::Spectrum;
pub use spikes::spikes;
pub use welch::{Density, welch};
