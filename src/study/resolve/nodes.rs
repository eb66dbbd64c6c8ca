//! Points of elastic castings that a study gives by nodes.

use super::issue::Issue;
use super::placement::PointTable;
use decore_model::scene::Scene;
use decore_model::structure::{NodesEntry, WeightedNodes};

/// A key of the study whose value is the nodes of a point.
pub(super) struct NodesKey<'a> {
    /// Path of the table that has the key.
    pub table: String,
    pub key: &'static str,
    pub entry: Option<&'a NodesEntry>,
    /// Keys of a location, which exclude nodes, and whether the table has them.
    pub beside: &'a [(&'static str, bool)],
}

/// The nodes of a casting.
#[derive(Clone, Copy)]
pub(super) struct NodesOf<'a> {
    pub casting: &'a str,
    pub is_elastic: bool,
    pub points: &'a PointTable,
}

/// Nodes of a point and their weighted mean in m from the centre of mass.
pub(super) type PlacedNodes = (WeightedNodes, [f64; 3]);

impl NodesOf<'_> {
    /// The nodes of a key; `None` without the key, or if an issue was added.
    pub fn resolve(self, key: NodesKey<'_>, issues: &mut Vec<Issue>) -> Option<PlacedNodes> {
        let NodesKey { table, key, entry, beside } = key;
        let placed = self.placed(key, entry?, beside);
        placed.map_err(|message| issues.push(Issue::new(format!("{table}.{key}"), message))).ok()
    }

    fn placed(self, key: &str, entry: &NodesEntry, beside: &[(&str, bool)]) -> Result<PlacedNodes, String> {
        if let Some((other, _)) = beside.iter().find(|(_, given)| *given) {
            return Err(format!("the nodes are the location: remove either `{key}` or `{other}`"));
        }
        let Self { casting, is_elastic, points } = self;
        if !is_elastic {
            return Err(format!(
                "casting `{casting}` is rigid and has no nodes: give a location in m, or its model in [casting.{casting}.structure]"
            ));
        }
        let nodes = entry.weighted()?;
        let known = points.nodes(casting).ok_or_else(|| format!("the nodes of casting `{casting}` were not read"))?;
        let place = known.place_m(&nodes)?;
        Ok((nodes, place))
    }
}

/// Strike points of a scene that are one node of a solid mesh: finer meshes are softer there.
pub(crate) fn single_nodes(scene: &Scene, points: &PointTable) -> Vec<Issue> {
    let single = scene.hammers.iter().filter_map(|hammer| {
        let casting = scene.castings.get(hammer.casting)?;
        let node = points.nodes(&casting.name)?.single_solid(hammer.strike_nodes.as_ref()?)?;
        let message = format!(
            "node {node} alone is the strike point: the flexibility of a single node of solid elements grows as the mesh gets \
             finer; name the nodes of an area"
        );
        Some(Issue::new(format!("hammer.{}.strike_nodes", hammer.name), message))
    });
    single.collect()
}
