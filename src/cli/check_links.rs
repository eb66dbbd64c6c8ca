//! Elastic castings, as `decore check` prints them: their modes, and how much they yield under each of their links.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::Serialize;

use decore_model::scene::{HammerLink, Owner, Scene};
use decore_model::system::{InterfaceModes, LinkFlexibility, PlacedModes, build_placed};

/// Number of frequencies that the text shows.
const SHOWN: usize = 6;

/// The elastic modes of a casting that a row keeps.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ElasticCasting {
    /// Name of the casting.
    pub casting: String,
    /// Natural frequencies of its elastic modes below the cut-off, in Hz.
    pub frequencies_hz: Vec<f64>,
}

/// Returns the elastic castings of a scene with their modes.
pub(super) fn elastic_castings(scene: &Scene, modes: &PlacedModes) -> Vec<ElasticCasting> {
    let casting = |(index, modes): (usize, &InterfaceModes)| ElasticCasting {
        casting: scene.castings[index].name.clone(),
        frequencies_hz: modes.omega_rad_s.iter().filter(|omega| **omega > 0.0).map(|omega| omega / TAU).collect(),
    };
    modes.castings().map(casting).collect()
}

/// One line per elastic casting.
pub(super) fn mode_lines(castings: &[ElasticCasting]) -> impl Iterator<Item = String> {
    castings.iter().enumerate().map(|(place, ElasticCasting { casting, frequencies_hz })| {
        let head = if place == 0 { "elastic modes" } else { "" };
        let shown: Vec<String> = frequencies_hz.iter().take(SHOWN).map(|frequency| format!("{frequency:.1}")).collect();
        let from = match frequencies_hz.len() {
            0 => String::new(),
            count if count > SHOWN => format!(": {}, ... Hz", shown.join(", ")),
            _ => format!(": {} Hz", shown.join(", ")),
        };
        format!("{head:<14} {casting}  {} below the cut-off{from}", frequencies_hz.len())
    })
}

/// A link in series with the residual flexibility R of an elastic casting: the flexibility of all modes above its cut-off.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ElasticLink {
    /// The hammer that strikes, or the fixture.
    pub link: String,
    /// Stiffness k by the study in N/m; null for laws with a power of the penetration.
    pub stiffness_n_per_m: Option<f64>,
    /// R along the link in m/N.
    pub residual_m_per_n: f64,
    /// k R: the share by which the link would be too stiff without R; null where k is.
    pub stiffness_times_residual: Option<f64>,
    /// Stiffness in N/m of the link alone, where k includes the local flexibility of the casting; null where it does not.
    pub own_stiffness_n_per_m: Option<f64>,
}

/// Returns the links of a scene's elastic castings; none if the scene cannot be built.
pub(super) fn elastic_links(scene: &Scene, modes: &PlacedModes) -> Vec<ElasticLink> {
    let Ok(model) = build_placed(scene, modes) else { return Vec::new() };
    let link = |of: &LinkFlexibility| ElasticLink {
        link: name(scene, of.owner),
        stiffness_n_per_m: of.stiffness_n_per_m,
        residual_m_per_n: of.residual_m_per_n,
        stiffness_times_residual: of.k_r(),
        own_stiffness_n_per_m: of.own_stiffness_n_per_m().filter(|_| of.included_m_per_n > 0.0),
    };
    model.elements().flexibilities().iter().map(link).collect()
}

fn name(scene: &Scene, owner: Owner) -> String {
    match owner {
        Owner::Hammer { hammer, link: HammerLink::ChiselCasting } => format!("hammer.{}", scene.hammers[hammer].name),
        Owner::Hammer { hammer, .. } => format!("within hammer.{}", scene.hammers[hammer].name),
        Owner::Fixture(id) => {
            let casting = &scene.castings[id.casting];
            let across = if id.axis > 0 { format!(" (across {})", id.axis) } else { String::new() };
            format!("casting.{}.fixture.{}{across}", casting.name, casting.fixtures[id.fixture].name)
        }
    }
}

/// One line per link.
pub(super) fn link_lines(links: &[ElasticLink]) -> impl Iterator<Item = String> {
    let width = links.iter().map(|link| link.link.len()).max().unwrap_or_default();
    links.iter().enumerate().map(move |(place, link)| {
        let head = if place == 0 { "elastic links" } else { "" };
        let k_r = link.stiffness_times_residual.map_or_else(
            || format!("R = {:.2e} m/N", link.residual_m_per_n),
            |k_r| format!("k R = {k_r:.4}, R = {:.2e} m/N", link.residual_m_per_n),
        );
        let own = link.stiffness_n_per_m.zip(link.own_stiffness_n_per_m).map_or_else(String::new, |(all, own)| {
            format!("; contact {all:.3e} N/m with the casting, {own:.3e} N/m without")
        });
        format!("{head:<14} {:<width$}  {k_r}{own}", link.link)
    })
}
