//! One pneumatic hammer: its parameters, gas chambers, valve and friction. Knows nothing of scenes or structures.

mod evaluate;
mod flow;
mod model;
mod parameters;

pub use evaluate::{ChamberBalance, HammerConstants, HammerRates, HammerState, body, chamber};
pub use flow::{Gas, choked_flow};
pub use model::HammerModel;
pub use parameters::{
    ChiselParameters, GuideParameters, HammerParameters, HousingParameters, PistonParameters, TelescopeParameters,
    ValveParameters,
};
