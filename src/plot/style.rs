//! Colours, and errors of the plotting library.

/// A colour as red, green and blue.
pub type Color = (u8, u8, u8);

/// Colours that colour-blind readers can distinguish (Okabe and Ito 2008), and a grey.
pub const COLORS: [Color; 7] =
    [(0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (86, 180, 233), (230, 159, 0), (110, 110, 110)];
/// Colour of bounds and floors.
pub const BLACK: Color = (0, 0, 0);

/// Message of the plotting library for a picture that could not be drawn.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("failed to draw: {0}")]
pub struct PlotError(String);

impl PlotError {
    pub(super) fn of(error: impl std::fmt::Display) -> Self {
        Self(error.to_string())
    }
}
