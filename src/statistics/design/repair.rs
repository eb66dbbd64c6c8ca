//! Latin hypercubes that meet constraints: by swaps at random; where these do not suffice, by matchings.
//!
//! All columns but one given, the rows that can meet the constraints at once are a maximum matching of rows and that column's
//! entries, found by augmenting paths (Kuhn 1955). Matchings of one column after the other never lose a row; between rounds
//! the rows that are left are moved at random. Constraints are added one by one, each to an arrangement that meets those
//! before it, so that matchings see which rows are half right.

use super::constraint::Conditions;
use super::error::DesignError;
use super::strata::Placement;
use super::table::{Builder, Candidate, Strata};
use decore_math::random::Stream;

/// Evaluations of rows that the search by matchings may take, per square of the number of rows, and bounds of their number.
const EVALUATIONS_PER_SQUARE: usize = 100;
const EVALUATIONS: [usize; 2] = [100_000, 16_000_000];
/// Evaluations for a proof that there is no arrangement, per pair of columns.
const PROOF_EVALUATIONS: usize = 8_000_000;
/// Largest number of rows for which a matching stores the permitted entries.
const MOST_REMEMBERED: usize = 4096;
/// Rounds over the columns before a proof is tried that there is no arrangement.
const ROUNDS: usize = 8;

impl Builder<'_, '_> {
    /// Moves entries of new rows within their columns until the constraints hold in all of them.
    pub fn repair(&mut self, table: &mut Strata, frozen: usize, stream: &mut Stream) -> Result<(), DesignError> {
        let Some(all) = self.conditions.as_ref().map(Conditions::all) else {
            return Ok(());
        };
        let before = table.columns.clone();
        if self.swapped(table, frozen, stream)? {
            return Ok(());
        }
        table.columns = before;
        let fresh = table.rows() - frozen;
        let [least, most] = EVALUATIONS;
        let left = EVALUATIONS_PER_SQUARE.saturating_mul(fresh.saturating_mul(fresh)).clamp(least, most);
        let mut search = Search { builder: self, table, frozen, stream, left };
        for count in 1..=all.len() {
            let among = &all[..count];
            if search.arrange(among, ROUNDS)? == 0 {
                continue;
            }
            if let Some(most) = search.proved()? {
                return Err(impossible(most, fresh));
            }
            let open = search.arrange(among, usize::MAX)?;
            if open > 0 {
                return Err(not_found(open, fresh));
            }
        }
        Ok(())
    }

    /// Swaps entries at random, unless it gets worse. Returns whether all rows meet the constraints in the end.
    fn swapped(&mut self, table: &mut Strata, frozen: usize, stream: &mut Stream) -> Result<bool, DesignError> {
        let rows = table.rows();
        let fresh = rows - frozen;
        let mut sound = (frozen..rows).map(|row| self.accepts(table, row)).collect::<Result<Vec<bool>, _>>()?;
        let mut bad: Vec<usize> = (0..fresh).filter(|row| !sound[*row]).collect();
        let mut left = 10_000 + 200 * fresh;
        while let Some(&last) = bad.last() {
            if sound[last] {
                bad.pop();
                continue;
            }
            if left == 0 || fresh < 2 {
                return Ok(false);
            }
            left -= 1;
            let column = stream.below(table.columns.len());
            let other = stream.below(fresh);
            if other == last {
                continue;
            }
            let (a, b) = (frozen + last, frozen + other);
            table.columns[column].swap(a, b);
            let after = [self.accepts(table, a)?, self.accepts(table, b)?];
            let score = |pair: [bool; 2]| u8::from(pair[0]) + u8::from(pair[1]);
            if score(after) < score([sound[last], sound[other]]) {
                table.columns[column].swap(a, b);
                continue;
            }
            if sound[other] && !after[1] {
                bad.push(other);
            }
            [sound[last], sound[other]] = after;
        }
        Ok(true)
    }
}

/// Remedy for either fault.
const REMEDY: &str = "narrow the ranges, or choose a kind that leaves out rows (`sobol`, `halton`, `random`)";

fn impossible(most: usize, fresh: usize) -> DesignError {
    DesignError::Unsatisfiable(format!(
        "the constraints cannot be met by a Latin hypercube: every stratum of every factor must be used, and however they are \
         paired at most {most} of {fresh} rows meet the constraints; {REMEDY}"
    ))
}

fn not_found(open: usize, fresh: usize) -> DesignError {
    DesignError::Unsatisfiable(format!(
        "no Latin hypercube that meets the constraints was found, though it is not proved that there is none: {open} of {fresh} \
         rows break them in the end, as every stratum of every factor must be used; try another seed, {REMEDY}"
    ))
}

/// A search for an arrangement of the new rows' entries. Rows and entries are counted from the first new row; an entry goes by the
/// row that holds it.
struct Search<'s, 'a, 'b> {
    builder: &'s mut Builder<'a, 'b>,
    table: &'s mut Strata,
    frozen: usize,
    stream: &'s mut Stream,
    /// Evaluations that may still be made.
    left: usize,
}

/// Rows that can hold the entries of a column, found on demand. Entries move: they are identified by the row that held them first.
struct Allowed {
    column: usize,
    /// Second column whose entry moves along to any row: the question is then whether any row can hold both entries.
    beside: Option<usize>,
    entries: Vec<usize>,
    /// By row and entry; empty if that were too many.
    known: Vec<Option<bool>>,
}

/// Search for a path through rows.
struct Walk<'a> {
    /// First row of the path.
    first: usize,
    /// Rows whose entries were looked at.
    visited: &'a mut [bool],
    /// Rows that keep their entries.
    sound: &'a [bool],
}

impl Search<'_, '_, '_> {
    fn fresh(&self) -> usize {
        self.table.rows() - self.frozen
    }

    /// Whether a row meets the constraints with these entries (column, holder) in place of its own.
    fn holds(&mut self, row: usize, entries: &[(usize, usize)], among: &[usize]) -> Result<bool, DesignError> {
        self.left = self.left.saturating_sub(1);
        let mut strata = self.table.strata(self.frozen + row);
        for (column, holder) in entries {
            strata[*column] = self.table.columns[*column][self.frozen + holder];
        }
        self.builder.meets(self.table, Candidate { row: self.frozen + row, strata: &strata }, among)
    }

    fn swap(&mut self, column: usize, [a, b]: [usize; 2]) {
        self.table.columns[column].swap(self.frozen + a, self.frozen + b);
    }

    /// The columns that some of these constraints look at; the first one if they look at none.
    fn columns(&self, among: &[usize]) -> Vec<usize> {
        let factors = self.builder.conditions.as_ref().map_or(&[][..], |conditions| conditions.factors);
        let mut columns: Vec<usize> = among.iter().filter_map(|index| factors.get(*index)).flatten().copied().collect();
        columns.retain(|column| *column < self.table.columns.len());
        columns.sort_unstable();
        columns.dedup();
        if columns.is_empty() { vec![0] } else { columns }
    }

    /// Looks for an arrangement that meets these constraints; the number of rows that break them in the end.
    fn arrange(&mut self, among: &[usize], rounds: usize) -> Result<usize, DesignError> {
        let mut columns = self.columns(among);
        let mut round = 0;
        loop {
            let mut sound =
                (0..self.fresh()).map(|row| self.holds(row, &[], among)).collect::<Result<Vec<bool>, _>>()?;
            self.stream.shuffle(&mut columns);
            for column in &columns {
                if sound.iter().all(|sound| *sound) {
                    return Ok(0);
                }
                let mut allowed = self.unknown(*column, None);
                self.rematch(&mut allowed, among, &mut sound)?;
            }
            let open: Vec<usize> = (0..sound.len()).filter(|row| !sound[*row]).collect();
            round += 1;
            // A single column is decided by one matching.
            if open.is_empty() || columns.len() == 1 || round >= rounds || self.left == 0 {
                return Ok(open.len());
            }
            for row in open {
                let column = columns[self.stream.below(columns.len())];
                let other = self.stream.below(sound.len());
                self.swap(column, [row, other]);
            }
        }
    }

    fn unknown(&self, column: usize, beside: Option<usize>) -> Allowed {
        let count = self.fresh();
        let squares = if count <= MOST_REMEMBERED { count * count } else { 0 };
        Allowed { column, beside, entries: (0..count).collect(), known: vec![None; squares] }
    }

    /// A maximum matching of rows and entries of a column, unless evaluations run out; rows that are sound stay so.
    fn rematch(&mut self, allowed: &mut Allowed, among: &[usize], sound: &mut [bool]) -> Result<(), DesignError> {
        let mut order: Vec<usize> = (0..sound.len()).collect();
        self.stream.shuffle(&mut order);
        let mut grown = true;
        while grown && self.left > 0 {
            grown = false;
            // An entry from which no free one was reached is of no use to the next row either.
            let mut visited = vec![false; sound.len()];
            for &row in &order {
                if sound[row] {
                    continue;
                }
                let walk = Walk { first: row, visited: &mut visited, sound };
                if let Some(path) = self.path(allowed, among, walk)? {
                    grown = true;
                    self.shift(allowed, &path);
                    for row in path {
                        sound[row] = self.can_hold(allowed, [row, row], among)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Breadth first from a row to one that is not sound and gives up its entry: the rows on the way, each of which can hold the
    /// entry of the next.
    fn path(
        &mut self,
        allowed: &mut Allowed,
        among: &[usize],
        walk: Walk<'_>,
    ) -> Result<Option<Vec<usize>>, DesignError> {
        let Walk { first, visited, sound } = walk;
        let count = sound.len();
        let mut reached = vec![(first, 0)];
        let mut next = 0;
        while next < reached.len() && self.left > 0 {
            let (row, _) = reached[next];
            let offset = self.stream.below(count);
            // Entries that are free first: they end the search.
            for free in [true, false] {
                for holder in (offset..count).chain(0..offset) {
                    if visited[holder] || sound[holder] == free || !self.can_hold(allowed, [row, holder], among)? {
                        continue;
                    }
                    visited[holder] = true;
                    if !free {
                        reached.push((holder, next));
                        continue;
                    }
                    // The entry of the first row closes the path to a circle.
                    let mut path = if holder == first { Vec::new() } else { vec![holder] };
                    while next > 0 {
                        path.push(reached[next].0);
                        next = reached[next].1;
                    }
                    path.push(first);
                    path.reverse();
                    return Ok(Some(path));
                }
            }
            next += 1;
        }
        Ok(None)
    }

    /// Whether a row can hold the entry that another one holds now.
    fn can_hold(
        &mut self,
        allowed: &mut Allowed,
        [row, holder]: [usize; 2],
        among: &[usize],
    ) -> Result<bool, DesignError> {
        let place = row * self.fresh() + allowed.entries[holder];
        if let Some(Some(known)) = allowed.known.get(place) {
            return Ok(*known);
        }
        let mut holds = self.holds(row, &[(allowed.column, holder)], among)?;
        if let Some(beside) = allowed.beside {
            let mut others = 0..self.fresh();
            while let (false, Some(other)) = (holds, others.next()) {
                holds = self.holds(other, &[(allowed.column, holder), (beside, row)], among)?;
            }
        }
        if let Some(known) = allowed.known.get_mut(place) {
            *known = Some(holds);
        }
        Ok(holds)
    }

    /// Every row of the path takes the entry of the next one, the last row the entry of the first.
    fn shift(&mut self, allowed: &mut Allowed, path: &[usize]) {
        for pair in path.windows(2) {
            self.swap(allowed.column, [pair[0], pair[1]]);
            allowed.entries.swap(pair[0], pair[1]);
        }
    }

    /// Largest number of rows that can meet the constraints, if it is proved to be less than all.
    ///
    /// Constraints that look at one column, or at two, are proved by a maximum matching. Rows differ from each other by the places
    /// of their points within the strata: of two columns the strata are matched, and may be paired if any row allows it.
    fn proved(&mut self) -> Result<Option<usize>, DesignError> {
        let all = self.builder.conditions.as_ref().map_or(Vec::new(), Conditions::all);
        let mut pairs: Vec<Vec<usize>> = all.iter().map(|index| self.columns(&[*index])).collect();
        pairs.retain(|columns| columns.len() <= 2);
        pairs.sort_unstable();
        pairs.dedup();
        let centred = self.builder.latin.spec.placement == Placement::Centred;
        for pair in pairs {
            let inside = |index: &usize| self.columns(&[*index]).iter().all(|column| pair.contains(column));
            let among: Vec<usize> = all.iter().copied().filter(inside).collect();
            let (column, beside) = match pair[..] {
                [first, second] => (second, Some(first).filter(|_| !centred)),
                _ => (pair[0], None),
            };
            let left = std::mem::replace(&mut self.left, PROOF_EVALUATIONS);
            let mut allowed = self.unknown(column, beside);
            let mut sound = vec![false; self.fresh()];
            for (row, sound) in sound.iter_mut().enumerate() {
                *sound = self.can_hold(&mut allowed, [row, row], &among)?;
            }
            self.rematch(&mut allowed, &among, &mut sound)?;
            let most = sound.iter().filter(|sound| **sound).count();
            let complete = std::mem::replace(&mut self.left, left) > 0;
            if most < sound.len() && complete {
                return Ok(Some(most));
            }
        }
        Ok(None)
    }
}
