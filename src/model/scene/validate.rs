//! Checks of a scene's values: all quantities finite and in range, castings held, every hammer above its casting.

use crate::hammer::HammerParameters;
use std::f64::consts::TAU;

use crate::parameter::{Fault, Parameters, short};
use crate::workpiece::{Casting, Fixture, OFFSET_TOLERANCE_M, WorkpieceError};

use super::links::PartId;
use super::model::{HammerUnit, Scene, Supply};
use super::solver::{ModeTreatment, SolverSettings};

/// Simulated time in s for the check of stiff fixtures. In longer runs, the time itself takes the steps.
const LONGEST_JUDGED_S: f64 = 100.0;

/// Kind of a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SceneProblemKind {
    /// A value is outside its range.
    Value,
    /// A casting lacks its inertia or is not held by its fixtures.
    Restraint,
    /// A hammer would miss its casting.
    Miss,
}

/// One fault of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneProblem {
    /// The kind of fault.
    pub kind: SceneProblemKind,
    /// The offending quantity by its path in a study, e.g. `casting.part.mass_kg`.
    pub path: String,
    /// The fault and the expected value.
    pub message: String,
}

/// Collects problems under a path.
struct Checks {
    problems: Vec<SceneProblem>,
}

impl Checks {
    fn push(&mut self, kind: SceneProblemKind, path: String, message: String) {
        self.problems.push(SceneProblem { kind, path, message });
    }

    fn group(&mut self, prefix: &str, group: &impl Parameters) {
        let mut faults = Vec::new();
        group.check(prefix, &mut faults);
        let problem = |Fault { path, message }| SceneProblem { kind: SceneProblemKind::Value, path, message };
        self.problems.extend(faults.into_iter().map(problem));
    }

    /// A direction needs a length.
    fn axis(&mut self, axis: &[f64; 3], path: String) {
        self.rule(*axis != [0.0; 3], path, "needs a direction x, y, z other than 0, 0, 0");
    }

    fn rule(&mut self, holds: bool, path: String, message: &str) {
        if !holds {
            self.push(SceneProblemKind::Value, path, message.to_string());
        }
    }
}

impl Scene {
    /// All faults of the scene's values, in the order hammers, castings, settings; empty for a scene that can be built.
    ///
    /// Names of interface points are not checked here: only the structure knows them.
    pub fn validate(&self) -> Vec<SceneProblem> {
        let mut checks = Checks { problems: Vec::new() };
        checks.group("environment", &self.environment);
        checks.axis(&self.environment.gravity_axis, "environment.gravity_axis".to_string());
        for hammer in &self.hammers {
            self.check_hammer(&mut checks, hammer);
        }
        for (index, casting) in self.castings.iter().enumerate() {
            self.check_casting(&mut checks, index, casting);
        }
        self.check_settings(&mut checks);
        checks.problems
    }

    fn check_hammer(&self, checks: &mut Checks, hammer: &HammerUnit) {
        let prefix = format!("hammer.{}", hammer.name);
        checks.group(&prefix, &Supply::of(hammer, &self.environment));
        checks.group(&prefix, hammer);
        checks.axis(&hammer.strike_axis, format!("{prefix}.strike_axis"));
        let mut before = hammer.start_time_s;
        for (index, &time) in hammer.supply_switch_times_s.iter().enumerate() {
            // A NaN is reported above.
            if time <= before {
                let message = format!("is {time}, expected a time after the switch before, {before} s");
                checks.push(SceneProblemKind::Value, format!("{prefix}.supply_switch_times_s.{index}"), message);
            }
            before = time;
        }
        let sum: f64 = hammer.mount.points.iter().map(|(_, weight)| weight).sum();
        let mount = !hammer.mount.points.is_empty() && (sum - 1.0).abs() < 1e-9;
        checks.rule(mount, format!("{prefix}.mount"), "needs one or more points whose weights sum to 1");
        checks.group(&format!("{prefix}.parameters"), &hammer.parameters);
        check_chambers(checks, &format!("{prefix}.parameters"), &hammer.parameters);
        match self.castings.get(hammer.casting) {
            None => checks.rule(false, format!("{prefix}.casting"), "names no casting of the scene"),
            Some(casting) => check_strike(checks, &prefix, hammer, casting),
        }
    }

    fn check_casting(&self, checks: &mut Checks, index: usize, casting: &Casting) {
        let prefix = format!("casting.{}", casting.name);
        let before = checks.problems.len();
        checks.group(&prefix, casting);
        if let Some(axis) = &casting.measuring_axis {
            checks.axis(axis, format!("{prefix}.measuring_axis"));
        }
        let held = !casting.fixtures.is_empty();
        checks.rule(held, format!("{prefix}.fixture"), "a casting needs at least one fixture");
        for fixture in &casting.fixtures {
            let prefix = format!("{prefix}.fixture.{}", fixture.name);
            checks.group(&prefix, fixture);
            checks.axis(&fixture.axis, format!("{prefix}.axis"));
            if let Some(pad) = &fixture.pad {
                checks.group(&prefix, pad);
            }
            check_kind(checks, &prefix, (casting, fixture));
            if let Some(message) = self.too_stiff(casting, fixture) {
                let key = fixture.pad.map_or("stiffness_n_per_m", |_| "pad_area_m2");
                checks.push(SceneProblemKind::Value, format!("{prefix}.{key}"), message);
            }
        }
        // Check the restraint only of a casting with valid values that every hammer hits.
        let missed = self.hammers.iter().any(|hammer| hammer.casting == index && misses(hammer, casting));
        if checks.problems.len() == before
            && !missed
            && let Err(error) = self.part(PartId::Casting(index))
        {
            let key = match error {
                WorkpieceError::MissingInertia { about_z: true, .. } => "inertia_z_kg_m2",
                WorkpieceError::MissingInertia { .. } => "inertia_kg_m2",
                WorkpieceError::Unrestrained { .. } => "fixture",
            };
            checks.push(SceneProblemKind::Restraint, format!("{prefix}.{key}"), error.to_string());
        }
    }

    /// Message for a fixture on which its casting swings too fast for any budget of steps.
    ///
    /// The coupled system has no lower highest frequency than the casting on this fixture alone, on a machine at rest (Rayleigh):
    /// `f = sqrt(k / m) / (2 pi)`, and no explicit step is longer than a period.
    fn too_stiff(&self, casting: &Casting, fixture: &Fixture) -> Option<String> {
        let (stiffness, mass_kg) = (fixture.spring()[0], casting.mass_kg);
        let frequency_hz = (stiffness / mass_kg).sqrt() / TAU;
        let span_s = self.duration_s.min(LONGEST_JUDGED_S);
        let most_steps = self.solver.max_steps.max(SolverSettings::default().max_steps);
        let slow = self.solver.method.is_implicit() || frequency_hz * span_s <= most_steps as f64;
        if slow || !frequency_hz.is_finite() || span_s <= 0.0 {
            return None;
        }
        let stated = match fixture.pad {
            Some(pad) => format!("gives a stiffness of {stiffness:.2e} N/m with material \"{}\"", pad.material.name()),
            None => format!("is {stiffness:e}"),
        };
        Some(format!(
            "{stated}, which is too stiff: casting `{}` ({} kg) would swing on fixture `{}` at {frequency_hz:.1e} Hz, \
             and steps of at most {:.1e} s would never end; expected about {:.0e} for a stiff one",
            casting.name,
            short(mass_kg),
            fixture.name,
            1.0 / frequency_hz,
            Fixture::default().stiffness_n_per_m
        ))
    }

    fn check_settings(&self, checks: &mut Checks) {
        checks.group("", self);
        checks.group("solver", &self.solver);
        let whole = !self.solver.method.is_fixed() || self.solver.modes == ModeTreatment::Integrated;
        checks.rule(whole, "solver.modes".to_string(), "must be \"integrated\" for a method with a fixed step");
        checks.group("outputs", &self.outputs);
        checks.axis(&self.outputs.points_axis, "outputs.points_axis".to_string());
    }
}

/// Checks that a fixture is a spring, a pad or a clamp.
fn check_kind(checks: &mut Checks, prefix: &str, (casting, fixture): (&Casting, &Fixture)) {
    let (clamps, pads) = (fixture.clamp_force_n > 0.0, fixture.one_sided);
    let path = |key: &str| format!("{prefix}.{key}");
    let message = "needs a `clamp_force_n` above 0";
    checks.rule(clamps || fixture.clamp_stiffness_n_per_m == 0.0, path("clamp_stiffness_n_per_m"), message);
    checks.rule(
        !clamps || fixture.pad.is_none(),
        path("material"),
        "needs no `clamp_force_n`: a clamp presses without a pad",
    );
    let message = "needs a pad (`one_sided = true`), on which the casting slides";
    checks.rule(pads || fixture.friction == 0.0, path("friction"), message);
    checks.rule(!(clamps && pads), path("clamp_force_n"), "needs `one_sided = false`: a pad carries, a clamp presses");
    let message =
        "needs a fixture with `one_sided = true` onto which it presses: other fixtures hold the casting without it";
    checks.rule(!clamps || casting.lies(), path("clamp_force_n"), message);
}

/// Whether a hammer's axis passes outside the casting's extent, seen from above. The extent along z is not known.
fn misses(hammer: &HammerUnit, casting: &Casting) -> bool {
    let margin = casting.margin_m(hammer.strike_point_m, hammer.axis());
    margin.is_some_and(|margin| margin < -OFFSET_TOLERANCE_M)
}

fn check_strike(checks: &mut Checks, prefix: &str, hammer: &HammerUnit, casting: &Casting) {
    if let Some([width, depth]) = casting.size_m
        && misses(hammer, casting)
    {
        let ([x, y], axis) = (hammer.strike_point_m, hammer.axis());
        let strikes = if axis[..2] == [0.0; 2] {
            format!("it strikes at ({x:.4}, {y:.4}) m from the centre")
        } else {
            let [along_x, along_y, along_z] = axis;
            format!(
                "its axis passes ({x:.4}, {y:.4}) m from the centre, along ({along_x:.4}, {along_y:.4}, {along_z:.4})"
            )
        };
        let message = format!(
            "hammer `{}` would miss casting `{}`: {strikes}, the casting measures {width} m by {depth} m",
            hammer.name, casting.name
        );
        checks.push(SceneProblemKind::Miss, format!("{prefix}.{}", hammer.strike_key()), message);
    }
}

/// Rules between parameters of one hammer.
///
/// A NaN breaks its range; here only an order of two sound numbers counts.
fn check_chambers(checks: &mut Checks, prefix: &str, parameters: &HammerParameters) {
    let (telescope, piston) = (&parameters.telescope, &parameters.piston);
    let empty = telescope.annulus_length_m <= telescope.stroke_m;
    let message = "must exceed the telescope's stroke_m: the annulus chamber would vanish at the end of the stroke";
    checks.rule(!empty, format!("{prefix}.telescope.annulus_length_m"), message);
    // V40 = front_clearance A3, so the front chamber keeps a volume while p < L_p + (A3 / A4) front_clearance.
    let reach = piston.chamber_length_m + piston.front_clearance_m / piston.front_area_ratio;
    let empty = reach <= piston.stroke_m + parameters.chisel.travel_m;
    let message = "must leave the front chamber a volume at the resting position, stroke_m + chisel.travel_m";
    checks.rule(!empty, format!("{prefix}.piston.chamber_length_m"), message);
}
