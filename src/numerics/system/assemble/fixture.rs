//! Links of the fixtures: springs between castings and machine.

use crate::scene::Scene;
use crate::system::elements::{ElementsBuilder, Spring};
use crate::system::points::{FixtureId, Owner, PointId};

/// Adds the springs of all fixtures.
pub(super) fn add_links(elements: &mut ElementsBuilder<'_>, scene: &Scene) {
    for (casting, held) in scene.castings.iter().enumerate() {
        for (fixture, parameters) in held.fixtures.iter().enumerate() {
            let id = FixtureId { casting, fixture };
            elements.spring(
                [PointId::Held(id), PointId::Support(id)],
                Spring {
                    stiffness_n_per_m: parameters.stiffness_n_per_m,
                    damping_n_s_per_m: parameters.damping_n_s_per_m,
                    owner: Owner::Fixture(id),
                },
            );
        }
    }
}
