//! A sound study and what is wrong with its variations.

use std::path::Path;

use decore_study::{Problem, Study, StudyError};

use crate::station::checked;

/// A sound study; tests replace parts of it.
pub const GOOD: &str = r#"title = "test"
duration_s = 1.0
[structure]
cutoff_hz = 300.0
[hammer.left]
mount = "R5"
supply_bar = 5.0
[casting.part]
mass_kg = 3.0
[casting.part.fixture.f1]
point = "T5"
stiffness_n_per_m = 3e7
[design]
kind = "latin_hypercube"
rows = 4
[design.factor.pressure]
path = "hammer.left.supply_bar"
range = [4.0, 6.0]
"#;

/// Faults of a text, from loading or checking.
pub fn faults(text: &str) -> Vec<Problem> {
    let error = match Study::parse(text, Path::new(env!("CARGO_MANIFEST_DIR")), "s.toml") {
        Ok(study) => checked(&study).expect_err("the study has no fault"),
        Err(error) => error,
    };
    assert!(matches!(error, StudyError::Invalid { .. }));
    assert!(!error.problems().is_empty());
    error.problems().to_vec()
}

/// The only fault of the sound study with `from` replaced by `to`.
pub fn fault(from: &str, to: &str) -> Problem {
    assert!(GOOD.contains(from), "{from}");
    let found = faults(&GOOD.replacen(from, to, 1));
    assert_eq!(found.len(), 1, "{found:#?}");
    found.into_iter().next().unwrap()
}

/// Holds a fault to its place, its key and a part of its text.
#[track_caller]
pub fn holds(problem: &Problem, line: usize, column: usize, key: &str, words: &str) {
    assert_eq!((problem.place.line, problem.place.column), (Some(line), Some(column)), "{problem}");
    assert_eq!(problem.key, key, "{problem}");
    let text = problem.to_string();
    assert!(text.contains(words), "{text}");
    assert!(text.starts_with(&format!("s.toml:{line}:{column}: ")), "{text}");
}
