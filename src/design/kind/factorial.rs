//! Classical plans: Plackett-Burman, central composite, Box-Behnken, one factor at a time.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::coordinate::Coordinate;
use super::super::error::DesignError;
use super::super::orthogonal::plackett_burman;
use super::fraction::{Fraction, MAX_RESOLUTION};

/// Where the axial points of a central composite design lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axial {
    /// At the ends of the ranges, the corners drawn in so that all but the centre are as far from it as a rotatable design
    /// wants: `alpha = F^(1/4)` for F corners.
    #[default]
    Inscribed,
    /// In the middle of the faces, the corners at the ends of the ranges.
    Faces,
}

/// Points given by shares of the ranges.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shares(pub(super) Vec<Vec<f64>>);

/// Central composite design: corners (a fraction of resolution five from five factors on), axial points, centre points.
pub(super) fn central_composite(factors: usize, axial: Axial, centres: usize) -> Result<Shares, DesignError> {
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
    Ok(Shares(rows))
}

/// Box-Behnken design: blocks of factors at all combinations of their ends, the others in the middle.
///
/// Pairs of factors, except for six and seven factors, where Box and Behnken (1960) use triples.
pub(super) fn box_behnken(factors: usize, centres: usize) -> Result<Shares, DesignError> {
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
    Ok(Shares(rows))
}

/// Plackett-Burman design: the fewest rows, a multiple of four, for main effects at two levels.
pub(super) fn screening(factors: usize) -> Result<Shares, DesignError> {
    let sizes = (1..).map(|quarter| 4 * quarter).skip_while(|runs| *runs <= factors).take(16);
    let design = sizes.filter_map(plackett_burman).next().ok_or_else(|| {
        DesignError::setting("kind", format!("no Plackett-Burman design is known here for {factors} factors"))
    })?;
    let share = |sign: &i8| if *sign > 0 { 1.0 } else { 0.0 };
    Ok(Shares(design.iter().map(|row| row.iter().take(factors).map(share).collect()).collect()))
}

/// One factor at a time: the base first, then each factor at its other levels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OneAtATime {
    base: Vec<Coordinate>,
    /// Factor and its coordinate, row 1 first.
    departures: Vec<(usize, Coordinate)>,
}

impl OneAtATime {
    /// `levels`: levels per factor, and whether it is real. Real factors have their base in the middle of the range,
    /// others at the level in the middle (categories: the first).
    pub(super) fn new(levels: &[(u64, bool, bool)]) -> Self {
        let mut base = Vec::with_capacity(levels.len());
        let mut departures = Vec::new();
        for (factor, &(count, real, category)) in levels.iter().enumerate() {
            let middle = if category { 0 } else { (count - 1) / 2 };
            base.push(if real { Coordinate::Share(0.5) } else { Coordinate::Step { step: middle, count } });
            let is_base = |step: u64| if real { 2 * step == count - 1 } else { step == middle };
            let steps = (0..count).filter(|step| !is_base(*step));
            departures.extend(steps.map(|step| (factor, Coordinate::Step { step, count })));
        }
        Self { base, departures }
    }

    pub(super) fn rows(&self) -> usize {
        1 + self.departures.len()
    }

    pub(super) fn at(&self, row: usize) -> Vec<Coordinate> {
        let mut coordinates = self.base.clone();
        let departure = row.checked_sub(1).and_then(|index| self.departures.get(index));
        if let Some((factor, coordinate)) = departure
            && let Some(entry) = coordinates.get_mut(*factor)
        {
            *entry = *coordinate;
        }
        coordinates
    }
}
