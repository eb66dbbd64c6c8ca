//! Random scenes of one hammer, over which the promises of the presets and the numerical errors of rows are held to the true error.
//!
//! Masses, laws of both contacts of the chisel, places, pressures, standoffs and fixtures differ. Castings are light for the hammer, as
//! heavier ones amplify small differences and have no true figures of their percussion.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use decore_model::metrics::{
    CastingMetrics, HammerMetrics, NumericalErrors, Percussion, Promise, RunMetrics, RunTotals, Span,
};
use decore_quantity::Quantity;
use decore_study::Study;
use decore_study::engine::{Engine, RowRunner};

/// Names of mount and fixture point of families whose casting only heaves.
const HEAVING: [[&str; 2]; 3] = [["R4", "T4"], ["R5", "T5"], ["R6", "T6"]];
/// Settings of the true figures: tolerance 1e-9, guide on its spring, all modes of the structure.
const TRUE: [&str; 5] = [
    "solver.fidelity=reference",
    "solver.tolerance=1e-9",
    "structure.mode_tolerance=0",
    "outputs.twins=0",
    "outputs.numerical_twin=none",
];

/// Scenes of one place.
pub struct Family {
    study: Study,
}

/// The families, each of `rows` scenes.
pub fn families(rows: usize) -> Vec<Family> {
    let heaving = HEAVING.iter().enumerate().map(|(seed, [mount, point])| {
        let scene = format!(
            "geometry = 'as_given'\nduration_s = 0.6\n[hammer.hammer]\nmount = '{mount}'\nstrike_point_m = [0.0, 0.0]\n\
             [casting.part.fixture.only]\npoint = '{point}'\ndamping_n_s_per_m = 4000.0\n"
        );
        let design = design(rows, seed, ([0.3, 2.5], &["only"]));
        scene + &design
    });
    let names = ["front_left", "front_right", "back_left", "back_right"];
    let fixtures: String = (names.iter().zip(["T1", "T3", "T7", "T9"]))
        .map(|(name, point)| format!("[casting.part.fixture.{name}]\npoint = '{point}'\n"))
        .collect();
    let turning = format!(
        "duration_s = 0.6\n[hammer.hammer]\nrail = 'rail'\n[casting.part]\nsize_m = [0.30, 0.28]\n\
         inertia_kg_m2 = [0.0135, 0.026]\n{fixtures}{}[design.factor.position]\npath = 'hammer.hammer.rail_position_m'\n\
         range = [-0.12, 0.12]\n",
        design(rows, HEAVING.len(), ([1.0, 3.0], &names))
    );
    let family = |text: String| {
        let study = Study::parse(&text, Path::new(""), "sample.toml").unwrap_or_else(|error| panic!("{error}"));
        Family { study }
    };
    heaving.chain([turning]).map(family).collect()
}

/// The design of a family: masses of the casting between two limits, fixtures of these names.
fn design(rows: usize, seed: usize, ([least_kg, most_kg], fixtures): ([f64; 2], &[&str])) -> String {
    let laws = "values = ['kelvin_voigt', 'kelvin_voigt_separating', 'hunt_crossley', 'hertz']";
    let paths: Vec<String> =
        fixtures.iter().map(|name| format!("'casting.part.fixture.{name}.stiffness_n_per_m'")).collect();
    let paths = paths.join(", ");
    format!(
        "[design]\nkind = 'random'\nrows = {rows}\nseed = {seed}\n\
         [design.factor.mass]\npath = 'casting.part.mass_kg'\nrange = [{least_kg}, {most_kg}]\n\
         [design.factor.pressure]\npath = 'hammer.hammer.supply_bar'\nrange = [4.0, 6.0]\n\
         [design.factor.standoff]\npath = 'hammer.hammer.standoff_m'\nrange = [0.060, 0.100]\n\
         [design.factor.fixture]\npaths = [{paths}]\nrange = [1e7, 1e8]\nscale = 'log'\n\
         [design.factor.casting_law]\npath = 'hammer.hammer.parameters.chisel.casting_contact.law'\n{laws}\n\
         [design.factor.piston_law]\npath = 'hammer.hammer.parameters.piston.chisel_contact.law'\n{laws}\n"
    )
}

impl Family {
    /// Outputs of all scenes under a preset, with numerical errors and scatter; `None` of a scene that did not reach its end.
    pub fn stated(&self, preset: &str) -> Vec<Option<RunMetrics>> {
        let fidelity = format!("solver.fidelity={preset}");
        self.run(&[fidelity.as_str(), "outputs.twins=2", "outputs.numerical_twin=all"])
    }

    /// Outputs of all scenes, converged.
    pub fn exact(&self) -> Vec<Option<RunMetrics>> {
        self.run(&TRUE)
    }

    fn run(&self, settings: &[&str]) -> Vec<Option<RunMetrics>> {
        let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
        let study = self.study.with_overrides(&settings).unwrap_or_else(|error| panic!("{error}"));
        let engine = Engine::new(study).unwrap_or_else(|error| panic!("{error}"));
        let design = engine.checked().design();
        let points: Vec<_> = (0..design.row_count()).filter_map(|row| design.row(row)).collect();
        let outcomes = engine.outcomes_at(&points, 0, &AtomicBool::new(false));
        let outcomes = outcomes.unwrap_or_else(|error| panic!("{error}")).expect("nothing stops them");
        outcomes.into_iter().map(|outcome| outcome.metrics).collect()
    }
}

/// An output of a row beside the true one; all errors relative to its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    /// Name of the output.
    pub output: &'static str,
    /// True error.
    pub error: f64,
    /// Error that the row states.
    pub stated: f64,
    /// Scatter that the row states.
    pub scatter: f64,
    /// Promise under which it is.
    pub promise: Promise,
}

impl Judged {
    /// Whether the true error is below twice the stated one plus the scatter.
    pub fn is_covered(&self) -> bool {
        self.error <= 2.0 * self.stated + self.scatter
    }
}

/// Relative scatter up to which a scene is calm: perturbations of 1e-9 and a tenth of the tolerance move neither energy nor frequency of
/// its blows by more under the preset `reference`.
const CALM: f64 = 1e-6;

/// Whether a scene does not amplify small differences, by its outputs under the preset `reference`.
pub fn is_calm(reference: &RunMetrics) -> bool {
    let scatter = reference.scatter.as_ref().expect("twins");
    reference.hammers.iter().zip(&scatter.hammers).all(|(hammer, scatter)| {
        let of = |name: &str| scatter.get(name).copied().flatten().unwrap_or(f64::INFINITY);
        let energy = of(HammerMetrics::periodic_energy_mean_j.name) / hammer.periodic_energy_mean_j.unwrap_or(0.0);
        let frequency = of(HammerMetrics::hit_frequency_hz.name) / hammer.hit_frequency_hz.unwrap_or(0.0);
        energy <= CALM && frequency <= CALM
    })
}

/// The outputs of a row that have a promise, beside the true ones: those of the whole run where the percussion is periodic and the
/// scene is calm.
pub fn judged(row: &RunMetrics, exact: &RunMetrics, calm: bool) -> Vec<Judged> {
    let periodic = [row, exact].iter().flat_map(|run| &run.hammers).all(|one| one.percussion == Percussion::Periodic);
    let numerical = row.numerical.as_ref().expect("a numerical twin");
    let scatter = row.scatter.as_ref().expect("twins");
    let mut all = Vec::new();
    let of = |errors: &NumericalErrors, at: usize| (errors.hammers[at].clone(), scatter.hammers[at].clone());
    for (at, (own, exact)) in row.hammers.iter().zip(&exact.hammers).enumerate() {
        let (errors, scatter) = of(numerical, at);
        let beside = |name: &str| [&errors, &scatter].map(|all| all.get(name).copied().flatten());
        all.extend(numbers(HammerMetrics::QUANTITIES, [own, exact], beside));
    }
    for (at, (own, exact)) in row.castings.iter().zip(&exact.castings).enumerate() {
        let beside =
            |name: &str| [&numerical.castings[at], &scatter.castings[at]].map(|all| all.get(name).copied().flatten());
        all.extend(numbers(CastingMetrics::QUANTITIES, [own, exact], beside));
    }
    // Works and impulses of the run are those of its only hammer.
    assert_eq!(row.totals.delivered_work_j, row.hammers[0].delivered_work_j, "{}", RunTotals::delivered_work_j.name);
    all.retain(|one| one.promise.span == Span::FirstImpact || (periodic && calm));
    all
}

/// The main numbers of one hammer or casting, with numerical error and scatter of each.
fn numbers<T>(
    quantities: &'static [Quantity<T>],
    [own, exact]: [&T; 2],
    beside: impl Fn(&str) -> [Option<f64>; 2],
) -> Vec<Judged> {
    let judge = |quantity: &Quantity<T>| {
        let number = |of: &T| (quantity.value)(of)?.number();
        let (own, exact) = (number(own)?, number(exact)?);
        let [stated, scatter] = beside(quantity.name);
        let relative = |error: f64| if error == 0.0 { 0.0 } else { error / exact.abs() };
        Some(Judged {
            output: quantity.name,
            error: relative((own - exact).abs()),
            stated: relative(stated?),
            scatter: relative(scatter?),
            promise: Promise::of(quantity.name)?,
        })
    };
    quantities.iter().filter(|quantity| quantity.main).filter_map(judge).collect()
}
