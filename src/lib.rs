//! decore: coupled simulation of pneumatic de-coring hammers, castings and a reduced machine structure, and designs of
//! experiments over it.
//!
//! # The flow
//!
//! ```text
//! study file --study--> design row --study--> Scene --+
//!                                                     +--system--> CoupledModel --integrate--> steps, events
//! matrices --structure--> ReducedStructure --modes----+                                            |
//!                                                                                               metrics
//!          tables <--dataset-- RowOutcome <--run------------------------------------------------------+
//!             |
//!             +--report--> summary
//!             +--comparison--> difference of two
//!             +--sensitivity, analysis--> indices of the factors
//!             +--surrogate, regression--> models, which predict rows not run
//!             +--features--> flat table for predictors of others
//!             +--refinement--> rows to run next
//!             +--best--> the factors to choose
//! ```
//!
//! A row's outcome depends on (study, seed, row) alone: [`run::run_row`] is a pure function of a scene and the structure's
//! modes, and [`study::CheckedStudy::scene`] one of the study and the row's index.
//!
//! # Five packages
//!
//! What knows nothing of hammers and machines is the package `decore-ground` in `src/ground/`: designs, indices of plain numbers,
//! signals. What computes is `decore-numerics` in `src/numerics/`: a row from its scene and machine to its outputs, and regressions.
//! Both are fully optimised. The tables that every row goes into are `decore-tables` in
//! `src/tables/`, optimised well. What a study takes besides, from its file to its rows, is `decore-core` in `src/core/`: it works
//! once per row or study and is optimised a little. This package reads and prints, and is not optimised at all: more would lengthen
//! a first build and save nobody time (`Cargo.toml`, profiles). The modules of all stand here under their names too, and programs
//! need not know of them:
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
//!
//! # Who may import whom
//!
//! One way only; a test holds the `use crate::` lines to this table. A module not named on the right is not imported.
//! Within a module the files import each other one way too.
//!
//! ```text
//! decore-ground
//! analysis    : quantity random
//! design      : random
//! files       :
//! quantity    :
//! random      :
//! signal      :
//! words       :
//!
//! decore-numerics
//! linalg      : number
//! number      :
//! parameter   :
//! regression  : design linalg number random
//! contact     : number parameter
//! workpiece   : parameter
//! hammer      : contact number parameter
//! integrate   : number quantity
//! structure   : files linalg parameter words
//! scene       : contact hammer integrate parameter quantity structure workpiece
//! system      : contact hammer integrate number scene workpiece
//! metrics     : design hammer integrate quantity scene system
//! run         : integrate metrics number quantity scene system
//!
//! decore-tables
//! dataset     : design files integrate metrics quantity run words
//!
//! decore-core
//! expression  :
//! study       : contact design expression files hammer parameter quantity scene structure words workpiece
//! engine      : dataset design integrate metrics quantity random run scene structure study system words
//! features    : dataset design files metrics quantity random run signal study
//!
//! decore
//! guide       :
//! plot        :
//! measurement : metrics signal study
//! accuracy    : integrate metrics plot quantity run scene system
//! report      : dataset metrics quantity run
//! comparison  : dataset quantity run
//! paper       : engine measurement metrics plot run scene signal study system
//! sensitivity : analysis dataset design metrics quantity run study
//! surrogate   : dataset files number quantity random regression sensitivity study
//! page        : dataset hammer metrics plot quantity report run scene sensitivity signal structure surrogate
//! best        : dataset design expression quantity random refinement regression run sensitivity study surrogate
//! refinement  : dataset design quantity random regression sensitivity study surrogate
//! python      : analysis dataset design engine metrics quantity run sensitivity study surrogate words
//! cli         : accuracy analysis best comparison dataset design engine features files guide integrate measurement metrics page paper plot quantity refinement report run scene sensitivity structure study surrogate system words
//! ```
//!
//! - [`random`]: random numbers addressed by position.
//! - [`quantity`]: one type of value; names, units and texts of outputs, declared once.
//! - [`linalg`]: dense and sparse factorisations and eigenpairs; the only module that calls faer.
//! - [`number`]: one number or several in the lanes of a vector, what a row's arithmetic is written over.
//! - [`parameter`]: parameters declared once, with unit, default, range and source.
//! - [`contact`], [`hammer`], [`workpiece`], [`structure`]: components that know nothing of each other.
//! - [`expression`]: arithmetic and logic over names, for constraints and derived factors.
//! - [`scene`]: all that one row needs, as plain data.
//! - [`system`]: the coupled model; its builder is the only part that knows scenes.
//! - [`integrate`]: time integration of piecewise smooth systems; never sees a hammer.
//! - [`metrics`]: outputs, computed while a run goes on.
//! - [`design`], [`study`]: rows of a design, addressable by (seed, row); the study file as typed and as resolved.
//! - [`run`]: one row, the parallel batch.
//! - [`accuracy`]: speed against error on a scene.
//! - [`dataset`], [`report`]: the tables and what is read from them.
//! - [`comparison`]: the difference of two datasets.
//! - [`analysis`], [`sensitivity`]: which factor matters: of plain tables of numbers, and of a dataset.
//! - [`regression`], [`surrogate`]: what a row not run would give: of plain tables of numbers, and of a dataset.
//! - [`features`]: the flat table that a predictor is trained on, its dictionary, groups and splits.
//! - [`refinement`]: which rows to run next, from what those before gave.
//! - [`best`]: the factors to choose by the study's goal, and how sure that is.
//! - [`engine`]: a study made ready to run: checked, its machines reduced; what a program that embeds decore begins with.
//! - [`files`]: files of others, read up to the size of their kind.
//! - [`guide`]: pages for users, as `decore help` prints them.
//! - [`page`]: pages of HTML that are one file each.
//! - [`paper`]: the publication that the model follows, beside what decore gives for its rig.
//! - [`plot`]: charts and scatter matrices as SVG; the only module that calls plotters.
//! - [`signal`]: signals, measured ones beside calculated ones: spectrum, filter, density, lost samples, shift in time.
//! - [`measurement`]: a measured channel beside a calculated signal.
//! - [`words`]: the name that a mistyped one stands for; names of a study as columns have them.
//! - [`cli`]: one file per command.
//! - `python`: the module of the Python package; with the feature of that name alone.
//!
//! # The same bytes on every system
//!
//! What a row's figures come from is computed with IEEE 754's operations, libm's functions and those of [`number`]: a platform's
//! own exponential or sine differs in the last bit, and several hammers on a casting amplify that. `clippy.toml` names the
//! functions that are refused for it; a module below is allowed them where it only describes, draws or analyses what rows gave,
//! and tests are.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod accuracy;
#[allow(clippy::disallowed_methods)]
pub mod best;
#[allow(clippy::disallowed_methods)]
pub mod cli;
pub mod comparison;
pub mod guide;
#[allow(clippy::disallowed_methods)]
pub mod measurement;
#[allow(clippy::disallowed_methods)]
pub mod page;
#[allow(clippy::disallowed_methods)]
pub mod paper;
#[allow(clippy::disallowed_methods)]
pub mod plot;
#[cfg(feature = "python")]
#[allow(clippy::disallowed_methods)]
pub mod python;
#[allow(clippy::disallowed_methods)]
pub mod refinement;
#[allow(clippy::disallowed_methods)]
pub mod report;
#[allow(clippy::disallowed_methods)]
pub mod sensitivity;
#[allow(clippy::disallowed_methods)]
pub mod surrogate;

pub use decore_core::{
    analysis, contact, dataset, design, engine, expression, features, files, hammer, integrate, linalg, metrics,
    number, parameter, quantity, random, regression, run, scene, signal, structure, study, system, words, workpiece,
};
