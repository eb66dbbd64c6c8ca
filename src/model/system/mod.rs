//! The coupled system: structure, hammers and castings joined by sparse blocks.
//!
//! - `points`: rows of the points of the parts, by id
//! - `layout`: positions of the quantities in the state vector
//! - `elements`: springs and one-sided contacts as sparse rows
//! - `block`: equations of motion of a part, one block per part
//! - `assemble`: builds a model from a scene and the machine's modes (only this part uses more of scenes than ids and links)
//! - `model`: constants of the coupled system
//! - `products`: products of short vectors
//! - `modal`: modes of a flexible part, integrated, and masses tied to its points
//! - `kernel`: motion of points from integrals of the forces on them
//! - `pairs`: numbers of some modes in registers
//! - `octave`: groups of modes by frequency, and the free motion of slower ones between their own rebases
//! - `impulse_response`, `base`: impulse-response condensation of the modes to their points, and the modes at a rebase
//! - `moments`, `dissipation`: repeated integrals of the forces from node to node, and the dissipation of condensed modes
//! - `placed`: the structure's modes, shared by scenes with one placement
//! - `discrete`: contacts, supplies and gates
//! - `coupled`: the model with its discrete state
//! - `motion`: motion of points and elements, forces and energies at a state
//! - `linear`: natural frequencies and receptances of machine and castings together
//! - `fixture_gauge`: powers of single fixtures at a state
//! - `rates`: the right-hand side, for one row or one in each lane
//! - `lanes`: rows of one shape side by side
//! - `integration`: the system for the integrator

mod assemble;
mod block;
mod coupled;
mod discrete;
mod dissipation;
mod elements;
mod fixture_gauge;
mod force_integrals;
mod impulse_response;
mod integration;
mod kernel;
mod lanes;
mod layout;
mod linear;
mod modal;
mod modal_state;
mod model;
mod motion;
mod placed;
mod points;
mod products;
mod rates;
mod rebase_group;
mod register_pair;

pub use assemble::{build, build_placed};

pub use coupled::Coupled;
pub use elements::LinkFlexibility;
pub use fixture_gauge::{FixtureGauge, FixturePower};
pub(crate) use lanes::{CoupledLanes, Shape};
pub(crate) use layout::CastingQuadrature;
pub use layout::HammerQuadrature;
pub use linear::LinearModel;
pub use model::{CoupledModel, ResidualMotion};
pub use placed::{InterfaceModes, PlacedModes, Residual, SceneModes};
