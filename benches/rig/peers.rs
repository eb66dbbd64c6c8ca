//! Other solvers on the same equations: a program of its own (`benches/peers`), built and run when the bench is.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

/// What the table says besides its rows.
const WORDS: &str = "
## Other solvers on the same equations

The same compiled right-hand side, scene and 60 modes (integrated: no other program condenses them), `tied` as for decore's fastest
setting, `spring` as published. Tolerances are absolute, in the same scales as decore's own (root mean square norms where decore
takes the largest); contacts are the solvers' own root functions, except for SciPy, whose contacts follow the state and which runs
up to just after the first impact. `slower`: over the CPU time of decore's fastest setting within the goals, measured just before.
`switches` of contacts: root finding that compares the ends of steps passes over contacts shorter than a step; `late` are those that
it lost and that were switched at the end of a step.

";

/// The table, or why there is none.
pub fn text(text: &mut String, study: &Path, tolerance: f64) {
    text.push_str(WORDS);
    match table(study, tolerance) {
        Ok(table) => text.push_str(&table),
        Err(reason) => {
            let _ = writeln!(text, "Not measured: {reason}.");
        }
    }
}

fn table(study: &Path, tolerance: f64) -> Result<String, String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers");
    // With decore's own folder of artefacts: most of what both need is there.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().ok_or("no folder for artefacts")?;
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let built = Command::new(cargo)
        .args(["build", "--release", "--quiet", "--manifest-path"])
        .arg(folder.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(target)
        .status();
    if !built.is_ok_and(|status| status.success()) {
        return Err("benches/peers could not be built".to_owned());
    }
    let program = target.join("release/peers");
    let library = target.join("release/libpeers.so");
    let output = Command::new(program)
        .arg(study)
        .arg(format!("{tolerance:e}"))
        .arg(library)
        .arg(folder.join("scipy_peers.py"))
        .stderr(Stdio::inherit())
        .output();
    match output {
        Ok(output) if output.status.success() => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        _ => Err("benches/peers did not run to its end".to_owned()),
    }
}
