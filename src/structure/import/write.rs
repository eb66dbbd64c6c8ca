//! Writing a model in an exchange format.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use sprs::CsMat;

use super::source::{MatrixFile, MatrixFormat, ModelFiles, Units};
use super::{abaqus, calculix, dmig, dofs, harwell_boeing, op4};
use crate::structure::error::StructureError;
use crate::structure::model::{DofLabel, FeModel};

/// A form in which matrices can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportFormat {
    /// Matrix Market, lower triangle.
    MatrixMarket,
    /// Matrix Market, gzip.
    MatrixMarketGzip,
    /// CalculiX `.sti`, `.mas`, `.dof`.
    Calculix,
    /// Nastran DMIG punch; ten digits only.
    Dmig,
    /// Nastran OUTPUT4 as text.
    Op4Text,
    /// Nastran OUTPUT4, binary.
    Op4Binary,
    /// Harwell-Boeing text.
    HarwellBoeing,
    /// Abaqus text by node and direction.
    Abaqus,
}

impl ExportFormat {
    /// All forms with their names on the command line.
    pub const NAMES: [(&'static str, Self); 8] = [
        ("matrix_market", Self::MatrixMarket),
        ("matrix_market_gz", Self::MatrixMarketGzip),
        ("calculix", Self::Calculix),
        ("dmig", Self::Dmig),
        ("op4", Self::Op4Text),
        ("op4_binary", Self::Op4Binary),
        ("harwell_boeing", Self::HarwellBoeing),
        ("abaqus", Self::Abaqus),
    ];

    /// Format of the files, ends of the names of stiffness, mass and damping.
    fn files(self) -> (MatrixFormat, [&'static str; 3]) {
        match self {
            Self::MatrixMarket => (MatrixFormat::MatrixMarket, ["K.mtx", "M.mtx", "D.mtx"]),
            Self::MatrixMarketGzip => (MatrixFormat::MatrixMarket, ["K.mtx.gz", "M.mtx.gz", "D.mtx.gz"]),
            Self::Calculix => (MatrixFormat::Calculix, ["model.sti", "model.mas", "model.dam"]),
            Self::Dmig => (MatrixFormat::Dmig, ["K.pch", "M.pch", "D.pch"]),
            Self::Op4Text | Self::Op4Binary => (MatrixFormat::Op4, ["K.op4", "M.op4", "D.op4"]),
            Self::HarwellBoeing => (MatrixFormat::HarwellBoeing, ["K.matrix", "M.matrix", "D.matrix"]),
            Self::Abaqus => (MatrixFormat::Abaqus, ["STIF1.mtx", "MASS1.mtx", "DMPV1.mtx"]),
        }
    }
}

/// Writes the matrices of a model, in SI units, with the list of rows and the table of points, into a folder; returns what to
/// read it back from.
///
/// # Errors
/// A format that needs labels of rows for a model without them, node numbers that Nastran does not have, files that cannot be
/// written.
pub fn write_model(model: &FeModel, format: ExportFormat, folder: &Path) -> Result<ModelFiles, StructureError> {
    let labels = model.labels();
    if labels.is_empty() && matches!(format, ExportFormat::Calculix | ExportFormat::Dmig | ExportFormat::Abaqus) {
        let found = "a model without them (name a dof_file or dofs_per_node)";
        return Err(StructureError::argument("export format", "nodes and directions of the rows", found));
    }
    if format == ExportFormat::Dmig
        && let Some(label) = labels.iter().find(|label| label.node < 1)
    {
        let found = format!("node {}", label.node);
        return Err(StructureError::argument(
            "export format dmig",
            "nodes numbered from 1 on, as Nastran has them",
            found,
        ));
    }
    let (matrix_format, [stiffness, mass, damping]) = format.files();
    let matrix = |file: &str, name: &str, matrix: &CsMat<f64>| -> Result<MatrixFile, StructureError> {
        let path = folder.join(file);
        write_file(&path, |out| write_matrix(out, format, (name, matrix), labels))?;
        Ok(MatrixFile { path, name: name.to_owned() })
    };
    let stiffness = matrix(stiffness, "KAAX", model.stiffness())?;
    let mass = matrix(mass, "MAAX", model.mass())?;
    let damping = model.damping().map(|values| matrix(damping, "BAAX", values)).transpose()?;
    let dofs = if labels.is_empty() {
        None
    } else {
        let path = folder.join("model.dof");
        write_file(&path, |out| out.write_all(dofs::write_dofs(labels).as_bytes()))?;
        Some(path)
    };
    let points = folder.join("points.csv");
    write_file(&points, |out| out.write_all(model.points().to_csv().as_bytes()))?;
    Ok(ModelFiles {
        format: matrix_format,
        units: Units::Si,
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

fn write_matrix(
    out: &mut dyn Write,
    format: ExportFormat,
    (name, matrix): (&str, &CsMat<f64>),
    labels: &[DofLabel],
) -> std::io::Result<()> {
    match format {
        ExportFormat::MatrixMarket | ExportFormat::MatrixMarketGzip => write_matrix_market(out, matrix),
        ExportFormat::Calculix => calculix::write(out, matrix),
        ExportFormat::Dmig => dmig::write(out, name, matrix, labels),
        ExportFormat::Op4Text => op4::write_text(out, name, matrix),
        ExportFormat::Op4Binary => op4::write_binary(out, name, matrix),
        ExportFormat::HarwellBoeing => harwell_boeing::write(out, name, matrix),
        ExportFormat::Abaqus => abaqus::write(out, matrix, labels),
    }
}

fn write_matrix_market(out: &mut dyn Write, matrix: &CsMat<f64>) -> std::io::Result<()> {
    let lower = || matrix.iter().filter(|(_, (row, column))| row >= column);
    writeln!(out, "%%MatrixMarket matrix coordinate real symmetric")?;
    writeln!(out, "{0} {0} {1}", matrix.rows(), lower().count())?;
    for (value, (row, column)) in lower() {
        writeln!(out, "{} {} {value:.17e}", row + 1, column + 1)?;
    }
    Ok(())
}
