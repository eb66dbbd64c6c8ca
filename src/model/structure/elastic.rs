//! An elastic casting: the modes of a finite element model that floats freely, and its motion at points anywhere on it.
//!
//! With `K Phi = M Phi Omega^2` below a cut-off the displacement of point i is
//!
//! ```text
//! u_i = sum_s phi_is q_s + sum_j R_ij F_j,    R = P' K^+ P - sum_elastic phi phi' / omega^2,    P = I - M Phi_r Phi_r'
//! ```
//!
//! with `Phi_r` the rigid motions and `F_j` the forces on the points. R is the static flexibility of all modes above the cut-off. It has no
//! mass, so that a stiff casting asks for no short steps.
//!
//! A point is an area: all nodes within a radius, with weights that fall smoothly to 0 at its edge and reproduce rigid motions exactly. Or
//! it is a set of nodes with weights of its own. The flexibility of a single node is a property of the mesh.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen, Vector3};

use super::body_nodes::{BodyNodes, Node};
use super::error::{Step, StructureError};
use super::fixed_interface::{Wanted, count, modes};
use super::model::FeModel;
use super::nodes::WeightedNodes;
use super::partition::{inner_rows, sparse_times};
use super::reduced::{Damping, damping_ratios};
use super::suspects;
use crate::direction::{across, dot, perpendicular};
use decore_math::linalg::{Below, PencilFactor, SymmetricPencil, multiply, multiply_transposed};

/// Index of the vertical among the directions of a node.
const VERTICAL: usize = 2;
/// Shift relative to the squared cut-off with which the stiffness of a floating body is factorised.
const SHIFT_OF_LIMIT: f64 = 1e-2;
/// Refinements of the residual flexibility. Each gains the two digits of [`SHIFT_OF_LIMIT`].
const REFINEMENTS: usize = 6;
/// Squared frequency relative to the cut-off's below which a motion is rigid: 0.3 % of the cut-off. Rounding in the matrices of a stiff body
/// reaches far above 0.
const RIGID_OF_LIMIT: f64 = 1e-5;
/// Rigid motions of a free body.
const RIGID_MOTIONS: usize = 6;
/// Largest force relative to the stiffness that rigid motions of a floating body cause.
const FLOATS: f64 = 1e-6;
/// Share of the largest mean square of vertical motion from which on a rigid motion has such.
const MOVES: f64 = 1e-10;
/// Share of the largest pivot below which the nodes of an area lie on a line.
const ON_A_LINE: f64 = 1e-9;

/// Modes above this frequency in Hz count as local: they yield around a point, and the body as a whole does not bend.
pub const LOCAL_HZ: f64 = 10_000.0;

const STEP: &str = "modes of the casting";
const ADVICE: &str = "check units and signs of the casting's matrices";

/// Settings of an elastic casting.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticSettings {
    /// Modes below this frequency are kept, in Hz.
    pub cutoff_hz: f64,
    /// Damping of the elastic modes; a list starts at the first of them.
    pub damping: Damping,
    /// Radius in m of the points' areas.
    pub point_radius_m: f64,
}

/// Side of a casting along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The surface that the axis reaches first: under a vertical strike the upper one.
    Struck,
    /// The surface that it reaches last, which fixtures hold.
    Held,
}

/// A point of an elastic body. Coordinates are in m from its centre of mass.
#[derive(Debug, Clone, PartialEq)]
pub enum BodyPoint {
    /// The surface on a line through a point along a unit vector.
    Surface {
        /// The point, m.
        at_m: [f64; 3],
        /// The unit vector.
        axis: [f64; 3],
        /// Which of the two surfaces.
        side: Side,
    },
    /// A place within it or on it.
    Place([f64; 3]),
    /// Nodes with weights.
    Nodes(WeightedNodes),
    /// Mean motion of its mass.
    Centre,
    /// Mean rotation of its mass about the first (0) or second (1) direction across the one of the motion, rad; see [`across`].
    Rotation(usize),
}

/// A point and the unit vector along which its motion counts.
pub type DirectedPoint = (BodyPoint, [f64; 3]);

/// Motion of a body at points.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyModes {
    /// Natural circular frequencies in rad/s; 0 for rigid motions, which come first: heave and two rotations for vertical points, else six.
    pub omega_rad_s: Vec<f64>,
    /// Damping ratios.
    pub damping_ratio: Vec<f64>,
    /// Mode shapes along the points' directions, mass-normalised: points x modes.
    pub rows: DMatrix<f64>,
    /// Residual flexibility R of the driven points in m/N: of all modes above the cut-off; symmetric.
    pub residual: DMatrix<f64>,
    /// Residual flexibility between the other points and the driven ones in m/N: motion of the first under forces on the second.
    pub watched: DMatrix<f64>,
    /// Local flexibility of each driven point in m/N: of all modes above [`LOCAL_HZ`], whatever the cut-off is.
    pub local: Vec<f64>,
}

/// Rows and shares of a node's motion, its weight before it is scaled, and 1 with its distances across the motion.
type WeighedNode = (Vec<(usize, f64)>, f64, Vector3<f64>);

/// The elastic body of a casting.
#[derive(Debug)]
pub struct ElasticBody {
    model: FeModel,
    settings: ElasticSettings,
    mass_kg: f64,
    nodes: BodyNodes,
    /// Row of the model for each row of the factor and of the shapes.
    rows: Vec<u32>,
    shift: f64,
    factor: PencilFactor,
    omega_rad_s: Vec<f64>,
    damping_ratio: Vec<f64>,
    /// Mode shapes that are kept; of the rigid motions only those that vertical forces excite.
    shapes: DMatrix<f64>,
    /// Circular frequencies of all elastic modes that are known, in rad/s: up to the cut-off or [`LOCAL_HZ`], whichever is higher. As many as
    /// are kept come first.
    elastic_rad_s: Vec<f64>,
    /// All rigid motions and these modes, and the mass matrix times these.
    below: DMatrix<f64>,
    below_inertia: DMatrix<f64>,
}

impl ElasticBody {
    /// Computes the modes of a body below the cut-off. The model's rows need labels, and its nodes need coordinates.
    ///
    /// # Errors
    /// Missing labels or coordinates; a stiffness that is not positive semidefinite; more modes than a study needs; not enough memory.
    pub fn new(model: FeModel, settings: ElasticSettings) -> Result<Self, StructureError> {
        suspects::require_order(&model)?;
        let (nodes, centre, masses_kg) = BodyNodes::with_mass(&model)?;
        let limit = (TAU * settings.cutoff_hz.max(LOCAL_HZ)).powi(2);
        let (kept, _) = inner_rows(&model, &[]);
        let pencil = SymmetricPencil::new(model.stiffness(), model.mass(), &kept).step(STEP, ADVICE)?;
        let count = count(&pencil, limit)?;
        Wanted { limit, suspect: suspects::mixed_units(&model, Some(masses_kg)) }.require(count, pencil.order())?;
        let shift = SHIFT_OF_LIMIT * limit;
        let factor = pencil.cholesky(shift).step(STEP, ADVICE)?;
        let modes = modes(&pencil, &factor, shift, Below { limit, count })?;
        if let Some(&omega_squared) = modes.values.first().filter(|value| **value < -RIGID_OF_LIMIT * limit) {
            return Err(StructureError::Indefinite { omega_squared });
        }
        let free = modes.values.iter().take_while(|value| **value <= RIGID_OF_LIMIT * limit).count();
        if free != RIGID_MOTIONS {
            let expected = "a model without supports and without loose parts: 6 motions without stiffness";
            let found = format!("{free} below {:.0} Hz", (RIGID_OF_LIMIT * limit).sqrt() / TAU);
            return Err(StructureError::argument("casting", expected, found));
        }
        let elastic: Vec<f64> = modes.values[free..].iter().map(|value| value.sqrt()).collect();
        let kept = elastic.iter().filter(|omega| **omega < TAU * settings.cutoff_hz).count();
        let rows = pencil.rows().to_vec();
        let found = modes.vectors.columns(0, free).into_owned();
        let rigid = rigid_motions(&model, centre, &rows).unwrap_or(found);
        let heaving = heaving(&nodes, &rows, &rigid);
        let omega_rad_s: Vec<f64> =
            vec![0.0; heaving.ncols()].into_iter().chain(elastic[..kept].iter().copied()).collect();
        let ratios = damping_ratios(&settings.damping, &elastic[..kept])?;
        let columns = |parts: [DMatrix<f64>; 2]| {
            let all: Vec<_> = parts.iter().flat_map(|part| part.column_iter()).collect();
            DMatrix::from_columns(&all)
        };
        let shapes = columns([heaving.clone(), modes.vectors.columns(free, kept).into_owned()]);
        let below = columns([rigid, modes.vectors.columns_range(free..).into_owned()]);
        let below_inertia = pencil.mass_times(&below).step(STEP, ADVICE)?;
        drop(pencil);
        Ok(Self {
            mass_kg: masses_kg[VERTICAL],
            nodes,
            rows,
            shift,
            factor,
            damping_ratio: vec![0.0; heaving.ncols()].into_iter().chain(ratios).collect(),
            omega_rad_s,
            shapes,
            elastic_rad_s: elastic,
            below,
            below_inertia,
            settings,
            model,
        })
    }

    /// Smallest and largest x, y and z of its nodes, m from the centre of mass.
    pub fn extent_m(&self) -> [[f64; 2]; 3] {
        [0, 1, 2].map(|axis| {
            let places = self.nodes.iter().map(|node| node.place_m[axis]);
            places.fold([0.0; 2], |[low, high]: [f64; 2], place| [low.min(place), high.max(place)])
        })
    }

    /// Mass in kg.
    pub fn mass_kg(&self) -> f64 {
        self.mass_kg
    }

    /// Motion at points along their directions. Forces act on the first `driven` of them; the others are watched.
    ///
    /// # Errors
    /// A point without nodes around it, a node that the model does not have, or that lacks a direction.
    pub fn at(&self, points: &[DirectedPoint], driven: usize) -> Result<BodyModes, StructureError> {
        let mut forces = DMatrix::zeros(self.rows.len(), points.len());
        let place: HashMap<usize, usize> = self.rows.iter().enumerate().map(|(at, row)| (*row as usize, at)).collect();
        for (index, point) in points.iter().enumerate() {
            for (row, weight) in self.weights(point)? {
                if let Some(&at) = place.get(&row) {
                    forces[(at, index)] += weight;
                }
            }
        }
        let driven = driven.min(points.len());
        let highest = self.highest(&forces, driven)?;
        let known = multiply_transposed(&forces, &self.below).step(STEP, ADVICE)?;
        let first = known.ncols() - self.elastic_rad_s.len();
        // Contribution of the known modes from an index on to the flexibility of the unknown ones.
        let and_modes = |from: usize| {
            let shares = known.columns_range(first + from..).into_owned();
            let scale = self.elastic_rad_s[from..].iter().map(|omega| omega.powi(-2));
            let scale = DMatrix::from_diagonal(&DVector::from_iterator(self.elastic_rad_s.len() - from, scale));
            &highest + &shares * scale * shares.rows(0, driven).transpose()
        };
        let symmetric = |of: &DMatrix<f64>| {
            let square = of.rows(0, driven);
            (square + square.transpose()) * 0.5
        };
        let kept = self.omega_rad_s.iter().filter(|omega| **omega > 0.0).count();
        let global = self.elastic_rad_s.iter().filter(|omega| **omega < TAU * LOCAL_HZ).count();
        let residual = and_modes(kept);
        let vertical = points.iter().all(|(_, direction)| direction[..VERTICAL] == [0.0; VERTICAL]);
        let heaving = self.omega_rad_s.len() - kept;
        let (rigid, rows) = if vertical {
            (heaving, multiply_transposed(&forces, &self.shapes).step(STEP, ADVICE)?)
        } else {
            (first, known.columns(0, first + kept).into_owned())
        };
        let with_rigid = |elastic: &[f64]| vec![0.0; rigid].into_iter().chain(elastic.iter().copied()).collect();
        Ok(BodyModes {
            omega_rad_s: with_rigid(&self.omega_rad_s[heaving..]),
            damping_ratio: with_rigid(&self.damping_ratio[heaving..]),
            rows,
            watched: residual.rows_range(driven..).into_owned(),
            residual: symmetric(&residual),
            local: symmetric(&and_modes(global)).diagonal().iter().copied().collect(),
        })
    }

    /// `sum phi phi' / omega^2` over the modes that are not known: along unit forces under the first `driven` of them.
    ///
    /// With `y = sum phi phi' f / (omega^2 + shift)` over these modes, `y + shift (K + shift M)^-1 M y + ...` is the sum that is wanted.
    fn highest(&self, forces: &DMatrix<f64>, driven: usize) -> Result<DMatrix<f64>, StructureError> {
        let product = |a: &DMatrix<f64>, b: &DMatrix<f64>| multiply(a, b).step(STEP, ADVICE);
        let along = multiply_transposed(&self.below, forces).step(STEP, ADVICE)?;
        let above = forces - product(&self.below_inertia, &along)?;
        let acting = above.columns(0, driven).into_owned();
        let mut solution: DMatrix<f64> = DMatrix::zeros(forces.nrows(), driven);
        for _ in 0..REFINEMENTS {
            let mut next = &acting + self.shift * self.mass_times(&solution);
            self.factor.solve(&mut next).step(STEP, ADVICE)?;
            // Remove rounding errors along the modes below the cut-off.
            let leak = multiply_transposed(&self.below_inertia, &next).step(STEP, ADVICE)?;
            solution = next - product(&self.below, &leak)?;
        }
        multiply_transposed(&above, &solution).step(STEP, ADVICE)
    }

    /// The mass matrix times vectors in the order of the factor.
    fn mass_times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(self.model.order(), x.ncols());
        self.rows.iter().enumerate().for_each(|(at, row)| all.row_mut(*row as usize).copy_from(&x.row(at)));
        let product = sparse_times(self.model.mass(), &all);
        DMatrix::from_fn(x.nrows(), x.ncols(), |at, column| product[(self.rows[at] as usize, column)])
    }

    /// Weight of a row of the model in the motion of a point.
    ///
    /// # Errors
    /// As for [`ElasticBody::at`].
    pub fn weight(&self, point: &DirectedPoint, row: usize) -> Result<f64, StructureError> {
        Ok(self.weights(point)?.iter().filter(|(known, _)| *known == row).map(|(_, weight)| weight).sum())
    }

    /// Rows of the model and their weights whose sum is the motion of a point.
    fn weights(&self, (point, direction): &DirectedPoint) -> Result<Vec<(usize, f64)>, StructureError> {
        let direction = *direction;
        match point {
            BodyPoint::Place(place) => self.area(*place, direction),
            BodyPoint::Surface { at_m, axis, side } => self.area(self.surface(*at_m, *axis, *side)?, direction),
            BodyPoint::Nodes(nodes) => self.nodes.motion(nodes, direction).map_err(|fault| {
                StructureError::argument("casting", "nodes with degrees of freedom", format!("a point that {fault}"))
            }),
            BodyPoint::Centre => Ok(self.mass_weights(0, direction)),
            BodyPoint::Rotation(axis) => Ok(self.mass_weights(1 + axis, direction)),
        }
    }

    /// Weights that take from a displacement along a direction d its share of one of the rigid motions `T = [1, -d (t x r)]`, t across d:
    /// `T = [1, y, -x]` for the vertical. They are a column of `M T (T' M T)^-1`.
    fn mass_weights(&self, motion: usize, direction: [f64; 3]) -> Vec<(usize, f64)> {
        let d = Vector3::from(direction);
        let about = across(direction).map(Vector3::from);
        let mut motions = DMatrix::zeros(self.model.order(), 3);
        for node in self.nodes.iter() {
            let r = Vector3::from(node.place_m);
            let shares = [1.0, -d.dot(&about[0].cross(&r)), -d.dot(&about[1].cross(&r))];
            for (row, along) in node.along(direction).into_iter().flatten() {
                shares.into_iter().enumerate().for_each(|(column, value)| motions[(row, column)] = along * value);
            }
        }
        let product = sparse_times(self.model.mass(), &motions);
        let moments: Matrix3<f64> = (motions.transpose() * &product).fixed_view::<3, 3>(0, 0).into_owned();
        let inverse = moments.pseudo_inverse(ON_A_LINE * moments.amax()).unwrap_or_default();
        let weights = product * inverse.column(motion);
        weights.iter().enumerate().filter(|(_, value)| **value != 0.0).map(|(row, value)| (row, *value)).collect()
    }

    /// The first or last place of the body within the radius of the line through a point along an axis.
    fn surface(&self, at_m: [f64; 3], axis: [f64; 3], side: Side) -> Result<[f64; 3], StructureError> {
        let from = |node: &Node| [0, 1, 2].map(|k| node.place_m[k] - at_m[k]);
        let near = |node: &&Node| {
            let aside = perpendicular(from(node), axis);
            dot(aside, aside).sqrt() <= self.settings.point_radius_m
        };
        let along = self.nodes.iter().filter(near).map(|node| dot(node.place_m, axis));
        let found = match side {
            Side::Struck => along.reduce(f64::min),
            Side::Held => along.reduce(f64::max),
        };
        let aside = perpendicular(at_m, axis);
        let [x, y, z] = at_m;
        let place = |along: f64| [0, 1, 2].map(|k| aside[k] + along * axis[k]);
        found.map(place).ok_or_else(|| {
            let z = if axis[..VERTICAL] == [0.0; VERTICAL] { String::new() } else { format!(", z = {z:.4} m") };
            self.no_nodes(format!("x = {x:.4} m, y = {y:.4} m{z}"))
        })
    }

    /// Nodes within the radius of a place. Their weights `w (a + b d1 + c d2)`, `w = (1 - (d/r)^2)^2`, sum to 1 and have their centre at the
    /// place, as seen along the direction of the motion: d1 and d2 are distances across it. Where all nodes lie on a line, only as far as
    /// these can.
    fn area(&self, place: [f64; 3], direction: [f64; 3]) -> Result<Vec<(usize, f64)>, StructureError> {
        let radius = self.settings.point_radius_m;
        let [first, second] = across(direction);
        let weighed = self.nodes.iter().filter_map(|node| {
            let d = [0, 1, 2].map(|axis| (node.place_m[axis] - place[axis]) / radius);
            let inside = 1.0 - (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            let along = node.along(direction)?;
            (inside > 0.0).then(|| (along, inside * inside, Vector3::new(1.0, dot(d, first), dot(d, second))))
        });
        let weighed: Vec<WeighedNode> = weighed.collect();
        if weighed.is_empty() {
            let [x, y, z] = place;
            return Err(self.no_nodes(format!("x = {x:.4} m, y = {y:.4} m, z = {z:.4} m")));
        }
        let moments = weighed.iter().fold(Matrix3::zeros(), |sum, (_, w, p)| sum + p * p.transpose() * *w);
        let factors =
            moments.pseudo_inverse(ON_A_LINE * moments.amax()).unwrap_or_default() * Vector3::new(1.0, 0.0, 0.0);
        let weights: Vec<f64> = weighed.iter().map(|(_, w, p)| w * factors.dot(p)).collect();
        let sum: f64 = weights.iter().sum();
        let shares = weighed.iter().zip(weights);
        let shares = shares.flat_map(|((rows, ..), w)| rows.iter().map(move |(row, along)| (*row, along * (w / sum))));
        Ok(shares.collect())
    }

    fn no_nodes(&self, place: String) -> StructureError {
        let radius = self.settings.point_radius_m;
        let expected = format!("a node within point_radius_m = {radius} of {place} from its centre of mass");
        StructureError::argument("casting", expected, "none: move the point, or set a larger radius")
    }
}

/// The six rigid motions by labels and coordinates, mass-normalised; `None` if the stiffness resists them. They are exact where an
/// eigensolver finds them to the rounding of the stiffness only.
fn rigid_motions(model: &FeModel, centre: [f64; 3], rows: &[u32]) -> Option<DMatrix<f64>> {
    let mut motions = DMatrix::zeros(model.order(), 6);
    for (row, label) in model.labels().iter().enumerate() {
        let place = model.positions_m().get(&label.node)?;
        let [x, y, z] = [0, 1, 2].map(|axis| place[axis] - centre[axis]);
        let rotations = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
        match label.dof {
            axis @ 0..3 => {
                motions[(row, axis)] = 1.0;
                rotations.iter().enumerate().for_each(|(about, motion)| motions[(row, 3 + about)] = motion[axis]);
            }
            dof @ 3..6 => motions[(row, dof)] = 1.0,
            _ => {}
        }
    }
    let stiffest = model.stiffness().data().iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let mut motions = DMatrix::from_fn(rows.len(), 6, |at, column| motions[(rows[at] as usize, column)]);
    let full = |motions: &DMatrix<f64>| {
        let mut all = DMatrix::zeros(model.order(), 6);
        rows.iter().enumerate().for_each(|(at, row)| all.row_mut(*row as usize).copy_from(&motions.row(at)));
        all
    };
    let all = full(&motions);
    if sparse_times(model.stiffness(), &all).amax() > FLOATS * stiffest * all.amax() {
        return None;
    }
    let moments = all.transpose() * sparse_times(model.mass(), &all);
    let inverse = moments.cholesky()?.l().try_inverse()?;
    motions *= inverse.transpose();
    Some(motions)
}

/// The rigid motions that move nodes vertically, orthonormal as those that they are made of. Vertical forces do not excite the others.
fn heaving(nodes: &BodyNodes, rows: &[u32], rigid: &DMatrix<f64>) -> DMatrix<f64> {
    let vertical: HashSet<usize> = nodes.iter().filter_map(|node| node.rows[VERTICAL]).collect();
    let picked: Vec<usize> = (0..rows.len()).filter(|at| vertical.contains(&(rows[*at] as usize))).collect();
    let picked = rigid.select_rows(&picked);
    let eigen = SymmetricEigen::new(picked.transpose() * &picked);
    let largest = eigen.eigenvalues.amax();
    let moving: Vec<usize> = (0..rigid.ncols()).filter(|at| eigen.eigenvalues[*at] > MOVES * largest).collect();
    rigid * eigen.eigenvectors.select_columns(&moving)
}
