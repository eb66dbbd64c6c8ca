//! A state and its time.

/// A state of a scene's system at a time.
#[derive(Debug, Clone, Copy)]
pub struct Instant<'y> {
    /// Time, s.
    pub t: f64,
    /// The state.
    pub y: &'y [f64],
}
