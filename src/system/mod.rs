//! The coupled system: structure, hammers and castings joined by sparse blocks.
//!
//! - `layout`: where each quantity lives in the state vector
//! - `elements`: springs and one-sided contacts as sparse rows
//! - `builder`: from a scene and the structure's modes to a model (the only part that knows scenes)
//! - `model`: constants of the coupled system and its energies
//! - `coupled`: the model with its discrete state, as the integrator sees it

mod builder;
mod coupled;
mod elements;
mod layout;
mod model;

pub use builder::{BuildError, InterfaceModes, build};
pub use coupled::Coupled;
pub use elements::{Contact, ContactKind, Elements, Spring};
pub use layout::{HammerQuadrature, Layout};
pub use model::{CastingSlot, CoupledModel, HammerSlot};
