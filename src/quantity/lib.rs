//! Values with their kinds and units, and output quantities that are declared once for all tables, JSON files and texts.
//!
//! - [`Value`], [`Kind`]: a value from the study to the report, and its type; [`Cell`]: one where there may be none
//! - [`put_cell`], [`take_cells`]: cells as bytes, and those of a row off them to the columns of their table
//! - [`CellColumn`]: the cells of a column
//! - [`Quantity`]: name, unit, description and getter of an output, made by `quantities!` from the field that holds it
//! - [`units`]: units of keys by their names, and conversions to them
//! - `named!`: closed sets of names, such as kinds and states

mod bytes;
mod column;
mod declare;
mod named;
pub mod units;
mod value;
pub mod words;

pub use bytes::{FREE_TAG, put_cell};
pub use column::{CellColumn, ColumnValues, take_cells};
pub use declare::first;
pub use declare::{Quantity, QuantityField};
pub use value::{Cell, Kind, Value};
