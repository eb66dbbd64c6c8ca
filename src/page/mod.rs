//! HTML pages, each a single file that needs no network: a dataset, a row with its motion, and the quality of a reduction. Data is JSON
//! and base64; the scripts in `src/assets/pages` draw it.

mod answer;
mod blocks;
mod dataset;
mod error;
mod knowledge;
mod model;
mod quality;
mod rows;
mod samples;
mod scene;
mod site;

pub use dataset::{MOST_ROWS, PageOf, dataset_page};
pub use error::PageError;
pub use quality::quality_page;
pub use scene::{MeasuredCurve, MeasuredPiece, SceneView, scene_page};
pub use site::{Extent, Site};
