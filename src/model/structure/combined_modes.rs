//! Combined modes: as few modes as rows, with the same static flexibility and the same mass as many.
//!
//! With `R = sum phi phi' / omega^2` and `A = sum phi phi'` over the many, the eigenproblem `R u = lambda A u` has one mode
//! `psi = A u`, `omega = 1 / sqrt(lambda)` per independent row, with `sum psi psi' = A` and `sum psi psi' / omega^2 = R`.

use nalgebra::{DMatrix, SymmetricEigen};

/// Share of the largest eigenvalue of A below which a combination of rows counts as one that none of the many moves.
const RANK: f64 = 1e-12;

/// Sums over modes for some rows.
#[derive(Debug, Clone)]
pub(super) struct ModeSums {
    /// `A = sum phi phi'` (rows x rows), 1/kg.
    pub mass: DMatrix<f64>,
    /// `R = sum phi phi' / omega^2` (rows x rows), m/N.
    pub flexibility: DMatrix<f64>,
}

/// The few.
#[derive(Debug, Clone)]
pub(super) struct CombinedModes {
    /// Circular frequencies in rad/s.
    pub omega_rad_s: Vec<f64>,
    /// `psi` (rows x modes), 1/sqrt(kg).
    pub rows: DMatrix<f64>,
    /// `G` with `psi' G = 1`: `G' B G` is a matrix B over the rows as the modes see it.
    pub inverse: DMatrix<f64>,
}

impl ModeSums {
    /// Returns modes that replace these; none if nothing moves. Their circular frequencies are limited to `range_rad_s`, the range of these
    /// modes, because rows that hardly move or yield have rounding errors.
    pub fn standing(self, range_rad_s: [f64; 2]) -> CombinedModes {
        let rows = self.mass.nrows();
        let mass = SymmetricEigen::new(self.mass);
        let least = RANK * mass.eigenvalues.max().max(0.0);
        let seen: Vec<usize> = (0..rows).filter(|&i| mass.eigenvalues[i] > least).collect();
        if seen.is_empty() {
            let none = DMatrix::zeros(rows, 0);
            return CombinedModes { omega_rad_s: Vec::new(), rows: none.clone(), inverse: none };
        }
        let axes = mass.eigenvectors.select_columns(&seen);
        // `axes / sqrt(D)` and `axes sqrt(D)`: both ways between the rows and coordinates in which A is 1.
        let scaled = |factor: fn(f64) -> f64| {
            let mut axes = axes.clone();
            for (mut axis, &i) in axes.column_iter_mut().zip(&seen) {
                axis.scale_mut(factor(mass.eigenvalues[i].sqrt()));
            }
            axes
        };
        let into = scaled(f64::recip);
        let flexibility = SymmetricEigen::new(into.tr_mul(&(self.flexibility * &into)));
        let [least_rad_s, most_rad_s] = range_rad_s;
        let omega = |lambda: &f64| lambda.max(0.0).sqrt().recip().min(most_rad_s).max(least_rad_s);
        CombinedModes {
            omega_rad_s: flexibility.eigenvalues.iter().map(omega).collect(),
            rows: scaled(|root| root) * &flexibility.eigenvectors,
            inverse: into * flexibility.eigenvectors,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_leads_to_no_frequency_beyond_the_range() {
        // The first gives way, the second only by rounding, the third by less than none.
        let flexibility = DMatrix::from_diagonal(&[1e-6, 1e-21, -1e-20].to_vec().into());
        let standing = ModeSums { mass: DMatrix::identity(3, 3), flexibility }.standing([100.0, 1e6]);
        let mut omega_rad_s = standing.omega_rad_s;
        omega_rad_s.sort_by(f64::total_cmp);
        assert_eq!(omega_rad_s, [1000.0, 1e6, 1e6]);
    }
}
