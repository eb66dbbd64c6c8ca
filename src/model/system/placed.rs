//! The structure's modes at the interface points of one placement, and constants that follow from them.

use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use nalgebra::{DMatrix, DVector};

use crate::scene::{PartId, PointId};
use crate::system::block::CondensedConstants;
use crate::system::dissipation::{Damping, interval_s};
use crate::system::impulse_response::Condensation;
use crate::system::modal::Modes;

/// Modes whose shape at every driven point is below this share of the largest are not excited by the scene and move
/// none of its points: leaving them out changes nothing beyond rounding.
const EXCITED_SHARE: f64 = 1e-9;

/// Modes of an elastic part as a scene sees them.
#[derive(Debug, Clone, PartialEq)]
pub struct InterfaceModes {
    /// Natural circular frequencies in rad/s.
    pub omega_rad_s: Vec<f64>,
    /// Damping ratio per mode.
    pub damping_ratio: Vec<f64>,
    /// Mode shapes along the strike axis at each point of the part, see [`crate::scene::Scene::points`].
    pub shapes: BTreeMap<PointId, Vec<f64>>,
}

impl InterfaceModes {
    /// Points that links join with their shapes, in the order of the machine's columns; or those that are watched.
    pub(super) fn rows(&self, watched: bool) -> impl Iterator<Item = (PointId, &Vec<f64>)> {
        self.shapes.iter().map(|(id, row)| (*id, row)).filter(move |(id, _)| id.is_watched() == watched)
    }

    /// The modes that the scene excites. Modes that no driven point moves stay at rest, even if a watched point follows them.
    fn excited(&self) -> Excited {
        let [rows, watched] = [false, true].map(|watched| self.rows(watched).map(|(_, row)| row).collect::<Vec<_>>());
        let share = |k: usize| rows.iter().fold(0.0_f64, |largest, row| largest.max(row[k].abs()));
        let count = self.omega_rad_s.len();
        let threshold = EXCITED_SHARE * (0..count).map(share).fold(0.0, f64::max);
        let kept: Vec<usize> = (0..count).filter(|&k| share(k) > threshold).collect();
        let omega = |k: &usize| self.omega_rad_s[*k];
        let shapes = |rows: &[&Vec<f64>]| DMatrix::from_fn(kept.len(), rows.len(), |s, n| rows[n][kept[s]]);
        let modes = Modes {
            omega_squared: DVector::from_iterator(kept.len(), kept.iter().map(|k| omega(k).powi(2))),
            damping: DVector::from_iterator(kept.len(), kept.iter().map(|k| 2.0 * self.damping_ratio[*k] * omega(k))),
            phi: shapes(&rows),
        };
        let points = self.rows(true).map(|(id, _)| id).collect();
        Excited { modes: Arc::new(modes), watched: Arc::new(Watched { points, shapes: shapes(&watched) }) }
    }
}

/// Modes that a scene excites.
#[derive(Debug, Clone)]
pub(super) struct Excited {
    /// Modes with their shapes at the driven points.
    pub modes: Arc<Modes>,
    /// Watched points.
    pub watched: Arc<Watched>,
}

/// Points that no link joins: they follow the modes.
#[derive(Debug, Clone)]
pub(super) struct Watched {
    /// The points.
    pub points: Vec<PointId>,
    /// Mode shapes: modes x points.
    pub shapes: DMatrix<f64>,
}

/// Flexibility of the modes of an elastic part that are left out, under forces on the points that links join, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct Residual {
    /// Flexibility between the points that links join in m/N; symmetric.
    pub flexibility: DMatrix<f64>,
    /// Motion of the watched points in m/N: watched points x points that links join.
    pub watched: DMatrix<f64>,
    /// Local flexibility of each point in m/N, including left-out modes: the part that a contact's stiffness may include.
    pub local: Vec<f64>,
}

/// Modes that scenes with one placement share, with results of the first scene for later ones.
#[derive(Debug)]
pub struct PlacedModes {
    interface: InterfaceModes,
    /// Residual flexibility of the points that links join; `None` for none.
    residual: Option<Residual>,
    /// Modes of the elastic castings, by the castings' indices.
    castings: BTreeMap<usize, Self>,
    excited: OnceLock<Excited>,
    condensed: OnceLock<Option<CondensedConstants>>,
}

impl From<InterfaceModes> for PlacedModes {
    fn from(interface: InterfaceModes) -> Self {
        Self {
            interface,
            residual: None,
            castings: BTreeMap::new(),
            excited: OnceLock::new(),
            condensed: OnceLock::new(),
        }
    }
}

/// Modes on which a scene can run.
pub trait SceneModes {
    /// Shows the modes with what scenes share.
    fn with_placed<T>(&self, see: impl FnOnce(&PlacedModes) -> T) -> T;
}

impl SceneModes for PlacedModes {
    fn with_placed<T>(&self, see: impl FnOnce(&PlacedModes) -> T) -> T {
        see(self)
    }
}

/// Modes of a machine that carries rigid castings only.
impl SceneModes for InterfaceModes {
    fn with_placed<T>(&self, see: impl FnOnce(&PlacedModes) -> T) -> T {
        see(&PlacedModes::from(self.clone()))
    }
}

impl<M: SceneModes> SceneModes for Arc<M> {
    fn with_placed<T>(&self, see: impl FnOnce(&PlacedModes) -> T) -> T {
        M::with_placed(self, see)
    }
}

impl Deref for PlacedModes {
    type Target = InterfaceModes;

    fn deref(&self) -> &InterfaceModes {
        &self.interface
    }
}

impl PlacedModes {
    /// Adds the residual flexibility of the modes left out; it has no mass.
    pub fn with_residual(self, residual: Residual) -> Self {
        Self { residual: Some(residual), ..self }
    }

    /// Adds the modes of an elastic casting, its rigid motions among them.
    pub fn with_casting(mut self, casting: usize, modes: Self) -> Self {
        self.castings.insert(casting, modes);
        self
    }

    /// The modes of the elastic castings, by the castings' indices.
    pub fn castings(&self) -> impl Iterator<Item = (usize, &InterfaceModes)> {
        self.castings.iter().map(|(casting, modes)| (*casting, &modes.interface))
    }

    /// The modes of the machine or of an elastic casting; `None` for a rigid part.
    pub(super) fn of(&self, part: PartId) -> Option<&Self> {
        match part {
            PartId::Casting(casting) => self.castings.get(&casting),
            PartId::Machine => Some(self),
            PartId::Hammer(_) => None,
        }
    }

    /// The residual flexibility of the points that links join.
    pub(super) fn residual(&self) -> Option<&Residual> {
        self.residual.as_ref()
    }

    /// The modes that scenes here excite. The shapes must all have the number of modes.
    pub(super) fn excited(&self) -> &Excited {
        self.excited.get_or_init(|| self.interface.excited())
    }

    /// These condensed, see [`Condensation::new`], for runs of `duration_s`: usually that of the first run.
    pub(super) fn condensed(&self, duration_s: f64) -> Option<CondensedConstants> {
        let new = |condensation: Arc<Condensation>, interval_s: f64| -> Option<CondensedConstants> {
            let damping = Arc::new(Damping::new(&condensation, interval_s)?);
            Some(CondensedConstants { modes: Arc::clone(&self.excited().modes), condensation, damping })
        };
        let first = || {
            let condensation = Arc::new(Condensation::new(&self.excited().modes)?);
            let interval_s = interval_s(&condensation, duration_s);
            new(condensation, interval_s)
        };
        let first = self.condensed.get_or_init(first).clone()?;
        let interval_s = interval_s(&first.condensation, duration_s);
        if first.damping.interval_s == interval_s { Some(first) } else { new(first.condensation, interval_s) }
    }
}
