//! Classical plans: two-level fractions, Plackett-Burman, central composite, Box-Behnken.

use std::sync::Arc;

use super::super::coordinate::Coordinate;
use super::super::distribution::Distribution;
use super::super::error::DesignError;
use super::super::factor::Factor;
use super::super::options::{Axial, DesignOptions, Needs};
use super::super::orthogonal::plackett_burman;
use super::fraction::{Aliases, Fraction, MAX_RESOLUTION};
use super::points::{Points, Request, Specification, bounded, numbers_only};

/// Default resolution of a fractional factorial: main effects clear of products of two factors.
const RESOLUTION: u64 = 4;

/// A regular fraction of the two-level factorial: main effects clear of effects of up to `resolution - 2` factors; of least
/// aberration up to 15 factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FractionalFactorial {
    /// 3 to 8.
    pub resolution: u32,
}

impl Specification for FractionalFactorial {
    fn of(keys: &DesignOptions) -> Result<Self, Needs> {
        Ok(Self { resolution: u32::try_from(keys.resolution.unwrap_or(RESOLUTION)).unwrap_or(u32::MAX) })
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        two_levels(request.factors)?;
        let factors = request.factors.len();
        Ok(Arc::new(Corners { fraction: Fraction::new(factors, self.resolution)?, factors }))
    }
}

/// The rows of a two-level fraction.
#[derive(Debug)]
struct Corners {
    fraction: Fraction,
    factors: usize,
}

impl Points for Corners {
    fn rows(&self) -> usize {
        self.fraction.rows()
    }

    fn at(&self, row: usize) -> Vec<Coordinate> {
        let end = |high: bool| Coordinate::Step { step: u64::from(high), count: 2 };
        (0..self.factors).map(|factor| end(self.fraction.is_high(row as u64, factor))).collect()
    }

    fn aliases(&self) -> Option<Aliases> {
        Some(Aliases::of(&self.fraction))
    }
}

/// Points given by shares of the ranges, row by row.
#[derive(Debug)]
struct Shares(Vec<Vec<f64>>);

impl Points for Shares {
    fn rows(&self) -> usize {
        self.0.len()
    }

    fn at(&self, row: usize) -> Vec<Coordinate> {
        self.0.get(row).into_iter().flatten().map(|share| Coordinate::Share(*share)).collect()
    }

    fn is_open(&self) -> bool {
        false
    }
}

/// The smallest known orthogonal two-level design for main effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlackettBurman;

impl Specification for PlackettBurman {
    fn of(_: &DesignOptions) -> Result<Self, Needs> {
        Ok(Self)
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        two_levels(request.factors)?;
        Ok(Arc::new(Shares(screening(request.factors.len())?)))
    }
}

/// Corners, axial points and centre, for quadratic models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CentralComposite {
    /// Position of the axial points.
    pub axial: Axial,
    /// Number of centre points.
    pub centres: usize,
}

impl Specification for CentralComposite {
    fn of(keys: &DesignOptions) -> Result<Self, Needs> {
        Ok(Self { axial: keys.axial.unwrap_or_default(), centres: keys.centres() })
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        numbers_only(request.factors)?;
        bounded("centre_points", self.centres as u64)?;
        Ok(Arc::new(Shares(central_composite(request.factors.len(), self.axial, self.centres)?)))
    }
}

/// Middles of edges (or of faces) and centre, for quadratic models without corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoxBehnken {
    /// Number of centre points.
    pub centres: usize,
}

impl Specification for BoxBehnken {
    fn of(keys: &DesignOptions) -> Result<Self, Needs> {
        Ok(Self { centres: keys.centres() })
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        numbers_only(request.factors)?;
        bounded("centre_points", self.centres as u64)?;
        Ok(Arc::new(Shares(box_behnken(request.factors.len(), self.centres)?)))
    }
}

fn two_levels(factors: &[Factor]) -> Result<(), DesignError> {
    let odd = |factor: &Factor| matches!(factor.distribution, Distribution::Categories { count } if count != 2);
    match factors.iter().position(odd) {
        Some(factor) => Err(DesignError::FactorKind {
            factor,
            expected: "a two-level design needs exactly two values to choose from",
        }),
        None => Ok(()),
    }
}

/// Central composite design: corners (a fraction of resolution five from five factors on), axial points, centre points.
fn central_composite(factors: usize, axial: Axial, centres: usize) -> Result<Vec<Vec<f64>>, DesignError> {
    let corners = Fraction::new(factors, if factors < 5 { MAX_RESOLUTION } else { 5 })?;
    let alpha = (corners.rows() as f64).sqrt().sqrt();
    let reach = match axial {
        Axial::Inscribed => 0.5 / alpha.max(1.0),
        Axial::Faces => 0.5,
    };
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for row in 0..corners.rows() as u64 {
        let share = |column| if corners.is_high(row, column) { 0.5 + reach } else { 0.5 - reach };
        rows.push((0..factors).map(share).collect());
    }
    for factor in 0..factors {
        for end in [0.0, 1.0] {
            rows.push((0..factors).map(|other| if other == factor { end } else { 0.5 }).collect());
        }
    }
    rows.extend(std::iter::repeat_n(vec![0.5; factors], centres));
    Ok(rows)
}

/// Box-Behnken design: blocks of factors at all combinations of their ends, the others in the middle.
///
/// Pairs of factors, except for six and seven factors, where Box and Behnken (1960) use triples.
fn box_behnken(factors: usize, centres: usize) -> Result<Vec<Vec<f64>>, DesignError> {
    if factors < 3 {
        return Err(DesignError::Factors("a Box-Behnken design needs at least three factors"));
    }
    let turned = |pattern: [usize; 3]| {
        (0..factors).map(move |turn| pattern.map(|place| (place + turn) % factors).to_vec()).collect()
    };
    let blocks: Vec<Vec<usize>> = match factors {
        6 | 7 => turned([0, 1, 3]),
        _ => (0..factors).flat_map(|a| (a + 1..factors).map(move |b| vec![a, b])).collect(),
    };
    let mut rows = Vec::new();
    for block in blocks {
        for signs in 0..1_usize << block.len() {
            let mut row = vec![0.5; factors];
            for (bit, factor) in block.iter().enumerate() {
                if let Some(share) = row.get_mut(*factor) {
                    *share = if (signs >> bit) & 1 == 1 { 1.0 } else { 0.0 };
                }
            }
            rows.push(row);
        }
    }
    rows.extend(std::iter::repeat_n(vec![0.5; factors], centres));
    Ok(rows)
}

/// Plackett-Burman design: the fewest rows, a multiple of four, for main effects at two levels.
fn screening(factors: usize) -> Result<Vec<Vec<f64>>, DesignError> {
    let sizes = (1..).map(|quarter| 4 * quarter).skip_while(|runs| *runs <= factors).take(16);
    let design = sizes.filter_map(plackett_burman).next().ok_or_else(|| {
        DesignError::setting("kind", format!("no Plackett-Burman design is known here for {factors} factors"))
    })?;
    let share = |sign: &i8| if *sign > 0 { 1.0 } else { 0.0 };
    Ok(design.iter().map(|row| row.iter().take(factors).map(share).collect()).collect())
}
