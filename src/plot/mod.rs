//! SVG pictures in one style: charts, stacked panels, scatter matrices, and a page for them.
//!
//! Every axis has a name with its unit, ticks have short labels, and legends are next to the data, never over them.

mod axis;
mod chart;
mod document;
mod matrix;
mod style;
mod thin;

pub use axis::Axis;
pub use chart::{Chart, Line, Marker, Series, panels};
pub use document::{document, escape};
pub use matrix::{MatrixFactor, scatter_matrix};
pub use style::{BLACK, COLORS, Color, PlotError};
pub use thin::thinned;
