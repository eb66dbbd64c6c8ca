//! The physics and its integration: closed forms, references, audits, and what the outputs mean.

mod accuracy;
mod analytic_contact;
mod analytic_contact_laws;
mod analytic_coupled;
mod analytic_fixed_step;
mod analytic_friction;
mod analytic_gas;
mod analytic_impact;
mod analytic_integrate;
mod audit;
#[path = "../common/mod.rs"]
mod common;
mod contacts;
mod directions;
mod elastic;
mod fixed_step_rig;
mod fragile;
mod hard_cases;
mod lanes;
mod ledger;
mod metrics;
mod numerical_twin;
mod one_sided;
mod outputs;
mod presets;
mod val_reference;
mod val_signal;
