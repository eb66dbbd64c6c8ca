//! Reasons to doubt a run that reached its end.

use decore_quantity::named;
use schemars::JsonSchema;
use serde::Serialize;

named! {
    /// Reason to doubt a run that reached its end: its equations are solved, but its inputs describe no hammer on a casting.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
    pub enum Warning {
        /// A chisel goes deeper into its casting than a quarter of its free travel.
        DeepContact = "deep_contact",
        /// A chisel-casting contact begins with more than twice the elastic force at the deepest penetration.
        DamperJump = "damper_jump",
    }
}

impl Warning {
    /// Meaning and remedy.
    pub fn advice(self) -> &'static str {
        match self {
            Self::DeepContact => {
                "a chisel goes deeper into its casting than a quarter of its free travel (`largest_penetration_m`): a contact law is for \
                 local deformation; take a stiffer contact"
            }
            Self::DamperJump => {
                "a peak force is the damper's jump at touch (`largest_jump_force_n`), more than twice the elastic force: take a larger \
                 restitution or less damping; `law = \"kelvin_voigt_separating\"` has the smallest jump for a restitution near 0, \
                 `hertz` and `hunt_crossley` have none"
            }
        }
    }

    /// The warnings of a column's text.
    pub fn of(text: &str) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |warning| text.split(", ").any(|name| name == warning.name()))
    }

    /// The text of a column: the names in their order, each once.
    pub(super) fn text(found: impl Iterator<Item = Self>) -> String {
        let mut found: Vec<Self> = found.collect();
        found.sort_unstable();
        found.dedup();
        found.into_iter().map(Self::name).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_keeps_its_warnings() {
        let twice = [Warning::DamperJump, Warning::DeepContact, Warning::DamperJump];
        let text = Warning::text(twice.into_iter());
        assert_eq!(text, "deep_contact, damper_jump");
        assert!(Warning::of(&text).eq(Warning::ALL));
        assert!(Warning::of("damper_jump").eq([Warning::DamperJump]));
        assert_eq!((Warning::of("").count(), Warning::text(std::iter::empty())), (0, String::new()));
    }
}
