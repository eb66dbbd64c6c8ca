//! Reader of symmetric matrices in Matrix Market coordinate form, plain or gzip.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;
use sprs::CsMat;

use super::error::{FileFault, StructureError};

/// Largest difference of `a_ij` and `a_ji` of a general matrix, relative to the largest of `|a_ij|`, `|a_ji|` and
/// `sqrt(|a_ii a_jj|)`. Exporters that write ten or more digits stay well below it.
const ASYMMETRY_TOLERANCE: f64 = 1e-9;

/// Reads a symmetric matrix from a Matrix Market file, plain or gzip (told by its first two bytes).
///
/// Accepted: `matrix coordinate real|integer symmetric|general`, square. The result holds both triangles.
/// A symmetric file may use the lower or the upper triangle, but not both; a general one must be symmetric to 1e-9 (the
/// mean of the two entries is taken). Entries given several times are summed, as finite element exporters write unassembled
/// contributions.
///
/// # Errors
/// File, line and reason: not readable, cut short, wrong header, not square, index out of range, not finite, asymmetric.
pub fn read_matrix_market(path: &Path) -> Result<CsMat<f64>, StructureError> {
    let file = path.display().to_string();
    let bytes =
        std::fs::read(path).map_err(|error| StructureError::Read { file: file.clone(), reason: error.to_string() })?;
    parse_matrix_market(&file, &bytes)
}

/// Like [`read_matrix_market`], from bytes in memory; `file` is the name that errors carry.
///
/// # Errors
/// As for [`read_matrix_market`].
pub fn parse_matrix_market(file: &str, bytes: &[u8]) -> Result<CsMat<f64>, StructureError> {
    let source: Box<dyn Read + '_> =
        if bytes.starts_with(&[0x1f, 0x8b]) { Box::new(MultiGzDecoder::new(bytes)) } else { Box::new(bytes) };
    let mut lines = Lines { file, reader: BufReader::new(source), text: String::new(), number: 0 };
    let symmetric = read_banner(&mut lines)?;
    let (order, count) = read_size(&mut lines)?;
    let entries = read_entries(&mut lines, order, count, symmetric)?;
    let matrix = assemble(file, order, entries)?;
    if symmetric { Ok(matrix) } else { symmetrise(file, &matrix) }
}

/// Line reader that knows its file and line number.
struct Lines<'a> {
    file: &'a str,
    reader: BufReader<Box<dyn Read + 'a>>,
    text: String,
    number: usize,
}

impl Lines<'_> {
    fn fault(&self, reason: impl Into<String>) -> StructureError {
        FileFault { file: self.file.to_owned(), line: self.number, reason: reason.into() }.into()
    }

    /// The next line, or `false` at the end of the file.
    fn advance(&mut self) -> Result<bool, StructureError> {
        self.text.clear();
        self.number += 1;
        match self.reader.read_line(&mut self.text) {
            Ok(read) => Ok(read > 0),
            Err(error) => Err(self.fault(format!("the file is cut short or damaged ({error})"))),
        }
    }

    /// Moves to the next line that is neither empty nor a comment.
    fn advance_to_data(&mut self, wanted: &str) -> Result<(), StructureError> {
        loop {
            if !self.advance()? {
                return Err(self.fault(format!("the file is cut short: {wanted} expected")));
            }
            let text = self.text.trim();
            if !text.is_empty() && !text.starts_with('%') {
                return Ok(());
            }
        }
    }
}

fn read_banner(lines: &mut Lines) -> Result<bool, StructureError> {
    const EXPECTED: &str = "expected \"%%MatrixMarket matrix coordinate real symmetric\" (or integer, general)";
    if !lines.advance()? {
        return Err(lines.fault(format!("the file is empty: {EXPECTED}")));
    }
    let words: Vec<String> = lines.text.split_whitespace().map(str::to_ascii_lowercase).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["%%matrixmarket", "matrix", "coordinate", "real" | "integer", symmetry @ ("symmetric" | "general")] => {
            Ok(symmetry == "symmetric")
        }
        _ => Err(lines.fault(format!("{EXPECTED}, found \"{}\"", lines.text.trim()))),
    }
}

fn read_size(lines: &mut Lines) -> Result<(usize, usize), StructureError> {
    lines.advance_to_data("the size line (rows, columns, entries)")?;
    let numbers: Vec<Option<usize>> = lines.text.split_whitespace().map(|word| word.parse().ok()).collect();
    match numbers[..] {
        [Some(rows), Some(columns), Some(_)] if rows != columns => {
            Err(lines.fault(format!("the matrix is not square: {rows} rows, {columns} columns")))
        }
        [Some(0), Some(_), Some(_)] => Err(lines.fault("the matrix is empty: at least one row expected")),
        [Some(rows), Some(_), Some(count)] => Ok((rows, count)),
        _ => Err(lines.fault(format!("expected rows, columns and entries, found \"{}\"", lines.text.trim()))),
    }
}

type Entry = (usize, usize, f64);

fn read_entries(lines: &mut Lines, order: usize, count: usize, symmetric: bool) -> Result<Vec<Entry>, StructureError> {
    let mut entries: Vec<Entry> = Vec::new();
    // The lower triangle is -1, the upper +1: a symmetric file that uses both would count couplings twice.
    let mut triangle = 0_i8;
    for index in 0..count {
        lines.advance_to_data(&format!("entry {} of {count}", index + 1))?;
        let (row, column, value) = read_entry(lines, order)?;
        entries.push((row, column, value));
        if symmetric && row != column {
            let side = if row > column { -1 } else { 1 };
            if triangle == -side {
                return Err(lines.fault("a symmetric file must hold one triangle only, found entries of both"));
            }
            triangle = side;
            entries.push((column, row, value));
        }
    }
    while lines.advance()? {
        let text = lines.text.trim();
        if !text.is_empty() && !text.starts_with('%') {
            return Err(lines.fault(format!("more than the {count} entries that the size line announces")));
        }
    }
    Ok(entries)
}

fn read_entry(lines: &Lines, order: usize) -> Result<Entry, StructureError> {
    let mut words = lines.text.split_whitespace();
    let (Some(row), Some(column), Some(value), None) = (words.next(), words.next(), words.next(), words.next()) else {
        let text = lines.text.trim();
        return Err(lines.fault(format!("expected row, column and value, found \"{text}\"")));
    };
    let index = |word: &str, what: &str| match word.parse::<usize>() {
        Ok(number) if (1..=order).contains(&number) => Ok(number - 1),
        _ => Err(lines.fault(format!("{what} out of range: expected 1 to {order}, found \"{word}\""))),
    };
    let (row, column) = (index(row, "row")?, index(column, "column")?);
    match value.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok((row, column, number)),
        _ => Err(lines.fault(format!("expected a finite number, found \"{value}\""))),
    }
}

/// Sorts by row and column, sums repeated entries in the order of the file.
pub(super) fn assemble(file: &str, order: usize, mut entries: Vec<Entry>) -> Result<CsMat<f64>, StructureError> {
    entries.sort_by_key(|&(row, column, _)| (row, column));
    let mut pointers = vec![0; order + 1];
    let (mut indices, mut data): (Vec<usize>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut last = None;
    for (row, column, value) in entries {
        if last == Some((row, column)) {
            if let Some(sum) = data.last_mut() {
                *sum += value;
            }
            continue;
        }
        last = Some((row, column));
        pointers[row + 1] += 1;
        indices.push(column);
        data.push(value);
    }
    for row in 0..order {
        pointers[row + 1] += pointers[row];
    }
    CsMat::try_new((order, order), pointers, indices, data)
        .map_err(|(.., error)| StructureError::Matrix { file: file.to_owned(), reason: error.to_string() })
}

/// Row and column of the first pair that differs by more than the tolerance.
pub(super) fn asymmetric_pair(matrix: &CsMat<f64>) -> Option<(usize, usize)> {
    let diagonal: Vec<f64> = (0..matrix.rows()).map(|row| matrix.get(row, row).copied().unwrap_or(0.0)).collect();
    for (&value, (row, column)) in matrix {
        let mirrored = matrix.get(column, row).copied().unwrap_or(0.0);
        let scale = value.abs().max(mirrored.abs()).max((diagonal[row] * diagonal[column]).abs().sqrt());
        if (value - mirrored).abs() > ASYMMETRY_TOLERANCE * scale {
            return Some((row, column));
        }
    }
    None
}

fn symmetrise(file: &str, matrix: &CsMat<f64>) -> Result<CsMat<f64>, StructureError> {
    if let Some((row, column)) = asymmetric_pair(matrix) {
        let value = |row, column| matrix.get(row, column).copied().unwrap_or(0.0);
        let (i, j) = (row + 1, column + 1);
        return Err(StructureError::Matrix {
            file: file.to_owned(),
            reason: format!(
                "the general matrix is not symmetric: entry ({i}, {j}) is {:e}, entry ({j}, {i}) is {:e}",
                value(row, column),
                value(column, row)
            ),
        });
    }
    let halves =
        matrix.iter().flat_map(|(&value, (row, column))| [(row, column, 0.5 * value), (column, row, 0.5 * value)]);
    assemble(file, matrix.rows(), halves.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "%%MatrixMarket matrix coordinate real ";

    fn fails(text: &str, line: usize, part: &str) {
        let error = parse_matrix_market("K.mtx", text.as_bytes()).expect_err(part);
        let StructureError::Line(fault) = &error else { panic!("{error}") };
        assert_eq!((fault.file.as_str(), fault.line), ("K.mtx", line), "{error}");
        assert!(error.to_string().contains(part), "{error}");
    }

    #[test]
    fn both_triangles_and_summed_duplicates() {
        let text = format!("{HEAD}symmetric\n% comment\n\n2 2 4\n1 1 2\n2 1 -0.5\n2 1 -0.5\n2 2 3e0\n\n");
        let matrix = parse_matrix_market("K", text.as_bytes()).expect("valid");
        assert_eq!(matrix.to_dense(), CsMat::csc_from_dense(matrix.to_dense().view(), 0.0).to_dense());
        let at = |i, j| matrix.get(i, j).copied();
        assert_eq!([at(0, 0), at(0, 1), at(1, 0), at(1, 1)], [Some(2.0), Some(-1.0), Some(-1.0), Some(3.0)]);
    }

    #[test]
    fn upper_triangle_and_general_give_the_same() {
        let lower = format!("{HEAD}symmetric\n3 3 4\n1 1 2\n3 1 -1\n2 2 5\n3 3 3\n");
        let upper = format!("{HEAD}symmetric\n3 3 4\n1 1 2\n1 3 -1\n2 2 5\n3 3 3\n");
        let general = format!("{HEAD}general\n3 3 5\n1 1 2\n1 3 -1\n3 1 -1\n2 2 5\n3 3 3\n");
        let read = |text: &str| parse_matrix_market("K", text.as_bytes()).expect("valid");
        assert_eq!(read(&lower), read(&upper));
        assert_eq!(read(&lower), read(&general));
    }

    #[test]
    fn faults_name_file_line_and_reason() {
        fails("", 1, "empty");
        fails("%%MatrixMarket matrix array real general\n", 1, "coordinate real symmetric");
        fails(&format!("{HEAD}skew-symmetric\n"), 1, "expected");
        fails(&format!("{HEAD}symmetric\n% only\n"), 3, "cut short");
        fails(&format!("{HEAD}symmetric\n2 3 1\n1 1 1\n"), 2, "not square: 2 rows, 3 columns");
        fails(&format!("{HEAD}symmetric\n2 x 1\n"), 2, "rows, columns and entries");
        fails(&format!("{HEAD}symmetric\n2 2 3\n1 1 1\n2 2 1\n"), 5, "entry 3 of 3");
        fails(&format!("{HEAD}symmetric\n2 2 1\n1 1 1\n2 2 1\n"), 4, "more than the 1 entries");
        fails(&format!("{HEAD}symmetric\n2 2 1\n1 3 1\n"), 3, "column out of range: expected 1 to 2, found \"3\"");
        fails(&format!("{HEAD}symmetric\n2 2 1\n0 1 1\n"), 3, "row out of range");
        fails(&format!("{HEAD}symmetric\n2 2 1\n1 1 NaN\n"), 3, "finite number, found \"NaN\"");
        fails(&format!("{HEAD}symmetric\n2 2 1\n1 1\n"), 3, "row, column and value");
        fails(&format!("{HEAD}symmetric\n3 3 2\n2 1 1\n1 3 1\n"), 4, "one triangle only");
    }

    #[test]
    fn asymmetric_general_matrix_is_an_error() {
        let text = format!("{HEAD}general\n2 2 4\n1 1 2\n1 2 -1\n2 1 -1.001\n2 2 3\n");
        let error = parse_matrix_market("K.mtx", text.as_bytes()).expect_err("asymmetric").to_string();
        assert!(error.starts_with("K.mtx: the general matrix is not symmetric: entry (1, 2) is -1e0"), "{error}");
        let one_sided = format!("{HEAD}general\n2 2 3\n1 1 2\n1 2 -1\n2 2 3\n");
        assert!(parse_matrix_market("K.mtx", one_sided.as_bytes()).is_err());
    }

    #[test]
    fn cut_gzip_is_an_error() {
        let whole: &[u8] = include_bytes!("../../studies/station/K.mtx.gz");
        let error = parse_matrix_market("K.mtx.gz", &whole[..whole.len() / 2]).expect_err("cut").to_string();
        assert!(error.contains("cut short"), "{error}");
    }
}
