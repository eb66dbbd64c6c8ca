//! Rank correlations of a hypercube's new rows compared with the wanted ones, updated from swap to swap.

use super::correlation::Correlation;
use super::optimise::Swap;
use decore_math::random::Stream;

/// Neighbours in rank are up to this share of the rows apart.
const NEIGHBOURHOOD: usize = 10;

/// Ranks by column of the rows from `frozen` on, and the sums that their correlations (Spearman) are made of.
pub(super) struct Ranks {
    frozen: usize,
    /// Ranks about their mean.
    columns: Vec<Vec<f64>>,
    /// Rows by rank.
    orders: Vec<Vec<usize>>,
    /// Sums over the rows of the products of two columns' ranks.
    products: Vec<Vec<f64>>,
    /// The same of a column with itself.
    norm: f64,
    asked: Vec<Vec<f64>>,
}

impl Ranks {
    /// Of the rows from `frozen` on of a table of strata by column.
    pub(super) fn new(correlation: &Correlation, table: &[Vec<u32>], frozen: usize) -> Self {
        let fresh = |column: &Vec<u32>| column.get(frozen..).unwrap_or(&[]).to_vec();
        let order = |column: &Vec<u32>| {
            let strata = fresh(column);
            let mut order: Vec<usize> = (0..strata.len()).collect();
            order.sort_by_key(|row| strata[*row]);
            order
        };
        let orders: Vec<Vec<usize>> = table.iter().map(order).collect();
        let rows = orders.first().map_or(0, Vec::len);
        let middle = 0.5 * (rows.max(1) - 1) as f64;
        let ranks = |order: &Vec<usize>| {
            let mut ranks = vec![0.0; rows];
            order.iter().enumerate().for_each(|(rank, row)| ranks[*row] = rank as f64 - middle);
            ranks
        };
        let columns: Vec<Vec<f64>> = orders.iter().map(ranks).collect();
        let product = |a: &Vec<f64>, b: &Vec<f64>| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let products = columns.iter().map(|a| columns.iter().map(|b| product(a, b)).collect()).collect();
        let norm = columns.first().map_or(1.0, |column| product(column, column)).max(1.0);
        Self { frozen, columns, orders, products, norm, asked: correlation.asked().to_vec() }
    }

    /// Deviation of a correlation from the wanted one, with `more` added to its sum of products.
    fn error(&self, a: usize, b: usize, more: f64) -> f64 {
        (self.products[a][b] + more) / self.norm - self.asked[a][b]
    }

    /// Change of the sum of products of a column with another one by a swap.
    fn gain(&self, Swap { column, a, b }: Swap, other: usize) -> f64 {
        let [a, b] = [a, b].map(|row| row - self.frozen);
        let (own, other) = (&self.columns[column], &self.columns[other]);
        (own[a] - own[b]) * (other[b] - other[a])
    }

    fn others(&self, column: usize) -> impl Iterator<Item = usize> {
        (0..self.columns.len()).filter(move |other| *other != column)
    }

    /// The largest difference from a correlation asked for.
    pub(super) fn worst(&self) -> f64 {
        let row = |column| self.others(column).map(move |other| self.error(column, other, 0.0).abs());
        (0..self.columns.len()).flat_map(row).fold(0.0, f64::max)
    }

    /// The largest difference of the swap's column after it.
    pub(super) fn worst_after(&self, swap: Swap) -> f64 {
        let error = |other| self.error(swap.column, other, self.gain(swap, other)).abs();
        self.others(swap.column).map(error).fold(0.0, f64::max)
    }

    /// Change of the sum of the squared differences by a swap.
    pub(super) fn change(&self, swap: Swap) -> f64 {
        let change = |other| {
            let [before, after] = [0.0, self.gain(swap, other)].map(|more| self.error(swap.column, other, more));
            after * after - before * before
        };
        self.others(swap.column).map(change).sum()
    }

    /// Two rows, counted from the first new one, whose ranks in a column are close; `None` if the draw falls off the end.
    pub(super) fn neighbours(&self, column: usize, stream: &mut Stream) -> Option<[usize; 2]> {
        let order = &self.orders[column];
        let rank = stream.below(order.len());
        let step = 1 + stream.below((order.len() / NEIGHBOURHOOD).max(1));
        Some([order[rank], *order.get(rank + step)?])
    }

    /// Makes the swap.
    pub(super) fn swap(&mut self, swap: Swap) {
        let Swap { column, a, b } = swap;
        for other in 0..self.columns.len() {
            if other != column {
                let gain = self.gain(swap, other);
                self.products[column][other] += gain;
                self.products[other][column] += gain;
            }
        }
        let [a, b] = [a, b].map(|row| row - self.frozen);
        let ranks = &mut self.columns[column];
        ranks.swap(a, b);
        let middle = 0.5 * (ranks.len().max(1) - 1) as f64;
        for row in [a, b] {
            self.orders[column][(ranks[row] + middle) as usize] = row;
        }
    }
}
