//! Optimisation of Latin hypercubes: threshold accepting over swaps of two entries of a column.
//!
//! Swaps keep every column a permutation. A swap is taken if it worsens the criterion by less than a threshold, which
//! falls geometrically to nothing (Dueck and Scheuer, J. Comput. Phys. 90, 1990): annealing without the exponential
//! function, whose last digit differs from one system's library to the next, while a design must not.

use decore_math::random::Stream;

/// Steps in which the threshold falls.
const STAGES: u64 = 400;
/// Lanes of the sums: fixed, so that the order of additions does not depend on the machine.
const LANES: usize = 8;

/// A quantity to be made small by swaps.
pub(super) trait Criterion {
    /// Recomputes all sums from the points; returns the quantity.
    fn refresh(&mut self) -> f64;
    /// Change of the quantity if rows `a` and `b` swap their entries in `column`.
    fn change(&mut self, swap: Swap) -> f64;
    /// Makes the swap.
    fn swap(&mut self, swap: Swap);
    /// Criterion by which designs are compared at the end; smaller is better.
    fn badness(&self) -> f64;
}

/// Two rows swap their entries in a column.
#[derive(Debug, Clone, Copy)]
pub(super) struct Swap {
    pub column: usize,
    pub a: usize,
    pub b: usize,
}

/// Length and temperature of the search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Schedule {
    pub proposals: u64,
    /// First and last threshold, relative to the quantity.
    pub thresholds: [f64; 2],
}

/// Movable rows and permitted swaps.
pub(super) struct Freedom<'a> {
    pub columns: usize,
    pub frozen: usize,
    pub rows: usize,
    pub allowed: &'a mut dyn FnMut(&[Swap], Swap) -> bool,
}

/// Anneals; returns the swaps that lead to the best design found.
pub(super) fn anneal(
    criterion: &mut impl Criterion,
    schedule: Schedule,
    freedom: Freedom<'_>,
    stream: &mut Stream,
) -> Vec<Swap> {
    let mobile = freedom.rows - freedom.frozen;
    let mut taken = Vec::new();
    let mut best = (f64::INFINITY, 0);
    if mobile < 2 || freedom.columns == 0 {
        return taken;
    }
    let [mut threshold, last] = schedule.thresholds;
    let cooling = root(last / threshold, STAGES - 1);
    for _ in 0..STAGES {
        let mut value = criterion.refresh();
        if criterion.badness() < best.0 {
            best = (criterion.badness(), taken.len());
        }
        for _ in 0..schedule.proposals.div_ceil(STAGES) {
            let swap = draw(&freedom, mobile, stream);
            let change = criterion.change(swap);
            if change < threshold * value && (freedom.allowed)(&taken, swap) {
                criterion.swap(swap);
                value += change;
                taken.push(swap);
            }
        }
        threshold *= cooling;
    }
    criterion.refresh();
    if criterion.badness() >= best.0 {
        taken.truncate(best.1);
    }
    taken
}

fn draw(freedom: &Freedom<'_>, mobile: usize, stream: &mut Stream) -> Swap {
    let column = stream.below(freedom.columns);
    let a = stream.below(mobile);
    let other = stream.below(mobile - 1);
    let b = other + usize::from(other >= a);
    Swap { column, a: freedom.frozen + a, b: freedom.frozen + b }
}

/// The `degree`-th root of a number in (0, 1], by bisection: made of multiplications only, the same on every system.
fn root(number: f64, degree: u64) -> f64 {
    let power = |base: f64| (0..degree).fold(1.0, |product, _| product * base);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if power(middle) < number { low = middle } else { high = middle }
    }
    high
}

/// Sum of the squared distances' inverse powers: phi_p to the p-th, small where the smallest distance is large.
///
/// The squares are squared so many times: p = 32 for 4, p = 16 for 3.
pub(super) struct Crowding<const SQUARINGS: u32> {
    /// Coordinates, a column after the other.
    points: Vec<Vec<f64>>,
    rows: usize,
    /// Squared distances; infinite from a row to itself.
    squares: Vec<f64>,
    /// Sum per row.
    sums: Vec<f64>,
}

impl<const SQUARINGS: u32> Crowding<SQUARINGS> {
    /// `points`: coordinates by column, scaled so that neighbours of a column lie about 1 apart.
    pub(super) fn new(points: Vec<Vec<f64>>) -> Self {
        let rows = points.first().map_or(0, Vec::len);
        let mut squares = vec![0.0; rows * rows];
        for column in &points {
            for (line, a) in squares.chunks_exact_mut(rows).zip(column) {
                line.iter_mut().zip(column).for_each(|(square, b)| *square += (a - b) * (a - b));
            }
        }
        for (row, line) in squares.chunks_exact_mut(rows).enumerate() {
            line[row] = f64::INFINITY;
        }
        Self { points, rows, squares, sums: vec![0.0; rows] }
    }

    fn line(&self, row: usize) -> &[f64] {
        &self.squares[row * self.rows..(row + 1) * self.rows]
    }

    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    pub(super) fn column(&self, column: usize) -> &[f64] {
        &self.points[column]
    }

    pub(super) fn square(&self, a: usize, b: usize) -> f64 {
        self.squares[a * self.rows + b]
    }

    /// Change by a swap of the part that the distances to all rows but the two themselves and those `beside` make up.
    pub(super) fn change_beyond(&mut self, Swap { column, a, b }: Swap, beside: &[usize]) -> f64 {
        // Distances that are left out are made infinite for a while; that of the two rows to each other stays.
        let left_out = [b].into_iter().chain(beside.iter().copied()).map(|row| (a, row));
        let left_out = left_out.chain([a].into_iter().chain(beside.iter().copied()).map(|row| (b, row)));
        let mut own = [(0, 0.0); 6];
        let mut left = 0.0;
        for (kept, (row, other)) in own.iter_mut().zip(left_out) {
            let place = row * self.rows + other;
            *kept = (place, self.squares[place]);
            left += inverse_power::<SQUARINGS>(self.squares[place]);
            self.squares[place] = f64::INFINITY;
        }
        let entries = &self.points[column];
        let shift = Shift { gap: entries[b] - entries[a], sum: entries[b] + entries[a] };
        let after = shift.crowding::<SQUARINGS>([self.line(a), self.line(b)], entries);
        for (place, square) in own.into_iter().take(2 + 2 * beside.len()) {
            self.squares[place] = square;
        }
        after - (self.sums[a] + self.sums[b] - left)
    }
}

/// `square^-(2^SQUARINGS)`.
#[inline(always)]
pub(super) fn inverse_power<const SQUARINGS: u32>(square: f64) -> f64 {
    let mut power = 1.0 / square;
    for _ in 0..SQUARINGS {
        power *= power;
    }
    power
}

/// Of a swap of entries `x_a` and `x_b`: the squared distance to a point at `x` grows by `gap (sum - 2 x)` for row a and
/// shrinks by as much for row b.
struct Shift {
    gap: f64,
    sum: f64,
}

impl Shift {
    fn at(&self, x: f64) -> f64 {
        self.gap * (self.sum - 2.0 * x)
    }

    /// Sum of both rows' inverse powers after the swap.
    fn crowding<const SQUARINGS: u32>(&self, [line_a, line_b]: [&[f64]; 2], column: &[f64]) -> f64 {
        let mut lanes = [0.0; LANES];
        let term = |a: f64, b: f64, x: f64| {
            let shift = self.at(x);
            inverse_power::<SQUARINGS>(a + shift) + inverse_power::<SQUARINGS>(b - shift)
        };
        let [a, b, x] = [line_a, line_b, column].map(|entries| entries.chunks_exact(LANES));
        let rest = a.remainder().iter().zip(b.remainder()).zip(x.remainder());
        for (lane, ((a, b), x)) in lanes.iter_mut().zip(rest) {
            *lane = term(*a, *b, *x);
        }
        for ((a, b), x) in a.zip(b).zip(x) {
            for lane in 0..LANES {
                lanes[lane] += term(a[lane], b[lane], x[lane]);
            }
        }
        lanes.iter().sum()
    }
}

impl<const SQUARINGS: u32> Criterion for Crowding<SQUARINGS> {
    fn refresh(&mut self) -> f64 {
        for (sum, line) in self.sums.iter_mut().zip(self.squares.chunks_exact(self.rows)) {
            *sum = line.iter().copied().map(inverse_power::<SQUARINGS>).sum();
        }
        0.5 * self.sums.iter().sum::<f64>()
    }

    fn change(&mut self, swap: Swap) -> f64 {
        self.change_beyond(swap, &[])
    }

    fn swap(&mut self, Swap { column, a, b }: Swap) {
        let entries = &mut self.points[column];
        let shift = Shift { gap: entries[b] - entries[a], sum: entries[b] + entries[a] };
        let own = inverse_power::<SQUARINGS>(self.squares[a * self.rows + b]);
        let mut sums = [own; 2];
        for (other, x) in entries.iter().enumerate().filter(|(other, _)| *other != a && *other != b) {
            for (row, sign, sum) in [(a, 1.0, 0), (b, -1.0, 1)] {
                let before = self.squares[row * self.rows + other];
                let after = before + sign * shift.at(*x);
                self.squares[row * self.rows + other] = after;
                self.squares[other * self.rows + row] = after;
                let power = inverse_power::<SQUARINGS>(after);
                sums[sum] += power;
                self.sums[other] += power - inverse_power::<SQUARINGS>(before);
            }
        }
        [self.sums[a], self.sums[b]] = sums;
        entries.swap(a, b);
    }

    fn badness(&self) -> f64 {
        -self.squares.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// Squared centred L2 discrepancy (Hickernell 1998).
pub(super) struct CentredDiscrepancy {
    /// Coordinates less one half, by column.
    points: Vec<Vec<f64>>,
    rows: usize,
    /// Product over the columns for each pair of rows.
    pairs: Vec<f64>,
    /// Product over the columns for each row against the cube.
    singles: Vec<f64>,
}

fn single(z: f64) -> f64 {
    1.0 + 0.5 * z.abs() - 0.5 * z * z
}

fn pair(a: f64, b: f64) -> f64 {
    1.0 + 0.5 * a.abs() + 0.5 * b.abs() - 0.5 * (a - b).abs()
}

impl CentredDiscrepancy {
    /// `points`: coordinates in the unit cube by column.
    pub(super) fn new(mut points: Vec<Vec<f64>>) -> Self {
        let rows = points.first().map_or(0, Vec::len);
        points.iter_mut().flatten().for_each(|x| *x -= 0.5);
        Self { points, rows, pairs: Vec::new(), singles: Vec::new() }
    }

    fn value(&self) -> f64 {
        let rows = self.rows as f64;
        let volume = (0..self.points.len()).fold(1.0, |product, _| product * (13.0 / 12.0));
        volume - 2.0 / rows * self.singles.iter().sum::<f64>() + self.pairs.iter().sum::<f64>() / (rows * rows)
    }
}

impl Criterion for CentredDiscrepancy {
    fn refresh(&mut self) -> f64 {
        self.singles = vec![1.0; self.rows];
        self.pairs = vec![1.0; self.rows * self.rows];
        for column in &self.points {
            for ((line, product), a) in self.pairs.chunks_exact_mut(self.rows).zip(&mut self.singles).zip(column) {
                *product *= single(*a);
                line.iter_mut().zip(column).for_each(|(product, b)| *product *= pair(*a, *b));
            }
        }
        self.value()
    }

    fn change(&mut self, Swap { column, a, b }: Swap) -> f64 {
        let (entries, rows) = (&self.points[column], self.rows);
        let (x_a, x_b) = (entries[a], entries[b]);
        let line = |row: usize| &self.pairs[row * rows..(row + 1) * rows];
        let mut lanes = [0.0; LANES];
        let term = |a: f64, b: f64, x: f64| {
            let (to_a, to_b) = (pair(x_a, x), pair(x_b, x));
            a * (to_b / to_a - 1.0) + b * (to_a / to_b - 1.0)
        };
        let [left, right, x] = [line(a), line(b), entries].map(|entries| entries.chunks_exact(LANES));
        let rest = left.remainder().iter().zip(right.remainder()).zip(x.remainder());
        for (lane, ((left, right), x)) in lanes.iter_mut().zip(rest) {
            *lane = term(*left, *right, *x);
        }
        for ((left, right), x) in left.zip(right).zip(x) {
            for lane in 0..LANES {
                lanes[lane] += term(left[lane], right[lane], x[lane]);
            }
        }
        let mut others: f64 = lanes.iter().sum();
        // The two rows themselves were counted as if they stood still: their own pair does not change, and each row's
        // pair with itself is no pair of distinct rows.
        let own = line(a)[b];
        others -= term(line(a)[a], own, x_a) + term(own, line(b)[b], x_b);
        let selves =
            line(a)[a] * (pair(x_b, x_b) / pair(x_a, x_a) - 1.0) + line(b)[b] * (pair(x_a, x_a) / pair(x_b, x_b) - 1.0);
        let ratio = single(x_b) / single(x_a);
        let singles = self.singles[a] * (ratio - 1.0) + self.singles[b] * (1.0 / ratio - 1.0);
        let count = rows as f64;
        (2.0 * others + selves) / (count * count) - 2.0 / count * singles
    }

    fn swap(&mut self, Swap { column, a, b }: Swap) {
        let (entries, rows) = (&mut self.points[column], self.rows);
        let (x_a, x_b) = (entries[a], entries[b]);
        for (other, x) in entries.iter().enumerate().filter(|(other, _)| *other != a && *other != b) {
            let ratio = pair(x_b, *x) / pair(x_a, *x);
            for (row, ratio) in [(a, ratio), (b, 1.0 / ratio)] {
                let product = self.pairs[row * rows + other] * ratio;
                self.pairs[row * rows + other] = product;
                self.pairs[other * rows + row] = product;
            }
        }
        let ratio = single(x_b) / single(x_a);
        self.singles[a] *= ratio;
        self.singles[b] /= ratio;
        let ratio = pair(x_b, x_b) / pair(x_a, x_a);
        self.pairs[a * rows + a] *= ratio;
        self.pairs[b * rows + b] /= ratio;
        entries.swap(a, b);
    }

    fn badness(&self) -> f64 {
        self.value()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(rows: usize, columns: usize, scale: f64) -> Vec<Vec<f64>> {
        let mut stream = Stream::new(3);
        let column = |_| {
            let mut column: Vec<f64> = (0..rows).map(|i| (i as f64 + 0.5) * scale).collect();
            stream.shuffle(&mut column);
            column
        };
        (0..columns).map(column).collect()
    }

    /// Every announced change is the difference of two fresh evaluations.
    fn changes_hold(criterion: &mut impl Criterion) {
        let mut stream = Stream::new(1);
        let mut value = criterion.refresh();
        for _ in 0..50 {
            let a = stream.below(19);
            let swap = Swap { column: stream.below(4), a, b: (a + 1 + stream.below(18)) % 19 };
            let change = criterion.change(swap);
            criterion.swap(swap);
            let after = criterion.refresh();
            let scale = value.abs().max(after.abs());
            assert!((after - value - change).abs() <= 1e-12 * scale, "{value} {after} {change}");
            value = after;
        }
    }

    #[test]
    fn changes_of_crowding_hold() {
        changes_hold(&mut Crowding::<4>::new(points(19, 4, 1.0)));
    }

    #[test]
    fn changes_of_discrepancy_hold() {
        changes_hold(&mut CentredDiscrepancy::new(points(19, 4, 1.0 / 19.0)));
    }
}
