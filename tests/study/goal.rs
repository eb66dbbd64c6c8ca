//! The question of a study: goal, limits and roles of factors.

use std::path::Path;

use decore_study::engine::checked;
use decore_study::{FactorRole, Study};

use crate::faults::{GOOD, holds};

/// A goal behind the good study.
fn with_goal(goal: &str) -> String {
    format!("{GOOD}\n[goal]\n{goal}\n")
}

fn parse(text: &str) -> Result<Study, decore_study::StudyError> {
    Study::parse(text, Path::new("."), "s.toml")
}

/// The words of the only fault of a goal, and the fault itself.
fn fault(goal: &str) -> decore_study::Problem {
    let error = match parse(&with_goal(goal)) {
        Err(error) => error,
        Ok(study) => match checked(study) {
            Err(decore_study::engine::EngineError::Study(error)) => error,
            other => panic!("{goal}: {other:?}"),
        },
    };
    let [problem] = error.problems() else { panic!("{error}") };
    problem.clone()
}

#[test]
fn a_goal_is_read_and_held_to_the_columns() {
    let goal =
        "maximise = \"strike_energy_j - 2 * delivered_work_j\"\nlimits = [\"4.5 >= max_casting_point_velocity_m_s\"]";
    let study = parse(&with_goal(goal)).unwrap_or_else(|error| panic!("{error}"));
    let read = study.goal().expect("a goal");
    assert!(read.maximise && read.confidence == 0.95 && !read.limits[0].at_most);
    checked(study).unwrap_or_else(|error| panic!("{error}"));
    let first = GOOD.lines().count() + 3;
    let unknown = fault("minimise = \"1 + strik_energy_j\"");
    holds(&unknown, first, 17, "goal.minimise", "did you mean `strike_energy_j`?");
    let limit = fault("minimise = \"strike_energy_j\"\nlimits = [\"max_casting_point_velocity <= 4\"]");
    holds(&limit, first + 1, 12, "goal.limits.0", "did you mean `max_casting_point_velocity_m_s`?");
    holds(
        &fault("maximise = \"strike_energy_j + max_casting_point_velocity_m_s\""),
        first,
        12,
        "goal.maximise",
        "joins values in J and m/s",
    );
    holds(
        &fault("maximise = \"strike_energy_j\"\nlimits = [\"strike_energy_j\"]"),
        first + 1,
        11,
        "goal.limits.0",
        "is not a comparison",
    );
    holds(&fault("maximise = \"strike_energy_j > 3\""), first, 12, "goal.maximise", "belong into `limits`");
    holds(&fault("maximise = \"3\""), first, 12, "goal.maximise", "names no output");
    holds(&fault("maximise = \"status\""), first, 13, "goal.maximise", "not a numerical column");
    holds(
        &fault("maximise = \"strike_energy_j\"\nconfidence = 1.0"),
        first + 1,
        14,
        "goal.confidence",
        "between 0 and 1",
    );
    assert!(fault("limits = []").to_string().contains("wants nothing"));
    assert!(
        fault("maximise = \"strike_energy_j\"\nminimise = \"strike_energy_j\"")
            .to_string()
            .contains("one of the two keys")
    );
}

#[test]
fn neither_goal_nor_roles_change_what_a_study_is() {
    let plain = parse(GOOD).unwrap_or_else(|error| panic!("{error}"));
    let asked = with_goal("maximise = \"strike_energy_j\"");
    let asked = parse(&asked.replacen("[design.factor.pressure]", "[design.factor.pressure]\nrole = \"uncertain\"", 1));
    let asked = asked.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(asked.factors()[0].role, FactorRole::Uncertain);
    assert_eq!(plain.hash(), asked.hash());
    let set = ["goal.confidence=0.9", "design.factor.pressure.role=decision"].map(str::to_owned);
    let set = asked.with_overrides(&set).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((plain.hash(), set.goal().map(|goal| goal.confidence)), (set.hash(), Some(0.9)));
    let [plain, asked, set] = [plain, asked, set].map(|study| checked(study).unwrap_or_else(|error| panic!("{error}")));
    assert_eq!([plain.frame_hash(), plain.budget_free_hash()], [asked.frame_hash(), asked.budget_free_hash()]);
    assert_eq!([plain.frame_hash(), plain.budget_free_hash()], [set.frame_hash(), set.budget_free_hash()]);
}

#[test]
fn a_factor_that_follows_from_others_has_no_role() {
    let derived = "[design.factor.twice]\nexpression = \"2 * pressure\"\nrole = \"uncertain\"\n";
    let error = parse(&format!("{GOOD}\n{derived}")).expect_err("a fault");
    assert!(error.to_string().contains("a factor with an expression has no role"), "{error}");
}
