//! Distributions of a dataset's main outputs and the ranking over a factor, counted in cells and drawn with characters.

use std::fmt::Write as _;

use super::numbers::{number, significant};
use super::summary::{Ranged, Report, ValueSpan, ranged};
use decore_dataset::{ColumnDescription, ColumnGroup, DatasetError, DatasetReader, TableName};
use decore_model::run::{RowOutcome, RowStatus};
use decore_quantity::{Cell, Value};

/// Cells of a distribution.
const CELLS: usize = 24;
/// Lines of the scatter.
const LINES: usize = 10;
/// Cells of a line of the scatter.
const ACROSS: usize = 48;
/// Assumed number of columns without a terminal.
const PLAIN_COLUMNS: usize = 80;

/// Terminal on which charts are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Paper {
    /// Columns of the terminal; `None` if there is none.
    pub columns: Option<usize>,
    /// Whether it shows blocks; otherwise letters and signs stand for them.
    pub blocks: bool,
}

impl Paper {
    /// Signs for few to many, the first for none.
    fn heights(self) -> &'static [char] {
        if self.blocks {
            &[' ', '\u{2581}', '\u{2582}', '\u{2583}', '\u{2584}', '\u{2585}', '\u{2586}', '\u{2587}', '\u{2588}']
        } else {
            &[' ', '.', ':', '-', '=', '+', '*', '#', '@']
        }
    }

    fn shades(self) -> &'static [char] {
        if self.blocks { &[' ', '\u{2591}', '\u{2592}', '\u{2593}', '\u{2588}'] } else { &[' ', '.', 'o', '*', '#'] }
    }
}

/// A span of values, cut in cells of one width.
#[derive(Debug, Clone, PartialEq)]
struct Axis {
    title: String,
    unit: String,
    span: ValueSpan,
}

impl Axis {
    /// Cell of a value out of `cells`; the first where all values are the same.
    fn cell(&self, value: f64, cells: usize) -> usize {
        let ValueSpan { low, high } = self.span;
        let share = (value - low) / (high - low);
        if share.is_finite() { ((share * cells as f64) as usize).min(cells - 1) } else { 0 }
    }

    fn words(&self) -> String {
        let unit = if self.unit == "1" || self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        format!("{} to {}{unit}", significant(self.span.low), significant(self.span.high))
    }
}

/// Number of rows in each cell of an output's range.
#[derive(Debug, Clone, PartialEq)]
struct Histogram {
    axis: Axis,
    counts: [u64; CELLS],
}

/// The ranking over a factor.
#[derive(Debug, Clone, PartialEq)]
struct Scatter {
    factor: Axis,
    counts: Vec<[u64; ACROSS]>,
    moments: CorrelationSums,
}

/// Sums for a correlation, by Welford's way.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct CorrelationSums {
    count: f64,
    mean: [f64; 2],
    /// Sums of squares of both and of their product.
    squares: [f64; 3],
}

impl CorrelationSums {
    fn add(&mut self, [x, y]: [f64; 2]) {
        self.count += 1.0;
        let before = [x - self.mean[0], y - self.mean[1]];
        self.mean[0] += before[0] / self.count;
        self.mean[1] += before[1] / self.count;
        let after = [x - self.mean[0], y - self.mean[1]];
        self.squares[0] += before[0] * after[0];
        self.squares[1] += before[1] * after[1];
        self.squares[2] += before[0] * after[1];
    }

    /// Pearson's correlation; 0 if one of both does not vary.
    fn correlation(&self) -> f64 {
        let [xx, yy, xy] = self.squares;
        let correlation = xy / (xx * yy).sqrt();
        if correlation.is_finite() { correlation } else { 0.0 }
    }
}

/// Distributions of the main outputs, and the ranking over the factor that it goes with most.
#[derive(Debug, Clone, PartialEq)]
pub struct Charts {
    histograms: Vec<Histogram>,
    ranking: Axis,
    scatter: Option<Scatter>,
}

/// Cells of a row, in their order.
struct ChartColumns<'a> {
    ranked: &'a ColumnDescription,
    factors: Vec<&'a ColumnDescription>,
    /// Columns of outputs, each with its histogram's place.
    outputs: Vec<(usize, &'a ColumnDescription)>,
}

/// Figures of a row that is done.
struct Done<'c> {
    rank: f64,
    factors: &'c [Cell<'c>],
    outputs: &'c [Cell<'c>],
}

impl ChartColumns<'_> {
    fn names(&self) -> Vec<&str> {
        let outputs = self.outputs.iter().map(|(_, column)| *column);
        let columns = [self.ranked].into_iter().chain(self.factors.iter().copied()).chain(outputs);
        [RowOutcome::status.name].into_iter().chain(columns.map(|column| column.name.as_str())).collect()
    }

    /// The figures of a row, if it is done.
    fn done<'c>(&self, cells: &'c [Cell<'c>]) -> Option<Done<'c>> {
        let [Some(Value::Text(status)), rank, others @ ..] = cells else { return None };
        let (factors, outputs) = others.split_at(self.factors.len().min(others.len()));
        let done = *status == RowStatus::Done.name();
        done.then(|| Done { rank: number(rank).unwrap_or(f64::NAN), factors, outputs })
    }
}

impl Charts {
    /// Reads a dataset to count, within the ranges that its summary has found. Memory is bounded, whatever the number of rows.
    ///
    /// # Errors
    /// Those of reading.
    pub fn of(reader: &DatasetReader, summary: &Report) -> Result<Self, DatasetError> {
        let all = reader.columns(TableName::Runs);
        let Ranged { titles, columns: outputs } = ranged(all);
        let factors: Vec<_> =
            all.iter().filter(|column| column.group == ColumnGroup::Factor && !column.unit.is_empty()).collect();
        let ranked = &summary.ranking;
        let span = |title: &str| {
            let range = summary.ranges.iter().find(|range| range.title == title);
            range.map_or(ValueSpan::default(), |range| ValueSpan { low: range.min, high: range.max })
        };
        let axis = |(title, unit): (String, String)| Axis { span: span(&title), title, unit };
        let mut charts = Self {
            histograms: titles.into_iter().map(|title| Histogram { axis: axis(title), counts: [0; CELLS] }).collect(),
            ranking: Axis { title: ranked.name.clone(), unit: ranked.unit.clone(), span: summary.spans.ranking },
            scatter: None,
        };
        let factor = |column: &&ColumnDescription| Scatter {
            factor: Axis {
                title: column.subject.clone().unwrap_or_else(|| column.name.clone()),
                unit: column.unit.clone(),
                span: summary.spans.factors.get(&column.name).copied().unwrap_or_default(),
            },
            counts: vec![[0; ACROSS]; LINES],
            moments: CorrelationSums::default(),
        };
        let mut scatters: Vec<Scatter> = factors.iter().map(factor).collect();
        let columns = ChartColumns { ranked, factors, outputs };
        reader.visit(TableName::Runs, &columns.names(), |cells| charts.count(&columns, &mut scatters, cells))?;
        charts.histograms.retain(|histogram| histogram.counts.iter().any(|count| *count > 0));
        let strength = |scatter: &Scatter| scatter.moments.correlation().abs();
        scatters.retain(|scatter| scatter.factor.span.high > scatter.factor.span.low);
        charts.scatter = scatters.into_iter().max_by(|a, b| strength(a).total_cmp(&strength(b)));
        Ok(charts)
    }

    fn count(&mut self, columns: &ChartColumns<'_>, scatters: &mut [Scatter], cells: &[Cell<'_>]) {
        let Some(Done { rank, factors, outputs }) = columns.done(cells) else { return };
        for (scatter, cell) in scatters.iter_mut().zip(factors) {
            if let Some(value) = number(cell).filter(|_| rank.is_finite()) {
                // The first line is the uppermost.
                let line = LINES - 1 - self.ranking.cell(rank, LINES);
                scatter.counts[line][scatter.factor.cell(value, ACROSS)] += 1;
                scatter.moments.add([value, rank]);
            }
        }
        for ((place, _), cell) in columns.outputs.iter().zip(outputs) {
            let Histogram { axis, counts } = &mut self.histograms[*place];
            number(cell).into_iter().for_each(|value| counts[axis.cell(value, CELLS)] += 1);
        }
    }

    /// The charts in characters; nothing where no row is done. Writing to a text cannot fail.
    pub fn text(&self, paper: Paper) -> String {
        let mut text = String::new();
        let columns = paper.columns.unwrap_or(PLAIN_COLUMNS);
        if !self.histograms.is_empty() {
            let _ = writeln!(text, "\nDistributions (rows done)");
        }
        let width = self.histograms.iter().map(|histogram| histogram.axis.title.chars().count()).max().unwrap_or(0);
        let range = self.histograms.iter().map(|histogram| histogram.axis.words().len()).max().unwrap_or(0);
        for Histogram { axis, counts } in &self.histograms {
            let bar = marks(counts, paper.heights());
            let _ = if width + CELLS + range + 6 <= columns {
                writeln!(text, "{:<width$}  |{bar}|  {}", axis.title, axis.words())
            } else {
                writeln!(text, "{}\n  |{bar}|  {}", axis.title, axis.words())
            };
        }
        if let Some(scatter) = &self.scatter {
            self.draw(scatter, Paper { columns: Some(columns), ..paper }, &mut text);
        }
        text
    }

    /// The scatter with its axes.
    fn draw(&self, scatter: &Scatter, paper: Paper, text: &mut String) {
        let columns = paper.columns.unwrap_or(PLAIN_COLUMNS);
        let correlation = scatter.moments.correlation();
        let _ = writeln!(
            text,
            "\n`{}` over factor `{}` (correlation {correlation:.2})",
            self.ranking.title, scatter.factor.title
        );
        let (high, low) = (significant(self.ranking.span.high), significant(self.ranking.span.low));
        let margin = high.chars().count().max(low.chars().count());
        // Cells are joined where the terminal is narrow.
        let joined = ACROSS.div_ceil(columns.saturating_sub(margin + 3).clamp(1, ACROSS));
        let most = scatter
            .counts
            .iter()
            .flat_map(|line| line.chunks(joined))
            .map(|cells| cells.iter().sum::<u64>())
            .max()
            .unwrap_or(0);
        for (index, line) in scatter.counts.iter().enumerate() {
            let label = match index {
                0 => high.as_str(),
                _ if index == LINES - 1 => low.as_str(),
                _ => "",
            };
            let cells = line.chunks(joined).map(|cells| mark(cells.iter().sum(), most, paper.shades()));
            let line: String = cells.collect();
            let _ = writeln!(text, "{label:>margin$} |{}", line.trim_end());
        }
        let _ = writeln!(text, "{:>margin$} +{}", "", "-".repeat(ACROSS.div_ceil(joined)));
        let _ = writeln!(text, "{:>margin$}  {}", "", scatter.factor.words());
    }
}

/// A sign per count.
fn marks(counts: &[u64], signs: &[char]) -> String {
    let most = counts.iter().copied().max().unwrap_or(0);
    counts.iter().map(|count| mark(*count, most, signs)).collect()
}

/// The sign of a count: the first for none, the last for the most.
fn mark(count: u64, most: u64, signs: &[char]) -> char {
    let steps = signs.len().saturating_sub(1) as u64;
    let place = (count * steps).div_ceil(most.max(1)).min(steps);
    signs.get(usize::try_from(place).unwrap_or(0)).copied().unwrap_or(' ')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_are_seen_beside_many() {
        let paper = |blocks| Paper { columns: None, blocks };
        assert_eq!(marks(&[0, 1, 50, 100], paper(true).heights()), " \u{2581}\u{2584}\u{2588}");
        assert_eq!(marks(&[0, 1, 50, 100], paper(false).heights()), " .=@");
        assert_eq!(marks(&[0, 0], paper(false).shades()), "  ");
    }

    #[test]
    fn values_fall_into_cells() {
        let axis = Axis { title: String::new(), unit: "J".to_owned(), span: ValueSpan { low: 2.0, high: 4.0 } };
        assert_eq!([2.0, 2.99, 3.0, 4.0].map(|value| axis.cell(value, 2)), [0, 0, 1, 1]);
        assert_eq!(axis.words(), "2.000 to 4.000 J");
        let same = Axis { span: ValueSpan { low: 2.0, high: 2.0 }, ..axis };
        assert_eq!(same.cell(2.0, 24), 0);
    }

    #[test]
    fn correlation_is_pearson_s() {
        let mut moments = CorrelationSums::default();
        for pair in [[1.0, 2.0], [2.0, 1.0], [3.0, 4.0], [4.0, 3.0], [5.0, 5.0]] {
            moments.add(pair);
        }
        // Sums of squares 10 and 10, of products 8.
        assert!((moments.correlation() - 0.8).abs() < 1e-12);
        assert_eq!(CorrelationSums::default().correlation(), 0.0);
    }
}
