//! Matrix Market: symmetric matrices in coordinate or array form, plain or gzip.

use std::io::Write;

use sprs::CsMat;

use crate::structure::error::StructureError;
use crate::structure::import::entry::{Form, Format, Imported, Named, RowLabels};
use crate::structure::import::lines::Lines;
use crate::structure::import::triplets::{MOST_ROWS, Storage, Triplets};

const COMMENT: &[&str] = &["%"];

pub(super) const FORMAT: Format = Format {
    endings: &["mtx"],
    read: |given| parse(given.file, given.bytes, given.listed).map(Imported::Rows),
    forms: &[
        Form { name: "matrix_market", files: ["K.mtx", "M.mtx", "D.mtx"], rows: RowLabels::Unused, loss: None, write },
        Form {
            name: "matrix_market_gz",
            files: ["K.mtx.gz", "M.mtx.gz", "D.mtx.gz"],
            rows: RowLabels::Unused,
            loss: None,
            write,
        },
    ],
};

/// Reads a symmetric matrix without a list of rows; `file` is the name that errors carry.
pub(in crate::structure::import) fn parse_matrix_market(
    file: &str,
    bytes: &[u8],
) -> Result<CsMat<f64>, StructureError> {
    parse(file, bytes, None)
}

/// Reads a symmetric matrix, plain or gzip (recognised by its first two bytes). `listed`: rows in the list of rows.
///
/// Accepted: `matrix coordinate|array real|integer symmetric|general`, square. The result holds both triangles; zeros of an
/// array are kept on the diagonal only.
/// A symmetric coordinate file may use the lower or the upper triangle, but not both; a general one must be symmetric to 1e-9 (the
/// mean of the two entries is taken). Entries given several times are summed, as finite element exporters write unassembled
/// contributions.
fn parse(file: &str, bytes: &[u8], listed: Option<usize>) -> Result<CsMat<f64>, StructureError> {
    let mut lines = Lines::new(file, bytes);
    match read_banner(&mut lines)? {
        (Layout::Coordinate, storage) => {
            let (order, count) = read_size(&mut lines, Layout::Coordinate)?;
            let entries = read_entries(&mut lines, order, count, storage)?;
            entries.justify(file, order, listed)?;
            entries.assemble(file, order, storage)
        }
        (Layout::Array, storage) => {
            let (order, _) = read_size(&mut lines, Layout::Array)?;
            read_values(&mut lines, order, storage)?.assemble(file, order, storage)
        }
    }
}

/// Layout of the entries.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Layout {
    /// Row, column and value of each.
    Coordinate,
    /// All values, column by column.
    Array,
}

fn read_banner(lines: &mut Lines) -> Result<(Layout, Storage), StructureError> {
    const EXPECTED: &str = "expected \"%%MatrixMarket matrix coordinate real symmetric\" (or array, integer, general)";
    if !lines.advance()? {
        return Err(lines.fault(format!("the file is empty: {EXPECTED}")));
    }
    let words: Vec<String> = lines.text.split_whitespace().map(str::to_ascii_lowercase).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let form = match words.get(2) {
        Some(&"coordinate") => Some(Layout::Coordinate),
        Some(&"array") => Some(Layout::Array),
        _ => None,
    };
    match (form, &words[..]) {
        (Some(form), ["%%matrixmarket", "matrix", _, "real" | "integer", symmetry @ ("symmetric" | "general")]) => {
            Ok((form, if *symmetry == "symmetric" { Storage::OneTriangle } else { Storage::Both }))
        }
        _ => Err(lines.fault(format!("{EXPECTED}, found \"{}\"", lines.text.trim()))),
    }
}

/// Order and number of entries; an array states no number.
fn read_size(lines: &mut Lines, form: Layout) -> Result<(usize, usize), StructureError> {
    let words = if form == Layout::Coordinate { "rows, columns and entries" } else { "rows and columns" };
    lines.advance_to(COMMENT, &format!("the size line ({words})"))?;
    let numbers: Option<Vec<usize>> = lines.text.split_whitespace().map(|word| word.parse().ok()).collect();
    let (rows, columns, count) = match (form, numbers.as_deref()) {
        (Layout::Coordinate, Some([rows, columns, count])) => (*rows, *columns, *count),
        (Layout::Array, Some([rows, columns])) => (*rows, *columns, 0),
        _ => return Err(lines.fault(format!("expected {words}, found \"{}\"", lines.text.trim()))),
    };
    if rows != columns {
        return Err(lines.fault(format!("the matrix is not square: {rows} rows, {columns} columns")));
    }
    if !(1..=MOST_ROWS).contains(&rows) {
        return Err(lines.fault(format!("a matrix of {rows} rows: expected 1 to {MOST_ROWS}")));
    }
    Ok((rows, count))
}

/// All values of a general array, or of the lower triangle of a symmetric one, by columns.
fn read_values(lines: &mut Lines, order: usize, storage: Storage) -> Result<Triplets, StructureError> {
    let mut entries = Triplets::default();
    for column in 0..order {
        let first = if storage == Storage::OneTriangle { column } else { 0 };
        for row in first..order {
            lines.advance_to(COMMENT, &format!("the value of row {}, column {}", row + 1, column + 1))?;
            let value = lines.number_in(&lines.text)?;
            if value != 0.0 || row == column {
                entries.push(row as u32, column as u32, value);
            }
        }
    }
    if lines.advance_past(COMMENT)? {
        return Err(lines.fault(format!("more values than a matrix of {order} rows has")));
    }
    Ok(entries)
}

fn read_entries(lines: &mut Lines, order: usize, count: usize, storage: Storage) -> Result<Triplets, StructureError> {
    let mut entries = Triplets::default();
    // A symmetric file that uses both triangles would count couplings twice.
    let mut lower: Option<bool> = None;
    for index in 0..count {
        lines.advance_to(COMMENT, &format!("entry {} of {count}", index + 1))?;
        let (row, column, value) = read_entry(lines, order)?;
        if storage == Storage::OneTriangle && row != column && *lower.get_or_insert(row > column) != (row > column) {
            return Err(lines.fault("a symmetric file must hold one triangle only, found entries of both"));
        }
        entries.push(row, column, value);
    }
    if lines.advance_past(COMMENT)? {
        return Err(lines.fault(format!("more than the {count} entries that the size line announces")));
    }
    Ok(entries)
}

fn read_entry(lines: &Lines, order: usize) -> Result<(u32, u32, f64), StructureError> {
    let mut words = lines.text.split_whitespace();
    let (Some(row), Some(column), Some(value), None) = (words.next(), words.next(), words.next(), words.next()) else {
        let text = lines.text.trim();
        return Err(lines.fault(format!("expected row, column and value, found \"{text}\"")));
    };
    Ok((lines.index_in(row, order, "row")?, lines.index_in(column, order, "column")?, lines.number_in(value)?))
}

/// Writes the lower triangle, 17 digits.
fn write(out: &mut dyn Write, named: &Named) -> std::io::Result<()> {
    let matrix = named.matrix;
    let lower = || matrix.iter().filter(|(_, (row, column))| row >= column);
    writeln!(out, "%%MatrixMarket matrix coordinate real symmetric")?;
    writeln!(out, "{0} {0} {1}", matrix.rows(), lower().count())?;
    for (value, (row, column)) in lower() {
        writeln!(out, "{} {} {value:.17e}", row + 1, column + 1)?;
    }
    Ok(())
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
        fails("%%MatrixMarket matrix array complex general\n", 1, "coordinate real symmetric");
        fails(&format!("{HEAD}skew-symmetric\n"), 1, "expected");
        fails(&format!("{HEAD}symmetric\n% only\n"), 3, "truncated");
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
    fn arrays_give_what_coordinates_give() {
        let read = |text: &str| parse_matrix_market("K", text.as_bytes()).expect("valid");
        let expected = read(&format!("{HEAD}symmetric\n3 3 4\n1 1 2\n3 1 -1\n2 2 5\n3 3 0\n"));
        const ARRAY: &str = "%%MatrixMarket matrix array real ";
        let general = format!("{ARRAY}general\n%\n3 3\n2\n0\n-1\n0\n5\n0\n-1\n0\n0\n");
        let symmetric = format!("\u{feff}{ARRAY}symmetric\r\n3 3\r\n2.\r\n0\r\n-1e0\r\n5\r\n0\r\n0\r\n");
        assert_eq!(read(&general), expected);
        assert_eq!(read(&symmetric), expected);
        fails(&format!("{ARRAY}general\n2 2\n1\n0\n0\n"), 6, "the value of row 2, column 2 expected");
        fails(&format!("{ARRAY}symmetric\n2 2\n1\n0\n1\n1\n"), 6, "more values than a matrix of 2 rows has");
        fails(&format!("{ARRAY}general\n2 3\n"), 2, "not square: 2 rows, 3 columns");
        fails(&format!("{ARRAY}general\n2 2 4\n"), 2, "expected rows and columns, found \"2 2 4\"");
    }

    #[test]
    fn memory_is_asked_for_by_entries_not_by_a_stated_size() {
        for order in ["9000000000000000000", "4000000000", "200000000"] {
            for (form, end) in [("coordinate", " 1\n1 1 2.0"), ("array", "\n2.0")] {
                let text = format!("%%MatrixMarket matrix {form} real symmetric\n{order} {order}{end}\n");
                let error = parse_matrix_market("K", text.as_bytes()).expect_err(order).to_string();
                let named = error.contains(&format!("{order} rows")) || error.contains("truncated: the value of row 2");
                assert!(named, "{error}");
            }
        }
        let lumped = format!("{HEAD}symmetric\n100000 100000 1\n1 1 2.0\n");
        assert_eq!(parse_matrix_market("M", lumped.as_bytes()).expect("valid").rows(), 100_000);
    }

    #[test]
    fn asymmetric_general_matrix_is_an_error() {
        let text = format!("{HEAD}general\n2 2 4\n1 1 2\n1 2 -1\n2 1 -1.001\n2 2 3\n");
        let error = parse_matrix_market("K.mtx", text.as_bytes()).expect_err("asymmetric").to_string();
        assert!(error.starts_with("K.mtx: the matrix is not symmetric: entry (1, 2) is -1e0"), "{error}");
        let one_sided = format!("{HEAD}general\n2 2 3\n1 1 2\n1 2 -1\n2 2 3\n");
        assert!(parse_matrix_market("K.mtx", one_sided.as_bytes()).is_err());
    }

    #[test]
    fn cut_gzip_is_an_error() {
        let whole: &[u8] = include_bytes!("../../../../assets/station/K.mtx.gz");
        let error = parse_matrix_market("K.mtx.gz", &whole[..whole.len() / 2]).expect_err("cut").to_string();
        assert!(error.contains("truncated"), "{error}");
    }
}
