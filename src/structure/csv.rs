//! The little of CSV that the tables of this module need: commas, no quotes, one header line, `#` comments.

use std::path::Path;

use super::error::{FileFault, StructureError};
use crate::files::{self, Limit};

/// A table as text, with what is needed to name a fault.
pub(super) struct Table {
    pub file: String,
    pub header: Vec<String>,
    pub header_line: usize,
    /// Line number and fields; as many fields as the header has.
    pub rows: Vec<(usize, Vec<String>)>,
}

pub(super) fn read_text(path: &Path) -> Result<String, StructureError> {
    files::read_text(path, Limit::POINTS)
        .map_err(|error| StructureError::Read { file: path.display().to_string(), reason: error.to_string() })
}

impl Table {
    pub fn parse(file: &str, text: &str) -> Result<Self, StructureError> {
        let fault = |line, reason: String| FileFault { file: file.to_owned(), line, reason };
        let mut lines = text
            .trim_start_matches('\u{feff}')
            .lines()
            .enumerate()
            .map(|(index, line)| (index + 1, line.trim()))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let split = |line: &str| line.split(',').map(|field| field.trim().to_owned()).collect::<Vec<_>>();
        let (header_line, header) =
            lines.next().ok_or_else(|| fault(1, "the table is empty: a header line expected".to_owned()))?;
        let header = split(header);
        for (index, name) in header.iter().enumerate() {
            if header[..index].contains(name) {
                return Err(fault(header_line, format!("column \"{name}\" appears twice")).into());
            }
        }
        let mut rows = Vec::new();
        for (line, text) in lines {
            let fields = split(text);
            if fields.len() != header.len() {
                let reason = format!("expected {} fields as in the header, found {}", header.len(), fields.len());
                return Err(fault(line, reason).into());
            }
            rows.push((line, fields));
        }
        if rows.is_empty() {
            return Err(fault(header_line + 1, "the table has a header but no rows".to_owned()).into());
        }
        Ok(Self { file: file.to_owned(), header, header_line, rows })
    }

    pub fn fault(&self, line: usize, reason: String) -> StructureError {
        FileFault { file: self.file.clone(), line, reason }.into()
    }

    /// Position of a column.
    pub fn column(&self, name: &str) -> Result<usize, StructureError> {
        self.header.iter().position(|column| column == name).ok_or_else(|| {
            let reason = format!("column \"{name}\" is missing; found: {}", self.header.join(", "));
            self.fault(self.header_line, reason)
        })
    }

    /// A finite number.
    pub fn number(&self, row: usize, column: usize) -> Result<f64, StructureError> {
        self.field(row, column, "a finite number", |text| text.parse().ok().filter(|value: &f64| value.is_finite()))
    }

    /// A field by its own rule; `expected` says which.
    pub fn field<T>(
        &self,
        row: usize,
        column: usize,
        expected: &str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<T, StructureError> {
        let (line, text) = self
            .rows
            .get(row)
            .and_then(|(line, fields)| Some((*line, fields.get(column)?.as_str())))
            .unwrap_or((self.header_line, ""));
        parse(text).ok_or_else(|| {
            let name = self.header.get(column).map_or("", String::as_str);
            self.fault(line, format!("{name}: expected {expected}, found \"{text}\""))
        })
    }
}
