//! Builds a coupled model from a scene and the machine's modes at its points. Only this part uses scenes.
//!
//! - `hammer`: hammers with their columns and contacts
//! - `equilibrium`: the state of rest
//! - `scales`: error scales of the states

mod equilibrium;
mod hammer;
mod scales;

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::scene::{ModeTreatment, Owner, Part, PartId, PointId, Scene};
use crate::system::block::{Block, Condensed, CoupledPart, Rigid};
use crate::system::elements::{Elements, FlexibilityError};
use crate::system::impulse_response;
use crate::system::layout::Layout;
use crate::system::modal::TiedMasses;
use crate::system::model::{CoupledModel, WeightedPair};
use crate::system::placed::{InterfaceModes, PlacedModes};
use crate::system::points::Points;
use crate::workpiece::WorkpieceError;

/// Reason why a scene cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// A casting is not held or lacks its inertia.
    #[error(transparent)]
    Workpiece(#[from] WorkpieceError),
    /// A hammer strikes a casting that is not in the scene.
    #[error("hammer `{hammer}` strikes casting number {casting}, but the scene has {castings}")]
    NoSuchCasting {
        /// Name of the hammer.
        hammer: String,
        /// Requested index.
        casting: usize,
        /// Castings in the scene.
        castings: usize,
    },
    /// The machine's modes have no shape at a point of the scene, or one at a point that the scene does not have.
    #[error("the scene and the machine's modes do not have the same points: only one of them has {point:?}")]
    Point {
        /// The point.
        point: PointId,
    },
    /// An elastic casting without modes.
    #[error("elastic casting number {casting} has no modes")]
    Modes {
        /// Index of the casting.
        casting: usize,
    },
    /// A contact's law cannot take the flexibility of the casting.
    #[error("the contact of {link} {error}")]
    Flexibility {
        /// Hammer and casting, or fixture and casting.
        link: String,
        /// The fault.
        error: FlexibilityError,
    },
    /// The machine's modes do not fit each other.
    #[error("{given} {what} were given, expected {expected}: one per mode")]
    Shapes {
        /// Damping ratios, or shares of modes in a shape.
        what: &'static str,
        /// Number given.
        given: usize,
        /// Number expected.
        expected: usize,
    },
    /// A casting tips off its one-sided fixtures.
    #[error(
        "casting `{casting}` cannot rest on its one-sided fixtures: its weight and its clamps tip it off them; place a fixture on the \
         other side, or a clamp (`clamp_force_n`) between the fixtures"
    )]
    NoRest {
        /// Name of the casting.
        casting: String,
    },
    /// Gravity pulls a casting along its pads, and only their friction holds it.
    #[error(
        "casting `{casting}` cannot rest: gravity pulls it sideways, where only the friction of its pads holds it, on which it would creep; \
         give its fixtures a `lateral_stiffness_n_per_m`"
    )]
    Slides {
        /// Name of the casting.
        casting: String,
    },
    /// The masses of the tied guides make no positive definite matrix.
    #[error("guide masses must be positive to be tied to their mounts")]
    GuideMass,
}

/// Builds the coupled model of a scene.
///
/// # Errors
/// [`BuildError`] if a casting is not held, a hammer's casting does not exist, or the mode shapes do not fit the scene.
pub fn build(scene: &Scene, modes: &InterfaceModes) -> Result<Arc<CoupledModel>, BuildError> {
    build_placed(scene, &PlacedModes::from(modes.clone()))
}

/// As [`build`], on modes that other scenes share.
///
/// # Errors
/// As for [`build`].
pub fn build_placed(scene: &Scene, placed: &PlacedModes) -> Result<Arc<CoupledModel>, BuildError> {
    check_strikes(scene)?;
    let described = scene.parts()?;
    for (id, _) in described.iter().filter(|(_, part)| *part == Part::Elastic) {
        check(scene, placed, *id)?;
    }
    let (layout, parts) = parts(scene, &described, placed)?;
    let points = points(scene, (&described, &parts), placed);
    let mut links = scene.links();
    equilibrium::share_loads(scene, &mut links)?;
    let elements = Elements::new(&links, &points, parts.iter().map(|part| part.columns.len()).sum());
    let residuals = parts.iter().filter_map(|part| Some((part.columns.start, placed.of(part.id)?.residual()?)));
    let elements = elements.with_residuals(&links, &residuals.collect::<Vec<_>>());
    let elements = elements.map_err(|error| inflexible(scene, error))?.with_frictions(&scene.frictions());
    let mut model = CoupledModel {
        layout,
        scales: scales::scales(&layout, described.iter().map(|(_, part)| part), &parts),
        supports: supports(&elements, &layout, &parts),
        sums: sums(&elements, &layout),
        hammers: (0..scene.hammers.len()).map(|h| hammer::slot(scene, h, (&points, &elements))).collect(),
        elements,
        parts,
        points,
        ambient_pressure_pa: scene.environment.ambient_pressure_pa,
        gas_constant_j_per_kg_k: scene.environment.gas_constant_j_per_kg_k,
        initial: Vec::new(),
    };
    model.initial = equilibrium::rest(&model);
    Ok(Arc::new(model))
}

/// The error of a contact with the names of its parts.
fn inflexible(scene: &Scene, error: FlexibilityError) -> BuildError {
    let casting = |casting: usize| &scene.castings[casting];
    let link = match error.owner() {
        Owner::Hammer { hammer, .. } => {
            let unit = &scene.hammers[hammer];
            format!("hammer `{}` with casting `{}`", unit.name, casting(unit.casting).name)
        }
        Owner::Fixture(id) => {
            let held = casting(id.casting);
            format!("fixture `{}` with casting `{}`", held.fixtures[id.fixture].name, held.name)
        }
    };
    BuildError::Flexibility { link, error }
}

/// Returns the parts with their blocks and the layout of the state. Flexible parts come first in the state, rigid parts come first in
/// the columns.
fn parts(
    scene: &Scene,
    described: &[(PartId, Part)],
    placed: &PlacedModes,
) -> Result<(Layout, Vec<CoupledPart>), BuildError> {
    let block = |(id, part): &(PartId, Part)| match (part, placed.of(*id)) {
        (Part::Rigid(freedoms), _) => Block::Rigid(Rigid { mass: freedoms.iter().map(|(_, mass)| *mass).collect() }),
        (Part::Elastic, Some(casting)) if *id != PartId::Machine => Block::Modal(Arc::clone(&casting.excited().modes)),
        (Part::Elastic, _) => machine(scene, placed),
    };
    let blocks: Vec<Block> = described.iter().map(block).collect();
    let is_rigid = |block: &Block| matches!(block, Block::Rigid(_));
    let flexible = blocks.iter().filter(|block| !is_rigid(block)).map(Block::states);
    let layout = Layout {
        flexible: flexible.fold([0; 2], |sum, states| [sum[0] + states[0], sum[1] + states[1]]),
        bodies: blocks.iter().filter(|block| is_rigid(block)).map(Block::columns).sum(),
        hammers: scene.hammers.len(),
        castings: scene.castings.len(),
    };
    // First column, displacement and velocity of the next rigid part and of the next flexible one.
    let mut next_rigid = [0, layout.position(0), layout.velocity(0)];
    let mut next_flexible = [layout.bodies, 0, layout.velocities()];
    let mut tied = tied_guides(scene, placed)?;
    let part = |(id, block): (PartId, Block)| {
        let next = if is_rigid(&block) { &mut next_rigid } else { &mut next_flexible };
        let [first, second] = block.states();
        let [columns, displacements, velocities] =
            [(0, block.columns()), (1, first), (2, second)].map(|(of, count)| {
                let begin = next[of];
                next[of] += count;
                begin..next[of]
            });
        let is_machine = id == PartId::Machine;
        let watched = placed.of(id).map(|modes| Arc::clone(&modes.excited().watched));
        let tied = if is_machine { tied.take() } else { None };
        CoupledPart { id, block, columns, states: [displacements, velocities], tied, watched }
    };
    Ok((layout, described.iter().map(|(id, _)| *id).zip(blocks).map(part).collect()))
}

/// Returns the machine's block: modes integrated or condensed, as the scene asks for or as costs less.
fn machine(scene: &Scene, placed: &PlacedModes) -> Block {
    let modes = &placed.excited().modes;
    let condense = match scene.solver.modes {
        ModeTreatment::Automatic => impulse_response::pays(modes),
        ModeTreatment::Integrated => false,
        ModeTreatment::Condensed => true,
    };
    // The machine is the first of the flexible parts: its integrals begin the state.
    let constants = if condense { placed.condensed(scene.duration_s) } else { None };
    constants.map_or_else(
        || Block::Modal(Arc::clone(modes)),
        |constants| Block::Condensed(Box::new(Condensed::at_rest(constants, 0))),
    )
}

/// Returns the guides as masses tied to their mounts, the first points of the machine.
fn tied_guides(scene: &Scene, placed: &PlacedModes) -> Result<Option<TiedMasses>, BuildError> {
    if !scene.ties(scene.solver.guide) || scene.hammers.is_empty() {
        return Ok(None);
    }
    let mass = scene.hammers.iter().map(|unit| unit.parameters.guide.mass_kg).collect();
    TiedMasses::new(&placed.excited().modes.phi, mass).map(Some).ok_or(BuildError::GuideMass)
}

/// Rows of the points of all parts: sums over the coordinates of rigid parts; of elastic parts a column per point that links join.
fn points(scene: &Scene, parts: (&[(PartId, Part)], &[CoupledPart]), placed: &PlacedModes) -> Points {
    let mut points = Points::default();
    let all = scene.points();
    for ((id, part), coupled) in parts.0.iter().zip(parts.1) {
        let columns = coupled.columns.clone();
        if let Part::Elastic = part {
            let driven = placed.of(*id).into_iter().flat_map(|modes| modes.rows(false)).map(|(point, _)| point);
            points.0.extend(driven.zip(columns).map(|(point, column)| (point, vec![(column, 1.0)])));
            continue;
        }
        for point in all.values().filter(|point| point.part == *id) {
            let row = part.row(&point.location, point.direction).into_iter();
            let row = row.map(|(freedom, coefficient)| (columns.start + freedom, coefficient));
            points.0.insert(point.id, row.collect());
        }
    }
    points
}

/// Checks that hammers strike castings of the scene.
fn check_strikes(scene: &Scene) -> Result<(), BuildError> {
    if let Some(unit) = scene.hammers.iter().find(|unit| unit.casting >= scene.castings.len()) {
        let (hammer, casting, castings) = (unit.name.clone(), unit.casting, scene.castings.len());
        return Err(BuildError::NoSuchCasting { hammer, casting, castings });
    }
    Ok(())
}

/// Checks that the modes of an elastic part have its points.
fn check(scene: &Scene, placed: &PlacedModes, part: PartId) -> Result<(), BuildError> {
    let modes: &InterfaceModes = match (placed.of(part), part) {
        (Some(modes), _) => modes,
        (None, PartId::Casting(casting)) => return Err(BuildError::Modes { casting }),
        (None, PartId::Machine | PartId::Hammer(_)) => return Ok(()),
    };
    let points = scene.points().into_values().filter(|point| point.part == part);
    let expected: BTreeSet<PointId> = points.map(|point| point.id).collect();
    if let Some(&point) = expected.symmetric_difference(&modes.shapes.keys().copied().collect()).next() {
        return Err(BuildError::Point { point });
    }
    let expected = modes.omega_rad_s.len();
    let shares = modes.shapes.values().map(|row| ("shares in a mode shape", row.len()));
    let mut counts = std::iter::once(("damping ratios", modes.damping_ratio.len())).chain(shares);
    counts
        .find(|(_, given)| *given != expected)
        .map_or(Ok(()), |(what, given)| Err(BuildError::Shapes { what, given, expected }))
}

/// Components of the state that each contact's penetration and rate depend on.
fn supports(elements: &Elements, layout: &Layout, parts: &[CoupledPart]) -> Vec<Vec<usize>> {
    let support = |contact: usize| {
        let mut components = Vec::new();
        let mut flexible = BTreeSet::new();
        for (column, _) in elements.row(elements.contact_row(contact)) {
            if column < layout.bodies {
                components.extend([layout.position(column), layout.velocity(column)]);
            } else {
                flexible.extend(parts.iter().position(|part| part.columns.contains(&column)));
            }
        }
        components.extend(flexible.into_iter().flat_map(|part: usize| parts[part].states.clone()).flatten());
        components
    };
    (0..elements.contacts().len()).map(support).collect()
}

/// Penetration and rate of each contact of bodies alone as sums of components.
fn sums(elements: &Elements, layout: &Layout) -> Vec<Option<WeightedPair>> {
    let sums = |contact: usize| {
        let row = || elements.row(elements.contact_row(contact));
        let bodies = row().all(|(column, _)| column < layout.bodies);
        bodies.then(|| {
            [
                row().map(|(column, c)| (layout.position(column), c)).collect(),
                row().map(|(column, c)| (layout.velocity(column), c)).collect(),
            ]
        })
    };
    (0..elements.contacts().len()).map(sums).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hammer::body;
    use crate::scene::FixtureId;
    use crate::scene::{Environment, Guide, HammerUnit, Mount, OutputSettings, SolverSettings};
    use crate::workpiece::{Casting, Fixture};

    const MOUNT: PointId = PointId::Mount { hammer: 0 };

    fn support(fixture: usize) -> PointId {
        PointId::Support(FixtureId { casting: 0, fixture, axis: 0 })
    }

    /// One hammer that strikes a casting on four fixtures off its centre; three modes, the last of which moves nothing.
    fn scene() -> (Scene, InterfaceModes) {
        let fixture = |at_m| Fixture { name: "f".into(), point: "T".into(), at_m, ..Fixture::default() };
        let casting = Casting {
            name: "part".into(),
            mass_kg: 2.0,
            inertia_kg_m2: Some([0.01, 0.02]),
            measuring_point_m: Some([0.05, -0.02]),
            fixtures: [[-0.1, -0.1], [0.1, -0.1], [-0.1, 0.1], [0.1, 0.1]].map(fixture).to_vec(),
            ..Casting::default()
        };
        let unit = HammerUnit {
            name: "left".into(),
            supply_pressure_pa: 6e5,
            mount: Mount { points: vec![("R".into(), 1.0)] },
            strike_point_m: [0.03, 0.07],
            ..HammerUnit::default()
        };
        let solver = SolverSettings {
            guide: Guide::Spring,
            modes: ModeTreatment::Integrated,
            max_steps: 10,
            max_wall_time_s: 1.0,
            ..SolverSettings::default()
        };
        let scene = Scene {
            machine: None,
            environment: Environment::default(),
            hammers: vec![unit],
            castings: vec![casting],
            duration_s: 0.1,
            solver,
            outputs: OutputSettings::default(),
        };
        let modes = InterfaceModes {
            omega_rad_s: vec![100.0, 200.0, 300.0],
            damping_ratio: vec![0.02; 3],
            shapes: (0..4)
                .map(|at| (support(at), vec![0.3, -0.1, 1e-13]))
                .chain([(MOUNT, vec![0.1, 0.2, 0.0])])
                .collect(),
        };
        (scene, modes)
    }

    /// A casting's point moves by `z + y tx - x ty`: at the strike point, the fixtures and the measuring point.
    #[test]
    fn points_of_a_casting_that_rotates() {
        let (scene, modes) = scene();
        let model = build(&scene, &modes).unwrap();
        assert_eq!(model.layout().bodies, body::COUNT + 3);
        let heave = model.points().row(PointId::Centre { casting: 0 })[0].0;
        let strike: Vec<_> = model.elements().row(model.elements().contact_row(model.hammers()[0].strike)).collect();
        let chisel = model.hammers()[0].points[body::CHISEL];
        assert_eq!(strike, [(chisel, 1.0), (heave, -1.0), (heave + 1, -0.07), (heave + 2, 0.03)]);
        let points = scene.points_of_casting(0);
        let names: Vec<&str> = points.iter().map(|(_, name)| name.as_str()).collect();
        assert_eq!(names, ["hammer.left", "fixture.f", "fixture.f", "fixture.f", "fixture.f", "measuring_point"]);
        let row = |id: PointId| model.points().row(id);
        assert_eq!(row(points[0].0), [(heave, 1.0), (heave + 1, 0.07), (heave + 2, -0.03)]);
        assert_eq!(row(points[5].0), [(heave, 1.0), (heave + 1, -0.02), (heave + 2, -0.05)]);
        assert_eq!(row(PointId::Rotation { casting: 0, axis: 1 }), [(heave + 2, 1.0)]);
        // Row 0 is the guide's spring; the first fixture follows.
        let fixture: Vec<_> = model.elements().row(1).collect();
        let node = model.layout().bodies + 1;
        assert_eq!(fixture, [(heave, 1.0), (heave + 1, -0.1), (heave + 2, 0.1), (node, -1.0)]);
        assert_eq!(model.masses().skip(heave).copied().collect::<Vec<f64>>(), [2.0, 0.01, 0.02]);
        // Points are found by their ids.
        assert_eq!(row(support(0)), [(node, 1.0)]);
        assert_eq!(row(MOUNT), [(model.hammers()[0].mount, 1.0)]);
    }

    /// Scenes at one placement share the constants of its modes. Their models equal the models of scenes that share nothing.
    #[test]
    fn constants_of_modes_are_shared() {
        let (scene, modes) = scene();
        let condensed = |standoff_m: f64| {
            let mut scene = scene.clone();
            scene.solver.modes = ModeTreatment::Condensed;
            scene.hammers[0].standoff_m = standoff_m;
            scene
        };
        let placed = PlacedModes::from(modes.clone());
        let [first, second] = [0.06, 0.08].map(|standoff_m| build_placed(&condensed(standoff_m), &placed).unwrap());
        let [one, other] = [&first, &second].map(|model| &model.parts[0].block.condensed().unwrap().constants);
        assert!(Arc::ptr_eq(&one.condensation, &other.condensation) && Arc::ptr_eq(&one.modes, &other.modes));
        let alone = build(&condensed(0.08), &modes).unwrap();
        let own = &alone.parts[0].block.condensed().unwrap().constants;
        assert!(!Arc::ptr_eq(&other.condensation, &own.condensation));
        assert_eq!(format!("{second:?}"), format!("{alone:?}"));
        // A scene that integrates them takes no condensation.
        assert!(build_placed(&scene, &placed).unwrap().parts[0].block.condensed().is_none());
    }

    /// A point's motion as a sum of states is its motion, be it of a rigid part or of one with modes; condensed modes are not states.
    #[test]
    fn motion_of_points_as_sums_of_states() {
        let (mut scene, modes) = scene();
        let model = build(&scene, &modes).unwrap();
        let y: Vec<f64> = (0..model.layout().dimension()).map(|at| (0.7 * at as f64).sin()).collect();
        let coupled = crate::system::Coupled::new(&model);
        for point in [MOUNT, support(2), PointId::Strike { hammer: 0 }, PointId::Rotation { casting: 0, axis: 0 }] {
            let (displacement, velocity) = coupled.motion(point, 0.0, &y);
            let sums = model.point_sums(point).unwrap();
            let [x, v] = sums.map(|sum| sum.iter().map(|(component, c)| c * y[*component]).sum::<f64>());
            assert!((x - displacement).abs() < 1e-14 && (v - velocity).abs() < 1e-14 && x != 0.0, "{point:?}");
        }
        scene.solver.modes = ModeTreatment::Condensed;
        assert!(build(&scene, &modes).unwrap().point_sums(MOUNT).is_none());
    }

    /// Modes that move no point of the scene are left out.
    #[test]
    fn modes_that_are_not_excited() {
        let (scene, modes) = scene();
        let model = build(&scene, &modes).unwrap();
        assert_eq!(model.modes(), 2);
        assert_eq!(model.parts[0].block.modes().unwrap().omega_squared.as_slice(), [1e4, 4e4]);
        assert!(model.scales.iter().all(|scale| scale.is_finite() && *scale > 0.0));
    }

    /// Watched points cost no state and do not decide whether modes are condensed. Modes that move only watched points are left out;
    /// the others run as without them.
    #[test]
    fn watched_points_cost_nothing() {
        let (scene, modes) = scene();
        let plain = build(&scene, &modes).unwrap();
        for count in [1, 4, 8] {
            let (mut scene, mut modes) = (scene.clone(), modes.clone());
            scene.outputs.points = (0..count).map(|point| format!("P{point}")).collect();
            modes.shapes.extend((0..count).map(|point| (PointId::Watched { point }, vec![0.1, 0.2, 30.0])));
            let model = build(&scene, &modes).unwrap();
            assert_eq!((model.layout(), model.modes()), (plain.layout(), plain.modes()));
            assert_eq!(model.elements().matrix(), plain.elements().matrix());
        }
    }

    /// Scenes and modes that do not fit are errors that name the misfit.
    #[test]
    fn scenes_that_cannot_be_built() {
        let (scene, modes) = scene();
        let fails = |change: &dyn Fn(&mut Scene, &mut InterfaceModes)| {
            let (mut scene, mut modes) = (scene.clone(), modes.clone());
            change(&mut scene, &mut modes);
            build(&scene, &modes).map(|_| ()).unwrap_err().to_string()
        };
        assert!(fails(&|scene, _| scene.hammers[0].casting = 3).contains("casting number 3, but the scene has 1"));
        assert!(fails(&|_, modes| _ = modes.shapes.remove(&MOUNT)).contains("Mount { hammer: 0 }"));
        assert!(fails(&|_, modes| _ = modes.shapes.insert(support(4), vec![0.0; 3])).contains("Support(FixtureId {"));
        assert!(fails(&|_, modes| modes.damping_ratio.push(0.0)).contains("4 damping ratios"));
        assert!(fails(&|_, modes| _ = modes.shapes.insert(MOUNT, vec![0.0])).contains("1 shares in a mode shape"));
        assert!(fails(&|scene, _| scene.castings[0].inertia_kg_m2 = None).contains("inertia"));
    }
}
