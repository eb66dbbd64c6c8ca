//! The coupled equations of the paper's rig as other solvers take them, and as a C ABI for Python's `ctypes`.
//!
//! Modes are integrated (a foreign solver knows no rebases), quadratures are left out, contacts either switch at roots or
//! follow the state.

#[path = "../../rig/scene.rs"]
pub mod scene;

mod abi;
mod problem;

pub use abi::*;
pub use problem::{Problem, Solution, problem_model};
