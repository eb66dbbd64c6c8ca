//! Checks of a scene's values: every quantity finite and in its physical range, castings held, no hammer beside its casting.

use crate::contact::ContactParameters;
use crate::hammer::{ChiselParameters, HammerParameters, PistonParameters, TelescopeParameters, ValveParameters};
use crate::workpiece::{Casting, OFFSET_TOLERANCE_M, WorkpieceError};

use super::{Environment, HammerUnit, ModeTreatment, Scene};

/// What kind of fault a problem is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SceneProblemKind {
    /// A value is outside its range.
    Value,
    /// A casting lacks its inertia or is not held by its fixtures.
    Restraint,
    /// A hammer would strike beside its casting.
    Miss,
}

/// One fault of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneProblem {
    /// The kind of fault.
    pub kind: SceneProblemKind,
    /// The offending quantity by its path in a study, e.g. `casting.part.mass_kg`.
    pub path: String,
    /// What is wrong and what was expected.
    pub message: String,
}

/// Most twins of a row.
const MOST_TWINS: usize = 1000;

/// Ranges that quantities are held to.
#[derive(Clone, Copy)]
enum Range {
    Any,
    NonNegative,
    Positive,
    AboveOne,
    AtLeastOne,
    /// Above 0, not above 1.
    Share,
}

impl Range {
    fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::NonNegative => value >= 0.0,
                Self::Positive => value > 0.0,
                Self::AboveOne => value > 1.0,
                Self::AtLeastOne => value >= 1.0,
                Self::Share => value > 0.0 && value <= 1.0,
            }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Any => "a finite number",
            Self::NonNegative => "zero or a positive number",
            Self::Positive => "a positive number",
            Self::AboveOne => "a number above 1",
            Self::AtLeastOne => "1 or a number above",
            Self::Share => "a number above 0 and not above 1",
        }
    }
}

/// Collects problems under a path.
struct Checks {
    problems: Vec<SceneProblem>,
}

impl Checks {
    fn push(&mut self, kind: SceneProblemKind, path: String, message: String) {
        self.problems.push(SceneProblem { kind, path, message });
    }

    fn value(&mut self, path: String, value: f64, range: Range) {
        if !range.holds(value) {
            let message = format!("is {value}, expected {}", range.words());
            self.push(SceneProblemKind::Value, path, message);
        }
    }

    fn values(&mut self, prefix: &str, entries: &[(&str, f64, Range)]) {
        for (key, value, range) in entries {
            self.value(format!("{prefix}.{key}"), *value, *range);
        }
    }

    fn contact(&mut self, prefix: &str, contact: &ContactParameters) {
        let entries = [
            ("stiffness_n_per_m", contact.stiffness_n_per_m, Range::Positive),
            ("damping_n_s_per_m", contact.damping_n_s_per_m, Range::NonNegative),
        ];
        self.values(prefix, &entries);
        let optional = [
            ("restitution", contact.restitution, Range::Share),
            ("power_stiffness_n_per_m_n", contact.power_stiffness_n_per_m_n, Range::Positive),
            ("damping_s_per_m", contact.damping_s_per_m, Range::NonNegative),
            ("exponent", contact.exponent, Range::AtLeastOne),
            ("reference_speed_m_s", contact.reference_speed_m_s, Range::Positive),
        ];
        for (key, value, range) in optional {
            if let Some(value) = value {
                self.value(format!("{prefix}.{key}"), value, range);
            }
        }
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
        check_environment(&mut checks, &self.environment);
        for hammer in &self.hammers {
            self.check_hammer(&mut checks, hammer);
        }
        for (index, casting) in self.castings.iter().enumerate() {
            self.check_casting(&mut checks, index, casting);
        }
        self.check_settings(&mut checks);
        checks.problems
    }

    /// Strike points on the casting with this index, in m from its centre of mass.
    pub fn strike_points(&self, casting: usize) -> Vec<[f64; 2]> {
        let strikes = |hammer: &&HammerUnit| hammer.casting == casting;
        self.hammers.iter().filter(strikes).map(|hammer| hammer.strike_point_m).collect()
    }

    fn check_hammer(&self, checks: &mut Checks, hammer: &HammerUnit) {
        let prefix = format!("hammer.{}", hammer.name);
        let over = hammer.supply_pressure_pa - self.environment.ambient_pressure_pa;
        let entries = [
            ("supply_bar", over / 1e5, Range::NonNegative),
            ("start_time_s", hammer.start_time_s, Range::NonNegative),
            ("gate_delay_s", hammer.gate_delay_s, Range::NonNegative),
            ("standoff_m", hammer.standoff_m, Range::NonNegative),
            ("strike_point_m", hammer.strike_point_m[0], Range::Any),
            ("strike_point_m", hammer.strike_point_m[1], Range::Any),
        ];
        checks.values(&prefix, &entries);
        let mut before = hammer.start_time_s;
        for (index, &time) in hammer.supply_switch_times_s.iter().enumerate() {
            // Written so that a NaN is out of order; that of the start is reported above.
            if !(time.is_finite() && (time > before || before.is_nan())) {
                let message = format!("is {time}, expected a time after the switch before, {before} s");
                checks.push(SceneProblemKind::Value, format!("{prefix}.supply_switch_times_s.{index}"), message);
            }
            before = time;
        }
        let sum: f64 = hammer.mount.points.iter().map(|(_, weight)| weight).sum();
        let mount = !hammer.mount.points.is_empty() && (sum - 1.0).abs() < 1e-9;
        checks.rule(mount, format!("{prefix}.mount"), "needs one or more points whose weights sum to 1");
        check_parameters(checks, &format!("{prefix}.parameters"), &hammer.parameters);
        match self.castings.get(hammer.casting) {
            None => checks.rule(false, format!("{prefix}.casting"), "names no casting of the scene"),
            Some(casting) => check_strike(checks, &prefix, hammer, casting),
        }
    }

    fn check_casting(&self, checks: &mut Checks, index: usize, casting: &Casting) {
        let prefix = format!("casting.{}", casting.name);
        let before = checks.problems.len();
        let mut entries = vec![
            ("mass_kg", casting.mass_kg, Range::Positive),
            ("centre_m", casting.centre_m[0], Range::Any),
            ("centre_m", casting.centre_m[1], Range::Any),
        ];
        if let Some(inertia) = &casting.inertia {
            entries.push(("inertia_kg_m2", inertia.x_kg_m2, Range::Positive));
            entries.push(("inertia_kg_m2", inertia.y_kg_m2, Range::Positive));
        }
        let sizes = casting.size_m.iter().flatten();
        entries.extend(sizes.map(|&length| ("size_m", length, Range::Positive)));
        let points = casting.measuring_point_m.iter().flatten();
        entries.extend(points.map(|&offset| ("measuring_point_m", offset, Range::Any)));
        checks.values(&prefix, &entries);
        let held = !casting.fixtures.is_empty();
        checks.rule(held, format!("{prefix}.fixture"), "a casting needs at least one fixture");
        for fixture in &casting.fixtures {
            let entries = [
                ("at_m", fixture.at_m[0], Range::Any),
                ("at_m", fixture.at_m[1], Range::Any),
                ("stiffness_n_per_m", fixture.stiffness_n_per_m, Range::Positive),
                ("damping_n_s_per_m", fixture.damping_n_s_per_m, Range::NonNegative),
            ];
            checks.values(&format!("{prefix}.fixture.{}", fixture.name), &entries);
        }
        // Only a casting with sound values that every hammer hits says something about its restraint.
        let missed = self.hammers.iter().any(|hammer| hammer.casting == index && misses(hammer, casting));
        if checks.problems.len() == before && !missed {
            let active = casting.active_rotations(&self.strike_points(index));
            if let Err(error) = casting.check_restraint(active) {
                let key = match error {
                    WorkpieceError::MissingInertia { .. } => "inertia_kg_m2",
                    WorkpieceError::Unrestrained { .. } => "fixture",
                };
                checks.push(SceneProblemKind::Restraint, format!("{prefix}.{key}"), error.to_string());
            }
        }
    }

    fn check_settings(&self, checks: &mut Checks) {
        checks.value("duration_s".to_string(), self.duration_s, Range::Positive);
        let tolerance = self.solver.tolerance;
        let bounded = tolerance > 0.0 && tolerance <= 0.1;
        checks.rule(bounded, "solver.tolerance".to_string(), "must lie above 0 and not above 0.1");
        checks.value("solver.step_s".to_string(), self.solver.stepping.step_s, Range::Positive);
        let whole = !self.solver.stepping.method.is_fixed() || self.solver.modes == ModeTreatment::Integrated;
        checks.rule(whole, "solver.modes".to_string(), "must be \"integrated\" for a method with a fixed step");
        let steps = self.solver.max_steps > 0;
        checks.rule(steps, "solver.max_steps".to_string(), "must be at least 1");
        checks.value("solver.max_wall_time_s".to_string(), self.solver.max_wall_time_s, Range::Positive);
        let outputs = [
            ("blow_window_s", self.outputs.blow_window_s, Range::Positive),
            ("blow_closing_speed_m_s", self.outputs.blow_closing_speed_m_s, Range::NonNegative),
            ("blow_separation_s", self.outputs.blow_separation_s, Range::NonNegative),
            ("periodic_agreement", self.outputs.periodic_agreement, Range::Positive),
            ("stall_rate_share", self.outputs.stall_rate_share, Range::Share),
        ];
        checks.values("outputs", &outputs);
        let period = self.outputs.longest_period_blows >= 1;
        checks.rule(period, "outputs.longest_period_blows".to_string(), "must be at least 1");
        let twins = self.outputs.twins <= MOST_TWINS;
        checks.rule(twins, "outputs.twins".to_string(), "must be at most 1000: each is a run of its own");
    }
}

/// Whether the strike point lies outside the casting's extent.
fn misses(hammer: &HammerUnit, casting: &Casting) -> bool {
    let outside = |(offset, length): (f64, f64)| offset.abs() > 0.5 * length + OFFSET_TOLERANCE_M;
    casting.size_m.is_some_and(|size| hammer.strike_point_m.into_iter().zip(size).any(outside))
}

fn check_strike(checks: &mut Checks, prefix: &str, hammer: &HammerUnit, casting: &Casting) {
    if let Some([width, depth]) = casting.size_m
        && misses(hammer, casting)
    {
        let [x, y] = hammer.strike_point_m;
        let message = format!(
            "hammer `{}` would miss casting `{}`: it strikes at ({x:.4}, {y:.4}) m from the centre, the casting measures \
             {width} m by {depth} m",
            hammer.name, casting.name
        );
        checks.push(SceneProblemKind::Miss, format!("{prefix}.strike_point_m"), message);
    }
}

fn check_environment(checks: &mut Checks, environment: &Environment) {
    let entries = [
        ("gas_constant_j_per_kg_k", environment.gas_constant_j_per_kg_k, Range::Positive),
        ("temperature_k", environment.temperature_k, Range::Positive),
        ("isentropic_exponent", environment.isentropic_exponent, Range::AboveOne),
        ("ambient_pressure_pa", environment.ambient_pressure_pa, Range::Positive),
        ("gravity_m_s2", environment.gravity_m_s2, Range::NonNegative),
        ("inflow_exponent", environment.inflow_exponent, Range::Positive),
        ("outflow_exponent", environment.outflow_exponent, Range::Positive),
        ("expansion_exponent", environment.expansion_exponent, Range::Positive),
    ];
    checks.values("environment", &entries);
}

fn check_parameters(checks: &mut Checks, prefix: &str, parameters: &HammerParameters) {
    let housing = &parameters.housing;
    let mut entries = vec![("mass_kg", housing.mass_kg, Range::NonNegative)];
    entries.extend(housing.inertia_kg_m2.map(|value| ("inertia_kg_m2", value, Range::NonNegative)));
    entries.extend(housing.centre_of_mass_m.map(|value| ("centre_of_mass_m", value, Range::Any)));
    checks.values(&format!("{prefix}.housing"), &entries);
    let guide = [
        ("mass_kg", parameters.guide.mass_kg, Range::Positive),
        ("stiffness_n_per_m", parameters.guide.stiffness_n_per_m, Range::Positive),
    ];
    checks.values(&format!("{prefix}.guide"), &guide);
    check_telescope(checks, &format!("{prefix}.telescope"), &parameters.telescope);
    check_piston(checks, &format!("{prefix}.piston"), &parameters.piston, &parameters.chisel);
    check_valve(checks, &format!("{prefix}.valve"), &parameters.valve);
    check_chisel(checks, &format!("{prefix}.chisel"), &parameters.chisel);
}

fn check_telescope(checks: &mut Checks, prefix: &str, telescope: &TelescopeParameters) {
    let entries = [
        ("cylinder_mass_kg", telescope.cylinder_mass_kg, Range::Positive),
        ("bore_m", telescope.bore_m, Range::Positive),
        ("annulus_area_ratio", telescope.annulus_area_ratio, Range::Positive),
        ("top_clearance_m", telescope.top_clearance_m, Range::Positive),
        ("top_dead_volume_m3", telescope.top_dead_volume_m3, Range::NonNegative),
        ("annulus_length_m", telescope.annulus_length_m, Range::Positive),
        ("inlet_area_m2", telescope.inlet_area_m2, Range::Positive),
        ("vent_area_m2", telescope.vent_area_m2, Range::Positive),
        ("stroke_m", telescope.stroke_m, Range::Positive),
        ("spring_stiffness_n_per_m", telescope.spring_stiffness_n_per_m, Range::Positive),
        ("spring_damping_n_s_per_m", telescope.spring_damping_n_s_per_m, Range::NonNegative),
        ("spring_preload_n", telescope.spring_preload_n, Range::NonNegative),
        ("friction_static_n", telescope.friction_static_n, Range::NonNegative),
        ("friction_velocity_m_s", telescope.friction_velocity_m_s, Range::Positive),
        ("friction_viscous_n_s_per_m", telescope.friction_viscous_n_s_per_m, Range::NonNegative),
        ("friction_directional_n_s_per_m", telescope.friction_directional_n_s_per_m, Range::NonNegative),
        ("retracting_share", telescope.retracting_share, Range::NonNegative),
        ("extending_share", telescope.extending_share, Range::NonNegative),
    ];
    checks.values(prefix, &entries);
    checks.contact(&format!("{prefix}.top_stop"), &telescope.top_stop);
    checks.contact(&format!("{prefix}.end_stop"), &telescope.end_stop);
    // A NaN is reported above; here only an order of two sound numbers counts.
    let empty = telescope.annulus_length_m <= telescope.stroke_m;
    let message = "must exceed the telescope's stroke_m: the annulus chamber would vanish at the end of the stroke";
    checks.rule(!empty, format!("{prefix}.annulus_length_m"), message);
}

fn check_piston(checks: &mut Checks, prefix: &str, piston: &PistonParameters, chisel: &ChiselParameters) {
    let entries = [
        ("mass_kg", piston.mass_kg, Range::Positive),
        ("bore_m", piston.bore_m, Range::Positive),
        ("front_area_ratio", piston.front_area_ratio, Range::Positive),
        ("stroke_m", piston.stroke_m, Range::Positive),
        ("chamber_length_m", piston.chamber_length_m, Range::Positive),
        ("rear_clearance_m", piston.rear_clearance_m, Range::Positive),
        ("front_clearance_m", piston.front_clearance_m, Range::Positive),
        ("rear_port_m", piston.rear_port_m, Range::NonNegative),
        ("front_port_m", piston.front_port_m, Range::NonNegative),
        ("port_width_m", piston.port_width_m, Range::Positive),
        ("rear_exhaust_area_m2", piston.rear_exhaust_area_m2, Range::Positive),
        ("front_exhaust_area_m2", piston.front_exhaust_area_m2, Range::Positive),
        ("friction_viscous_n_s_per_m", piston.friction_viscous_n_s_per_m, Range::NonNegative),
    ];
    checks.values(prefix, &entries);
    checks.contact(&format!("{prefix}.rear_wall"), &piston.rear_wall);
    checks.contact(&format!("{prefix}.chisel_contact"), &piston.chisel_contact);
    // V40 = front_clearance A3, so the front chamber keeps a volume while p < L_p + (A3 / A4) front_clearance.
    let reach = piston.chamber_length_m + piston.front_clearance_m / piston.front_area_ratio;
    let empty = reach <= piston.stroke_m + chisel.travel_m;
    let message = "must leave the front chamber a volume at the resting position, stroke_m + chisel.travel_m";
    checks.rule(!empty, format!("{prefix}.chamber_length_m"), message);
}

fn check_valve(checks: &mut Checks, prefix: &str, valve: &ValveParameters) {
    let entries = [
        ("mass_kg", valve.mass_kg, Range::Positive),
        ("area_m2", valve.area_m2, Range::Positive),
        ("travel_m", valve.travel_m, Range::Positive),
        ("supply_share", valve.supply_share, Range::Positive),
        ("rear_feed_area_m2", valve.rear_feed_area_m2, Range::Positive),
        ("front_feed_area_m2", valve.front_feed_area_m2, Range::Positive),
        ("friction_viscous_n_s_per_m", valve.friction_viscous_n_s_per_m, Range::NonNegative),
    ];
    checks.values(prefix, &entries);
    checks.contact(&format!("{prefix}.stop"), &valve.stop);
}

fn check_chisel(checks: &mut Checks, prefix: &str, chisel: &ChiselParameters) {
    let entries = [
        ("mass_kg", chisel.mass_kg, Range::Positive),
        ("travel_m", chisel.travel_m, Range::Positive),
        ("friction_viscous_n_s_per_m", chisel.friction_viscous_n_s_per_m, Range::NonNegative),
    ];
    checks.values(prefix, &entries);
    checks.contact(&format!("{prefix}.cylinder_contact"), &chisel.cylinder_contact);
    checks.contact(&format!("{prefix}.casting_contact"), &chisel.casting_contact);
}
