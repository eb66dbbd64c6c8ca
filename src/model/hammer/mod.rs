//! One pneumatic hammer: its parameters, gas chambers, valve and friction. Independent of scenes and structures.
//!
//! A component's parameters, prepared constants and equations are in one file: `telescope`, `piston`, `valve`, `chisel`, and `housing`
//! with the guide. `state`, `flow` and `chambers` below them have the state and the gas; `parameters`, `evaluate` and `model` above them
//! combine the components.

mod chambers;
mod chisel;
mod evaluate;
mod flow;
mod housing;
mod model;
mod parameters;
mod piston;
mod state;
mod telescope;
mod valve;

pub(crate) use evaluate::HammerConstants;
pub use flow::Gas;
pub(crate) use flow::choked_flow;
pub use model::HammerModel;
pub use parameters::HammerParameters;
pub use state::{HammerState, body, chamber};
pub use valve::ValveParameters;
