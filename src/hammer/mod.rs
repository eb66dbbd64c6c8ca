//! One pneumatic hammer: its parameters, gas chambers, valve and friction. Knows nothing of scenes or structures.

mod flow;
mod model;
mod parameters;

pub use flow::{FlowFunction, choked_flow};
pub use model::{ChamberBalance, Gas, HammerModel, HammerRates, HammerState, body, chamber};
pub use parameters::{
    ChiselParameters, GuideParameters, HammerParameters, HousingParameters, PistonParameters, TelescopeParameters,
    ValveParameters,
};
