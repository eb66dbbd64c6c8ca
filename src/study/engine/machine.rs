//! The machine of a study: structure reduced once, modes per placement of the hammers.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::{InterfaceDemand, PointTable, StructureSettings, StructureSource};
use decore_model::scene::{Housings, Location, PartId, PointId, STANDARD, Scene};
use decore_model::structure::{
    BodyModes, Damping, DirectedPoint, DirectedPoints, ElasticBody, ElasticSettings, FeModel, InterfacePoints,
    ModalOptions, ModalTable, ModeSelection, ModelFiles, ModesAt, ReducedStructure, ReductionSettings, RigidMass,
    SelectionSettings, StructureError, cache_path, reduce, reduce_files,
};
use decore_model::system::{InterfaceModes, PlacedModes, Residual};

/// Index of the vertical translation among the six DOFs of a point.
const VERTICAL: usize = 2;
/// Relative difference of masses that are the same.
const SAME_MASS: f64 = 0.01;
/// DOFs of a point.
const POINT_DOFS: usize = 6;
/// Placements whose modes are kept; a design with more (a continuous rail position) solves each row's own.
const CACHED_PLACEMENTS: usize = 128;

/// Weighted points in a form that can be compared: names, and the bits of every weight.
type PointsKey = Vec<(String, u64)>;
/// Housings of a scene with the bits of their numbers, its points on the structure with their directions, and those on elastic castings.
type PlacementKey = (Vec<(PointsKey, [u64; 10])>, Vec<(PointId, PointsKey, [u64; 3])>, Vec<(PointId, String)>);

/// The reduced machine of a study, shared by all rows.
#[derive(Debug)]
pub struct Machine {
    reduced: ReducedStructure,
    options: ModalOptions,
    /// Settings of the selection of modes per scene.
    selection: Option<SelectionSettings>,
    housings: Housings,
    /// The reduction from which numerical twins take all modes.
    whole: AllModes,
    /// Modes for rows: all of them, or the selection for the study's tolerance.
    cache: Mutex<HashMap<PlacementKey, Arc<PlacedModes>>>,
    /// The elastic castings of the study, by their indices.
    castings: ElasticCastings,
    notes: Vec<String>,
}

/// The reduction from which numerical twins take all modes.
#[derive(Debug)]
enum AllModes {
    /// The one that rows run on.
    Same,
    /// Built-in station with more fixed-interface modes, reduced on first use.
    Station(Box<ReductionSettings>, Box<OnceLock<Result<ReducedStructure, String>>>),
}

/// Elastic castings of a study, by their indices.
pub type ElasticCastings = Arc<BTreeMap<usize, ElasticCasting>>;

/// An elastic casting of a study.
#[derive(Debug)]
pub struct ElasticCasting {
    name: String,
    body: ElasticBody,
}

/// Hammers and fixtures of a scene on the machine.
struct Placement {
    /// The bodies that the structure carries.
    bodies: Vec<RigidMass>,
    /// The points at which the scene touches the structure, in the order of the rows of mode shapes.
    points: Vec<PointId>,
    /// Nodes and directions.
    rows: Vec<DirectedPoints>,
    /// Points of elastic castings: those that links join come first.
    castings: BTreeMap<usize, CastingPoints>,
}

/// Points of an elastic casting.
#[derive(Default)]
struct CastingPoints {
    driven: Vec<(PointId, DirectedPoint)>,
    watched: Vec<(PointId, DirectedPoint)>,
}

/// A structure before its reduction, for the checks of a study.
#[derive(Debug)]
pub enum SourceModel {
    /// A finite element model.
    Model(Box<FeModel>),
    /// The files of a finite element model, of which only the points have been read: a reduction may be at hand.
    Files(Box<ModelFiles>, InterfacePoints, bool),
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
            StructureSource::Station => Self::Model(Box::new(FeModel::station()?)),
            StructureSource::Matrices(source) => {
                let points = InterfacePoints::read(&source.files.points)?;
                Self::Files(Box::new(source.files.clone()), points, source.cache)
            }
            StructureSource::ModalTable { table, points } => {
                Self::ModalTable(ModalTable::read(table)?, InterfacePoints::read(points)?)
            }
        })
    }

    /// Names and positions of its interface points.
    pub fn points(&self) -> PointTable {
        let points = match self {
            Self::Model(model) => model.points(),
            Self::Files(_, points, _) | Self::ModalTable(_, points) => points,
        };
        points.iter().map(|point| (point.name.clone(), point.position_m)).collect()
    }
}

impl ElasticCasting {
    /// Computes the modes of a casting from its model.
    ///
    /// # Errors
    /// As for [`ElasticBody::new`].
    pub(super) fn new(name: &str, model: FeModel, settings: &ElasticSettings) -> Result<Self, StructureError> {
        let body = ElasticBody::new(model, settings.clone()).map_err(|error| named(error, name))?;
        Ok(Self { name: name.to_owned(), body })
    }
}

/// An error about a casting, with the casting's name.
pub(super) fn named(error: StructureError, casting: &str) -> StructureError {
    match error {
        StructureError::Argument { name, expected, found } if name == "casting" => {
            StructureError::Argument { name: format!("casting.{casting}.structure"), expected, found }
        }
        other => other,
    }
}

impl Machine {
    /// Reduces a structure to the interface points that a study can use, see [`reduction_settings`].
    ///
    /// # Errors
    /// What [`reduce`] finds wrong with the structure.
    pub fn new(
        model: SourceModel,
        settings: &StructureSettings,
        (demand, castings): (&InterfaceDemand, &ElasticCastings),
    ) -> Result<Self, StructureError> {
        let settings_of = || reduction_settings(settings, demand);
        let whole = match &settings.source {
            StructureSource::Station if settings.fixed_interface_cutoff_hz < STANDARD.station_basis_hz => {
                let fixed_interface_cutoff_hz = STANDARD.station_basis_hz;
                let settings = ReductionSettings { fixed_interface_cutoff_hz, ..settings_of() };
                AllModes::Station(Box::new(settings), Box::default())
            }
            _ => AllModes::Same,
        };
        let mut notes = Vec::new();
        let reduced = match model {
            SourceModel::Model(model) => reduce(&model, &settings_of())?,
            SourceModel::Files(files, _, cache) => {
                let settings = settings_of();
                let (reduced, outcome) = reduce_files(&files, &settings, cache)?;
                notes.extend(outcome.note(&cache_path(&files, &settings)));
                reduced
            }
            SourceModel::ModalTable(table, points) => ReducedStructure::from_modal_table(&table, points)?,
        };
        notes.extend(reduced.remarks().iter().map(|remark| format!("the machine looks wrong: {remark}")));
        let damping = settings.damping_ratio.clone();
        let selection = settings.mode_tolerance;
        Ok(Self {
            reduced,
            options: ModalOptions { cutoff_hz: settings.cutoff_hz, damping },
            selection: selection.map(|tolerance| SelectionSettings { tolerance, band_hz: settings.mode_band_hz }),
            housings: settings.housings,
            whole,
            cache: Mutex::default(),
            castings: Arc::clone(castings),
            notes,
        })
    }

    /// Notes for the user, in lines: a cached reduction that could not be used, doubtful matrices.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Modes of the machine with the housings of a scene on their mounts, and their shapes at the scene's interface points;
    /// where the study sets a tolerance, those that the scene needs and the residual modes of the others.
    ///
    /// # Errors
    /// A mount or fixture point that was not kept, or a placement whose eigenproblem has no solution.
    pub fn modes(&self, scene: &Scene) -> Result<Arc<PlacedModes>, StructureError> {
        self.require_masses(scene)?;
        let placement = self.placement(scene);
        let key = key(&placement);
        // A panic elsewhere leaves the map whole: entries are inserted in one go.
        let cached = self.cache.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        if let Some(placed) = cached {
            return Ok(placed);
        }
        // A pure function of the scene: the cache only saves time.
        let chosen = match self.selection {
            Some(settings) => self.select_at(&placement, settings)?.1,
            None => placement.all(&self.reduced.modes_at(&placement.bodies, &self.options, &placement.rows)?),
        };
        let placed = Arc::new(self.with_castings(chosen.into(), &placement)?);
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        if cache.len() < CACHED_PLACEMENTS {
            cache.insert(key, Arc::clone(&placed));
        }
        Ok(placed)
    }

    /// All modes of the machine with the housings of a scene on their mounts, whatever the study selects; of the built-in station all
    /// that the basis of the preset `standard` has. Where the study lists a damping ratio per mode, its modes below the cut-off: there
    /// is no damping for others.
    ///
    /// # Errors
    /// As for [`Machine::modes`], in words.
    pub fn all_modes(&self, scene: &Scene) -> Result<Arc<PlacedModes>, String> {
        let reduced = match &self.whole {
            AllModes::Same => &self.reduced,
            AllModes::Station(settings, whole) => {
                let reduce = || FeModel::station().and_then(|model| reduce(&model, settings));
                whole.get_or_init(|| reduce().map_err(|error| error.to_string())).as_ref().map_err(String::clone)?
            }
        };
        let cutoff_hz = match (&self.options.damping, self.selection) {
            (Damping::PerMode(_), None) => self.options.cutoff_hz,
            _ => f64::MAX,
        };
        let options = ModalOptions { cutoff_hz, damping: self.options.damping.clone() };
        let placement = self.placement(scene);
        let modes = reduced.modes_at(&placement.bodies, &options, &placement.rows);
        let modes = placement.all(&modes.map_err(|error| error.to_string())?);
        Ok(Arc::new(self.with_castings(modes.into(), &placement).map_err(|error| error.to_string())?))
    }

    /// Checks the masses of elastic castings against their matrices.
    fn require_masses(&self, scene: &Scene) -> Result<(), StructureError> {
        for (index, ElasticCasting { body, .. }) in self.castings.iter() {
            let Some(casting) = scene.castings.get(*index) else { continue };
            let (given, found) = (casting.mass_kg, body.mass_kg());
            if (given - found).abs() > SAME_MASS * found {
                let (name, expected) =
                    (format!("casting.{}.mass_kg", casting.name), format!("the mass of its matrices, {found:.4} kg"));
                return Err(StructureError::Argument { name, expected, found: given.to_string() });
            }
        }
        Ok(())
    }

    /// Smallest and largest x, y and z of an elastic casting, m from its centre of mass; `None` for a rigid casting.
    pub fn casting_extent_m(&self, casting: usize) -> Option<[[f64; 2]; 3]> {
        self.castings.get(&casting).map(|casting| casting.body.extent_m())
    }

    /// Adds the modes of the elastic castings.
    fn with_castings(&self, modes: PlacedModes, placement: &Placement) -> Result<PlacedModes, StructureError> {
        let mut modes = modes;
        for (casting, CastingPoints { driven, watched }) in &placement.castings {
            let Some(elastic) = self.castings.get(casting) else { continue };
            let (ids, points): (Vec<PointId>, Vec<DirectedPoint>) = driven.iter().chain(watched).cloned().unzip();
            let BodyModes { omega_rad_s, damping_ratio, rows, residual, watched, local } =
                elastic.body.at(&points, driven.len()).map_err(|error| named(error, &elastic.name))?;
            let shapes = rows.row_iter().map(|row| row.iter().copied().collect());
            let interface =
                InterfaceModes { omega_rad_s, damping_ratio, shapes: ids.into_iter().zip(shapes).collect() };
            let residual = Residual { flexibility: residual, watched, local };
            modes = modes.with_casting(*casting, PlacedModes::from(interface).with_residual(residual));
        }
        Ok(modes)
    }

    /// Selection of modes for a scene; `None` if the study sets no tolerance.
    ///
    /// # Errors
    /// As for [`Machine::modes`].
    pub fn selection(&self, scene: &Scene) -> Result<Option<ModeSelection>, StructureError> {
        let select = |settings| Ok(self.select_at(&self.placement(scene), settings)?.0);
        self.selection.map(select).transpose()
    }

    /// Selects the modes that matter to a scene's mounts (first), fixtures and watched points. Returns the selection, and the modes to run
    /// on.
    ///
    /// # Errors
    /// As for [`Machine::modes`]; settings out of range.
    pub fn select(
        &self,
        scene: &Scene,
        settings: SelectionSettings,
    ) -> Result<(ModeSelection, InterfaceModes), StructureError> {
        self.select_at(&self.placement(scene), settings)
    }

    fn select_at(
        &self,
        placement: &Placement,
        settings: SelectionSettings,
    ) -> Result<(ModeSelection, InterfaceModes), StructureError> {
        let Placement { bodies, rows, .. } = placement;
        let modes = self.reduced.modes_to_select(bodies, &self.options.damping, rows, settings)?;
        let selection = modes.select(settings)?;
        let chosen = placement.selected(&modes, &selection);
        Ok((selection, chosen))
    }

    fn placement(&self, scene: &Scene) -> Placement {
        let bodies = match self.housings {
            Housings::Add => housings(scene),
            Housings::Included => Vec::new(),
        };
        let points = scene.points().into_values().filter(|point| point.part == PartId::Machine);
        let (points, rows) = points
            .filter_map(|point| match point.location {
                Location::Nodes(nodes) => Some((point.id, (nodes, point.direction))),
                _ => None,
            })
            .unzip();
        let mut castings: BTreeMap<usize, CastingPoints> = BTreeMap::new();
        for point in scene.points().into_values() {
            if let (PartId::Casting(casting), Location::Place(place)) = (point.part, point.location) {
                let points = castings.entry(casting).or_default();
                let list = if point.id.is_watched() { &mut points.watched } else { &mut points.driven };
                list.push((point.id, (place, point.direction)));
            }
        }
        Placement { bodies, points, rows, castings }
    }
}

impl Placement {
    /// All modes.
    fn all(&self, modes: &ModesAt) -> InterfaceModes {
        let shapes = modes.rows.row_iter().map(|row| row.iter().copied().collect());
        InterfaceModes {
            omega_rad_s: modes.omega_rad_s.clone(),
            damping_ratio: modes.damping_ratio.clone(),
            shapes: self.points.iter().copied().zip(shapes).collect(),
        }
    }

    /// Kept modes, then residual modes.
    fn selected(&self, modes: &ModesAt, selection: &ModeSelection) -> InterfaceModes {
        let residual = &selection.residual;
        let with_residual = |of: &[f64], residual: &[f64]| -> Vec<f64> {
            selection.kept.iter().map(|&mode| of[mode]).chain(residual.iter().copied()).collect()
        };
        let rows = selection.rows.row_iter().zip(residual.rows.row_iter());
        let shapes = rows.map(|(kept, residual)| kept.iter().chain(residual.iter()).copied().collect());
        InterfaceModes {
            omega_rad_s: with_residual(&modes.omega_rad_s, &residual.omega_rad_s),
            damping_ratio: with_residual(&modes.damping_ratio, &residual.damping_ratio),
            shapes: self.points.iter().copied().zip(shapes).collect(),
        }
    }
}

/// DOFs that a study's reduction keeps: all six DOFs of every candidate mount, because a housing is added there (only translations if
/// housings are part of the machine), and the translations of every other point; of translations only the vertical if all else is
/// vertical in every row.
pub fn reduction_settings(settings: &StructureSettings, demand: &InterfaceDemand) -> ReductionSettings {
    let translations = if demand.sideways { 0..VERTICAL + 1 } else { VERTICAL..VERTICAL + 1 };
    let dofs = match settings.housings {
        Housings::Add => 0..POINT_DOFS,
        Housings::Included => translations.clone(),
    };
    let mounts = demand.mounts.iter().flat_map(|mount| dofs.clone().map(|dof| (mount.clone(), dof)));
    let others = demand.others.iter().flat_map(|point| translations.clone().map(|dof| (point.clone(), dof)));
    ReductionSettings {
        interface: mounts.chain(others).collect(),
        fixed_interface_cutoff_hz: settings.fixed_interface_cutoff_hz,
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
                axis: hammer.axis(),
            }
        })
        .collect()
}

fn key(placement: &Placement) -> PlacementKey {
    let bits = |points: &[(String, f64)]| -> PointsKey {
        points.iter().map(|(name, weight)| (name.clone(), weight.to_bits())).collect()
    };
    let entry = |housing: &RigidMass| {
        let ([j0, j1, j2], [c0, c1, c2]) = (housing.inertia_kg_m2, housing.centre_of_mass_m);
        let [x, y, z] = housing.axis;
        (bits(&housing.points), [housing.mass_kg, j0, j1, j2, c0, c1, c2, x, y, z].map(f64::to_bits))
    };
    let points = placement.points.iter().zip(&placement.rows);
    let points = points.map(|(id, (points, direction))| (*id, bits(points), direction.map(f64::to_bits)));
    // Shortest digits that give the number back: equal texts are equal places.
    let of_castings = placement.castings.values().flat_map(|points| points.driven.iter().chain(&points.watched));
    let of_castings = of_castings.map(|(id, place)| (*id, format!("{place:?}"))).collect();
    (placement.bodies.iter().map(entry).collect(), points.collect(), of_castings)
}
