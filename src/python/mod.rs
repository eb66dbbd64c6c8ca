//! Module of the Python package `decore`: the functions of [`decore_study::engine`] and [`decore_dataset`] that the command line uses,
//! for notebooks and programs. The Python part with all types is in `decore/` next to this file.
//!
//! The interpreter is released during simulation, reading and writing. Conversions between values and Python objects hold it; other
//! threads get their turn every few milliseconds.

mod command;
mod dataset;
mod error;
mod factor;
mod frame;
mod function;
mod ready;
mod row;
mod study;
mod surrogate;
mod sweep;
mod table;
mod value;
mod wait;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use decore_model::run::thread_count;

/// Opens the dataset in a folder.
///
/// >>> decore.open(dataset.folder).rows_done
/// 24
#[pyfunction]
fn open(py: Python<'_>, dataset: value::FilePath) -> PyResult<dataset::Dataset> {
    dataset::Dataset::open(py, &dataset.0)
}

#[pymodule]
fn _decore(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    wait::imported();
    // Also for threads that rayon starts by itself, without a limit.
    thread_count(0).map_err(|error| PyValueError::new_err(error.to_string()))?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(open, module)?)?;
    // `pickle` calls names that are not in the package.
    module.setattr("_problem", wrap_pyfunction!(error::problem, module)?)?;
    module.setattr("_function", wrap_pyfunction!(function::unpickled, module)?)?;
    module.setattr("_models", wrap_pyfunction!(surrogate::unpickled, module)?)?;
    module.setattr("_commands", wrap_pyfunction!(command::commands, module)?)?;
    module.setattr("_call", wrap_pyfunction!(command::call, module)?)?;
    module.setattr("_study", wrap_pyfunction!(study::unpickled, module)?)?;
    module.add_class::<study::Study>()?;
    module.add_class::<factor::Factor>()?;
    module.add_class::<row::Row>()?;
    module.add_class::<function::Function>()?;
    module.add_class::<sweep::Progress>()?;
    module.add_class::<dataset::Dataset>()?;
    module.add_class::<surrogate::Surrogate>()?;
    module.add_class::<table::Table>()?;
    module.add_class::<table::Column>()?;
    module.add_class::<error::Problem>()?;
    module.add("Error", py.get_type::<error::Error>())?;
    module.add("StudyError", py.get_type::<error::StudyError>())?;
    module.add("MachineError", py.get_type::<error::MachineError>())?;
    module.add("DatasetError", py.get_type::<error::DatasetError>())?;
    module.add("SweepError", py.get_type::<error::SweepError>())?;
    module.add("StudyWarning", py.get_type::<error::StudyWarning>())?;
    module.add("PredictionWarning", py.get_type::<error::PredictionWarning>())
}
