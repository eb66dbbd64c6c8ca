//! Outputs of matched rows, and the outputs that differ by more than their scatter.

use super::error::ComparisonError;
use super::matching::{MatchedRows, Matching, Texts};
use super::result::{Comparison, OutputDifference, PairDifference};
use super::settings::ComparisonSettings;
use decore_dataset::{ColumnDescription, ColumnGroup, DatasetError, DatasetReader, RowRecord, TableName};
use decore_quantity::{Cell, Kind, Value};

/// Memory in bytes for outputs that are compared at the same time.
const TOGETHER: usize = 256 << 20;
/// Bytes per row and output: value and scatter in B, difference.
const PER_ROW: usize = 3 * size_of::<f64>();

/// An output that both datasets have.
struct Output<'r> {
    /// Column in each dataset.
    columns: [&'r ColumnDescription; 2],
    /// Name of the column with its scatter; `None` if there is none.
    scatter: [Option<String>; 2],
}

/// Outputs that are compared, and outputs that cannot be.
pub(super) struct Outputs<'r> {
    compared: Vec<Output<'r>>,
    /// Names of outputs that B lacks.
    pub only_in_a: Vec<String>,
    /// Names of outputs that A lacks.
    pub only_in_b: Vec<String>,
    /// Names of outputs with different units or types.
    pub of_other_units: Vec<String>,
}

/// An output of one row; NaN for a missing value, the number of a text for a text.
#[derive(Clone, Copy)]
struct Sample {
    value: f64,
    scatter: f64,
}

impl<'r> Outputs<'r> {
    /// The columns of these names, or all main outputs.
    ///
    /// # Errors
    /// [`DatasetError::UnknownColumn`] for a name that neither has.
    pub fn of(a: &'r DatasetReader, b: &'r DatasetReader, names: &[String]) -> Result<Self, DatasetError> {
        let find = |reader: &'r DatasetReader, name: &str| reader.column(TableName::Runs, name);
        let wanted: Vec<&str> = match names {
            [] => main_outputs(a).chain(main_outputs(b).filter(|name| find(a, name).is_err())).collect(),
            names => names.iter().map(String::as_str).collect(),
        };
        let mut outputs =
            Self { compared: Vec::new(), only_in_a: Vec::new(), only_in_b: Vec::new(), of_other_units: Vec::new() };
        for name in wanted {
            match (find(a, name), find(b, name)) {
                (Err(error), Err(_)) => return Err(error),
                (Ok(_), Err(_)) => outputs.only_in_a.push(name.to_owned()),
                (Err(_), Ok(_)) => outputs.only_in_b.push(name.to_owned()),
                (Ok(first), Ok(other)) if (&first.unit, first.kind) != (&other.unit, other.kind) => {
                    outputs.of_other_units.push(name.to_owned());
                }
                (Ok(first), Ok(other)) => outputs.compared.push(Output {
                    columns: [first, other],
                    scatter: [a, b].map(|reader| find(reader, &first.scatter_name()).ok().map(|c| c.name.clone())),
                }),
            }
        }
        Ok(outputs)
    }

    /// Compares the outputs of the matched rows, as many outputs at a time as memory allows.
    ///
    /// # Errors
    /// Those of reading; a dataset that changes meanwhile.
    pub fn compare(
        &self,
        matching: &Matching<'_>,
        settings: &ComparisonSettings,
        found: &mut Comparison,
    ) -> Result<(), ComparisonError> {
        let [rows_a, rows_b] = matching.counts();
        let together = TOGETHER / PER_ROW / rows_a.max(rows_b).max(1);
        for outputs in self.compared.chunks(together.max(1)) {
            let mut texts = Texts::default();
            let mut in_b = vec![Vec::with_capacity(rows_b); outputs.len()];
            read(matching, 1, outputs, |_, cells| {
                cells.samples(&mut texts).zip(&mut in_b).for_each(|(sample, samples)| samples.push(sample));
            })?;
            let mut tallies: Vec<Tally<'_>> = outputs.iter().map(|output| Tally::new(output, settings)).collect();
            read(matching, 0, outputs, |place, cells| {
                let Some(pair) = matching.done(place) else { return };
                for ((sample, samples), tally) in cells.samples(&mut texts).zip(&in_b).zip(&mut tallies) {
                    tally.add(pair, [sample, samples[pair.b]]);
                }
            })?;
            for tally in tallies {
                tally.end(matching, &texts, found);
            }
        }
        found.beyond.listed.truncate(settings.most);
        Ok(())
    }
}

/// Names of the outputs whose scatter twins measure.
fn main_outputs(reader: &DatasetReader) -> impl Iterator<Item = &str> {
    let of_runs = |column: &&ColumnDescription| {
        matches!(column.group, ColumnGroup::Hammer | ColumnGroup::Casting | ColumnGroup::Run) && column.main
    };
    reader.columns(TableName::Runs).iter().filter(of_runs).map(|column| column.name.as_str())
}

/// A row's cells of the outputs and their scatters.
struct Cells<'c> {
    cells: &'c [Cell<'c>],
    /// Whether each output has its scatter behind it.
    with_scatter: &'c [bool],
}

impl<'c> Cells<'c> {
    fn samples<'t>(&self, texts: &'t mut Texts) -> impl Iterator<Item = Sample> + use<'c, 't> {
        let mut cells = self.cells.iter();
        let mut number = move |cell: Option<&Cell<'c>>| match cell {
            Some(Some(Value::Text(text))) => texts.number(text) as f64,
            Some(Some(value)) => value.number().unwrap_or(f64::NAN),
            Some(None) | None => f64::NAN,
        };
        self.with_scatter.iter().map(move |with_scatter| {
            let value = number(cells.next());
            Sample { value, scatter: if *with_scatter { number(cells.next()) } else { f64::NAN } }
        })
    }
}

/// Shows the outputs of one of the two datasets, row by row with its place.
fn read(
    matching: &Matching<'_>,
    side: usize,
    outputs: &[Output<'_>],
    mut visit: impl FnMut(usize, Cells<'_>),
) -> Result<(), ComparisonError> {
    let reader = matching.readers[side];
    let mut names = vec![RowRecord::row.name];
    for output in outputs {
        names.push(&output.columns[side].name);
        names.extend(output.scatter[side].as_deref());
    }
    let with_scatter: Vec<bool> = outputs.iter().map(|output| output.scatter[side].is_some()).collect();
    let (mut place, mut same) = (0, true);
    reader.visit(TableName::Runs, &names, |cells| {
        if let [Some(Value::Count(row)), cells @ ..] = cells {
            same &= matching.row_at(side, place) == Some(*row);
            if same {
                visit(place, Cells { cells, with_scatter: &with_scatter });
            }
            place += 1;
        }
    })?;
    if same && place == matching.counts()[side] {
        return Ok(());
    }
    Err(ComparisonError::Changed { folder: reader.folder().to_owned() })
}

/// A pair of rows whose output differs.
#[derive(Clone, Copy)]
struct Differing {
    pair: MatchedRows,
    samples: [Sample; 2],
    judged: Judged,
}

/// Comparison of an output of two rows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Judged {
    /// Absolute difference; infinite for texts that differ and where one is missing.
    difference: f64,
    /// Permitted difference; 0 for texts.
    allowed: f64,
    /// Whether twins measured it.
    measured: bool,
}

impl Judged {
    fn of([a, b]: [Sample; 2], is_text: bool, relative: f64) -> Self {
        let difference = match () {
            () if a.value == b.value => 0.0,
            () if is_text || a.value.is_nan() || b.value.is_nan() => f64::INFINITY,
            () => (a.value - b.value).abs(),
        };
        let scatter = match [a.scatter.is_nan(), b.scatter.is_nan()] {
            [false, false] => Some(a.scatter + b.scatter),
            [false, true] => Some(2.0 * a.scatter),
            [true, false] => Some(2.0 * b.scatter),
            [true, true] => None,
        };
        let allowed = match scatter {
            // A value that is missing has nothing that could be allowed.
            _ if a.value.is_nan() || b.value.is_nan() => 0.0,
            // Of a text it is the share of twins with another one.
            Some(scatter) if is_text => {
                if scatter > 0.0 {
                    f64::INFINITY
                } else {
                    0.0
                }
            }
            Some(scatter) => 2.0 * scatter,
            None if is_text => 0.0,
            None => relative * a.value.abs().max(b.value.abs()).min(f64::MAX),
        };
        Self { difference, allowed, measured: scatter.is_some() }
    }

    fn is_beyond(self) -> bool {
        self.difference > self.allowed
    }

    /// Ratio of the difference to the permitted difference.
    fn excess(self) -> f64 {
        if self.difference > 0.0 { self.difference / self.allowed } else { 0.0 }
    }
}

/// Counts one output over the rows.
struct Tally<'o> {
    output: &'o Output<'o>,
    settings: &'o ComparisonSettings,
    pairs: u64,
    measured: u64,
    beyond: u64,
    one_sided: u64,
    differences: Vec<f64>,
    worst: Option<Differing>,
    /// Farthest beyond first.
    listed: Vec<Differing>,
}

impl<'o> Tally<'o> {
    fn new(output: &'o Output<'o>, settings: &'o ComparisonSettings) -> Self {
        Self {
            output,
            settings,
            pairs: 0,
            measured: 0,
            beyond: 0,
            one_sided: 0,
            differences: Vec::new(),
            worst: None,
            listed: Vec::new(),
        }
    }

    fn is_text(&self) -> bool {
        self.output.columns[0].kind.is_text()
    }

    fn add(&mut self, pair: MatchedRows, samples: [Sample; 2]) {
        if samples.iter().all(|sample| sample.value.is_nan()) {
            return;
        }
        let judged = Judged::of(samples, self.is_text(), self.settings.relative);
        let differing = Differing { pair, samples, judged };
        self.pairs += 1;
        self.measured += u64::from(judged.measured);
        if !self.is_text() && judged.difference.is_finite() {
            self.differences.push(judged.difference);
        }
        if samples.iter().any(|sample| sample.value.is_nan()) {
            // Without a difference: the worst one is of the others.
            self.one_sided += 1;
        } else if judged.difference > self.worst.map_or(0.0, |worst| worst.judged.difference) {
            self.worst = Some(differing);
        }
        if judged.is_beyond() {
            self.beyond += 1;
            let excess = judged.excess();
            let place = self.listed.partition_point(|other| other.judged.excess() >= excess);
            if place < self.settings.most {
                self.listed.insert(place, differing);
                self.listed.truncate(self.settings.most);
            }
        }
    }

    /// Assigns the counts and the worst rows to their outputs.
    fn end(mut self, matching: &Matching<'_>, texts: &Texts, found: &mut Comparison) {
        let shown = |differing: &Differing| self.pair(differing, matching, texts);
        let listed: Vec<PairDifference> = self.listed.iter().map(shown).collect();
        let worst = self.worst.as_ref().map(shown);
        found.beyond.count += self.beyond;
        for (entry, differing) in listed.into_iter().zip(&self.listed) {
            let excess = differing.judged.excess();
            let place = found.beyond.listed.partition_point(|other| excess_of(other) >= excess);
            found.beyond.listed.insert(place, entry);
        }
        let [column, _] = self.output.columns;
        found.outputs.push(OutputDifference {
            name: column.name.clone(),
            unit: column.unit.clone(),
            pairs: self.pairs,
            measured: self.measured,
            beyond: self.beyond,
            one_sided: self.one_sided,
            median: median(&mut self.differences),
            worst,
        });
    }

    fn pair(&self, differing: &Differing, matching: &Matching<'_>, texts: &Texts) -> PairDifference {
        let [column, _] = self.output.columns;
        let [row_a, row_b] = matching.indices(differing.pair);
        let value = |sample: Sample| {
            let number = sample.value;
            (!number.is_nan()).then(|| match column.kind {
                Kind::Real => Value::Real(number),
                Kind::Count => Value::Count(number as u64),
                Kind::Integer => Value::Integer(number as i64),
                Kind::Text | Kind::Category => Value::Text(texts.text(number as usize).to_owned()),
            })
        };
        let [value_a, value_b] = differing.samples.map(value);
        let Judged { difference, allowed, measured } = differing.judged;
        PairDifference {
            output: column.name.clone(),
            unit: column.unit.clone(),
            row_a,
            row_b,
            value_a,
            value_b,
            allowed: difference.is_finite().then_some(allowed),
            measured,
        }
    }
}

/// Ratio of a listed difference to the permitted difference.
fn excess_of(pair: &PairDifference) -> f64 {
    pair.difference().zip(pair.allowed).map_or(f64::INFINITY, |(difference, allowed)| difference / allowed)
}

/// The middle value, of an even number of them the mean of the two in the middle.
fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    let even = values.len().is_multiple_of(2);
    let (below, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let lower = if even { below.iter().copied().fold(f64::NEG_INFINITY, f64::max) } else { upper };
    Some(0.5 * (lower + upper))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: f64 = f64::NAN;

    fn judged(a: [f64; 2], b: [f64; 2]) -> Judged {
        let sample = |[value, scatter]: [f64; 2]| Sample { value, scatter };
        Judged::of([sample(a), sample(b)], false, 0.01)
    }

    #[test]
    fn ranges_that_may_meet_do_not_differ() {
        // Half ranges of 1 and 2: a may be 2 from the far end of its range, b 4 from that of its.
        assert!(!judged([10.0, 1.0], [16.0, 2.0]).is_beyond());
        assert!(judged([10.0, 1.0], [16.1, 2.0]).is_beyond());
        // Where one has none, it is taken to scatter as much.
        assert!(!judged([10.0, NONE], [14.0, 1.0]).is_beyond());
        assert!(judged([10.0, 1.0], [14.1, NONE]).is_beyond());
        assert!(judged([10.0, 0.0], [10.0 + 1e-12, 0.0]).is_beyond(), "no scatter at all");
        assert_eq!(judged([10.0, 1.0], [16.0, 2.0]), Judged { difference: 6.0, allowed: 6.0, measured: true });
    }

    #[test]
    fn without_twins_a_share_of_the_value_is_allowed() {
        assert!(!judged([100.0, NONE], [99.0, NONE]).is_beyond());
        assert!(judged([100.0, NONE], [98.9, NONE]).is_beyond());
        assert!(judged([0.0, NONE], [1e-300, NONE]).is_beyond(), "nothing is allowed of nothing");
        assert!(!judged([0.0, NONE], [-0.0, NONE]).is_beyond());
        assert!(judged([NONE, NONE], [1.0, NONE]).is_beyond(), "only one of them has a value");
        assert!(judged([NONE, 5.0], [1.0, NONE]).is_beyond());
        assert!(!judged([f64::INFINITY, NONE], [f64::INFINITY, NONE]).is_beyond());
        assert!(judged([f64::INFINITY, NONE], [1.0, NONE]).is_beyond());
    }

    #[test]
    fn texts_differ_unless_a_twin_has_the_other_one() {
        let judged = |a: [f64; 2], b: [f64; 2]| {
            let sample = |[value, scatter]: [f64; 2]| Sample { value, scatter };
            Judged::of([sample(a), sample(b)], true, 0.01).is_beyond()
        };
        assert!(judged([0.0, NONE], [1.0, NONE]));
        assert!(judged([0.0, 0.0], [1.0, 0.0]));
        assert!(!judged([0.0, 0.0], [1.0, 0.25]));
        assert!(!judged([1.0, NONE], [1.0, NONE]));
        assert!(judged([1.0, 0.25], [NONE, 0.25]), "only one of them has a value");
    }

    #[test]
    fn medians() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(&mut []), None);
    }
}
