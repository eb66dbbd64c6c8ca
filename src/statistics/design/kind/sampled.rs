//! Points that fill the cube, any of them computed alone: Sobol', Halton, random.

use std::sync::Arc;

use super::super::coordinate::Coordinate;
use super::super::error::DesignError;
use super::super::options::{DesignOptions, Needs};
use super::super::sobol::{MAX_DIMENSIONS, SobolSequence};
use super::growth::Growth;
use super::halton::HaltonSequence;
use super::points::{Points, Request, Specification};
use decore_math::random::uniform;

/// Sobol' points in the order of the Gray code, direction numbers of Joe and Kuo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sobol {
    /// Number of rows; powers of two are best.
    pub rows: usize,
    /// Whether digits are scrambled after Owen; without, the first point is the lower corner.
    pub scramble: bool,
}

/// Halton points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Halton {
    /// Number of rows.
    pub rows: usize,
    /// Whether digits are scrambled; without, the first point is the lower corner.
    pub scramble: bool,
}

/// Independent random points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Random {
    /// Number of rows.
    pub rows: usize,
}

impl Specification for Sobol {
    fn of(keys: &DesignOptions) -> Result<Self, Needs> {
        Ok(Self { rows: keys.row_count()?, scramble: keys.scrambled() })
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        let sequence = sobol(request.factors.len(), self.scramble.then_some(request.seed))?;
        let probability = move |row, factor| sequence.at(row, factor);
        Ok(Sampled { rows: self.rows, factors: request.factors.len(), probability }.shared())
    }

    fn growth(&self) -> Option<Growth> {
        Some(Growth { key: "rows", count: self.rows, doubles: true })
    }
}

impl Specification for Halton {
    fn of(keys: &DesignOptions) -> Result<Self, Needs> {
        Ok(Self { rows: keys.row_count()?, scramble: keys.scrambled() })
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        let sequence = HaltonSequence::new(request.factors.len(), self.scramble.then_some(request.seed));
        let probability = move |row, factor| sequence.at(row, factor);
        Ok(Sampled { rows: self.rows, factors: request.factors.len(), probability }.shared())
    }

    fn growth(&self) -> Option<Growth> {
        Some(Growth { key: "rows", count: self.rows, doubles: false })
    }
}

impl Specification for Random {
    fn of(keys: &DesignOptions) -> Result<Self, Needs> {
        Ok(Self { rows: keys.row_count()? })
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        let seed = request.seed;
        let probability = move |row, factor: usize| uniform(seed, factor as u64, row);
        Ok(Sampled { rows: self.rows, factors: request.factors.len(), probability }.shared())
    }

    fn growth(&self) -> Option<Growth> {
        Some(Growth { key: "rows", count: self.rows, doubles: false })
    }
}

/// Points by their probabilities, of (row, factor).
struct Sampled<P> {
    rows: usize,
    factors: usize,
    probability: P,
}

impl<P: Fn(u64, usize) -> f64 + Send + Sync + 'static> Sampled<P> {
    fn shared(self) -> Arc<dyn Points> {
        Arc::new(self)
    }
}

impl<P> std::fmt::Debug for Sampled<P> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} sampled points of {} factors", self.rows, self.factors)
    }
}

impl<P: Fn(u64, usize) -> f64 + Send + Sync> Points for Sampled<P> {
    fn rows(&self) -> usize {
        self.rows
    }

    fn at(&self, row: usize) -> Vec<Coordinate> {
        (0..self.factors).map(|factor| Coordinate::Probability((self.probability)(row as u64, factor))).collect()
    }

    fn is_sampled(&self) -> bool {
        true
    }
}

/// Sobol' points of so many dimensions, scrambled by a seed.
pub(super) fn sobol(dimensions: usize, scramble: Option<u64>) -> Result<SobolSequence, DesignError> {
    if dimensions > MAX_DIMENSIONS {
        let message =
            format!("Sobol' points of {dimensions} dimensions are not known, expected {MAX_DIMENSIONS} at most");
        return Err(DesignError::setting("kind", message));
    }
    Ok(SobolSequence::new(dimensions, scramble))
}
