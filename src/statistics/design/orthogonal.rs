//! Finite fields and designs from them: orthogonal arrays of strength two, Hadamard matrices.

/// Irreducible monic polynomials of the small prime powers: (order, prime, coefficients below the leading
/// one, constant first).
const POLYNOMIALS: [(u64, u64, &[u64]); 8] = [
    (4, 2, &[1, 1]),
    (8, 2, &[1, 1, 0]),
    (9, 3, &[1, 0]),
    (16, 2, &[1, 1, 0, 0]),
    (25, 5, &[2, 0]),
    (27, 3, &[1, 2, 0]),
    (32, 2, &[1, 0, 1, 0, 0]),
    (49, 7, &[1, 0]),
];

/// A finite field; elements are 0..order, digits in base `prime` being the coefficients of a polynomial.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    order: u64,
    prime: u64,
    polynomial: &'static [u64],
}

impl Field {
    /// The field of this order, if there is one and it is known here: primes and prime powers up to 49.
    pub(super) fn new(order: u64) -> Option<Self> {
        if is_prime(order) {
            return Some(Self { order, prime: order, polynomial: &[0] });
        }
        let (order, prime, polynomial) = *POLYNOMIALS.iter().find(|(known, ..)| *known == order)?;
        Some(Self { order, prime, polynomial })
    }

    /// Number of elements.
    pub(super) fn order(&self) -> u64 {
        self.order
    }

    pub(super) fn add(&self, a: u64, b: u64) -> u64 {
        self.combine(a, b, |a, b| a + b)
    }

    pub(super) fn subtract(&self, a: u64, b: u64) -> u64 {
        self.combine(a, b, |a, b| a + self.prime - b)
    }

    fn combine(&self, mut a: u64, mut b: u64, digit: impl Fn(u64, u64) -> u64) -> u64 {
        let (mut sum, mut place) = (0, 1);
        for _ in self.polynomial {
            sum += digit(a % self.prime, b % self.prime) % self.prime * place;
            (a, b) = (a / self.prime, b / self.prime);
            place *= self.prime;
        }
        sum
    }

    pub(super) fn multiply(&self, a: u64, b: u64) -> u64 {
        if self.polynomial.len() == 1 {
            return (u128::from(a) * u128::from(b) % u128::from(self.order)) as u64;
        }
        let top = self.order / self.prime;
        // Horner over b's digits, the highest first: shift by x, reduce, add.
        let (mut product, mut place) = (0, top);
        while place > 0 {
            let carried = product / top;
            let shifted = product % top * self.prime;
            let reduction = self.polynomial.iter().rev().fold(0, |word, digit| word * self.prime + digit);
            product = self.subtract(shifted, self.scale(reduction, carried));
            product = self.add(product, self.scale(a, b / place % self.prime));
            place /= self.prime;
        }
        product
    }

    /// `digit` times an element.
    fn scale(&self, element: u64, digit: u64) -> u64 {
        (0..digit).fold(0, |sum, _| self.add(sum, element))
    }

    /// Quadratic character: 0 for 0, 1 for squares, -1 for others.
    fn characters(&self) -> Vec<i8> {
        let mut characters = vec![-1; self.order as usize];
        for element in 0..self.order {
            if let Some(character) = characters.get_mut(self.multiply(element, element) as usize) {
                *character = i8::from(element != 0);
            }
        }
        characters
    }
}

fn is_prime(number: u64) -> bool {
    number >= 2
        && (2..).take_while(|divisor| divisor * divisor <= number).all(|divisor| !number.is_multiple_of(divisor))
}

/// Symbol in row `row` and column `column` of the orthogonal array of strength two by Bose: `order^2` rows, up to
/// `order + 1` columns; every pair of symbols stands once in every two columns. Also the row's rank among those with the
/// same symbol in the column.
pub(super) fn bose(field: &Field, row: u64, column: u64) -> (u64, u64) {
    let (a, b) = (row / field.order, row % field.order);
    // Columns b, a, a + b, a + 2 b ...: in the first the rank is a, in the others b tells equal symbols apart.
    if column == 0 { (b, a) } else { (field.add(a, field.multiply(column - 1, b)), b) }
}

/// Signs of a Plackett-Burman design of `runs` rows: `runs - 1` balanced orthogonal columns. `None` if no construction
/// is known here.
///
/// Paley's first construction, doubling, and Paley's second: all multiples of four below 92.
pub(super) fn plackett_burman(runs: usize) -> Option<Vec<Vec<i8>>> {
    let hadamard = hadamard(runs)?;
    // Rows are signed so that the first column is all ones, which is then the mean.
    let normalise = |row: Vec<i8>| {
        let sign = row.first().copied().unwrap_or(1);
        row.into_iter().skip(1).map(|entry| entry * sign).collect()
    };
    Some(hadamard.into_iter().map(normalise).collect())
}

fn hadamard(size: usize) -> Option<Vec<Vec<i8>>> {
    if size == 1 {
        return Some(vec![vec![1]]);
    }
    if size == 2 || !size.is_multiple_of(4) {
        return (size == 2).then(|| vec![vec![1, 1], vec![1, -1]]);
    }
    let order = size as u64 - 1;
    if let Some(field) = Field::new(order).filter(|_| order % 4 == 3) {
        return Some(paley(&field, |_, core| vec![vec![core]], 1));
    }
    if let Some(half) = hadamard(size / 2) {
        let double = |sign: i8| {
            half.iter().map(move |row| row.iter().copied().chain(row.iter().map(move |e| sign * e)).collect())
        };
        return Some(double(1).chain(double(-1)).collect());
    }
    let order = size as u64 / 2 - 1;
    let field = Field::new(order).filter(|_| order % 4 == 1)?;
    // Entries 0 of the symmetric conference matrix become [[1, -1], [-1, -1]], entries +-1 become +-[[1, 1], [1, -1]].
    let block = |diagonal: bool, e: i8| {
        if diagonal { vec![vec![1, -1], vec![-1, -1]] } else { vec![vec![e, e], vec![e, -e]] }
    };
    Some(paley(&field, block, 2))
}

/// Paley's matrix over a field with every entry replaced by a block; the diagonal's entry is 1 for blocks of one.
fn paley(field: &Field, block: impl Fn(bool, i8) -> Vec<Vec<i8>>, width: usize) -> Vec<Vec<i8>> {
    let characters = field.characters();
    let size = field.order as usize + 1;
    let entry = |row: usize, column: usize| match (row, column) {
        _ if row == column => 1,
        (0, _) => 1,
        // Antisymmetric where -1 is no square, symmetric where it is.
        (_, 0) => {
            if width == 1 {
                -1
            } else {
                1
            }
        }
        (row, column) => {
            let difference = field.subtract(row as u64 - 1, column as u64 - 1);
            characters.get(difference as usize).copied().unwrap_or(0)
        }
    };
    let mut matrix = Vec::with_capacity(size * width);
    for row in 0..size {
        let blocks: Vec<Vec<Vec<i8>>> = (0..size).map(|column| block(row == column, entry(row, column))).collect();
        for line in 0..width {
            matrix.push(blocks.iter().filter_map(|block| block.get(line)).flatten().copied().collect());
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_have_no_zero_divisors_and_distribute() {
        for order in [2, 3, 4, 5, 7, 8, 9, 16, 25, 27, 32, 49] {
            let field = Field::new(order).unwrap();
            for a in 1..order {
                let mut products: Vec<u64> = (0..order).map(|b| field.multiply(a, b)).collect();
                products.sort_unstable();
                assert!(products.iter().copied().eq(0..order), "{order}: multiples of {a}");
                let (b, c) = (a * 7 % order, a * 3 % order);
                let left = field.multiply(a, field.add(b, c));
                assert_eq!(left, field.add(field.multiply(a, b), field.multiply(a, c)));
            }
        }
        assert_eq!(Field::new(6), None);
    }

    #[test]
    fn plackett_burman_columns_are_balanced_and_orthogonal() {
        for runs in (4..92).step_by(4) {
            let design = plackett_burman(runs).unwrap_or_else(|| panic!("{runs}"));
            assert_eq!(design.len(), runs);
            for first in 0..runs - 1 {
                assert_eq!(design.iter().map(|row| i32::from(row[first])).sum::<i32>(), 0, "{runs}: column {first}");
                for second in 0..first {
                    let product: i32 = design.iter().map(|row| i32::from(row[first] * row[second])).sum();
                    assert_eq!(product, 0, "{runs}: columns {second} and {first}");
                }
            }
        }
    }
}
