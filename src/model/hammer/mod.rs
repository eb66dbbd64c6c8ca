//! One pneumatic hammer: its parameters, gas chambers, valve and friction. Knows nothing of scenes or structures.
//!
//! A component's parameters, the constants prepared from them and the equations that use them stand in one file: `telescope`,
//! `piston`, `valve`, `chisel`, and `housing` with the guide. They meet state and gas in `state`, `flow` and `chambers` below
//! them, each other in `parameters`, `evaluate` and `model` above them.

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
