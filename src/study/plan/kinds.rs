//! Reads the kind of design, its parts and correlations from the keys of the design section.

use std::path::Path;
use std::sync::Arc;

use super::factor::FactorInfo;
use super::table::{self, CellSpan};
use crate::file::{CorrelationEntry, DesignEntry, FactorEntry, PartEntry};
use decore_statistics::design::{DesignError, DesignKind, Kind, Needs, Product, ProductPart, Table, Union};

/// A key at fault.
pub(super) struct Fault {
    /// Path of the table.
    pub at: Vec<String>,
    pub message: String,
}

/// A kind of design and the files that it was read from.
pub(super) struct DesignChoice {
    pub kind: Kind,
    pub files: Vec<RowFile>,
}

/// A file with rows of the design.
#[derive(Debug, Clone)]
pub(crate) struct RowFile {
    /// As the study names it.
    pub name: String,
    /// Rows as text, in place of the file: its format does not matter.
    pub content: String,
}

/// Reads how the rows of a study's design are chosen.
pub(super) struct KindReader<'a> {
    pub entry: &'a DesignEntry,
    /// The drawn factors, in the order of the design.
    pub drawn: Vec<&'a FactorInfo>,
    /// Folder for relative file names.
    pub directory: &'a Path,
}

/// A part as typed, with its place in the study and its factors.
struct DesignPart<'a> {
    entry: &'a PartEntry,
    at: Vec<String>,
    /// Indices of its factors among the drawn ones.
    places: Vec<usize>,
    factors: Vec<&'a FactorInfo>,
    directory: &'a Path,
}

impl<'a> KindReader<'a> {
    /// The kind of design that the study asks for.
    pub fn kind(&self) -> Result<DesignChoice, Vec<Fault>> {
        let (entry, whole) = (self.entry, self.entry.as_part());
        let at = vec!["design".to_string()];
        if !matches!(entry.kind, Some(DesignKind::Union | DesignKind::Product)) {
            if !entry.part.is_empty() {
                return Err(one(&at, "part", "belongs to `kind = \"union\"` or `kind = \"product\"`"));
            }
            return self.part(&whole, at, (0..self.drawn.len()).collect()).kind();
        }
        if let Some(key) = whole.options().given().first() {
            return Err(one(&at, key, "belongs to a part (`[[design.part]]`), not to the whole union or product"));
        }
        if entry.part.is_empty() {
            return Err(one(&at, "part", "missing key: a union or product needs parts (`[[design.part]]`)"));
        }
        self.parts(entry.kind == Some(DesignKind::Product))
    }

    /// A union or product of the design's parts.
    fn parts(&self, product: bool) -> Result<DesignChoice, Vec<Fault>> {
        let (mut parts, mut files, mut faults) = (Vec::new(), Vec::new(), Vec::new());
        for (index, entry) in self.entry.part.iter().enumerate() {
            let at = ["design", "part", &index.to_string()].map(str::to_string).to_vec();
            let part = self.part_places(entry, &at, product).map(|places| self.part(entry, at, places));
            match part.and_then(|part| Ok((part.kind()?, part.places))) {
                Ok((DesignChoice { kind, files: more }, factors)) => {
                    parts.push(ProductPart { kind, factors });
                    files.extend(more);
                }
                Err(more) => faults.extend(more),
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let kind = match product {
            true => Kind::Product(Product { parts }),
            false => Kind::Union(Union { parts: parts.into_iter().map(|part| part.kind).collect() }),
        };
        Ok(DesignChoice { kind, files })
    }

    fn part(&self, entry: &'a PartEntry, at: Vec<String>, places: Vec<usize>) -> DesignPart<'a> {
        let factors = places.iter().filter_map(|place| self.drawn.get(*place).copied()).collect();
        DesignPart { entry, at, places, factors, directory: self.directory }
    }

    /// Indices of a part's factors: those that it names in a product, all of them in a union.
    fn part_places(&self, entry: &PartEntry, at: &[String], product: bool) -> Result<Vec<usize>, Vec<Fault>> {
        let fault = |message: &str| Err(one(at, "factors", message));
        match (product, &entry.factors) {
            (true, Some(names)) => self.places(names).or_else(|message| fault(&message)),
            (true, None) => fault("missing key: name the factors of this part of the product"),
            (false, Some(_)) => fault("belongs to a product: all parts of a union have all factors"),
            (false, None) => Ok((0..self.drawn.len()).collect()),
        }
    }

    fn places(&self, names: &[String]) -> Result<Vec<usize>, String> {
        let place = |name: &String| {
            let place = self.drawn.iter().position(|factor| factor.name == *name);
            place.ok_or_else(|| format!("there is no drawn factor `{name}`"))
        };
        names.iter().map(place).collect()
    }

    /// The matrix of rank correlations of all drawn factors.
    pub fn correlations(&self, entry: &CorrelationEntry) -> Result<Vec<Vec<f64>>, DesignError> {
        let places = self.places(&entry.factors).map_err(DesignError::Correlation)?;
        let size = self.drawn.len();
        let mut whole: Vec<Vec<f64>> =
            (0..size).map(|i| (0..size).map(|j| if i == j { 1.0 } else { 0.0 }).collect()).collect();
        let square = entry.matrix.len() == places.len() && entry.matrix.iter().all(|row| row.len() == places.len());
        let mut seen = places.clone();
        seen.sort_unstable();
        seen.dedup();
        if !square || seen.len() != places.len() {
            let message = format!("expected a square matrix with a row for each of {} different factors", seen.len());
            return Err(DesignError::Correlation(message));
        }
        for (i, row) in places.iter().zip(&entry.matrix) {
            for (j, value) in places.iter().zip(row) {
                whole[*i][*j] = *value;
            }
        }
        Ok(whole)
    }
}

/// A factor as typed. If the study gives no domain, it comes from the table's file.
pub(super) fn spanned(
    design: &DesignEntry,
    (name, factor): (&str, &FactorEntry),
    directory: &Path,
) -> Result<FactorEntry, Fault> {
    let told = factor.range.is_some()
        || factor.values.is_some()
        || factor.distribution.is_some()
        || factor.expression.is_some();
    let whole = design.as_part();
    let own = |part: &&PartEntry| part.factors.as_ref().is_none_or(|names| names.iter().any(|own| own == name));
    let mut tables = [&whole].into_iter().chain(&design.part).filter(|part| part.kind == Some(DesignKind::Table));
    let file = tables.find(own).and_then(|part| part.file.as_ref());
    let (false, Some(file)) = (told, file) else {
        return Ok(factor.clone());
    };
    let integer = factor.integer == Some(true);
    let span = table::span(&directory.join(file), name, integer)
        .map_err(|message| Fault { at: ["design", "factor", name].map(str::to_string).to_vec(), message })?;
    Ok(match span {
        CellSpan::Range(range) => FactorEntry { range: Some(range), ..factor.clone() },
        // A single value or texts need none of the keys of a range.
        CellSpan::Values(values) => {
            FactorEntry { values: Some(values), scale: None, integer: None, levels: None, ..factor.clone() }
        }
    })
}

/// Path of a key of a table.
fn key_at(at: &[String], key: &str) -> Vec<String> {
    at.iter().cloned().chain([key.to_string()]).collect()
}

/// One fault of a key of a table.
fn one(at: &[String], key: &str, message: &str) -> Vec<Fault> {
    vec![Fault { at: key_at(at, key), message: message.to_string() }]
}

impl DesignPart<'_> {
    fn kind(&self) -> Result<DesignChoice, Vec<Fault>> {
        let (kind, options) = (self.entry.kind.unwrap_or_default(), self.entry.options());
        let stray = options.given().into_iter().filter(|key| !kind.keys().contains(key));
        let faults: Vec<Fault> =
            stray.flat_map(|key| one(&self.at, key, "belongs to other kinds of design than this one")).collect();
        if !faults.is_empty() {
            return Err(faults);
        }
        match kind.of(&options) {
            Ok(kind) => Ok(DesignChoice { kind, files: Vec::new() }),
            Err(Needs::Rows) => self.table(),
            Err(Needs::Parts) => Err(one(&self.at, "kind", "a part cannot have parts itself")),
            Err(Needs::Number(key)) => Err(one(&self.at, key, "missing key: this kind of design needs a number")),
        }
    }

    fn table(&self) -> Result<DesignChoice, Vec<Fault>> {
        let fault = |message: &str| one(&self.at, "file", message);
        let Some(file) = &self.entry.file else {
            return Err(fault("missing key: a table needs a file (CSV or Parquet)"));
        };
        let rows = table::read(&self.directory.join(file), &self.factors).map_err(|message| fault(&message))?;
        let files = vec![RowFile { name: file.clone(), content: format!("{rows:?}") }];
        Ok(DesignChoice { kind: Kind::Table(Table { rows: Arc::new(rows) }), files })
    }
}
