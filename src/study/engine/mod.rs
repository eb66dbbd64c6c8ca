//! From a study to rows that run: what a program that embeds decore begins with, and what every command stands on.
//!
//! ```text
//! Study --points, constraints--> CheckedStudy --machines reduced--> Engine --> scene, outcome, signals, dataset
//! ```
//!
//! A [`Study`](crate::Study) is what a file says. A [`CheckedStudy`](crate::CheckedStudy) knows the interface points
//! of its machine; only it has rows, as constraints may ask where points are. An [`Engine`] has the machines reduced to what the
//! rows use. Nothing here prints, draws or ends the process: a sweep tells a closure of [`SweepEvent`]s and stops by a flag.

mod course;
mod design_table;
mod error;
mod event;
mod info;
mod inputs;
mod machine;
mod monitor;
mod prepared;
mod repeats;
mod sample;
mod signals;
mod stub;
mod sweep;

pub use course::{Course, Verdict, pursue};
pub use design_table::design_table;
pub use error::EngineError;
pub use event::SweepEvent;
pub use machine::{ElasticCastings, Machine, SourceModel, reduction_settings};
pub use prepared::{Engine, RowRunner, RowScene, checked};
pub use repeats::{MOST_COMPARED, Repeats};
pub use stub::StubRows;
pub use sweep::{SweepSettings, sweep};
