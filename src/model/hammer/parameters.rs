//! Parameters of one pneumatic hammer, combined from its components. Each component declares its own.
//!
//! The same structure is the hammer file (TOML) and the input of the model. Every field defaults to the published hammer or, if the
//! publication has no value, to an assumed or calibrated one; the field's text states the source. Published values: Mariadass et al.,
//! Appl. Mech. 2023, 4, 1206-1226, Table 2 ("Table 2" in the components).

use super::chisel::ChiselParameters;
use super::housing::{GuideParameters, HousingParameters};
use super::piston::PistonParameters;
use super::state::body;
use super::telescope::TelescopeParameters;
use super::valve::ValveParameters;
use crate::parameter::parameters;

parameters! { file
    /// All parameters of one hammer.
    #[derive(Copy)]
    pub struct HammerParameters {
        /// The rigid housing on the mount; it changes the machine's modes.
        pub housing: HousingParameters, "", [group], "";
        /// The guide between the housing's mount and the telescope.
        pub guide: GuideParameters, "", [group], "";
        /// The telescope: cylinder, return spring, stops, friction, its two chambers.
        pub telescope: TelescopeParameters, "", [group], "";
        /// The percussion piston with its two chambers and exhaust ports.
        pub piston: PistonParameters, "", [group], "";
        /// The spool valve that feeds the percussion chambers.
        pub valve: ValveParameters, "", [group], "";
        /// The chisel and its contacts.
        pub chisel: ChiselParameters, "", [group], "";
    }
}

/// Stiffness of a guide's spring over that of the hammer's stiffest contact from which the guide may be tied. The error of the tie
/// falls with the stiffness; on the paper's rig (a ratio of 16) it is 1e-6 of the first impact's energy, 1e-5 of the arm's velocity.
const RIGID_STIFFNESS_RATIO: f64 = 10.0;
/// Smallest frequency of a guide on its spring, relative to the fastest contact, for a tied guide.
const RIGID_FREQUENCY_RATIO: f64 = 2.0;

impl HammerParameters {
    /// Whether the chisel keeps bouncing between piston and nose when little moves it: errors of many small bounces then add up until
    /// the first impact.
    pub fn chisel_chatters(&self) -> bool {
        let (cylinder, piston) = (1.0 / self.telescope.cylinder_mass_kg, 1.0 / self.piston.mass_kg);
        let chisel = 1.0 / self.chisel.mass_kg;
        self.piston.chisel_contact.keeps_slow_bounces(1.0 / (piston + chisel))
            || self.chisel.cylinder_contact.keeps_slow_bounces(1.0 / (chisel + cylinder))
    }

    /// Whether the guide's spring is so stiff, and the guide so fast, that the guide moves with its mount for all practical purposes: a
    /// spring ten times as stiff as the stiffest contact, and a frequency `sqrt(k/m)` twice as high as the fastest, `sqrt(k (1/m1 + 1/m2))`
    /// with the masses of the contacting bodies.
    pub fn guide_is_rigid(&self) -> bool {
        let (cylinder, piston) = (1.0 / self.telescope.cylinder_mass_kg, 1.0 / self.piston.mass_kg);
        let (spool, chisel) = (1.0 / self.valve.mass_kg, 1.0 / self.chisel.mass_kg);
        let contacts = [
            (&self.piston.rear_wall, piston + cylinder),
            (&self.piston.chisel_contact, piston + chisel),
            (&self.valve.stop, spool + cylinder),
            (&self.chisel.cylinder_contact, chisel + cylinder),
            (&self.chisel.casting_contact, chisel),
            (&self.telescope.end_stop, cylinder),
        ];
        let stiffest = contacts.iter().map(|(contact, _)| contact.stiffness_n_per_m).fold(0.0, f64::max);
        let fastest = contacts.iter().map(|(contact, mass)| contact.stiffness_n_per_m * mass).fold(0.0, f64::max);
        let guide = &self.guide;
        guide.stiffness_n_per_m >= RIGID_STIFFNESS_RATIO * stiffest
            && guide.stiffness_n_per_m / guide.mass_kg >= RIGID_FREQUENCY_RATIO.powi(2) * fastest
    }

    /// Masses of the bodies, kg.
    pub fn masses_kg(&self) -> [f64; body::COUNT] {
        [
            self.guide.mass_kg,
            self.telescope.cylinder_mass_kg,
            self.valve.mass_kg,
            self.piston.mass_kg,
            self.chisel.mass_kg,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::ContactLawName;

    /// The published chisel comes to rest between its contacts; under Hunt-Crossley or without loss it does not.
    #[test]
    fn analytic_chatter() {
        let with = |change: &dyn Fn(&mut HammerParameters)| {
            let mut hammer = HammerParameters::default();
            change(&mut hammer);
            hammer.chisel_chatters()
        };
        assert!(!with(&|_| ()));
        assert!(!with(&|hammer| hammer.chisel.casting_contact.restitution = Some(1.0)), "the casting is not there yet");
        assert!(!with(&|hammer| hammer.piston.chisel_contact.restitution = Some(0.98)));
        assert!(with(&|hammer| hammer.piston.chisel_contact.restitution = Some(1.0)));
        assert!(with(&|hammer| hammer.chisel.cylinder_contact.damping_n_s_per_m = 0.0));
        assert!(with(&|hammer| hammer.piston.chisel_contact.law = ContactLawName::HuntCrossley));
    }

    /// The published guide is rigid compared with its hammer; a softer or heavier one, or one with a stiffer contact, is not.
    #[test]
    fn analytic_rigid_guides() {
        let with = |change: &dyn Fn(&mut HammerParameters)| {
            let mut hammer = HammerParameters::default();
            change(&mut hammer);
            hammer.guide_is_rigid()
        };
        assert!(with(&|_| ()));
        // Ten times 6.06e8 N/m (chisel in its nose).
        assert!(with(&|hammer| hammer.guide.stiffness_n_per_m = 6.57e9));
        assert!(!with(&|hammer| (hammer.guide.stiffness_n_per_m, hammer.guide.mass_kg) = (6.05e9, 0.1)));
        // Four times 5.971e8 N/m (1/0.4546 kg + 1/1.8157 kg) = 6.57e9 1/s2.
        assert!(!with(&|hammer| hammer.guide.stiffness_n_per_m = 6.56e9));
        assert!(with(&|hammer| hammer.guide.mass_kg = 1.52));
        assert!(!with(&|hammer| hammer.guide.mass_kg = 1.53));
        assert!(!with(&|hammer| hammer.chisel.casting_contact.stiffness_n_per_m = 1.01e9));
    }
}
