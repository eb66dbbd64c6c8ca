//! Hypercubes that are their own mirror image through the centre: half the search, and among them lie most of the best.
//!
//! Of rows in mirrored pairs (Ye, Li and Sudjianto, J. Stat. Plan. Inference 90, 2000) each one's distances are its mirror
//! image's, so a swap and its mirror image together cost hardly more than a swap alone.

use super::optimise::{Criterion, Crowding, Swap, inverse_power};
use decore_math::random::Stream;

/// [`Crowding`] of a hypercube whose row `i` is the mirror image of row `rows - 1 - i`; every swap takes its mirror image along.
pub(super) struct Mirrored<const SQUARINGS: u32> {
    whole: Crowding<SQUARINGS>,
    rows: usize,
}

impl<const SQUARINGS: u32> Mirrored<SQUARINGS> {
    pub(super) fn new(whole: Crowding<SQUARINGS>) -> Self {
        let rows = whole.rows();
        Self { whole, rows }
    }

    fn mirror(&self, row: usize) -> usize {
        mirror(self.rows, row)
    }
}

fn mirror(rows: usize, row: usize) -> usize {
    rows - 1 - row
}

/// The swap of the mirror images; `None` if that is the swap itself.
pub(super) fn companion(rows: usize, Swap { column, a, b }: Swap) -> Option<Swap> {
    (mirror(rows, a) != b).then(|| Swap { column, a: mirror(rows, a), b: mirror(rows, b) })
}

/// Columns of such a hypercube, otherwise at random: strata 0 to `rows - 1`.
pub(super) fn columns(rows: usize, count: usize, stream: &mut Stream) -> Vec<Vec<u32>> {
    let column = |_| {
        let half = rows / 2;
        let mut lower: Vec<u32> = (0..half as u32).collect();
        stream.shuffle(&mut lower);
        let mut strata = vec![half as u32; rows];
        for (row, stratum) in lower.into_iter().enumerate() {
            let ends = [stratum, rows as u32 - 1 - stratum];
            let first = stream.below(2);
            strata[row] = ends[first];
            strata[mirror(rows, row)] = ends[1 - first];
        }
        strata
    };
    (0..count).map(column).collect()
}

impl<const SQUARINGS: u32> Criterion for Mirrored<SQUARINGS> {
    fn refresh(&mut self) -> f64 {
        self.whole.refresh()
    }

    fn change(&mut self, swap: Swap) -> f64 {
        let Swap { column, a, b } = swap;
        let (image_a, image_b) = (self.mirror(a), self.mirror(b));
        if image_a == a || image_b == b {
            // The row in the centre stays there.
            return f64::INFINITY;
        }
        if image_a == b {
            return self.whole.change(swap);
        }
        // Of the distances among these four rows only those from a row to its own image change: the two exchange them. Those to
        // all other rows change as their mirror images do.
        let entries = self.whole.column(column);
        let gap = |row: usize, image: usize| (entries[row] - entries[image]) * (entries[row] - entries[image]);
        let gain = gap(b, image_b) - gap(a, image_a);
        let own = [self.whole.square(a, image_a), self.whole.square(b, image_b)];
        let power = inverse_power::<SQUARINGS>;
        let after = power(own[0] + gain) + power(own[1] - gain);
        let others = self.whole.change_beyond(swap, &[image_a, image_b]);
        2.0 * others + after - power(own[0]) - power(own[1])
    }

    fn swap(&mut self, swap: Swap) {
        self.whole.swap(swap);
        if let Some(companion) = companion(self.rows, swap) {
            self.whole.swap(companion);
        }
    }

    fn badness(&self) -> f64 {
        self.whole.badness()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every announced change is the difference of two fresh evaluations, and mirrored rows stay mirrored.
    #[test]
    fn changes_hold() {
        for rows in [8, 9] {
            let mut stream = Stream::new(5);
            let columns = columns(rows, 3, &mut stream);
            let points = columns.iter().map(|column| column.iter().map(|stratum| f64::from(*stratum)).collect());
            let mut mirrored = Mirrored::<4>::new(Crowding::new(points.collect()));
            let mut value = mirrored.refresh();
            for _ in 0..200 {
                let a = stream.below(rows);
                let swap = Swap { column: stream.below(3), a, b: (a + 1 + stream.below(rows - 1)) % rows };
                let change = mirrored.change(swap);
                if change == f64::INFINITY {
                    continue;
                }
                mirrored.swap(swap);
                let after = mirrored.refresh();
                assert!((after - value - change).abs() <= 1e-12 * value.max(after), "{value} {after} {change}");
                value = after;
                for column in 0..3 {
                    let entries = mirrored.whole.column(column);
                    assert!((0..rows).all(|row| entries[row] + entries[rows - 1 - row] == (rows - 1) as f64));
                }
            }
        }
    }
}
