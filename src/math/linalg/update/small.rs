//! Systems of few equations, without memory of their own.

/// Solves `A x = b` in place by elimination with row pivots: A by rows, b becomes x. Whether A is regular.
pub(super) fn solve(a: &mut [f64], b: &mut [f64]) -> bool {
    let n = b.len();
    for k in 0..n {
        let largest = |best: usize, row: usize| if a[row * n + k].abs() > a[best * n + k].abs() { row } else { best };
        let pivot = (k + 1..n).fold(k, largest);
        let size = a[pivot * n + k].abs();
        if size.is_nan() || size == 0.0 {
            return false;
        }
        if pivot != k {
            (k..n).for_each(|column| a.swap(k * n + column, pivot * n + column));
            b.swap(k, pivot);
        }
        let (above, below) = a.split_at_mut((k + 1) * n);
        let row = &above[k * n..];
        for (i, other) in below.chunks_exact_mut(n).enumerate() {
            let share = other[k] / row[k];
            for (entry, pivot) in other[k + 1..].iter_mut().zip(&row[k + 1..]) {
                *entry -= share * pivot;
            }
            b[k + 1 + i] -= share * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = a[k * n + k + 1..(k + 1) * n].iter().zip(&b[k + 1..]).map(|(a, x)| a * x).sum();
        b[k] = (b[k] - known) / a[k * n + k];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_exchanged_where_a_pivot_vanishes() {
        let mut a = [0.0, 2.0, 1.0, 4.0, 1.0, -1.0, 2.0, 0.0, 3.0];
        let mut b = [7.0, 3.0, 11.0];
        assert!(solve(&mut a, &mut b));
        assert!(b.iter().zip([1.0, 2.0, 3.0]).all(|(x, expected)| (x - expected).abs() < 1e-14), "{b:?}");
        assert!(!solve(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 2.0]));
        assert!(!solve(&mut [f64::NAN], &mut [1.0]));
    }
}
