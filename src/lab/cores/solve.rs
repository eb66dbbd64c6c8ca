//! From tests to doses, from doses to times.

use std::path::PathBuf;

use super::course::Courses;
use super::error::CoresError;
use super::read::{ReadTest, read};
use super::result::{CoreTest, CoreTests, DoseAtShare, RowTimes};
use decore_dataset::{DatasetReader, TableColumn};
use decore_quantity::{CellColumn, Kind, Value};
use decore_statistics::lifetime::{Between, Lifetime, LifetimeLaw, Tested};
use decore_study::DesignOutline;

/// Probability of intervals.
const LEVEL: f64 = 0.95;
/// Shares of the cores whose doses are stated.
const SHARES: [f64; 3] = [0.1, 0.5, 0.9];
/// Failures below which intervals are wide whatever the law.
const FEW: usize = 5;

/// What is asked of the tests.
#[derive(Debug, Clone, PartialEq)]
pub struct CoreSettings {
    /// Table of tests.
    pub tests: PathBuf,
    /// Law of the dose at which a core is out.
    pub law: LifetimeLaw,
    /// Number of rows that are listed.
    pub best: usize,
}

/// Times of all core points of all rows that are done, as columns.
#[derive(Debug, Clone, PartialEq)]
pub struct OutTimes {
    /// Row, core point, and times with their intervals.
    pub columns: Vec<TableColumn>,
    /// Number of rows of the table.
    pub rows: usize,
}

/// Doses at which cores are out, and times until the cores of the dataset's rows are out.
///
/// # Errors
/// [`CoresError`].
pub fn solve(reader: &DatasetReader, settings: &CoreSettings) -> Result<(CoreTests, OutTimes), CoresError> {
    let study = &reader.manifest().study;
    let outline = DesignOutline::read(&study.study_text, &study.overrides, &study.study_name)?;
    let courses = Courses::read(reader, &outline)?;
    let read = read(&settings.tests, reader, &courses)?;
    let tests = read.iter().map(|test| dosed(test, &courses)).collect::<Result<Vec<CoreTest>, _>>()?;
    let given: Vec<Tested> = tests.iter().map(|test| Tested { dose: test.dose, failed: test.out }).collect();
    let law = Lifetime::fit(settings.law, &given, LEVEL)
        .map_err(|source| CoresError::Law { file: settings.tests.display().to_string(), source })?;
    let (median, next_core) = (law.quantile(0.5), law.next());
    let mut rows = slowest(&courses, next_core);
    let rows_without_time = courses.rows.len() - rows.len();
    rows.truncate(settings.best);
    let out = given.iter().filter(|test| test.failed).count();
    let found = CoreTests {
        law: settings.law,
        level: LEVEL,
        scatter: law.scatter(),
        doses: SHARES.into_iter().map(|share| DoseAtShare { share, dose: law.quantile(share) }).collect(),
        next_core,
        out,
        still_in: given.len() - out,
        rows,
        rows_done: courses.rows.len(),
        rows_without_time,
        warnings: few(out),
        tests,
    };
    Ok((found, times(&courses, median, next_core)))
}

/// A test with the dose of its core point.
fn dosed(test: &ReadTest, courses: &Courses) -> Result<CoreTest, CoresError> {
    let core = courses.cores[test.core].clone();
    let course = courses.rows.get(&test.row).and_then(|cores| cores.get(test.core).copied().flatten());
    let fault = |message: String| CoresError::Table(format!("{}: {message}", test.place));
    let course = course.ok_or_else(|| fault(format!("row {} has no dose of core {core}", test.row)))?;
    let (row, time_s) = (test.row, test.time_s);
    let dose = course.dose_at(time_s).ok_or_else(|| {
        let advice = if time_s < course.start_s {
            format!("its first impact is at {:.4} s: check the time", course.start_s)
        } else {
            format!("set `duration_s` of the study to {time_s} and run the row again")
        };
        fault(format!("core {core} of row {row} has no dose yet after {time_s} s; {advice}"))
    })?;
    Ok(CoreTest { row, core, time_s, out: test.out, dose })
}

/// The slowest core of each row, in the order of its time; rows with a core that never comes out are left out.
fn slowest(courses: &Courses, dose: Between) -> Vec<RowTimes> {
    let mut rows: Vec<RowTimes> = Vec::new();
    for (row, cores) in &courses.rows {
        let times = cores.iter().map(|course| {
            let course = (*course)?;
            let time = |dose: f64| course.time_s(dose);
            Some(Between { value: time(dose.value)?, low: time(dose.low)?, high: time(dose.high)? })
        });
        let Some(times) = times.collect::<Option<Vec<Between>>>() else { continue };
        let slower = |best: usize, core: usize| if times[core].value > times[best].value { core } else { best };
        let Some(core) = (0..times.len()).reduce(slower) else { continue };
        rows.push(RowTimes { row: *row, core: courses.cores[core].clone(), core_out_after_s: times[core] });
    }
    rows.sort_by(|a, b| a.core_out_after_s.value.total_cmp(&b.core_out_after_s.value));
    rows
}

/// Warns of few cores that were out.
fn few(out: usize) -> Vec<String> {
    let few = (out < FEW).then(|| format!("only {out} tests ended with a core that was out: the intervals are wide"));
    few.into_iter().collect()
}

/// The table of all core points.
fn times(courses: &Courses, median: Between, next: Between) -> OutTimes {
    let all = || {
        courses
            .rows
            .iter()
            .flat_map(|(row, cores)| cores.iter().enumerate().map(move |(core, course)| (row, core, course)))
    };
    let column = |name: &str, unit: &str, description: &str, values: CellColumn| TableColumn {
        name: name.to_owned(),
        unit: unit.to_owned(),
        description: description.to_owned(),
        values,
    };
    let time = |dose: f64| {
        let cells = all().map(|(_, _, course)| course.and_then(|course| course.time_s(dose)).map(Value::Real));
        CellColumn::of(Kind::Real, cells)
    };
    let doses = all().map(|(_, _, course)| course.map(|course| Value::Real(course.dose)));
    let names = all().map(|(_, core, _)| Some(Value::Text(courses.cores[core].as_str())));
    let percent = 100.0 * LEVEL;
    let columns = vec![
        column(
            "row",
            "1",
            "Row of the dataset.",
            CellColumn::of(Kind::Count, all().map(|(row, _, _)| Some(Value::Count(*row)))),
        ),
        column("core", "", "Core point: CASTING.NAME.", CellColumn::of(Kind::Category, names)),
        column("dose_98hz_10khz", "1", "Dose of the core point in the run.", CellColumn::of(Kind::Real, doses)),
        column("core_out_after_s", "s", "Time after which half of the cores are out.", time(median.value)),
        column(
            "core_out_after_median_low_s",
            "s",
            &format!("Lower end of the {percent} % confidence interval of core_out_after_s."),
            time(median.low),
        ),
        column(
            "core_out_after_median_high_s",
            "s",
            &format!("Upper end of the {percent} % confidence interval of core_out_after_s."),
            time(median.high),
        ),
        column(
            "core_out_after_low_s",
            "s",
            &format!("Lower end of the interval in which the time of a core lies with {percent} %."),
            time(next.low),
        ),
        column(
            "core_out_after_high_s",
            "s",
            &format!("Upper end of the interval in which the time of a core lies with {percent} %."),
            time(next.high),
        ),
    ];
    OutTimes { rows: columns.first().map_or(0, |column| column.values.count), columns }
}
