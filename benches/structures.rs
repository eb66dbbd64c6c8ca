//! Reduction at scale: hexahedral elasticity from 3e3 to 3e5 DOF and a CalculiX model, against scipy in the same run.
//!
//! `cargo bench --bench structures` writes the section `structures` of `benches/RESULTS.md` and `benches/structures.svg`.
//! `DECORE_PYTHON` names an interpreter with scipy (and scikit-sparse for CHOLMOD); what it lacks is left out and said so. A
//! number as argument leaves out models with more DOF, `--sizes-only` the other programs. `--exports` writes the section
//! `structure_exports` instead: size and time of a model in every exchange format. Every reduction runs in a process of
//! its own on one thread, so that peaks of memory can be compared.

mod support;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use decore_model::structure::{
    DofLabel, ExportFormat, FeModel, InterfacePoint, InterfacePoints, MatrixFile, MatrixFormat, ModelFiles,
    ModelMatrices, Observer, PointPlace, ReductionSettings, Units, reduce_observed, write_model,
};
use serde::{Deserialize, Serialize};
use sprs::CsMat;

/// Edges of the cubes in elements: 3 n^3 DOF, one face held.
const SIZES: [usize; 4] = [10, 22, 31, 46];
/// The cube whose files are weighed.
const EXPORTED: usize = 31;
/// Cubes up to this size are given to SuperLU too; beyond, its factor outgrows time and memory of this bench.
const LARGEST_SUPERLU: usize = 31;
/// Cut-off in Hz that leaves about 50 fixed-interface modes of the cube.
const CUTOFF_HZ: f64 = 4650.0;
/// Steps in the order of the table.
const STEPS: [&str; 4] = ["factor", "constraint", "modes", "count"];

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Outcome {
    steps: BTreeMap<String, f64>,
    peak_bytes: f64,
    hz: Vec<f64>,
    check: Vec<f64>,
}

impl Outcome {
    fn total(&self) -> f64 {
        self.steps.values().sum()
    }
}

/// Stiffness and mass of a cube element of edge `h`, trilinear, 2 x 2 x 2 points.
fn element(h: f64) -> ([[f64; 24]; 24], [[f64; 8]; 8]) {
    const E: f64 = 206.94e9;
    const NU: f64 = 0.288;
    const DENSITY: f64 = 7829.0;
    let (lambda, mu) = (E * NU / ((1.0 + NU) * (1.0 - 2.0 * NU)), E / (2.0 * (1.0 + NU)));
    let corner = |a: usize| [a & 1, (a >> 1) & 1, a >> 2].map(|bit| 2.0 * bit as f64 - 1.0);
    let (mut k, mut m) = ([[0.0; 24]; 24], [[0.0; 8]; 8]);
    let volume = (h / 2.0).powi(3);
    for point in (0..8).map(|p| corner(p).map(|c| c / 3.0_f64.sqrt())) {
        let shape = |a: usize| corner(a).iter().zip(point).map(|(c, x)| 0.5 * (1.0 + c * x)).product::<f64>();
        let gradient = |a: usize| {
            let c = corner(a);
            let along = |d: usize| {
                (0..3).map(|e| if e == d { 0.5 * c[e] } else { 0.5 * (1.0 + c[e] * point[e]) }).product::<f64>()
            };
            [0, 1, 2].map(|d| along(d) * 2.0 / h)
        };
        for a in 0..8 {
            for b in 0..8 {
                let (p, q) = (gradient(a), gradient(b));
                let dot: f64 = (0..3).map(|d| p[d] * q[d]).sum();
                m[a][b] += DENSITY * shape(a) * shape(b) * volume;
                for i in 0..3 {
                    for j in 0..3 {
                        let same = if i == j { mu * dot } else { 0.0 };
                        k[3 * a + i][3 * b + j] += (lambda * p[i] * q[j] + mu * p[j] * q[i] + same) * volume;
                    }
                }
            }
        }
    }
    (k, m)
}

/// A matrix of 3 x 3 blocks: the sum over the elements that two nodes share of the element's block of its corners.
fn assemble(n: usize, block: impl Fn(usize, usize) -> [[f64; 3]; 3], coupled: bool) -> CsMat<f64> {
    let side = n + 1;
    let nodes = side * side * n;
    let (mut pointers, mut indices, mut data) = (vec![0], Vec::new(), Vec::new());
    for node in 0..nodes {
        let at = [node % side, node / side % side, node / (side * side) + 1].map(|x| x as i64);
        let mut blocks: Vec<(usize, [[f64; 3]; 3])> = Vec::with_capacity(27);
        for offset in 0..27_i64 {
            let other = [at[0] + offset % 3 - 1, at[1] + offset / 3 % 3 - 1, at[2] + offset / 9 - 1];
            let last = n as i64;
            if !((0..=last).contains(&other[0]) && (0..=last).contains(&other[1]) && (1..=last).contains(&other[2])) {
                continue;
            }
            let mut sum = [[0.0; 3]; 3];
            for cell in 0..8_i64 {
                let corner = [at[0] - (cell & 1), at[1] - (cell >> 1 & 1), at[2] - (cell >> 2)];
                let bits = [other[0] - corner[0], other[1] - corner[1], other[2] - corner[2]];
                if corner.iter().any(|x| *x < 0 || *x >= last) || bits.iter().any(|bit| !(0..2).contains(bit)) {
                    continue;
                }
                let part = block(cell as usize, (bits[0] + 2 * bits[1] + 4 * bits[2]) as usize);
                (0..3).for_each(|i| (0..3).for_each(|j| sum[i][j] += part[i][j]));
            }
            let column = (other[2] as usize - 1) * side * side + other[1] as usize * side + other[0] as usize;
            blocks.push((column, sum));
        }
        for i in 0..3 {
            for (column, sum) in &blocks {
                for j in (0..3).filter(|j| coupled || i == *j) {
                    indices.push(3 * column + j);
                    data.push(sum[i][j]);
                }
            }
            pointers.push(indices.len());
        }
    }
    CsMat::new((3 * nodes, 3 * nodes), pointers, indices, data)
}

/// A steel cube of 1 m with n elements per edge, held at one face; eight points on its top face.
fn cube(n: usize) -> FeModel {
    let (k, m) = element(1.0 / n as f64);
    let block = |a: usize, b: usize| std::array::from_fn(|i| std::array::from_fn(|j| k[3 * a + i][3 * b + j]));
    let stiffness = assemble(n, block, true);
    let diagonal =
        |a: usize, b: usize| std::array::from_fn(|i| std::array::from_fn(|j| if i == j { m[a][b] } else { 0.0 }));
    let mass = assemble(n, diagonal, false);
    let side = n + 1;
    let labels = (0..mass.rows()).map(|row| DofLabel { node: (row / 3) as i64 + 1, dof: row % 3 }).collect();
    let point = |index: usize| {
        let (x, y) = ((index % 4) * n / 3, (index / 4) * n);
        InterfacePoint {
            name: format!("P{index}"),
            role: "mount".to_owned(),
            place: PointPlace::Rows { first: 3 * ((n - 1) * side * side + y * side + x), dofs: Some(3) },
            position_m: [x as f64 / n as f64, y as f64 / n as f64, 1.0],
        }
    };
    let points = InterfacePoints::new((0..8).map(point).collect()).expect("unique");
    FeModel::new(ModelMatrices { mass, stiffness, damping: None, labels }, points).expect("sound")
}

fn calculix() -> FeModel {
    let file = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/solid").join(name);
    let matrix = |name: &str| MatrixFile { path: file(name), name: String::new() };
    FeModel::read(&ModelFiles {
        format: MatrixFormat::Calculix,
        units: Units::Si,
        stiffness: matrix("ccx_raw.sti.gz"),
        mass: matrix("ccx_raw.mas.gz"),
        damping: None,
        dofs: Some(file("ccx_raw.dof.gz")),
        nodes: None,
        dofs_per_node: None,
        points: file("points.csv"),
    })
    .expect("shipped")
}

/// 0 stands for the CalculiX model.
fn model(size: usize) -> (FeModel, ReductionSettings) {
    let (model, points, cutoff_hz) = if size == 0 {
        (calculix(), ["R1", "R3", "R5", "R7", "R9", "T1", "T3", "T5"].map(str::to_owned), 750.0)
    } else {
        (cube(size), std::array::from_fn(|index| format!("P{index}")), CUTOFF_HZ)
    };
    let interface = points.iter().flat_map(|point| (0..3).map(|dof| (point.clone(), dof))).collect();
    (model, ReductionSettings { interface, fixed_interface_cutoff_hz: cutoff_hz })
}

/// The reduction by this program, in this process.
fn own(size: usize) -> Outcome {
    let (model, settings) = model(size);
    let mut observer = Observer::active();
    let (structure, facts) = reduce_observed(&model, &settings, &mut observer).expect("reduces");
    let mut steps = BTreeMap::new();
    let mut peak_bytes = 0.0_f64;
    for record in observer.records() {
        let name = match record.name.as_str() {
            name if name.starts_with("condition") => continue,
            name if name.starts_with("count") => "count",
            name if name.starts_with("factorisation") => "factor",
            name if name.starts_with("order") => "order",
            name if name.starts_with("constraint") => "constraint",
            name if name.starts_with("fixed-interface") => "modes",
            _ => "projection",
        };
        *steps.entry(name.to_owned()).or_insert(0.0) += record.cpu_s.unwrap_or(record.time_s);
        peak_bytes = peak_bytes.max(record.peak_bytes.unwrap_or(0) as f64);
    }
    let b = facts.interface;
    let q = structure.m_zz().nrows() - b;
    let m_qb: f64 = structure.m_zz().view((0, q), (q, b)).iter().map(|value| value.abs()).sum();
    let trace = |matrix: &nalgebra::DMatrix<f64>| (q..q + b).map(|i| matrix[(i, i)]).sum::<f64>();
    let check = vec![m_qb, trace(structure.m_zz()), trace(structure.k_zz())];
    Outcome { steps, peak_bytes, hz: facts.fixed_interface_hz, check }
}

fn run_own(size: usize) -> Outcome {
    let output = Command::new(std::env::current_exe().expect("this program"))
        .args(["--child", &size.to_string()])
        .output()
        .expect("starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("an outcome")
}

fn export(size: usize, folder: &Path) {
    let (model, settings) = model(size);
    for (name, matrix) in [("K", model.stiffness()), ("M", model.mass())] {
        let write =
            |end: &str, bytes: Vec<u8>| fs::write(folder.join(format!("{name}.{end}")), bytes).expect("written");
        let pointers = matrix.proper_indptr();
        write("indptr", pointers.iter().flat_map(|value| (*value as i64).to_le_bytes()).collect());
        write("indices", matrix.indices().iter().flat_map(|value| (*value as i32).to_le_bytes()).collect());
        write("data", matrix.data().iter().flat_map(|value| value.to_le_bytes()).collect());
    }
    let rows =
        settings.interface.iter().map(|(point, dof)| model.rows_of(point).expect("known")[*dof].expect("there") as i64);
    fs::write(folder.join("b.rows"), rows.flat_map(i64::to_le_bytes).collect::<Vec<u8>>()).expect("written");
}

fn run_other(folder: &Path, solver: &str, modes: usize) -> Result<Outcome, String> {
    let python = std::env::var("DECORE_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/structures.py");
    let output = Command::new(&python)
        .arg(script)
        .arg(folder)
        .args([solver, &modes.to_string()])
        .envs([("OMP_NUM_THREADS", "1"), ("OPENBLAS_NUM_THREADS", "1"), ("MKL_NUM_THREADS", "1")])
        .output()
        .map_err(|error| error.to_string())?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(text.lines().last().unwrap_or("failed").to_owned());
    }
    serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())
}

struct Row {
    name: String,
    dofs: usize,
    own: Outcome,
    others: Vec<(&'static str, Result<Outcome, String>)>,
}

fn measure(size: usize, alone: bool) -> Row {
    let begin = Instant::now();
    let own = run_own(size);
    eprintln!("{size}: {} modes, {:.1} s in all {:?}", own.hz.len(), begin.elapsed().as_secs_f64(), own.steps);
    let dofs = if size == 0 { 9762 } else { 3 * (size + 1) * (size + 1) * size };
    let mut others = Vec::new();
    if !alone && size <= 40 {
        let folder = tempfile::tempdir().expect("a folder");
        export(size, folder.path());
        for solver in ["superlu", "cholmod"] {
            if solver == "superlu" && size > LARGEST_SUPERLU {
                continue;
            }
            let outcome = run_other(folder.path(), solver, own.hz.len());
            if let Ok(outcome) = &outcome {
                let worst = own.hz.iter().zip(&outcome.hz).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
                let check =
                    own.check.iter().zip(&outcome.check).skip(1).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
                eprintln!(
                    "  {solver}: {:.1} s {:?}; frequencies {worst:.1e}, matrices {check:.1e}",
                    outcome.total(),
                    outcome.steps
                );
                assert!(worst < 1e-6 && check < 1e-6, "the programs disagree");
            }
            others.push((solver, outcome));
        }
    }
    let name = if size == 0 { "CalculiX station, C3D10".to_owned() } else { format!("cube {size}^3, hex8") };
    Row { name, dofs, own, others }
}

fn section(rows: &[Row]) -> String {
    let mut text = String::from(
        "# Reduction at scale\n\nWritten by `cargo bench --bench structures`: Craig-Bampton with 24 interface DOFs and all fixed-interface modes below a\ncut-off that leaves about 50, one thread, each program in a process of its own; times are processor times. `count` is the proof that no mode is missing\n(a factorisation that the others do without); ratios are the other program's figure over decore's, so more than 1 is in\ndecore's favour. SuperLU in symmetric mode with minimum degree, CHOLMOD with METIS, both with ARPACK on their factor.\n\n| model | DOF | modes | order s | factor s | constraint s | modes s | count s | all s | peak MB |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let step = |name: &str| row.own.steps.get(name).copied().unwrap_or(0.0);
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.0} |",
            row.name,
            row.dofs,
            row.own.hz.len(),
            step("order"),
            step("factor"),
            step("constraint"),
            step("modes"),
            step("count"),
            row.own.total(),
            row.own.peak_bytes / 1e6
        );
    }
    text.push_str("\n| model | against | factor with order | constraint | modes | all, same work | all, count included | peak memory |\n|---|---|---|---|---|---|---|---|\n");
    for row in rows {
        for (solver, outcome) in &row.others {
            let name = if *solver == "superlu" { "scipy, SuperLU" } else { "scipy, CHOLMOD and METIS" };
            match outcome {
                Err(reason) => {
                    let _ = writeln!(text, "| {} | {name} | not run: {reason} | | | | | |", row.name);
                }
                Ok(other) => {
                    let ours = |names: &[&str]| names.iter().filter_map(|name| row.own.steps.get(*name)).sum::<f64>();
                    let ratio = |name: &str, own: f64| other.steps.get(name).copied().unwrap_or(0.0) / own;
                    let _ = writeln!(
                        text,
                        "| {} | {name} | {:.1} | {:.1} | {:.1} | **{:.2}** | {:.2} | {:.2} |",
                        row.name,
                        ratio("factor", ours(&["order", "factor"])),
                        ratio(STEPS[1], ours(&[STEPS[1]])),
                        ratio(STEPS[2], ours(&[STEPS[2]])),
                        other.total() / (row.own.total() - ours(&["count"])),
                        other.total() / row.own.total(),
                        other.peak_bytes / row.own.peak_bytes
                    );
                }
            }
        }
    }
    text.push_str("\n![time and memory over DOF](structures.svg)\n");
    text
}

/// Title, place from the left, decades of the axis, figure.
type Panel = (&'static str, f64, [f64; 2], &'static dyn Fn(&Outcome) -> f64);

/// Time and memory of the cubes over DOF, both axes logarithmic.
fn growth(rows: &[Row]) -> String {
    let cubes: Vec<&Row> = rows.iter().filter(|row| row.name.starts_with("cube")).collect();
    let place = |dofs: f64| 70.0 + (dofs.log10() - 3.3) / 2.4 * 300.0;
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"820\" height=\"330\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"820\" height=\"330\" fill=\"white\"/>\n",
    );
    let panels: [Panel; 2] = [
        ("time in s", 0.0, [-2.0, 3.0], &|outcome| outcome.total()),
        ("peak memory in MB", 410.0, [1.0, 4.0], &|outcome| outcome.peak_bytes / 1e6),
    ];
    for (title, left, [low, high], figure) in panels {
        let height = |value: f64| 280.0 - (value.log10() - low) / (high - low) * 240.0;
        let _ = writeln!(
            svg,
            "<g transform=\"translate({left} 0)\"><text x=\"70\" y=\"24\" font-size=\"14\">{title} over DOF</text>"
        );
        for decade in low as i32..=high as i32 {
            let y = height(10_f64.powi(decade));
            let _ = writeln!(
                svg,
                "<path d=\"M70 {y}H370\" stroke=\"#ddd\"/><text x=\"62\" y=\"{:.0}\" text-anchor=\"end\">1e{decade}</text>",
                y + 4.0
            );
        }
        for dofs in [1e4, 1e5] {
            let x = place(dofs);
            let _ = writeln!(
                svg,
                "<path d=\"M{x} 40V280\" stroke=\"#ddd\"/><text x=\"{x}\" y=\"298\" text-anchor=\"middle\">{dofs:e}</text>"
            );
        }
        let series = [("decore", "#0b6"), ("superlu", "#c33"), ("cholmod", "#36c")];
        for (index, (name, colour)) in series.into_iter().enumerate() {
            let outcome = |row: &Row| -> Option<f64> {
                let found = row.others.iter().find(|(solver, _)| *solver == name);
                let outcome = if name == "decore" {
                    Some(&row.own)
                } else {
                    found.and_then(|(_, outcome)| outcome.as_ref().ok())
                };
                outcome.map(figure)
            };
            let points: Vec<(f64, f64)> =
                cubes.iter().filter_map(|row| Some((place(row.dofs as f64), height(outcome(row)?)))).collect();
            let line: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
            let _ = writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
                line.join(" ")
            );
            for (x, y) in points {
                let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"{colour}\"/>");
            }
            let y = 56 + 18 * index;
            let _ = writeln!(
                svg,
                "<path d=\"M80 {}h18\" stroke=\"{colour}\" stroke-width=\"3\"/><text x=\"104\" y=\"{y}\">{name}</text>",
                y - 4
            );
        }
        svg.push_str("</g>\n");
    }
    svg.push_str("</svg>\n");
    svg
}

/// A cube in every exchange format: bytes of stiffness and mass, time to write and to read.
fn exports(size: usize) -> String {
    let model = cube(size);
    let mut text = format!(
        "# Exchange formats\n\nWritten by `cargo bench --bench structures -- --exports`: stiffness and mass of the cube of {size}^3 elements, {} DOF, {} entries of\nthe stiffness, in every format; sizes over that of Matrix Market, wall times on this machine.\n\n| format | MB | over Matrix Market | written in s | read in s |\n|---|---|---|---|---|\n",
        model.order(),
        model.stiffness().nnz()
    );
    let mut market = 0.0;
    for format in ExportFormat::all() {
        let name = format.name();
        let folder = tempfile::tempdir().expect("a folder");
        let begin = Instant::now();
        let files = write_model(&model, format, folder.path()).expect("written");
        let written_s = begin.elapsed().as_secs_f64();
        let bytes = |path: &Path| fs::metadata(path).expect("written").len() as f64;
        let size = bytes(&files.stiffness.path) + bytes(&files.mass.path);
        market = if name == "matrix_market" { size } else { market };
        let begin = Instant::now();
        let read = FeModel::read(&files).expect("reads back");
        let read_s = begin.elapsed().as_secs_f64();
        // Some formats leave out zeros.
        let entries =
            |matrix: &CsMat<f64>| matrix.data().iter().copied().filter(|value| *value != 0.0).collect::<Vec<_>>();
        let exact = entries(read.stiffness()) == entries(model.stiffness());
        assert!(exact || format.loss().is_some(), "{name}: entries differ");
        let _ = writeln!(text, "| {name} | {:.0} | {:.2} | {written_s:.1} | {read_s:.1} |", size / 1e6, size / market);
        eprintln!("{name}: {:.0} MB, {written_s:.1} s, {read_s:.1} s", size / 1e6);
    }
    text
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.iter().any(|word| word == "--exports") {
        support::write_section("structure_exports", &exports(EXPORTED));
        return;
    }
    if let Some(position) = arguments.iter().position(|word| word == "--child") {
        let size = arguments.get(position + 1).and_then(|word| word.parse().ok()).expect("a size");
        println!("{}", serde_json::to_string(&own(size)).expect("plain data"));
        return;
    }
    let limit = arguments.iter().find_map(|word| word.parse::<usize>().ok()).unwrap_or(usize::MAX);
    let alone = arguments.iter().any(|word| word == "--sizes-only");
    let sizes = std::iter::once(0).chain(SIZES).filter(|size| 3 * (size + 1) * (size + 1) * size <= limit);
    let mut rows = Vec::new();
    for size in sizes {
        rows.push(measure(size, alone));
        // Written after every model: the large ones take long.
        if limit == usize::MAX && !alone {
            let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/structures.svg");
            fs::write(path, growth(&rows)).expect("written");
            support::write_section("structures", &section(&rows));
        }
    }
    print!("{}", section(&rows));
}
