//! Reasons why signals cannot be treated.

/// Reason why a signal could not be treated.
#[derive(Debug, thiserror::Error)]
pub enum SignalError {
    /// A filter that cannot be designed.
    #[error("a low-pass of order {order} at {cutoff_hz} Hz for {rate_hz} samples a second: {expected}")]
    Filter {
        /// Order asked for.
        order: usize,
        /// Cut-off frequency asked for in Hz.
        cutoff_hz: f64,
        /// Samples a second.
        rate_hz: f64,
        /// Expected value.
        expected: &'static str,
    },
    /// A signal that is too short.
    #[error("a signal of {samples} samples, where at least {least} are needed to {purpose}")]
    Short {
        /// Samples of the signal.
        samples: usize,
        /// Least number.
        least: usize,
        /// Purpose of the samples.
        purpose: &'static str,
    },
}
