//! Force laws of one-sided contacts.
//!
//! A contact acts along one relative coordinate: the penetration `d` (m, positive when the bodies overlap) and its rate `d'` (m/s). The
//! laws are pure functions; `system` decides when a contact is closed.
//!
//! - [`ContactParameters`]: user settings of a contact
//! - [`ContactLaw`]: law with its coefficients, for the coupled system
//! - [`restitution`]: closed forms between damping and the coefficient of restitution

mod law;
mod parameters;
pub mod restitution;

pub use law::ContactLaw;
pub use parameters::{ContactLawName, ContactParameters, kelvin_voigt};
