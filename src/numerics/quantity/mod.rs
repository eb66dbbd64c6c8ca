//! Values with their kinds and units, and output quantities declared once: what every table, JSON file and text is made of.
//!
//! - [`Value`], [`Kind`]: a value from the study to the report, and its type; [`Cell`]: one where there may be none
//! - [`put_cell`], [`take_cell`]: a cell as bytes
//! - [`NumberColumn`]: the cells of a column of numbers
//! - [`Quantity`]: name, unit, description and getter of an output, made by `quantities!` from the field that holds it
//! - `named!`: closed sets of names, such as kinds and states

mod bytes;
mod declare;
mod named;
mod numbers;
mod value;

pub use bytes::{FREE_TAG, put_cell, take_cell};
pub use declare::{Quantity, QuantityField};
pub use declare::{first, quantities};
pub use named::named;
pub use numbers::{NumberColumn, Numbers};
pub use value::{Cell, Kind, Value};
