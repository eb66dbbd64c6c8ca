//! Polynomial chaos: least squares over orthogonal polynomials.

use nalgebra::DMatrix;

use super::error::RegressionError;
use super::gaussian::check;
use super::groups::{Groups, LeftOut};
use super::points::Points;
use super::residuals::Residuals;
use decore_math::linalg::{cholesky, multiply_transposed, solve_lower};

/// Terms at most for this many rows: as many for other numbers in proportion.
const MOST_TERMS: [usize; 2] = [7, 10];
/// A row's own share in its fit is less than 1 by at least this. Closer to 1, its error when left out is rounding.
const LEAST_OTHERS: f64 = 1e-8;

/// A polynomial of all products of Legendre polynomials up to a total degree, fitted by least squares (Sudret, Reliab. Eng. Syst.
/// Saf. 93, 2008); of a factor of names, each but the first has a term of degree 1. The degree is the one with the smallest errors
/// of rows that were left out.
#[derive(Debug, Clone, PartialEq)]
pub struct PolynomialChaos {
    /// Total degree.
    pub degree: usize,
    /// Number of terms.
    pub terms: usize,
    /// Errors of rows that were left out.
    pub residuals: Residuals,
}

/// A factor's polynomial in a term.
#[derive(Debug, Clone, Copy, PartialEq)]
enum FactorPolynomial {
    /// The Legendre polynomial of this degree.
    Legendre { factor: usize, degree: usize },
    /// 1 for the name with this number, 0 for others.
    Name { factor: usize, number: f64 },
}

impl PolynomialChaos {
    /// Fits degrees 1, 2, ... as long as there are enough rows, and none that a term stands on alone; groups are left out together.
    ///
    /// # Errors
    /// As [`super::GaussianProcess::fit`]; [`RegressionError::TooFew`] also where not even degree 1 has enough rows;
    /// [`RegressionError::Linalg`] where its terms depend on each other in the rows, [`RegressionError::Alone`] where they do without some.
    pub fn fit(points: &Points, values: &[f64], groups: &Groups) -> Result<Self, RegressionError> {
        check(points, values)?;
        let most = points.rows() * MOST_TERMS[0] / MOST_TERMS[1];
        let (mut best, mut failed): (Option<Self>, Option<RegressionError>) = (None, None);
        for degree in 1.. {
            let Some(terms) = terms(points, degree, most) else { break };
            match residuals(points, (values, groups), &terms) {
                Ok(residuals) if best.as_ref().is_none_or(|best| residuals.q2() > best.residuals.q2()) => {
                    best = Some(Self { degree, terms: terms.len(), residuals });
                }
                Ok(_) => {}
                // Terms of higher degrees depend on each other all the more.
                Err(error) => {
                    failed = Some(error);
                    break;
                }
            }
        }
        let too_few = RegressionError::TooFew {
            found: points.rows(),
            least: ((points.factors() + 1) * MOST_TERMS[1]).div_ceil(MOST_TERMS[0]),
        };
        best.ok_or_else(|| failed.unwrap_or(too_few))
    }
}

/// The terms of a total degree; `None` if they are more than `most`.
fn terms(points: &Points, degree: usize, most: usize) -> Option<Vec<Vec<FactorPolynomial>>> {
    let mut terms = vec![(Vec::new(), 0)];
    for (factor, nominal) in points.nominal().iter().enumerate() {
        let mut parts: Vec<(FactorPolynomial, usize)> = match nominal {
            false => (1..=degree).map(|degree| (FactorPolynomial::Legendre { factor, degree }, degree)).collect(),
            true => {
                let mut names: Vec<f64> = (0..points.rows()).map(|row| points.row(row)[factor]).collect();
                names.sort_by(f64::total_cmp);
                names.dedup();
                names.into_iter().skip(1).map(|number| (FactorPolynomial::Name { factor, number }, 1)).collect()
            }
        };
        parts.retain(|(_, own)| *own <= degree);
        let longer: Vec<(Vec<FactorPolynomial>, usize)> = (terms.iter())
            .flat_map(|(term, sum)| {
                parts.iter().map(move |(part, own)| ([term.as_slice(), &[*part]].concat(), sum + own))
            })
            .filter(|(_, sum)| *sum <= degree)
            .collect();
        terms.extend(longer);
        if terms.len() > most {
            return None;
        }
    }
    Some(terms.into_iter().map(|(term, _)| term).collect())
}

fn residuals(
    points: &Points,
    (values, groups): (&[f64], &Groups),
    terms: &[Vec<FactorPolynomial>],
) -> Result<Residuals, RegressionError> {
    let columns = DMatrix::from_fn(points.rows(), terms.len(), |row, term| {
        terms[term].iter().map(|part| part.at(points.row(row))).product()
    });
    let factor = cholesky(multiply_transposed(&columns, &columns)?)?;
    // With `L L' = X' X` and `Z = L^-1 X'`: the fit is `Z' Z y`, the shares of a group's rows in their own fits `Z_I' Z_I`.
    let mut shares = columns.transpose();
    solve_lower(&factor, &mut shares)?;
    let fitted = &shares * DMatrix::from_column_slice(values.len(), 1, values);
    let rest = |a: usize, b: usize| f64::from(u8::from(a == b)) - shares.column(a).dot(&shares.column(b));
    let own: Vec<f64> = (0..values.len()).map(|row| rest(row, row)).collect();
    let off: Vec<f64> =
        shares.column_iter().zip(values).map(|(column, value)| value - column.dot(&fitted.column(0))).collect();
    let found = LeftOut::new(groups, (&off, &own), rest).map_err(|_| RegressionError::Alone)?;
    if !found.owns.iter().all(|own| *own >= LEAST_OTHERS) {
        return Err(RegressionError::Alone);
    }
    let freedom = points.rows().saturating_sub(terms.len()).max(1) as f64;
    let squares: f64 = off.iter().map(|error| error * error).sum();
    let deviations = found.owns.iter().map(|own| (squares / freedom / own).sqrt()).collect();
    Ok(Residuals::new((values, groups), found.errors, deviations))
}

impl FactorPolynomial {
    fn at(self, row: &[f64]) -> f64 {
        match self {
            Self::Name { factor, number } => f64::from(u8::from(row[factor] == number)),
            Self::Legendre { factor, degree } => legendre(degree, 2.0 * row[factor] - 1.0),
        }
    }
}

/// Legendre polynomial whose mean square over [-1, 1] is 1.
fn legendre(degree: usize, x: f64) -> f64 {
    let (mut last, mut value) = (0.0, 1.0);
    for k in 0..degree {
        let k = k as f64;
        (last, value) = (value, ((2.0 * k + 1.0) * x * value - k * last) / (k + 1.0));
    }
    value * (2.0 * degree as f64 + 1.0).sqrt()
}
