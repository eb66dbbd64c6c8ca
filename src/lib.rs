//! decore simulates pneumatic de-coring hammers, castings and a reduced machine structure as one coupled system, and runs designs of
//! experiments over it.
//!
//! # The library
//!
//! To embed decore, use three modules: [`study`] reads study files, [`engine`] runs their rows, [`dataset`] reads and writes the tables.
//!
//! ```
//! use std::path::Path;
//!
//! use decore::engine::{Engine, RowRunner, SweepEvent, SweepSettings};
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
//!
//! # Packages
//!
//! ```text
//! decore-files       files read up to a size, written whole
//! decore-quantity    values, units, declared outputs, names
//! decore-math        numbers in lanes, linear algebra, random numbers, special functions
//! decore-statistics  designs, sensitivity indices, regression, signals
//! decore-model       one row: scene -> coupled model -> steps -> outputs
//! decore-dataset     the tables
//! decore-study       study files, the engine
//! decore-lab         reports, comparison, sensitivity, surrogates, refinement, features
//! decore             command line, pages, plots, Python
//! ```
//!
//! Each package imports only the packages above it. `ARCHITECTURE.md` shows the flow of a row through them. A row's outcome depends only
//! on (study, seed, row).
//!
//! # The same bytes on every system
//!
//! Rows use only IEEE 754 operations and functions of libm and `decore_math::number`. A platform's own exponential or sine differs in the
//! last bit, and several hammers on one casting amplify this difference. `clippy.toml` lists the functions that are forbidden for this
//! reason. Modules that describe, draw or analyse rows may use them.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod accuracy;
#[allow(clippy::disallowed_methods)]
pub mod cli;
pub mod guide;
#[allow(clippy::disallowed_methods)]
pub mod page;
#[allow(clippy::disallowed_methods)]
pub mod paper;
#[allow(clippy::disallowed_methods)]
pub mod plot;
#[cfg(feature = "python")]
#[allow(clippy::disallowed_methods)]
pub mod python;

pub use decore_dataset as dataset;
pub use decore_study as study;
pub use decore_study::engine;
