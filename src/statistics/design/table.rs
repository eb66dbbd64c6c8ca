//! Tables of the strata of Latin hypercubes whose rows depend on each other: built stage by stage.

use super::constraint::Conditions;
use super::coordinate::Coordinate;
use super::correlation::Correlation;
use super::error::DesignError;
use super::strata::OpenHypercube;
use decore_math::random::{Stream, hash};

/// Streams of random numbers beyond those of the factors, counted on by the stage.
pub(super) const OPTIMISER_STREAM: u64 = 1 << 40;
const GROWTH_STREAM: u64 = 1 << 41;
const REPAIR_STREAM: u64 = 1 << 42;
const CORRELATION_STREAM: u64 = 1 << 43;

/// Strata by column and row; `stages`: number of strata and of rows at the end of each stage.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Strata {
    stages: Vec<usize>,
    pub columns: Vec<Vec<u32>>,
}

impl Strata {
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    pub fn strata_of(&self, row: usize) -> usize {
        self.stages.iter().copied().find(|stage| row < *stage).unwrap_or(1)
    }

    /// A row's strata.
    pub fn strata(&self, row: usize) -> Vec<u32> {
        self.columns.iter().filter_map(|column| column.get(row)).copied().collect()
    }
}

/// An entry of a table.
#[derive(Clone, Copy)]
struct Entry {
    row: usize,
    column: usize,
}

/// Candidate for a row.
#[derive(Clone, Copy)]
pub(super) struct Candidate<'a> {
    /// The row.
    pub row: usize,
    /// Stratum in each column.
    pub strata: &'a [u32],
}

/// Makes the table of a Latin hypercube.
pub(super) struct Builder<'a, 'b> {
    pub latin: &'a OpenHypercube,
    pub conditions: Option<Conditions<'b>>,
    pub correlation: Option<&'a Correlation>,
}

impl Builder<'_, '_> {
    pub fn build(mut self) -> Result<Strata, DesignError> {
        let spec = &self.latin.spec;
        let mut table = Strata { stages: Vec::new(), columns: vec![Vec::new(); self.latin.columns()] };
        for (stage, &rows) in spec.grown_from.iter().chain([&spec.rows]).enumerate() {
            let frozen = table.stages.last().copied().unwrap_or(0);
            let stream = |stream: u64| Stream::new(hash(self.latin.seed, stream, stage as u64));
            let [mut growth, mut repair] = [GROWTH_STREAM, REPAIR_STREAM].map(stream);
            let [mut correlation, mut optimiser] = [CORRELATION_STREAM, OPTIMISER_STREAM].map(stream);
            if frozen == 0 {
                for (column, strata) in table.columns.iter_mut().enumerate() {
                    strata.extend((0..rows).map(|row| self.latin.stratum(row as u64, column as u64) as u32));
                }
            } else {
                self.grow(&mut table, rows, &mut growth);
            }
            table.stages.push(rows);
            if let Some(correlation) = self.correlation {
                let mut fresh: Vec<&mut [u32]> =
                    table.columns.iter_mut().filter_map(|column| column.get_mut(frozen..)).collect();
                correlation.rearrange(&mut fresh)?;
            }
            self.repair(&mut table, frozen, &mut repair)?;
            self.refine(&mut table, frozen, &mut correlation)?;
            self.optimise(&mut table, frozen, &mut optimiser)?;
        }
        Ok(table)
    }

    /// Adds rows in strata that are empty, the ones farthest from being hit first where there are more than rows.
    fn grow(&self, table: &mut Strata, rows: usize, stream: &mut Stream) {
        let frozen = table.stages.last().copied().unwrap_or(0);
        for column in 0..self.latin.columns() {
            let mut hit = vec![false; rows];
            for row in 0..frozen {
                if let Some(hit) = hit.get_mut(self.stratum_among(table, Entry { row, column }, rows)) {
                    *hit = true;
                }
            }
            let empty: Vec<u32> = (0..rows as u32).filter(|stratum| !hit[*stratum as usize]).collect();
            let added = rows - frozen;
            // Evenly spread over the empty strata; there are at least as many as rows are added.
            let spread = |index: usize| empty[((2 * index + 1) * empty.len()) / (2 * added)];
            let mut fresh: Vec<u32> = (0..added).map(spread).collect();
            stream.shuffle(&mut fresh);
            table.columns[column].extend(fresh);
        }
    }

    /// Stratum of an earlier row when the range is cut into `strata` ones.
    fn stratum_among(&self, table: &Strata, Entry { row, column }: Entry, strata: usize) -> usize {
        let before = table.strata_of(row);
        let stratum = table.columns[column][row] as usize;
        // In whole numbers as far as possible: exact where the new number is a multiple of the old.
        let (whole, rest) = (stratum * strata / before, stratum * strata % before);
        let place = self.latin.place(row, column) * strata as f64;
        (whole + ((rest as f64 + place) / before as f64) as usize).min(strata - 1)
    }

    /// Coordinates of a row with these strata.
    pub fn coordinates(&self, table: &Strata, row: usize, entries: &[u32]) -> Vec<Coordinate> {
        let strata = table.strata_of(row) as u64;
        let coordinate = |(column, entry): (usize, &u32)| {
            let place = self.latin.place(row, column);
            Coordinate::Stratum { stratum: u64::from(*entry), strata, place }
        };
        entries.iter().enumerate().map(coordinate).collect()
    }

    /// Whether a row with these strata meets the constraints named.
    pub fn meets(
        &mut self,
        table: &Strata,
        Candidate { row, strata }: Candidate<'_>,
        among: &[usize],
    ) -> Result<bool, DesignError> {
        let coordinates = self.coordinates(table, row, strata);
        let met = self.conditions.as_mut().map(|conditions| (conditions.met)(&coordinates, among));
        Ok(met.transpose()?.is_none_or(|met| met == among.len()))
    }

    /// Whether a row meets all constraints.
    pub fn accepts(&mut self, table: &Strata, row: usize) -> Result<bool, DesignError> {
        let all = self.conditions.as_ref().map_or(Vec::new(), Conditions::all);
        self.meets(table, Candidate { row, strata: &table.strata(row) }, &all)
    }
}
