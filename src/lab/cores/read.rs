//! The table of tests.

use std::path::Path;

use super::course::Courses;
use super::error::CoresError;
use decore_dataset::{ColumnDescription, ColumnGroup, DatasetReader, RowRecord, TableName};
use decore_quantity::words::{did_you_mean, nearest};
use decore_quantity::{Cell, Value};
use decore_study::{column_names, factor_rows, sparse_rows};

/// Column with the row of the dataset that a test is.
const ROW: &str = "row";
/// Column with the core point.
const CORE: &str = "core";
/// Column with the time after which the core was out.
const OUT: &str = "core_out_after_s";
/// Column with the end of a test whose core stayed in.
const ENDED: &str = "test_ended_after_s";
/// Relative difference up to which numbers of factors are the same.
const SAME: f64 = 1e-6;
/// Rows that a message names at most.
const NAMED: usize = 5;

/// One test as the table states it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ReadTest {
    /// Where it stands in the table.
    pub place: String,
    /// Row of the dataset.
    pub row: u64,
    /// Place of the core point among those of the dataset.
    pub core: usize,
    /// Time at which the core was out, or at which the test ended, s.
    pub time_s: f64,
    /// Whether the core was out.
    pub out: bool,
}

/// Reads the tests of a CSV or Parquet file: a row each, with the row of the dataset or the values of factors.
///
/// # Errors
/// [`CoresError::Table`] with file, line and column.
pub(super) fn read(file: &Path, reader: &DatasetReader, courses: &Courses) -> Result<Vec<ReadTest>, CoresError> {
    let header = column_names(file, OUT).map_err(CoresError::Table)?;
    let has = |name: &str| header.iter().any(|column| column == name);
    let optional = [CORE, ENDED].into_iter().filter(|name| has(name));
    let names: Vec<&str> = std::iter::once(OUT).chain(optional).collect();
    let lines = sparse_rows(file, &names).map_err(CoresError::Table)?;
    let rows = if has(ROW) { numbered(file, courses)? } else { matched(file, &header, reader)? };
    let mut tests = Vec::with_capacity(lines.len());
    for (line, row) in lines.iter().zip(rows) {
        let place = format!("{}, {}", file.display(), line.place);
        let cell = |name: &str| {
            let at = names.iter().position(|known| *known == name);
            at.and_then(|at| line.cells.get(at)).map_or("", |cell| cell.trim())
        };
        let fault = |message: String| CoresError::Table(format!("{place}, {message}"));
        let core = core(cell(CORE), &courses.cores).map_err(fault)?;
        let (time_s, out) = time(cell(OUT), cell(ENDED)).map_err(fault)?;
        tests.push(ReadTest { place, row, core, time_s, out });
    }
    Ok(tests)
}

/// Place of a core point by its name, CASTING.NAME, or by NAME if that is clear.
fn core(name: &str, cores: &[String]) -> Result<usize, String> {
    let known = || cores.join(", ");
    let mut matches = (0..cores.len()).filter(|place| {
        let whole = &cores[*place];
        name.is_empty() || whole == name || whole.split_once('.').is_some_and(|(_, own)| own == name)
    });
    match (matches.next(), matches.next()) {
        (Some(only), None) => Ok(only),
        (Some(_), Some(_)) if name.is_empty() => {
            Err(format!("column `{CORE}`: expected the core that was tested, one of {}", known()))
        }
        (Some(_), Some(_)) => {
            Err(format!("column `{CORE}`: several castings have a core `{name}`, expected one of {}", known()))
        }
        (None, _) => {
            let own = cores.iter().filter_map(|whole| whole.split_once('.')).map(|(_, own)| own);
            let hint = did_you_mean(nearest(name, cores.iter().map(String::as_str).chain(own)));
            Err(format!("column `{CORE}`: the dataset has no core `{name}`; it has: {}{hint}", known()))
        }
    }
}

/// Time of a test, and whether the core was out then.
fn time(out: &str, ended: &str) -> Result<(f64, bool), String> {
    // Tables of pandas have NaN where there is nothing.
    let stated = |cell: &str| !cell.is_empty() && !cell.eq_ignore_ascii_case("nan");
    let number = |name: &str, cell: &str| {
        let number = cell.parse::<f64>().ok().filter(|number| *number > 0.0 && number.is_finite());
        number.ok_or_else(|| format!("column `{name}`: expected a positive time in s, found `{cell}`"))
    };
    match (stated(out), stated(ended)) {
        (true, _) => Ok((number(OUT, out)?, true)),
        (false, true) => Ok((number(ENDED, ended)?, false)),
        (false, false) => Err(format!(
            "column `{OUT}`: expected a time in s; if the core stayed in, leave it empty and give the length of the test in column \
             `{ENDED}`"
        )),
    }
}

/// Rows by their numbers.
fn numbered(file: &Path, courses: &Courses) -> Result<Vec<u64>, CoresError> {
    let lines = sparse_rows(file, &[ROW]).map_err(CoresError::Table)?;
    let number = |line: decore_study::TableRow| {
        let cell = line.cells.first().map_or("", |cell| cell.trim());
        let number = cell.parse::<f64>().ok().filter(|number| number.fract() == 0.0 && *number >= 0.0);
        let fault = |message: String| {
            CoresError::Table(format!("{}, {}, column `{ROW}`: {message}", file.display(), line.place))
        };
        let row = number.ok_or_else(|| fault(format!("expected the number of a row, found `{cell}`")))? as u64;
        match courses.rows.contains_key(&row) {
            true => Ok(row),
            false => Err(fault(format!("the dataset has no row {row} that is done"))),
        }
    };
    lines.into_iter().map(number).collect()
}

/// Rows by the values of the factors that the table has.
fn matched(file: &Path, header: &[String], reader: &DatasetReader) -> Result<Vec<u64>, CoresError> {
    let factors: Vec<&ColumnDescription> =
        reader.columns(TableName::Runs).iter().filter(|column| column.group == ColumnGroup::Factor).collect();
    let subject = |column: &ColumnDescription| column.subject.clone().unwrap_or_default();
    let stated =
        |column: &&&ColumnDescription| header.iter().any(|name| *name == column.name || *name == subject(column));
    let known: Vec<&ColumnDescription> = factors.iter().filter(stated).copied().collect();
    if known.is_empty() {
        let names: Vec<String> = factors.iter().map(|column| subject(column)).collect();
        return Err(CoresError::Table(format!(
            "{} has no column `{ROW}` and none of the factors ({}): state which row of the dataset each test is",
            file.display(),
            names.join(", ")
        )));
    }
    let subjects: Vec<String> = known.iter().map(|column| subject(column)).collect();
    let lines =
        factor_rows(file, &subjects.iter().map(String::as_str).collect::<Vec<_>>()).map_err(CoresError::Table)?;
    let names: Vec<&str> =
        std::iter::once(RowRecord::row.name).chain(known.iter().map(|column| column.name.as_str())).collect();
    let mut found: Vec<Vec<u64>> = vec![Vec::new(); lines.len()];
    reader.visit(TableName::Runs, &names, |cells| {
        let Some((Some(Value::Count(row)), values)) = cells.split_first() else { return };
        for (line, found) in lines.iter().zip(&mut found) {
            if line.cells.iter().zip(values).all(|(typed, value)| same(typed, *value)) {
                found.push(*row);
            }
        }
    })?;
    let only = |(line, rows): (&decore_study::TableRow, Vec<u64>)| match rows.as_slice() {
        [row] => Ok(*row),
        rows => {
            let place = format!("{}, {}", file.display(), line.place);
            let list: Vec<String> = rows.iter().take(NAMED).map(u64::to_string).collect();
            Err(CoresError::Table(match rows {
                [] => format!(
                    "{place}: no row of the dataset has these values of {}: run this row first",
                    subjects.join(", ")
                ),
                _ => format!(
                    "{place}: rows {} have these values of {}: add a column `{ROW}`",
                    list.join(", "),
                    subjects.join(", ")
                ),
            }))
        }
    };
    lines.iter().zip(found).map(only).collect()
}

/// Whether a cell of the table is the value of a factor.
fn same(typed: &str, value: Cell<'_>) -> bool {
    match value {
        Some(Value::Text(text)) => text == typed.trim(),
        Some(number) => number.number().zip(typed.trim().parse::<f64>().ok()).is_some_and(|(number, typed)| {
            number == typed || (number - typed).abs() <= SAME * number.abs().max(typed.abs())
        }),
        None => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cores_have_short_names_where_they_are_clear() {
        let cores = ["head.left", "head.right", "block.left"].map(str::to_owned);
        assert_eq!((core("right", &cores), core("block.left", &cores)), (Ok(1), Ok(2)));
        assert!(core("left", &cores).unwrap_err().contains("several castings"));
        assert!(core("rihgt", &cores).unwrap_err().contains("has no core `rihgt`"));
        assert!(core("", &cores).unwrap_err().contains("one of head.left"));
        assert_eq!(core("", &cores[..1]), Ok(0));
    }

    #[test]
    fn times_are_of_cores_that_are_out_or_of_whole_tests() {
        assert_eq!((time("12.5", ""), time("12.5", "60")), (Ok((12.5, true)), Ok((12.5, true))));
        assert_eq!((time("", "60"), time("NaN", "60.0")), (Ok((60.0, false)), Ok((60.0, false))));
        assert!(time("", "").unwrap_err().contains("test_ended_after_s"));
        assert!(time("-1", "").unwrap_err().contains("found `-1`"));
    }

    #[test]
    fn numbers_match_within_rounding_and_texts_as_they_are() {
        assert!(same("0.05", Some(Value::Real(0.050_000_000_1))) && !same("0.05", Some(Value::Real(0.0501))));
        assert!(same("steel", Some(Value::Text("steel"))) && !same("5", Some(Value::Text("steel"))));
        assert!(same("0", Some(Value::Real(0.0))) && !same("", None));
    }
}
