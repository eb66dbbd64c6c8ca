//! The tables of this module: CSV with one header line and `#` comments, faults with their line.

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

use csv::{Reader, ReaderBuilder, StringRecord, Trim};

use super::error::{FileFault, StructureError};
use decore_files::Limit;

/// A table as text, with the data for error messages.
pub(super) struct CsvTable {
    pub file: String,
    pub header: Vec<String>,
    pub header_line: usize,
    /// Line number and fields; as many fields as the header has.
    pub rows: Vec<(usize, Vec<String>)>,
    /// Whether semicolons part the fields: numbers may have a decimal comma then.
    semicolons: bool,
}

pub(super) fn read_text(path: &Path) -> Result<String, StructureError> {
    decore_files::read_text(path, Limit::POINTS)
        .map_err(|error| StructureError::Read { file: path.display().to_string(), reason: error.to_string() })
}

/// Number of the line that has just been read.
fn line_of<R: Read>(reader: &Reader<R>) -> usize {
    reader.position().line().saturating_sub(1) as usize
}

impl CsvTable {
    pub fn parse(file: &str, text: &str) -> Result<Self, StructureError> {
        let fault = |line, reason: String| FileFault { file: file.to_owned(), line, reason };
        // Every line ends with a single character, so that the reader's position gives its number.
        let text = format!("{}\n", text.trim_start_matches('\u{feff}').replace("\r\n", "\n"));
        let head = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#')).unwrap_or("");
        // Spreadsheets of many countries write a decimal comma, and semicolons between fields.
        let semicolons = head.contains(';') && !head.contains(',');
        let mut reader = ReaderBuilder::new()
            .delimiter(if semicolons { b';' } else { b',' })
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(Trim::All)
            .from_reader(text.as_bytes());
        let mut lines: Vec<(usize, Vec<String>)> = Vec::new();
        let mut record = StringRecord::new();
        while reader.read_record(&mut record).map_err(|error| fault(line_of(&reader), error.to_string()))? {
            // A line of blanks, a comment that is indented.
            let first = record.get(0).unwrap_or_default();
            if (first.is_empty() && record.len() == 1) || first.starts_with('#') {
                continue;
            }
            lines.push((line_of(&reader), record.iter().map(str::to_owned).collect()));
        }
        let mut lines = lines.into_iter();
        let (header_line, header) =
            lines.next().ok_or_else(|| fault(1, "the table is empty: a header line expected".to_owned()))?;
        for (index, name) in header.iter().enumerate() {
            if header[..index].contains(name) {
                return Err(fault(header_line, format!("column \"{name}\" appears twice")).into());
            }
        }
        let mut rows = Vec::new();
        for (line, fields) in lines {
            if fields.len() != header.len() {
                let reason = format!("expected {} fields as in the header, found {}", header.len(), fields.len());
                return Err(fault(line, reason).into());
            }
            rows.push((line, fields));
        }
        if rows.is_empty() {
            return Err(fault(header_line + 1, "the table has a header but no rows".to_owned()).into());
        }
        Ok(Self { file: file.to_owned(), header, header_line, rows, semicolons })
    }

    pub fn fault(&self, line: usize, reason: String) -> StructureError {
        FileFault { file: self.file.clone(), line, reason }.into()
    }

    /// A fault in a row.
    pub fn fault_in(&self, row: usize, reason: String) -> StructureError {
        self.fault(self.rows.get(row).map_or(self.header_line, |(line, _)| *line), reason)
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
        self.field(row, column, "a finite number", |text| {
            self.with_point(text).parse().ok().filter(|value: &f64| value.is_finite())
        })
    }

    /// A text of numbers with decimal points.
    pub fn with_point<'t>(&self, text: &'t str) -> Cow<'t, str> {
        if self.semicolons { text.replace(',', ".").into() } else { text.into() }
    }

    /// Reads a field with its own rule; `expected` describes the rule.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_name_the_line_whatever_stands_before_it() {
        let line = |text: &str| match CsvTable::parse("t", text) {
            Err(StructureError::Line(fault)) => fault.line,
            other => panic!("{:?}", other.map(|table| table.rows)),
        };
        for end in ["\n", "\r\n"] {
            let text = ["\u{feff}# a", "", "name, x", "  # b", "  ", "\"P, 1\", 2", "Q"].join(end);
            assert_eq!(line(&text), 7);
            let table = CsvTable::parse("t", text.trim_end_matches('Q')).expect("valid");
            assert_eq!((table.header_line, table.rows), (3, vec![(6, vec!["P, 1".to_owned(), "2".to_owned()])]));
        }
        let table = CsvTable::parse("t", "name;x\nP;1,5\nQ;-2,5e-1\n").expect("valid");
        assert_eq!([table.number(0, 1), table.number(1, 1)], [Ok(1.5), Ok(-0.25)]);
        let mixed = CsvTable::parse("t", "name,x\nP,1;5\n").expect("valid");
        assert!(mixed.number(0, 1).is_err());
        assert_eq!([line(""), line("name\n"), line("a,b,a\n1,2,3\n")], [1, 2, 1]);
    }
}
