//! The coupled system as a linear one: natural frequencies and receptances of machine and castings together.
//!
//! With the coordinates q of all parts (modes, and the freedoms of rigid castings), `u = Phi q + R e` the motion of the columns under forces e
//! on them without the links, and E the rows of the links,
//!
//! ```text
//! F = (S + i w B) E u             forces of the links
//! (K + i w C - w^2 M) q = Phi' (e - E' F)
//! motion = Phi q + R (e - E' F)
//! ```
//!
//! S and B hold the links in series with the residual flexibility R of elastic parts. Springs and pads that are pressed at rest count. The
//! bodies of the hammers do not, but guides that are tied to their mounts do.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector};

use super::assemble::{BuildError, build_placed};
use super::block::{Block, CoupledPart};
use super::model::CoupledModel;
use super::placed::{PlacedModes, SceneModes};
use crate::scene::{PartId, PointId, Scene};
use decore_math::linalg::{LinalgError, cholesky, solve_lower, symmetric_eigenvalues};

/// Circular frequency in rad/s whose square is added to all squares of frequencies: motions without stiffness have one too.
const SHIFT_RAD_S: f64 = 1.0;

/// Share of the depth at rest over which the stiffness of a pressed contact is taken.
const SMALL: f64 = 1e-4;

/// Motion of a point.
#[derive(Debug, Clone)]
struct LinearPoint {
    /// By the coordinates.
    shape: DVector<f64>,
    /// By the forces on the columns, through the residual flexibility, m/N.
    residual: DVector<f64>,
    /// Force on each column per force on the point; `None` if no force can act on it.
    weights: Option<DVector<f64>>,
}

/// Machine and castings of a scene as one linear system.
#[derive(Debug, Clone)]
pub struct LinearModel {
    /// Squared frequencies and damping of the coordinates without the links.
    stiffness: DVector<f64>,
    damping: DVector<f64>,
    mass: DMatrix<f64>,
    /// Motion of the links by the coordinates, links x coordinates; and of the columns, links x columns.
    shares: DMatrix<f64>,
    rows: DMatrix<f64>,
    /// Stiffness and damping of the links, links x links.
    links: [DMatrix<f64>; 2],
    points: BTreeMap<PointId, LinearPoint>,
}

impl LinearModel {
    /// Of a scene on its modes.
    ///
    /// # Errors
    /// As for [`super::build`].
    pub fn new(scene: &Scene, modes: &impl SceneModes) -> Result<Self, BuildError> {
        modes.with_placed(|placed| {
            let model = build_placed(scene, placed)?;
            Ok(Self::of(&model, scene, placed))
        })
    }

    fn of(model: &CoupledModel, scene: &Scene, placed: &PlacedModes) -> Self {
        let parts: Vec<&CoupledPart> =
            model.parts.iter().filter(|part| !matches!(part.id, PartId::Hammer(_))).collect();
        let Coordinates { stiffness, damping, mass, phi } = Coordinates::of(&parts, model.elements.matrix().cols());
        let residual = residual(&parts, placed, phi.nrows());
        let (rows, links) = links(model, &parts);
        let points = scene.points().into_values().filter_map(|point| {
            let found = match model.watched(point.id) {
                Some((place, at)) => watched(&parts, placed, (model.parts[place].id, at), phi.shape())?,
                None => {
                    let row = model.points.row(point.id);
                    if row.is_empty() || matches!(point.part, PartId::Hammer(_)) {
                        return None;
                    }
                    let mut weights = DVector::zeros(phi.nrows());
                    row.iter().for_each(|(column, share)| weights[*column] += share);
                    let (shape, residual) = (phi.tr_mul(&weights), &residual * &weights);
                    LinearPoint { shape, residual, weights: Some(weights) }
                }
            };
            Some((point.id, found))
        });
        let points = points.collect();
        Self { stiffness, damping, mass, shares: &rows * &phi, rows, links, points }
    }

    /// Points whose motion is known: the rows of [`Self::receptances`].
    pub fn points(&self) -> impl Iterator<Item = PointId> {
        self.points.keys().copied()
    }

    /// Points on which forces can act, as links join them: the columns of [`Self::receptances`].
    pub fn driven(&self) -> impl Iterator<Item = PointId> {
        self.points.iter().filter(|(_, point)| point.weights.is_some()).map(|(id, _)| *id)
    }

    /// Undamped natural frequencies in Hz, rising; 0 for motions without stiffness.
    ///
    /// The lowest are the most accurate: the eigenvalues of `(K + s M)^-1 M` are solved for.
    ///
    /// # Errors
    /// Values that are not finite; no convergence.
    pub fn frequencies_hz(&self) -> Result<Vec<f64>, LinalgError> {
        let shift = SHIFT_RAD_S * SHIFT_RAD_S;
        let stiffness = DMatrix::from_diagonal(&self.stiffness) + self.shares.tr_mul(&(&self.links[0] * &self.shares));
        let factor = cholesky(stiffness + &self.mass * shift)?;
        let mut half = self.mass.clone();
        solve_lower(&factor, &mut half)?;
        let mut inverse = half.transpose();
        solve_lower(&factor, &mut inverse)?;
        let values = symmetric_eigenvalues(&((&inverse + inverse.transpose()) * 0.5))?;
        Ok(values.iter().rev().map(|value| (1.0 / value - shift).max(0.0).sqrt() / TAU).collect())
    }

    /// Motion of each point per harmonic force on each driven point in m/N; static at 0 Hz. `None` where the system has no finite answer.
    pub fn receptances(&self, hz: f64) -> Option<DMatrix<Complex<f64>>> {
        let omega = TAU * hz;
        let with = |stiffness: &DMatrix<f64>, damping: &DMatrix<f64>| {
            stiffness.zip_map(damping, |stiffness, damping| Complex::new(stiffness, omega * damping))
        };
        let columns = |of: &dyn Fn(&LinearPoint) -> Option<DVector<f64>>| {
            let all: Vec<DVector<f64>> = self.points.values().filter_map(of).collect();
            DMatrix::from_fn(all.first().map_or(0, DVector::len), all.len(), |row, at| real(all[at][row]))
        };
        let driven = |point: &LinearPoint| point.weights.is_some();
        let links = with(&self.links[0], &self.links[1]);
        let (shares, rows) = (self.shares.map(real), self.rows.map(real));
        let free = with(&DMatrix::from_diagonal(&self.stiffness), &DMatrix::from_diagonal(&self.damping));
        let mass = self.mass.map(|mass| real(omega * omega * mass));
        let dynamic = free - mass + shares.tr_mul(&(&links * &shares));
        let along = &rows * columns(&|point| driven(point).then(|| point.residual.clone()));
        let load = columns(&|point| driven(point).then(|| point.shape.clone()));
        let coordinates = dynamic.lu().solve(&(load - shares.tr_mul(&(&links * &along))))?;
        let of_links = &links * (&shares * &coordinates + along);
        let forces = columns(&|point| point.weights.clone()) - rows.tr_mul(&of_links);
        let shapes = columns(&|point| Some(point.shape.clone()));
        let residual = columns(&|point| Some(point.residual.clone()));
        let motion = shapes.tr_mul(&coordinates) + residual.tr_mul(&forces);
        Some(motion).filter(|motion| motion.iter().all(|value| value.is_finite()))
    }
}

/// The coordinates of all parts.
struct Coordinates {
    stiffness: DVector<f64>,
    damping: DVector<f64>,
    mass: DMatrix<f64>,
    /// Motion of the columns, columns x coordinates.
    phi: DMatrix<f64>,
}

impl Coordinates {
    fn of(parts: &[&CoupledPart], columns: usize) -> Self {
        let count = |part: &CoupledPart| part.block.modes().map_or(part.columns.len(), |modes| modes.phi.nrows());
        let all = parts.iter().map(|part| count(part)).sum();
        let (mut stiffness, mut damping) = (DVector::zeros(all), DVector::zeros(all));
        let (mut mass, mut phi) = (DMatrix::identity(all, all), DMatrix::zeros(columns, all));
        let mut first = 0;
        for part in parts {
            let own = first..first + count(part);
            if let Block::Rigid(rigid) = &part.block {
                for ((at, column), kg) in own.clone().zip(part.columns.clone()).zip(&rigid.mass) {
                    (mass[(at, at)], phi[(column, at)]) = (*kg, 1.0);
                }
            }
            if let Some(modes) = part.block.modes() {
                stiffness.rows_mut(first, own.len()).copy_from(&modes.omega_squared);
                damping.rows_mut(first, own.len()).copy_from(&modes.damping);
                let of_part = (part.columns.len(), own.len());
                phi.view_mut((part.columns.start, first), of_part).copy_from(&modes.phi.transpose());
                for (point, kg) in part.tied.iter().flat_map(|tied| tied.mass.iter().enumerate()) {
                    let shape = modes.phi.column(point);
                    mass.view_mut((first, first), (own.len(), own.len())).ger(*kg, &shape, &shape, 1.0);
                }
            }
            first = own.end;
        }
        Self { stiffness, damping, mass, phi }
    }
}

/// Residual flexibility of all parts, columns x columns.
fn residual(parts: &[&CoupledPart], placed: &PlacedModes, columns: usize) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(columns, columns);
    for part in parts.iter().filter(|part| part.block.modes().is_some()) {
        let Some(own) = placed.of(part.id).and_then(PlacedModes::residual) else { continue };
        let (first, count) = (part.columns.start, part.columns.len());
        all.view_mut((first, first), (count, count)).copy_from(&own.flexibility);
    }
    all
}

/// Rows of the springs and of the contacts that are pressed at rest, links x columns, with their stiffness and damping. Links of the bodies of
/// hammers are left out.
fn links(model: &CoupledModel, parts: &[&CoupledPart]) -> (DMatrix<f64>, [DMatrix<f64>; 2]) {
    let elements = &model.elements;
    let known = |row: usize| elements.row(row).all(|(at, _)| parts.iter().any(|part| part.columns.contains(&at)));
    let springs: Vec<usize> = (0..elements.springs().len()).filter(|row| known(*row)).collect();
    let pressed =
        |contact: &usize| elements.contacts()[*contact].rest_force_n > 0.0 && known(elements.contact_row(*contact));
    let contacts: Vec<usize> = (0..elements.contacts().len()).filter(pressed).collect();
    let all = springs.iter().copied().chain(contacts.iter().map(|contact| elements.contact_row(*contact)));
    let all: Vec<usize> = all.collect();
    let mut rows = DMatrix::zeros(all.len(), elements.matrix().cols());
    for (at, row) in all.iter().enumerate() {
        elements.row(*row).for_each(|(column, share)| rows[(at, column)] += share);
    }
    let mut laws = [(); 2].map(|()| DMatrix::zeros(all.len(), all.len()));
    for (at, row) in springs.iter().enumerate() {
        let spring = &elements.springs()[*row];
        for (other, column) in springs.iter().enumerate() {
            let own = if at == other { [spring.stiffness_n_per_m, spring.damping_n_s_per_m] } else { [0.0; 2] };
            let [stiffness, damping] = elements
                .series()
                .map_or(own, |series| [series.stiffness[(*row, *column)], series.damping[(*row, *column)]]);
            (laws[0][(at, other)], laws[1][(at, other)]) = (stiffness, damping);
        }
    }
    for (at, contact) in contacts.iter().enumerate() {
        let (contact, at) = (&elements.contacts()[*contact], springs.len() + at);
        let depth_m = contact.law.static_penetration(contact.rest_force_n, 0.0);
        let more_m = SMALL * depth_m;
        laws[0][(at, at)] =
            (contact.law.closed_force(depth_m + more_m, 0.0) - contact.law.closed_force(depth_m, 0.0)) / more_m;
        laws[1][(at, at)] = contact.law.closed_force(depth_m, 1.0) - contact.law.closed_force(depth_m, 0.0);
    }
    (rows, laws)
}

/// Motion of a watched point of an elastic part.
fn watched(
    parts: &[&CoupledPart],
    placed: &PlacedModes,
    (id, at): (PartId, usize),
    (columns, coordinates): (usize, usize),
) -> Option<LinearPoint> {
    let mut first = 0;
    for part in parts {
        let count = part.block.modes().map_or(part.columns.len(), |modes| modes.phi.nrows());
        if part.id == id {
            let mut point =
                LinearPoint { shape: DVector::zeros(coordinates), residual: DVector::zeros(columns), weights: None };
            point.shape.rows_mut(first, count).copy_from(&part.watched.as_ref()?.shapes.column(at));
            if let Some(own) = placed.of(id).and_then(PlacedModes::residual) {
                let of_part = own.watched.row(at).transpose();
                point.residual.rows_mut(part.columns.start, part.columns.len()).copy_from(&of_part);
            }
            return Some(point);
        }
        first += count;
    }
    None
}

fn real(value: f64) -> Complex<f64> {
    Complex::new(value, 0.0)
}
