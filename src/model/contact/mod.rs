//! Force laws of one-sided contacts.
//!
//! A contact acts along one relative coordinate: the penetration `d` (m, positive when the bodies overlap) and its rate
//! `d'` (m/s). The laws are pure functions; which contact is closed, and when, is the business of `system`.
//!
//! - [`ContactParameters`]: what a user states about a contact
//! - [`ContactLaw`]: the law with its coefficients, as the coupled system evaluates it
//! - [`restitution`]: closed forms between damping and the coefficient of restitution

mod law;
mod parameters;
pub mod restitution;

pub use law::ContactLaw;
pub use parameters::{ContactLawName, ContactParameters, kelvin_voigt};
