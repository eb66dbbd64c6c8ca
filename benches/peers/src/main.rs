//! Solves decore's equations of the paper's rig with other programs and prints a table beside decore's own time.
//!
//! `peers STUDY TOLERANCE LIBRARY SCRIPT`: the study, the tolerance of decore's fastest setting within the goals, the shared library
//! of this package and the script that gives it to SciPy. The bench of the rig runs it.

mod cvode;
mod foreign;
mod run;

use std::path::Path;
use std::process::Command;

use cpu_time::ThreadTime;
use decore_model::run::run_row;
use decore_model::scene::{Guide, Scene, SolverSettings};
use foreign::Method;
use peers::scene::{FIGURES, Rig, errors, figures, meets_goals, prepare};
use peers::{Problem, problem_model};
use run::{Goal, Stop};

/// Tolerance of the reference.
const REFERENCE_TOLERANCE: f64 = 1e-9;
/// Simulated time in s of SciPy's runs: past the first impact.
const SCIPY_END_S: f64 = 0.06;
/// Longest CPU time of a run of SciPy's in s.
const SCIPY_LONGEST_S: f64 = 45.0;

/// A foreign solver.
enum Solver {
    Cvode,
    Diffsol(Method),
}

/// A row of the table.
struct Row {
    name: String,
    /// CPU ms per simulated second of the row, and of decore's run just before.
    ms_per_s: [f64; 2],
    steps: u64,
    evaluations: u64,
    /// Switches of contacts; those that root finding had missed.
    switches: [u64; 2],
    errors: [f64; 4],
    remark: String,
}

impl Row {
    /// Time over decore's.
    fn slower(&self) -> f64 {
        self.ms_per_s[0] / self.ms_per_s[1]
    }

    fn verdict(&self, goal: f64) -> &'static str {
        if self.slower() >= goal { "met" } else { "**missed**" }
    }
}

/// Runs of decore.
struct Yardstick<'a> {
    rig: &'a Rig,
    tolerance: f64,
}

impl Yardstick<'_> {
    fn solver(&self, guide: Guide, tolerance: f64) -> SolverSettings {
        SolverSettings { tolerance, guide, ..self.rig.scene.solver }
    }

    /// Figures at the reference's tolerance, of a run of `end_s`.
    fn exact(&self, end_s: f64) -> [f64; 4] {
        let solver = self.solver(Guide::Spring, REFERENCE_TOLERANCE);
        let scene = Scene { solver, duration_s: end_s, ..self.rig.scene.clone() };
        figures(run_row(&scene, &self.rig.modes).metrics.as_ref().expect("the reference run"))
    }

    fn scene(&self) -> Scene {
        Scene { solver: self.solver(Guide::Tied, self.tolerance), ..self.rig.scene.clone() }
    }

    /// decore's own row.
    fn row(&self, exact: &[f64; 4]) -> Row {
        let outcome = run_row(&self.scene(), &self.rig.modes);
        let ms_per_s = self.ms_per_s();
        Row {
            name: format!("**decore**, tied, {:.0e}", self.tolerance),
            ms_per_s: [ms_per_s, ms_per_s],
            steps: outcome.counters.steps,
            evaluations: outcome.counters.rhs_evaluations,
            switches: [outcome.counters.located_events, 0],
            errors: outcome.metrics.as_ref().map_or([f64::NAN; 4], |metrics| errors(&figures(metrics), exact)),
            remark: String::new(),
        }
    }

    /// CPU ms per simulated second of the fastest setting within the goals: the median of three runs.
    fn ms_per_s(&self) -> f64 {
        let scene = self.scene();
        let mut times = [(); 3].map(|()| {
            let begin = ThreadTime::now();
            run_row(&scene, &self.rig.modes);
            begin.elapsed().as_secs_f64()
        });
        times.sort_by(f64::total_cmp);
        1e3 * times[1] / scene.duration_s
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [study, tolerance, library, script] = arguments.as_slice() else {
        eprintln!("usage: peers STUDY TOLERANCE LIBRARY SCRIPT");
        std::process::exit(2);
    };
    let rig = prepare(Path::new(study), &[]);
    let yardstick = Yardstick { rig: &rig, tolerance: tolerance.parse().unwrap_or(1e-5) };
    let exact = yardstick.exact(rig.scene.duration_s);
    println!(
        "| solver | ms per s | slower than decore | steps | right-hand sides | switches, late | {} | |\n|---|---|---|---|---|---|---|---|---|---|---|",
        FIGURES.join(" | ")
    );
    print(&yardstick.row(&exact));
    let cvode = cvode::Library::load();
    let mut rows = Vec::new();
    for (solver, guide, tolerance) in cases() {
        let row = foreign_row(&yardstick, (&solver, guide, tolerance), (cvode, &exact));
        print(&row);
        rows.push(row);
    }
    scipy_rows(&yardstick, [study, library, script]).iter().for_each(print);
    verdicts(&rows);
}

/// What the rows say of the goals.
fn verdicts(rows: &[Row]) {
    let of = |name: &'static str| rows.iter().filter(move |row| row.name.starts_with(name) && row.slower().is_finite());
    let fastest = |a: &&Row, b: &&Row| a.slower().total_cmp(&b.slower());
    println!();
    match of("CVODE").find(|row| row.name.ends_with("tied, 1e-5")) {
        Some(row) => println!("- {}: {:.0} times slower (goal 60: {}).", row.name, row.slower(), row.verdict(60.0)),
        None => println!("- CVODE: not measured."),
    }
    match of("diffsol").filter(|row| meets_goals(&row.errors)).min_by(fastest) {
        Some(row) => println!(
            "- diffsol's fastest within the goals, {}: {:.1} times slower (goal 10: {}).",
            row.name,
            row.slower(),
            row.verdict(10.0)
        ),
        None => println!("- No setting of diffsol is within the goals for the errors."),
    }
    if let Some(row) = of("diffsol").min_by(fastest) {
        println!("- diffsol's fastest at any error, {}: {:.1} times slower.", row.name, row.slower());
    }
}

fn cases() -> Vec<(Solver, Guide, f64)> {
    use Guide::{Spring, Tied};
    vec![
        (Solver::Cvode, Tied, 1e-5),
        (Solver::Cvode, Tied, 1e-6),
        (Solver::Cvode, Spring, 1e-5),
        (Solver::Diffsol(Method::Tsit45), Tied, 1e-5),
        (Solver::Diffsol(Method::Tsit45), Tied, 1e-6),
        (Solver::Diffsol(Method::Tsit45), Tied, 1e-7),
        (Solver::Diffsol(Method::Tsit45), Tied, 1e-8),
        (Solver::Diffsol(Method::Tsit45), Tied, 1e-9),
        (Solver::Diffsol(Method::Tsit45), Spring, 1e-5),
        (Solver::Diffsol(Method::Tsit45), Spring, 1e-6),
        (Solver::Diffsol(Method::Tsit45), Spring, 1e-7),
        (Solver::Diffsol(Method::Esdirk34), Tied, 1e-5),
        (Solver::Diffsol(Method::Bdf), Tied, 1e-5),
    ]
}

fn foreign_row(
    yardstick: &Yardstick<'_>,
    (solver, guide, tolerance): (&Solver, Guide, f64),
    (cvode, exact): (Option<cvode::Library>, &[f64; 4]),
) -> Row {
    let scene = &yardstick.rig.scene;
    let model = problem_model(yardstick.rig, guide);
    let mut problem = Problem::new(&model, scene.outputs.clone());
    let own = yardstick.ms_per_s();
    let goal = Goal::new(tolerance, scene.duration_s);
    let begin = ThreadTime::now();
    let (name, ended) = match (solver, cvode) {
        (Solver::Cvode, Some(library)) => ("CVODE BDF", cvode::integrate(library, &mut problem, &goal)),
        (Solver::Cvode, None) => ("CVODE BDF", Err(Stop::Failed("not installed".to_owned()))),
        (Solver::Diffsol(method), _) => {
            let name = match method {
                Method::Tsit45 => "diffsol Tsit45",
                Method::Bdf => "diffsol BDF",
                Method::Esdirk34 => "diffsol ESDIRK34",
            };
            (name, foreign::integrate(*method, &mut problem, &goal))
        }
    };
    let time = begin.elapsed().as_secs_f64();
    let (reached, remark) = match ended {
        Ok(reached) => (reached, String::new()),
        Err(Stop::OutOfTime(reached)) => (reached, format!("given up at {reached:.2} s")),
        Err(Stop::Failed(reason)) => (f64::NAN, reason),
    };
    let whole = remark.is_empty();
    let found = problem.solution.figures(&scene.outputs, scene.duration_s);
    let guide = if guide == Guide::Tied { "tied" } else { "spring" };
    Row {
        name: format!("{name}, roots, {guide}, {tolerance:.0e}"),
        ms_per_s: [1e3 * time / reached, own],
        steps: problem.steps,
        evaluations: problem.evaluations,
        switches: problem.switches,
        errors: if whole { errors(&found, exact) } else { [f64::NAN; 4] },
        remark,
    }
}

/// Rows of the script; one that says why not where it does not run.
fn scipy_rows(yardstick: &Yardstick<'_>, [study, library, script]: [&String; 3]) -> Vec<Row> {
    let exact = yardstick.exact(SCIPY_END_S);
    let own = yardstick.ms_per_s();
    let settings = [1e-5, SCIPY_END_S, SCIPY_LONGEST_S].map(|value| format!("{value:e}"));
    let output = Command::new("python3").arg(script).args([library, study]).args(settings).output();
    let text = match output {
        Ok(output) if output.status.success() => String::from_utf8_lossy(&output.stdout).into_owned(),
        _ => {
            let (name, remark) = ("SciPy LSODA, Radau".to_owned(), "not installed".to_owned());
            return vec![Row {
                name,
                ms_per_s: [f64::NAN, own],
                steps: 0,
                evaluations: 0,
                switches: [0; 2],
                errors: [f64::NAN; 4],
                remark,
            }];
        }
    };
    let row = |line: &str| {
        let value: serde_json::Value = serde_json::from_str(line).ok()?;
        let number = |key: &str| value[key].as_f64().unwrap_or(f64::NAN);
        let reached = number("reached_s");
        let found = [number("first_impact_j"), f64::NAN, f64::NAN, number("peak_velocity_m_s")];
        Some(Row {
            name: format!("{}, follows the state, tied, 1e-5", value["name"].as_str()?),
            ms_per_s: [1e3 * number("cpu_s") / reached, own],
            steps: value["steps"].as_u64()?,
            evaluations: value["evaluations"].as_u64()?,
            switches: [0; 2],
            errors: errors(&found, &exact),
            remark: format!("first {:.3} s only", reached),
        })
    };
    text.lines().filter_map(row).collect()
}

fn print(row: &Row) {
    let cell = |value: f64, text: String| if value.is_finite() { text } else { "-".to_owned() };
    let (ms, [switches, late]) = (row.ms_per_s[0], row.switches);
    let errors: Vec<String> = row.errors.iter().map(|error| cell(*error, format!("{error:.0e}"))).collect();
    let remark = if meets_goals(&row.errors) { "within the goals" } else { row.remark.as_str() };
    println!(
        "| {} | {} | {} | {} | {} | {} | {} | {remark} |",
        row.name,
        cell(ms, format!("{ms:.0}")),
        cell(ms, format!("{:.1}", row.slower())),
        row.steps,
        row.evaluations,
        if switches > 0 { format!("{switches}, {late}") } else { "-".to_owned() },
        errors.join(" | ")
    );
}
