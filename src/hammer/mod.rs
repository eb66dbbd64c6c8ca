//! One pneumatic hammer: its parameters, gas chambers, valve and friction. Knows nothing of scenes or structures.

mod parameters;

pub use parameters::{
    ChiselParameters, GuideParameters, HammerParameters, HousingParameters, PistonParameters,
    TelescopeParameters, ValveParameters,
};
