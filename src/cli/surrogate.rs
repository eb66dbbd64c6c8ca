//! `decore surrogate` fits models of a dataset's outputs; `decore predict` predicts rows that were not run.

use std::path::PathBuf;

use clap::Args;

use super::exit::{Exit, Failure, write_file};
use super::inputs::expect_dataset;
use super::json::print_result;
use super::outputs::{Form, Output, check_outputs};
use super::text::eprint_line;
use super::written::Written;
use decore_dataset::{DatasetReader, write_table};
use decore_lab::surrogate::{PREDICTOR, SurrogateSettings};

#[derive(Debug, Args)]
pub(super) struct SurrogateArguments {
    /// Folder of the dataset
    dataset: PathBuf,
    /// Columns of the table of runs
    ///
    /// By default: delivered work, work of the first impacts, hit frequency, largest casting velocity and air.
    #[arg(long, num_args = 1.., value_name = "NAME")]
    outputs: Vec<String>,
    /// Write the models to this Parquet file, and predict.py to the same folder
    ///
    /// predict.py predicts with NumPy alone.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file of models
    #[arg(long, requires = "output")]
    replace: bool,
    /// Warn at each use of a model with a Q2 below this
    #[arg(long, default_value_t = SurrogateSettings::default().least_q2, value_name = "Q2", value_parser = share)]
    least_q2: f64,
    /// Print the quality of the models as JSON (schemas/surrogate.schema.json)
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
pub(super) struct PredictArguments {
    /// File of models from `decore surrogate --output`
    model: PathBuf,
    /// CSV or Parquet file with the places to predict
    ///
    /// It needs a column for each factor, with the factor's name or `factor_` and the name.
    table: PathBuf,
    /// Parquet file for the predictions
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    replace: bool,
    /// Print the list of written files as JSON (schemas/written.schema.json)
    #[arg(long)]
    json: bool,
}

/// Reads a Q2.
fn share(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "expected a number from 0 to 1, e.g. 0.9".to_owned())
}

pub(super) fn surrogate(arguments: &SurrogateArguments) -> Result<Exit, Failure> {
    expect_dataset(&arguments.dataset)?;
    let predictor = arguments.output.as_ref().map(|path| path.with_file_name("predict.py"));
    let outputs = [
        Output {
            flag: "--output",
            path: arguments.output.as_deref(),
            form: Form::File { endings: &["parquet"], replace: arguments.replace },
        },
        Output { flag: "--output", path: predictor.as_deref(), form: Form::Companion(PREDICTOR) },
    ];
    check_outputs(std::slice::from_ref(&arguments.dataset), &outputs)?;
    let reader = DatasetReader::open(&arguments.dataset)?;
    let (outputs, least_q2) = (arguments.outputs.clone(), arguments.least_q2);
    let settings = SurrogateSettings { outputs, least_q2, ..SurrogateSettings::default() };
    let model = decore_lab::surrogate::fit(&reader, &settings)?;
    model.check()?;
    if let (Some(path), Some(predictor)) = (&arguments.output, &predictor) {
        decore_lab::surrogate::write(&model, path)?;
        write_file(predictor, PREDICTOR)?;
    }
    print_result(arguments.json, &model.surrogate, || model.surrogate.to_string())?;
    model.surrogate.warnings().iter().for_each(|warning| eprint_line(&format_args!("warning: {warning}")));
    Ok(Exit::Done)
}

pub(super) fn predict(arguments: &PredictArguments) -> Result<Exit, Failure> {
    let output = Output {
        flag: "--output",
        path: Some(&arguments.output),
        form: Form::File { endings: &["parquet"], replace: arguments.replace },
    };
    check_outputs(&[arguments.model.clone(), arguments.table.clone()], &[output])?;
    let model = decore_lab::surrogate::read(&arguments.model)?;
    let predicted = decore_lab::surrogate::predict(&model, &arguments.table)?;
    write_table(&arguments.output, &model.info, "predictions", &predicted.columns)?;
    let (rows, path) = (predicted.rows, arguments.output.display());
    let mut written = Written::default();
    written.table("predictions", &arguments.output, rows)?;
    predicted.warnings(&model).into_iter().for_each(|warning| written.warn(warning));
    written.print(arguments.json, &format_args!("{rows} rows predicted: {path}"))?;
    Ok(Exit::Done)
}
