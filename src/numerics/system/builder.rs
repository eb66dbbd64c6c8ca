//! From a scene and the structure's modes at its interface points to a coupled model. The only part that knows scenes.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::DMatrix;

use crate::contact::{ContactLaw, ContactParameters};
use crate::hammer::{Gas, HammerModel, body};
use crate::scene::{Environment, HammerUnit, ModeTreatment, Scene};
use crate::system::elements::{Contact, ContactKind, Elements, ElementsBuilder, Spring};
use crate::system::impulse_response::{self, Condensation, SCALED_INTEGRALS};
use crate::system::layout::Layout;
use crate::system::modal::TiedGuides;
use crate::system::model::{CastingPoint, CastingSlot, CoupledModel, HammerSlot, MEASURING_POINT, Sums};
use crate::system::placed::{Condensed, InterfaceModes, PlacedModes};
use crate::workpiece::WorkpieceError;

/// Error scale of a body's position in m. At tolerance 1 it would be 29.5 kN in the contact of chisel and casting, 0.4 of the
/// peak of a first impact; at the default tolerance a step may miss 0.3 N of it.
const POSITION_SCALE_M: f64 = 1e-4;
/// Error scale of a body's velocity in m/s.
const VELOCITY_SCALE_M_S: f64 = 1.0;
/// Error scale of a piston's velocity in m/s: between blows it moves freely and steps are long, and its error reaches every
/// blow. Ten times finer than for other bodies costs one step in a hundred and errs five times less in the first impact.
const PISTON_VELOCITY_SCALE_M_S: f64 = 0.1;
/// Error scale of a chamber's pressure in Pa.
const PRESSURE_SCALE_PA: f64 = 1e5;
/// Lever in m that turns a rotation into the displacement whose scale applies.
const ROTATION_LEVER_M: f64 = 0.1;
/// Why a scene cannot be built.
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
        /// Index asked for.
        casting: usize,
        /// Castings in the scene.
        castings: usize,
    },
    /// The structure's modes do not fit the scene.
    #[error("mode shapes for {given} {what} were given, the scene has {expected}")]
    Shapes {
        /// Mounts, fixtures, points or modes.
        what: &'static str,
        /// Number given.
        given: usize,
        /// Number expected.
        expected: usize,
    },
    /// The masses of the tied guides make no positive definite matrix.
    #[error("guide masses must be positive to be tied to their mounts")]
    GuideMass,
}

/// Sparse row over the points.
type Row = Vec<(usize, f64)>;

/// Numbers of bodies and points of a scene.
struct Numbering {
    tied: bool,
    bodies: usize,
    /// First body of each hammer, then of each casting.
    first_hammer_body: Vec<usize>,
    first_casting_body: Vec<usize>,
    /// Active rotations of each casting.
    rotations: Vec<[bool; 2]>,
}

impl Numbering {
    fn new(scene: &Scene) -> Result<Self, BuildError> {
        let tied = scene.ties(scene.solver.guide);
        let per_hammer = if tied { body::COUNT - 1 } else { body::COUNT };
        let first_hammer_body = (0..scene.hammers.len()).map(|h| h * per_hammer).collect();
        let mut bodies = per_hammer * scene.hammers.len();
        let (mut first_casting_body, mut rotations) = (Vec::new(), Vec::new());
        for (index, casting) in scene.castings.iter().enumerate() {
            let active = casting.active_rotations(&scene.strike_points(index));
            casting.check_restraint(active)?;
            first_casting_body.push(bodies);
            rotations.push(active);
            bodies += 1 + active.iter().filter(|active| **active).count();
        }
        Ok(Self { tied, bodies, first_hammer_body, first_casting_body, rotations })
    }

    /// Points of a hammer's bodies; `mount` is the interface point that carries it.
    fn hammer_points(&self, hammer: usize, mount: usize) -> [usize; body::COUNT] {
        let first = self.first_hammer_body[hammer];
        if self.tied {
            [self.bodies + mount, first, first + 1, first + 2, first + 3]
        } else {
            [first, first + 1, first + 2, first + 3, first + 4]
        }
    }

    /// The bodies of a casting: its heave and the rotations that the scene needs.
    fn casting_bodies(&self, casting: usize) -> Range<usize> {
        let heave = self.first_casting_body[casting];
        heave..heave + 1 + self.rotations[casting].iter().filter(|active| **active).count()
    }

    /// The row of the casting's motion at a point: `z + y tx - x ty`.
    fn casting_point(&self, casting: usize, at_m: [f64; 2], sign: f64) -> Row {
        let heave = self.first_casting_body[casting];
        let mut row = vec![(heave, sign)];
        let levers = [at_m[1], -at_m[0]];
        let active = (0..2).filter(|&axis| self.rotations[casting][axis]);
        row.extend(active.enumerate().map(|(k, axis)| (heave + 1 + k, sign * levers[axis])));
        row
    }
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
    check_shapes(scene, placed)?;
    let numbering = Numbering::new(scene)?;
    let modes = placed.excited();
    let condensed = condensed(scene, placed);
    let condensation = condensed.as_ref().map(|condensed| &condensed.condensation);
    let count = modes.omega_squared.len();
    let layout = Layout {
        modes: count,
        structure: condensation.map_or([count; 2], |condensed| [condensed.states(), 0]),
        bodies: numbering.bodies,
        hammers: scene.hammers.len(),
        castings: scene.castings.len(),
    };
    let mut elements = ElementsBuilder::default();
    let mut hammers = Vec::with_capacity(scene.hammers.len());
    for h in 0..scene.hammers.len() {
        hammers.push(add_hammer(&mut elements, &numbering, scene, h));
    }
    add_fixtures(&mut elements, &numbering, scene);
    let elements = elements.assemble(numbering.bodies + modes.phi.ncols());
    let mut model = CoupledModel {
        layout,
        scales: scales(&layout, &numbering, &modes.phi, condensation.map(AsRef::as_ref)),
        supports: supports(&elements, &layout),
        sums: sums(&elements, &layout),
        elements,
        castings: castings(scene, &numbering, &layout),
        body_mass: body_masses(scene, &numbering, &hammers),
        hammers,
        tied: tied_guides(scene, &modes.phi)?,
        modes: Arc::clone(modes),
        condensation: condensation.cloned(),
        damping: condensed.map(|condensed| condensed.damping),
        ambient_pressure_pa: scene.environment.ambient_pressure_pa,
        gas_constant_j_per_kg_k: scene.environment.gas_constant_j_per_kg_k,
        initial: Vec::new(),
    };
    model.initial = rest(&model);
    Ok(Arc::new(model))
}

/// The modes condensed, if the scene asks for it or it costs less.
fn condensed(scene: &Scene, placed: &PlacedModes) -> Option<Condensed> {
    let condense = match scene.solver.modes {
        ModeTreatment::Automatic => impulse_response::pays(placed.excited()),
        ModeTreatment::Integrated => false,
        ModeTreatment::Condensed => true,
    };
    if condense { placed.condensed(scene.duration_s) } else { None }
}

fn check_shapes(scene: &Scene, modes: &InterfaceModes) -> Result<(), BuildError> {
    let expect = |what, given, expected| {
        if given == expected { Ok(()) } else { Err(BuildError::Shapes { what, given, expected }) }
    };
    let count = modes.omega_rad_s.len();
    expect("damping ratios", modes.damping_ratio.len(), count)?;
    expect("mounts", modes.mounts.len(), scene.hammers.len())?;
    expect("castings", modes.fixtures.len(), scene.castings.len())?;
    for (rows, casting) in modes.fixtures.iter().zip(&scene.castings) {
        expect("fixtures", rows.len(), casting.fixtures.len())?;
    }
    expect("points", modes.points.len(), scene.outputs.points.len())?;
    for row in modes.rows() {
        expect("modes", row.len(), count)?;
    }
    for unit in &scene.hammers {
        if unit.casting >= scene.castings.len() {
            return Err(BuildError::NoSuchCasting {
                hammer: unit.name.clone(),
                casting: unit.casting,
                castings: scene.castings.len(),
            });
        }
    }
    Ok(())
}

/// Adds the springs and contacts of one hammer.
fn add_hammer(elements: &mut ElementsBuilder, numbering: &Numbering, scene: &Scene, h: usize) -> HammerSlot {
    let unit = &scene.hammers[h];
    let model = HammerModel::new(&unit.parameters, gas(&scene.environment), scene.environment.gravity_m_s2);
    let points = numbering.hammer_points(h, h);
    if !numbering.tied {
        elements.spring(
            vec![(points[body::GUIDE], 1.0), (numbering.bodies + h, -1.0)],
            Spring {
                stiffness_n_per_m: unit.parameters.guide.stiffness_n_per_m,
                damping_n_s_per_m: 0.0,
                casting: None,
            },
        );
    }
    let mut percussion = 0;
    for (kind, [plus, minus], parameters, offset_m) in internal_contacts(unit) {
        let row = vec![(points[plus], 1.0), (points[minus], -1.0)];
        let law = internal_law(&parameters, model.mass(), [plus, minus]);
        let index = elements.contact(row, Contact { hammer: h, kind, law, offset_m });
        if kind == ContactKind::PistonChisel {
            percussion = index;
        }
    }
    // The tip of the resting chisel stands `standoff` off the casting.
    let gap = model.rest().position[body::CHISEL] + unit.standoff_m;
    let mut row = numbering.casting_point(unit.casting, unit.strike_point_m, -1.0);
    row.push((points[body::CHISEL], 1.0));
    let law = strike_law(scene, unit);
    let kind = ContactKind::ChiselCasting;
    let strike = elements.contact(row, Contact { hammer: h, kind, law, offset_m: gap });
    HammerSlot {
        name: unit.name.clone(),
        model,
        points,
        mount: h,
        strike,
        percussion,
        casting: unit.casting,
        supply_pressure_pa: unit.supply_pressure_pa,
        supply_times_s: std::iter::once(unit.start_time_s).chain(unit.supply_switch_times_s.iter().copied()).collect(),
        gate_delay_s: unit.gate_delay_s,
    }
}

/// Contacts within a hammer: kind, the bodies with coefficients +1 and -1, parameters, offset.
fn internal_contacts(unit: &HammerUnit) -> [(ContactKind, [usize; 2], ContactParameters, f64); 8] {
    use ContactKind::{EndStop, Nose, PistonChisel, RearWall, Retainer, SpoolFront, SpoolRear, TopStop};
    use body::{CHISEL, CYLINDER, GUIDE, PISTON, SPOOL};
    let p = &unit.parameters;
    let (nose, stop) = (p.chisel.cylinder_contact, p.valve.stop);
    [
        (TopStop, [GUIDE, CYLINDER], p.telescope.top_stop, 0.0),
        (EndStop, [CYLINDER, GUIDE], p.telescope.end_stop, p.telescope.stroke_m),
        (RearWall, [CYLINDER, PISTON], p.piston.rear_wall, 0.0),
        (PistonChisel, [PISTON, CHISEL], p.piston.chisel_contact, p.piston.stroke_m),
        (Nose, [CYLINDER, CHISEL], nose, 0.0),
        (Retainer, [CHISEL, CYLINDER], nose, p.chisel.travel_m),
        (SpoolRear, [CYLINDER, SPOOL], stop, 0.0),
        (SpoolFront, [SPOOL, CYLINDER], stop, p.valve.travel_m),
    ]
}

/// Law of a contact between two bodies of a hammer. The guide stands on its mount: only the other body's mass counts.
fn internal_law(parameters: &ContactParameters, mass: &[f64; body::COUNT], bodies: [usize; 2]) -> ContactLaw {
    let inverse = bodies.iter().filter(|body| **body != body::GUIDE).map(|body| 1.0 / mass[*body]).sum::<f64>();
    parameters.law(1.0 / inverse)
}

/// Law of a hammer's contact with its casting.
fn strike_law(scene: &Scene, unit: &HammerUnit) -> ContactLaw {
    unit.parameters.chisel.casting_contact.law(scene.strike_mass_kg(unit))
}

/// Adds the springs between castings and structure. Interface points of fixtures follow those of the mounts.
fn add_fixtures(elements: &mut ElementsBuilder, numbering: &Numbering, scene: &Scene) {
    let mut point = numbering.bodies + scene.hammers.len();
    for (c, casting) in scene.castings.iter().enumerate() {
        for fixture in &casting.fixtures {
            let mut row = numbering.casting_point(c, fixture.at_m, 1.0);
            row.push((point, -1.0));
            elements.spring(
                row,
                Spring {
                    stiffness_n_per_m: fixture.stiffness_n_per_m,
                    damping_n_s_per_m: fixture.damping_n_s_per_m,
                    casting: Some(c),
                },
            );
            point += 1;
        }
    }
}

fn tied_guides(scene: &Scene, phi: &DMatrix<f64>) -> Result<Option<TiedGuides>, BuildError> {
    if !scene.ties(scene.solver.guide) || scene.hammers.is_empty() {
        return Ok(None);
    }
    // Their mounts are the first interface points.
    let mass = scene.hammers.iter().map(|unit| unit.parameters.guide.mass_kg).collect();
    TiedGuides::new(phi, mass).map(Some).ok_or(BuildError::GuideMass)
}

fn castings(scene: &Scene, numbering: &Numbering, layout: &Layout) -> Vec<CastingSlot> {
    let slot = |c: usize| CastingSlot {
        heave: numbering.first_casting_body[c],
        velocities: numbering.casting_bodies(c).map(|body| layout.velocity(body)).collect(),
        points: casting_points(scene, numbering, c),
    };
    (0..scene.castings.len()).map(slot).collect()
}

/// The points of a casting whose velocity is watched.
fn casting_points(scene: &Scene, numbering: &Numbering, c: usize) -> Vec<CastingPoint> {
    let casting = &scene.castings[c];
    let strikes = scene.hammers.iter().filter(|unit| unit.casting == c);
    let strikes = strikes.map(|unit| (format!("hammer.{}", unit.name), unit.strike_point_m));
    let fixtures = casting.fixtures.iter().map(|fixture| (format!("fixture.{}", fixture.name), fixture.at_m));
    let named: Vec<(String, [f64; 2])> = strikes.chain(fixtures).collect();
    let rotates = numbering.rotations[c].contains(&true);
    let watched = if rotates { named.len() } else { 1 };
    let measured = casting.measuring_point_m.map(|at_m| (MEASURING_POINT.to_owned(), at_m));
    let point = |(name, at_m)| CastingPoint { name, row: numbering.casting_point(c, at_m, 1.0) };
    named.into_iter().take(watched).chain(measured).map(point).collect()
}

/// Mass or inertia of each body, in the order of the numbering.
fn body_masses(scene: &Scene, numbering: &Numbering, hammers: &[HammerSlot]) -> Vec<f64> {
    let mut masses = Vec::with_capacity(numbering.bodies);
    for slot in hammers {
        let first = usize::from(numbering.tied);
        masses.extend_from_slice(&slot.model.mass()[first..]);
    }
    for (casting, active) in scene.castings.iter().zip(&numbering.rotations) {
        masses.push(casting.mass_kg);
        // `check_restraint` has made sure that a casting that rotates has its inertia.
        let inertia = casting.inertia_kg_m2.unwrap_or([0.0; 2]);
        masses.extend((0..2).filter(|&axis| active[axis]).map(|axis| inertia[axis]));
    }
    masses
}

/// Error scales of the states.
fn scales(layout: &Layout, numbering: &Numbering, phi: &DMatrix<f64>, condensation: Option<&Condensation>) -> Vec<f64> {
    let mut bodies = vec![1.0; layout.bodies];
    for casting in 0..layout.castings {
        bodies[numbering.casting_bodies(casting)][1..].fill(1.0 / ROTATION_LEVER_M);
    }
    // What the structure's states matter by is what they move the interface points.
    // One scale for all modes: those that hardly move a point are held to the energy of those that do. An explicit method
    // may be unstable for them, and what no output shows would still be energy from nowhere.
    let unit: Vec<f64> = match condensation {
        None => vec![1.0 / phi.amax(); phi.nrows()],
        Some(condensation) => (0..phi.ncols()).map(|point| condensation.force_scale(point)).collect(),
    };
    let scaled = |unit: &[f64], scale: f64| unit.iter().map(|u| u * scale).collect::<Vec<_>>();
    let mut scales = Vec::with_capacity(layout.states());
    if condensation.is_some() {
        let integrals: [f64; SCALED_INTEGRALS] = [VELOCITY_SCALE_M_S, POSITION_SCALE_M];
        integrals.iter().for_each(|scale| scales.extend(scaled(&unit, *scale)));
        scales.resize(layout.structure[0], f64::INFINITY);
        scales.extend(scaled(&bodies, POSITION_SCALE_M));
    } else {
        scales.extend(scaled(&unit, POSITION_SCALE_M));
        scales.extend(scaled(&bodies, POSITION_SCALE_M));
        scales.extend(scaled(&unit, VELOCITY_SCALE_M_S));
    }
    let mut velocities = scaled(&bodies, VELOCITY_SCALE_M_S);
    for hammer in 0..layout.hammers {
        velocities[numbering.hammer_points(hammer, hammer)[body::PISTON]] = PISTON_VELOCITY_SCALE_M_S;
    }
    scales.extend(velocities);
    scales.resize(layout.states(), PRESSURE_SCALE_PA);
    scales
}

/// Components of the state that each contact's penetration and rate depend on.
fn supports(elements: &Elements, layout: &Layout) -> Vec<Vec<usize>> {
    let support = |contact: usize| {
        let mut components = Vec::new();
        for (point, _) in elements.row(elements.contact_row(contact)) {
            if point < layout.bodies {
                components.extend([layout.position(point), layout.velocity(point)]);
            } else {
                components.extend(layout.structure_displacements());
                components.extend(layout.structure_velocities());
            }
        }
        components
    };
    (0..elements.contacts().len()).map(support).collect()
}

/// Penetration and rate of each contact of bodies alone as sums of components.
fn sums(elements: &Elements, layout: &Layout) -> Vec<Option<Sums>> {
    let sums = |contact: usize| {
        let row = || elements.row(elements.contact_row(contact));
        let bodies = row().all(|(point, _)| point < layout.bodies);
        bodies.then(|| {
            [
                row().map(|(point, c)| (layout.position(point), c)).collect(),
                row().map(|(point, c)| (layout.velocity(point), c)).collect(),
            ]
        })
    };
    (0..elements.contacts().len()).map(sums).collect()
}

/// State of rest.
fn rest(model: &CoupledModel) -> Vec<f64> {
    let layout = &model.layout;
    let mut y = vec![0.0; layout.dimension()];
    for (h, slot) in model.hammers.iter().enumerate() {
        let rest = slot.model.rest();
        for (&point, position) in slot.points.iter().zip(rest.position) {
            if point < layout.bodies {
                y[layout.position(point)] = position;
            }
        }
        y[layout.pressures(h)].copy_from_slice(&rest.pressure);
    }
    y
}

fn gas(environment: &Environment) -> Gas {
    Gas {
        specific_energy_j_per_kg: environment.gas_constant_j_per_kg_k * environment.temperature_k,
        isentropic_exponent: environment.isentropic_exponent,
        inflow_exponent: environment.inflow_exponent,
        outflow_exponent: environment.outflow_exponent,
        expansion_exponent: environment.expansion_exponent,
        ambient_pressure_pa: environment.ambient_pressure_pa,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Guide, ModeTreatment, Mount, OutputSettings, SolverSettings};
    use crate::workpiece::{Casting, Fixture};

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
            mounts: vec![vec![0.1, 0.2, 0.0]],
            fixtures: vec![vec![vec![0.3, -0.1, 1e-13]; 4]],
            points: Vec::new(),
        };
        (scene, modes)
    }

    /// A casting's point moves by `z + y tx - x ty`: at the strike point, the fixtures and the measuring point.
    #[test]
    fn points_of_a_casting_that_rotates() {
        let (scene, modes) = scene();
        let model = build(&scene, &modes).unwrap();
        assert_eq!(model.layout().bodies, body::COUNT + 3);
        let heave = model.castings()[0].heave;
        let strike: Vec<_> = model.elements().row(model.elements().contact_row(model.hammers()[0].strike)).collect();
        let chisel = model.hammers()[0].points[body::CHISEL];
        assert_eq!(strike, [(chisel, 1.0), (heave, -1.0), (heave + 1, -0.07), (heave + 2, 0.03)]);
        let points = &model.castings()[0].points;
        let names: Vec<&str> = points.iter().map(|point| point.name.as_str()).collect();
        assert_eq!(names, ["hammer.left", "fixture.f", "fixture.f", "fixture.f", "fixture.f", "measuring_point"]);
        assert_eq!(points[0].row, [(heave, 1.0), (heave + 1, 0.07), (heave + 2, -0.03)]);
        assert_eq!(points[5].row, [(heave, 1.0), (heave + 1, -0.02), (heave + 2, -0.05)]);
        // Row 0 is the guide's spring; the first fixture follows.
        let fixture: Vec<_> = model.elements().row(1).collect();
        let node = model.layout().bodies + 1;
        assert_eq!(fixture, [(heave, 1.0), (heave + 1, -0.1), (heave + 2, 0.1), (node, -1.0)]);
        assert_eq!(model.body_mass[heave..], [2.0, 0.01, 0.02]);
    }

    /// Scenes at one place share what follows from its modes alone, and their models are those of scenes that share nothing.
    #[test]
    fn what_follows_from_the_modes_is_found_once() {
        let (scene, modes) = scene();
        let condensed = |standoff_m: f64| {
            let mut scene = scene.clone();
            scene.solver.modes = ModeTreatment::Condensed;
            scene.hammers[0].standoff_m = standoff_m;
            scene
        };
        let placed = PlacedModes::from(modes.clone());
        let [first, second] = [0.06, 0.08].map(|standoff_m| build_placed(&condensed(standoff_m), &placed).unwrap());
        let [one, other] = [&first, &second].map(|model| model.condensation.as_ref().unwrap());
        assert!(Arc::ptr_eq(one, other) && Arc::ptr_eq(&first.modes, &second.modes));
        let alone = build(&condensed(0.08), &modes).unwrap();
        assert!(!Arc::ptr_eq(other, alone.condensation.as_ref().unwrap()));
        assert_eq!(format!("{second:?}"), format!("{alone:?}"));
        // A scene that integrates them takes no condensation.
        assert!(build_placed(&scene, &placed).unwrap().condensation.is_none());
    }

    /// Modes that move no point of the scene are left out.
    #[test]
    fn modes_that_are_not_excited() {
        let (scene, modes) = scene();
        let model = build(&scene, &modes).unwrap();
        assert_eq!(model.layout().modes, 2);
        assert_eq!(model.modes.omega_squared.as_slice(), [1e4, 4e4]);
        assert!(model.scales.iter().all(|scale| scale.is_finite() && *scale > 0.0));
    }

    /// What does not fit is an error that says what.
    #[test]
    fn scenes_that_cannot_be_built() {
        let (scene, modes) = scene();
        let fails = |change: &dyn Fn(&mut Scene, &mut InterfaceModes)| {
            let (mut scene, mut modes) = (scene.clone(), modes.clone());
            change(&mut scene, &mut modes);
            build(&scene, &modes).map(|_| ()).unwrap_err().to_string()
        };
        assert!(fails(&|scene, _| scene.hammers[0].casting = 3).contains("casting number 3, but the scene has 1"));
        assert!(fails(&|_, modes| modes.mounts.clear()).contains("0 mounts"));
        assert!(fails(&|_, modes| modes.fixtures[0].truncate(2)).contains("2 fixtures"));
        assert!(fails(&|_, modes| modes.fixtures.clear()).contains("0 castings"));
        assert!(fails(&|_, modes| modes.damping_ratio.push(0.0)).contains("4 damping ratios"));
        assert!(fails(&|_, modes| modes.mounts[0].truncate(1)).contains("1 modes"));
        assert!(fails(&|scene, _| scene.castings[0].inertia_kg_m2 = None).contains("inertia"));
    }
}
