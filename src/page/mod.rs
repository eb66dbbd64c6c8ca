//! Pages of HTML that are one file each: data, drawing and style in it, and no request to any network.
//!
//! The scripts and the style are files in `src/assets/pages`. A page's bytes depend on the dataset alone.

mod blocks;
mod dataset;
mod rows;

pub use dataset::{MOST_ROWS, PageError, dataset_page};
