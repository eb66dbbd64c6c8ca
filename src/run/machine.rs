//! The machine of a study: its structure reduced once, its modes per placement of the hammers.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::scene::Scene;
use crate::structure::{
    Damping, FeModel, InterfacePoints, ModalOptions, ModalTable, ReducedStructure, ReductionSettings, RigidMass,
    StructureError, StructureModes, reduce,
};
use crate::study::{DampingRatio, Housings, InterfaceDemand, PointTable, StructureSettings, StructureSource};
use crate::system::InterfaceModes;

/// Direction of every strike in the machine's coordinates: vertical, downwards.
const STRIKE_DIRECTION: [f64; 3] = [0.0, 0.0, -1.0];
/// Index of the vertical translation among the six DOFs of a point.
const VERTICAL: usize = 2;
/// DOFs of a point.
const POINT_DOFS: usize = 6;
/// Placements whose modes are kept; a design with more (a continuous rail position) solves each row's own.
const CACHED_PLACEMENTS: usize = 128;

/// Housings of a scene in a form that can be compared: names, and the bits of every number.
type PlacementKey = Vec<(Vec<(String, u64)>, [u64; 7])>;

/// The reduced machine of a study, shared by all rows.
#[derive(Debug)]
pub struct Machine {
    reduced: ReducedStructure,
    options: ModalOptions,
    housings: Housings,
    cache: Mutex<HashMap<PlacementKey, Arc<StructureModes>>>,
}

/// A structure as read, before its reduction: what a study is checked against.
#[derive(Debug)]
pub enum SourceModel {
    /// Finite element matrices.
    Matrices(FeModel),
    /// Modal table with its points.
    ModalTable(ModalTable, InterfacePoints),
}

impl SourceModel {
    /// Reads the structure that the settings name.
    ///
    /// # Errors
    /// What is wrong with its files.
    pub fn read(settings: &StructureSettings) -> Result<Self, StructureError> {
        Ok(match &settings.source {
            StructureSource::Station => Self::Matrices(FeModel::station()?),
            StructureSource::Matrices { stiffness, mass, points } => {
                Self::Matrices(FeModel::read(mass, stiffness, points)?)
            }
            StructureSource::ModalTable { table, points } => {
                Self::ModalTable(ModalTable::read(table)?, InterfacePoints::read(points)?)
            }
        })
    }

    /// Names and positions of its interface points.
    pub fn points(&self) -> PointTable {
        let points = match self {
            Self::Matrices(model) => model.points(),
            Self::ModalTable(_, points) => points,
        };
        points.iter().map(|point| (point.name.clone(), point.position_m)).collect()
    }
}

impl Machine {
    /// Reduces a structure to the interface points that a study can use: all six DOFs of every candidate mount, the
    /// vertical of every fixture point.
    ///
    /// # Errors
    /// What [`reduce`] finds wrong with the structure.
    pub fn new(
        model: SourceModel,
        settings: &StructureSettings,
        demand: &InterfaceDemand,
    ) -> Result<Self, StructureError> {
        let reduced = match model {
            SourceModel::Matrices(model) => {
                let mut interface: Vec<(String, usize)> = Vec::new();
                for mount in &demand.mounts {
                    interface.extend((0..POINT_DOFS).map(|dof| (mount.clone(), dof)));
                }
                interface.extend(demand.fixtures.iter().map(|point| (point.clone(), VERTICAL)));
                let fixed_interface_cutoff_hz = settings.fixed_interface_cutoff_hz;
                reduce(&model, &ReductionSettings { interface, fixed_interface_cutoff_hz })?
            }
            SourceModel::ModalTable(table, points) => ReducedStructure::from_modal_table(&table, points)?,
        };
        let damping = match &settings.damping_ratio {
            DampingRatio::Uniform(ratio) => Damping::Ratio(*ratio),
            DampingRatio::PerMode(ratios) => Damping::PerMode(ratios.clone()),
        };
        Ok(Self {
            reduced,
            options: ModalOptions { cutoff_hz: settings.cutoff_hz, damping },
            housings: settings.housings,
            cache: Mutex::default(),
        })
    }

    /// Modes of the machine with the housings of a scene on their mounts, and their shapes at the scene's interface points.
    ///
    /// # Errors
    /// A mount or fixture point that was not kept, or a placement whose eigenproblem has no solution.
    pub fn modes(&self, scene: &Scene) -> Result<InterfaceModes, StructureError> {
        let modes = self.placed(scene)?;
        let row = |points: &[(String, f64)]| modes.row(points, STRIKE_DIRECTION);
        let mounts = scene.hammers.iter().map(|hammer| row(&hammer.mount.points));
        let fixtures = scene.castings.iter().map(|casting| {
            casting.fixtures.iter().map(|fixture| row(&[(fixture.point.clone(), 1.0)])).collect::<Result<_, _>>()
        });
        Ok(InterfaceModes {
            mounts: mounts.collect::<Result<_, _>>()?,
            fixtures: fixtures.collect::<Result<_, _>>()?,
            omega_rad_s: modes.omega_rad_s.clone(),
            damping_ratio: modes.damping_ratio.clone(),
        })
    }

    /// The modes of a placement, from the cache where it is there. A pure function of the scene: the cache only saves time.
    fn placed(&self, scene: &Scene) -> Result<Arc<StructureModes>, StructureError> {
        let housings = match self.housings {
            Housings::Add => housings(scene),
            Housings::Included => Vec::new(),
        };
        let key = key(&housings);
        // A panic elsewhere leaves the map whole: entries are inserted in one go.
        let cached = self.cache.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        if let Some(modes) = cached {
            return Ok(modes);
        }
        let modes = Arc::new(self.reduced.modes(&housings, &self.options)?);
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        if cache.len() < CACHED_PLACEMENTS {
            cache.insert(key, Arc::clone(&modes));
        }
        Ok(modes)
    }
}

/// The housings of a scene; one without mass is none.
fn housings(scene: &Scene) -> Vec<RigidMass> {
    let massive = scene.hammers.iter().filter(|hammer| hammer.parameters.housing.mass_kg > 0.0);
    massive
        .map(|hammer| {
            let housing = &hammer.parameters.housing;
            RigidMass {
                points: hammer.mount.points.clone(),
                mass_kg: housing.mass_kg,
                inertia_kg_m2: housing.inertia_kg_m2,
                centre_of_mass_m: housing.centre_of_mass_m,
            }
        })
        .collect()
}

fn key(housings: &[RigidMass]) -> PlacementKey {
    let entry = |housing: &RigidMass| {
        let points = housing.points.iter().map(|(name, weight)| (name.clone(), weight.to_bits())).collect();
        let ([j0, j1, j2], [c0, c1, c2]) = (housing.inertia_kg_m2, housing.centre_of_mass_m);
        (points, [housing.mass_kg, j0, j1, j2, c0, c1, c2].map(f64::to_bits))
    };
    housings.iter().map(entry).collect()
}
