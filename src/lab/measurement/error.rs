//! Reasons why a measurement cannot be compared with a signal.

use decore_statistics::signal::SignalError;

/// Reason why a measurement cannot be compared with a signal.
#[derive(Debug, thiserror::Error)]
pub enum MeasurementError {
    /// The file cannot be read, or a cell is not a number.
    #[error("{0}")]
    File(String),
    /// Times do not rise.
    #[error("{place}: time {time_s} s is not after the one before, {before_s} s; times of a measurement rise")]
    Order {
        /// Place of the fault, in words.
        place: String,
        /// The time.
        time_s: f64,
        /// The one before.
        before_s: f64,
    },
    /// A measurement over a time that is too long.
    #[error(
        "the measurement goes from {from_s} to {to_s} s, which at {interval_s} s a sample are more than {most} samples: \
         keep only the part that you want to compare (are the times in s? `--time-column COLUMN:ms` reads ms)"
    )]
    Long {
        /// First time of the measurement.
        from_s: f64,
        /// Last time of the measurement.
        to_s: f64,
        /// Interval of the calculated signal.
        interval_s: f64,
        /// Most samples.
        most: usize,
    },
    /// Signal and measurement have no time in common.
    #[error(
        "with an offset of {offset_s} s the measurement lies from {from_s} to {to_s} s, the calculated signal from 0 to {duration_s} s: too \
         little in common (give another --offset-s)"
    )]
    Apart {
        /// The offset.
        offset_s: f64,
        /// Begin of the measurement on the calculated time.
        from_s: f64,
        /// End of the row.
        to_s: f64,
        /// End of the calculated signal.
        duration_s: f64,
    },
    /// Filtering and shifting.
    #[error("{0}")]
    Signal(#[from] SignalError),
}
