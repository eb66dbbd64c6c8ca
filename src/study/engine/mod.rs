//! Runs the rows of a study: the entry point for programs that embed decore, and the basis of every command.
//!
//! ```text
//! Study --points, constraints--> CheckedStudy --machines reduced--> Engine --> scene, outcome, signals, dataset
//! ```
//!
//! A [`Study`](crate::Study) is the content of a file. A [`CheckedStudy`](crate::CheckedStudy) knows the interface points of its machine.
//! Only it has rows, because constraints may use the positions of points. An [`Engine`] has the machines, reduced for the rows. Nothing
//! here prints, draws or ends the process: a sweep reports [`SweepEvent`]s to a closure and stops by a flag.

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
