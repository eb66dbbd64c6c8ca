//! From a study to rows that run: what a program that embeds decore begins with, and what every command stands on.
//!
//! ```text
//! Study --points, constraints--> CheckedStudy --machines reduced--> Engine --> scene, outcome, signals, dataset
//! ```
//!
//! A [`Study`](crate::study::Study) is what a file says. A [`CheckedStudy`](crate::study::CheckedStudy) knows the interface points
//! of its machine; only it has rows, as constraints may ask where points are. An [`Engine`] has the machines reduced to what the
//! rows use. Nothing here prints, draws or ends the process: a sweep tells a closure of [`SweepEvent`]s and stops by a flag.
//!
//! ```
//! use std::path::Path;
//!
//! use decore::engine::{Engine, Rows, SweepEvent, SweepSettings};
//!
//! # let folder = tempfile::tempdir()?;
//! let settings = ["duration_s=0.15".to_owned()];
//! let engine = Engine::load(Path::new("studies/pressure_grid.toml"), &settings)?;
//! println!("row 3: {:?}, {:?}", engine.checked().row_values(3), engine.scene(3)?.scene.hammers[0].mount);
//! let (outcome, signals) = engine.outcome_with_signals(3, 1e-4)?;
//! let listener = |event: SweepEvent<'_>| println!("{event:?}");
//! let status = engine.run(folder.path(), &SweepSettings { listener: &listener, ..SweepSettings::default() })?;
//!
//! assert!(outcome.metrics.is_some() && signals.is_some_and(|signals| signals[0].values.len() == 1501));
//! assert_eq!((status.rows_done, status.rows_failed), (8, 0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod design_table;
mod error;
mod event;
mod info;
mod inputs;
mod machine;
mod monitor;
mod prepared;
mod signals;
mod stub;
mod sweep;

pub use design_table::design_table;
pub use error::EngineError;
pub use event::{Listener, SweepEvent};
pub use machine::{Machine, SourceModel, reduction_settings};
pub use prepared::{Engine, RowScene, Rows, checked};
pub use stub::StubRows;
pub use sweep::{SweepSettings, sweep};
