//! Writing a model in an exchange format.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use sprs::CsMat;

use super::dofs;
use super::entry::{Named, RowLabels};
use super::formats::ExportFormat;
use super::source::{MatrixFile, ModelFiles, Units};
use crate::structure::error::StructureError;
use crate::structure::label::repeated;
use crate::structure::model::FeModel;

/// Writes the matrices of a model, in SI units, with the list of rows and the table of points, into a folder. Returns the settings to read
/// it.
///
/// # Errors
/// A format that needs labels of rows for a model without them or with some twice, node numbers that Nastran does not have, files that
/// cannot be
/// written.
pub fn write_model(model: &FeModel, export: ExportFormat, folder: &Path) -> Result<ModelFiles, StructureError> {
    let labels = model.labels();
    let form = export.form;
    if labels.is_empty() && form.rows != RowLabels::Unused {
        let found = "a model without them (name a dof_file or dofs_per_node)";
        return Err(StructureError::argument("export format", "nodes and directions of the rows", found));
    }
    if form.rows == RowLabels::NumberedFromOne
        && let Some(label) = labels.iter().find(|label| label.node < 1)
    {
        let what = format!("export format {}", form.name);
        let found = format!("node {}", label.node);
        return Err(StructureError::argument(what, "nodes numbered from 1 on, as Nastran has them", found));
    }
    if matches!(form.rows, RowLabels::Distinct | RowLabels::NumberedFromOne)
        && let Some(([first, second], label)) = repeated(labels)
    {
        let what = format!("export format {}", form.name);
        let found = format!("node {} direction {} in rows {first} and {second}", label.node, label.dof + 1);
        return Err(StructureError::argument(what, "rows of which no two are the same node and direction", found));
    }
    let [stiffness, mass, damping, rows, points] = export.files();
    let matrix = |file: &str, name: &str, matrix: &CsMat<f64>| -> Result<MatrixFile, StructureError> {
        let path = folder.join(file);
        write_file(&path, |out| (form.write)(out, &Named { name, matrix, labels }))?;
        Ok(MatrixFile { path, name: name.to_owned() })
    };
    let stiffness = matrix(stiffness, "KAAX", model.stiffness())?;
    let mass = matrix(mass, "MAAX", model.mass())?;
    let damping = model.damping().map(|values| matrix(damping, "BAAX", values)).transpose()?;
    let dofs = if labels.is_empty() {
        None
    } else {
        let path = folder.join(rows);
        write_file(&path, |out| out.write_all(dofs::write_dofs(labels).as_bytes()))?;
        Some(path)
    };
    let points = folder.join(points);
    write_file(&points, |out| out.write_all(model.points().to_csv().as_bytes()))?;
    Ok(ModelFiles {
        format: export.format,
        units: Units::Si,
        nodes: None,
        stiffness,
        mass,
        damping,
        dofs,
        dofs_per_node: None,
        points,
    })
}

fn write_file(path: &PathBuf, body: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<(), StructureError> {
    let write = || -> std::io::Result<()> {
        let mut out = BufWriter::new(File::create(path)?);
        if path.extension().is_some_and(|extension| extension == "gz") {
            let mut packed = GzEncoder::new(&mut out, Compression::fast());
            body(&mut packed)?;
            packed.finish()?;
        } else {
            body(&mut out)?;
        }
        out.flush()
    };
    write().map_err(|error| StructureError::Write { file: path.display().to_string(), reason: error.to_string() })
}
