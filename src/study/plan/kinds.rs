//! From the keys of the design section to the kind of design, its parts and correlations.

use std::path::Path;
use std::sync::Arc;

use super::factors::FactorInfo;
use super::table::{self, Span};
use crate::design::{DesignError, Kind};
use crate::study::design_kind::{DesignKind, Made};
use crate::study::file::{CorrelationEntry, DesignEntry, FactorEntry, PartEntry};

/// Path of a key and what is wrong with it.
pub(in crate::study) type Fault = (Vec<String>, String);
/// Names of files and their contents.
type Files = Vec<(String, String)>;
/// A kind and the files it was read from.
type Chosen = (Kind, Files);

/// The drawn factors of a study, in the order of the design.
pub(in crate::study) struct Drawn<'a> {
    factors: Vec<&'a FactorInfo>,
}

/// A part with its place in the study and its factors.
struct Part<'a> {
    entry: &'a PartEntry,
    at: Vec<String>,
    factors: Vec<&'a FactorInfo>,
    directory: &'a Path,
}

impl<'a> Drawn<'a> {
    pub fn new(factors: &'a [FactorInfo]) -> Self {
        Self { factors: factors.iter().filter(|factor| factor.distribution.is_some()).collect() }
    }

    /// The kind of design that the study asks for.
    pub fn kind(&self, entry: &DesignEntry, directory: &Path) -> Result<Chosen, Vec<Fault>> {
        let root = vec!["design".to_string()];
        let fault = |key: &str, message: &str| Err(vec![(key_at(&root, key), message.to_string())]);
        let whole = entry.as_part();
        let kind = entry.kind.unwrap_or_default();
        if !matches!(kind, DesignKind::Union | DesignKind::Product) {
            if !entry.part.is_empty() {
                return fault("part", "belongs to `kind = \"union\"` or `kind = \"product\"`");
            }
            return Part { entry: &whole, at: root, factors: self.factors.clone(), directory }.kind();
        }
        if let Some(key) = whole.options().given().first() {
            return fault(key, "belongs to a part (`[[design.part]]`), not to the whole union or product");
        }
        if entry.part.is_empty() {
            return fault("part", "missing key: a union or product needs parts (`[[design.part]]`)");
        }
        let (mut kinds, mut files, mut faults) = (Vec::new(), Vec::new(), Vec::new());
        for (index, part) in entry.part.iter().enumerate() {
            let at = key_at(&key_at(&root, "part"), &index.to_string());
            match self.part(part, at, (kind, directory)) {
                Ok((kind, places, more)) => {
                    kinds.push((kind, places));
                    files.extend(more);
                }
                Err(more) => faults.extend(more),
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let kind = match kind {
            DesignKind::Union => Kind::Union(kinds.into_iter().map(|(kind, _)| kind).collect()),
            _ => Kind::Product(kinds),
        };
        Ok((kind, files))
    }

    fn part(
        &self,
        entry: &PartEntry,
        at: Vec<String>,
        (whole, directory): (DesignKind, &Path),
    ) -> Result<(Kind, Vec<usize>, Files), Vec<Fault>> {
        let key = key_at(&at, "factors");
        let places = match (whole, &entry.factors) {
            (DesignKind::Product, Some(names)) => self.places(names).map_err(|message| vec![(key, message)])?,
            (DesignKind::Product, None) => {
                return Err(vec![(key, "missing key: name the factors of this part of the product".into())]);
            }
            (_, Some(_)) => {
                return Err(vec![(key, "belongs to a product: all parts of a union have all factors".into())]);
            }
            (_, None) => (0..self.factors.len()).collect(),
        };
        let factors = places.iter().filter_map(|place| self.factors.get(*place).copied()).collect();
        let (kind, files) = Part { entry, at, factors, directory }.kind()?;
        Ok((kind, places, files))
    }

    fn places(&self, names: &[String]) -> Result<Vec<usize>, String> {
        let place = |name: &String| {
            let place = self.factors.iter().position(|factor| factor.name == *name);
            place.ok_or_else(|| format!("there is no drawn factor `{name}`"))
        };
        names.iter().map(place).collect()
    }

    /// The matrix of rank correlations of all drawn factors.
    pub fn correlations(&self, entry: &CorrelationEntry) -> Result<Vec<Vec<f64>>, DesignError> {
        let places = self.places(&entry.factors).map_err(DesignError::Correlation)?;
        let size = self.factors.len();
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

/// A factor as typed, with what it varies over from a table's file where the study says nothing of it.
pub(in crate::study) fn spanned(
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
        .map_err(|message| (["design", "factor", name].map(str::to_string).to_vec(), message))?;
    Ok(match span {
        Span::Range(range) => FactorEntry { range: Some(range), ..factor.clone() },
        // A single value or texts need none of the keys of a range.
        Span::Values(values) => {
            FactorEntry { values: Some(values), scale: None, integer: None, levels: None, ..factor.clone() }
        }
    })
}

fn key_at(at: &[String], key: &str) -> Vec<String> {
    at.iter().cloned().chain([key.to_string()]).collect()
}

impl Part<'_> {
    fn kind(&self) -> Result<Chosen, Vec<Fault>> {
        let options = self.entry.options();
        let (keys, make) = options.kind.unwrap_or_default().entry();
        let stray = options.given().into_iter().filter(|key| !keys.contains(key));
        let faults: Vec<Fault> = stray
            .map(|key| (key_at(&self.at, key), "belongs to other kinds of design than this one".to_string()))
            .collect();
        if !faults.is_empty() {
            return Err(faults);
        }
        let fault = |key: &str, message: &str| vec![(key_at(&self.at, key), message.to_string())];
        match make(&options) {
            Ok(Made::Kind(kind)) => Ok((kind, Vec::new())),
            Ok(Made::Table) => self.table(),
            Ok(Made::Union | Made::Product) => Err(fault("kind", "a part cannot have parts itself")),
            Err(key) => Err(fault(key, "missing key: this kind of design needs a number")),
        }
    }

    fn table(&self) -> Result<Chosen, Vec<Fault>> {
        let at = key_at(&self.at, "file");
        let Some(file) = &self.entry.file else {
            return Err(vec![(at, "missing key: a table needs a file (CSV or Parquet)".into())]);
        };
        let rows = table::read(&self.directory.join(file), &self.factors).map_err(|message| vec![(at, message)])?;
        // The values themselves stand for the file: its format does not matter.
        let content = format!("{rows:?}");
        Ok((Kind::Table(Arc::new(rows)), vec![(file.clone(), content)]))
    }
}
