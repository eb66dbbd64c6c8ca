//! Pages of HTML that are one file each and need no network: a dataset to look through, a row to see at work, with data
//! as JSON and base64, drawn by the scripts in `src/assets/pages`; the quality of a reduction.

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

pub use dataset::{MOST_ROWS, PageOf, dataset_page};
pub use error::PageError;
pub use quality::quality_page;
pub use scene::{MeasuredCurve, MeasuredPiece, SceneView, scene_page};
