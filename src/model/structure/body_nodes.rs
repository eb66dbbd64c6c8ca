//! Nodes of an elastic body by their numbers.

use std::collections::{HashMap, HashSet};

use super::error::StructureError;
use super::label::SCALAR;
use super::model::FeModel;
use super::motions::RigidMotions;
use super::nodes::WeightedNodes;

/// Displacements of a node; directions from here on are rotations.
const DISPLACEMENTS: usize = 3;

/// A node with its place from the centre of mass and the rows of its displacements.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub place_m: [f64; 3],
    pub rows: [Option<usize>; DISPLACEMENTS],
    /// Whether it has rows of rotations: nodes of solid elements have none.
    rotates: bool,
    /// Whether it has a direction twice.
    repeated: bool,
}

impl Node {
    /// Rows and shares of its motion along a direction; `None` if it lacks one of them.
    pub fn along(&self, direction: [f64; 3]) -> Option<Vec<(usize, f64)>> {
        let parts = self.rows.iter().zip(direction).filter(|(_, share)| *share != 0.0);
        parts.map(|(row, share)| row.map(|row| (row, share))).collect()
    }
}

/// The nodes of an elastic body that have a displacement and a place, in the order of their first rows.
#[derive(Debug, Clone)]
pub struct BodyNodes {
    nodes: Vec<Node>,
    index: HashMap<i64, usize>,
    /// Numbers of nodes that have a place but no displacement.
    held: HashSet<i64>,
}

impl BodyNodes {
    /// Nodes of a model, places from its centre of mass.
    ///
    /// # Errors
    /// Rows without labels, nodes without coordinates.
    pub fn new(model: &FeModel) -> Result<Self, StructureError> {
        Ok(Self::with_mass(model)?.0)
    }

    /// The nodes, the centre of mass in m and the mass in kg.
    pub(super) fn with_mass(model: &FeModel) -> Result<(Self, [f64; 3], [f64; 3]), StructureError> {
        let Some(motions) = RigidMotions::new(model) else {
            let expected = "rows with labels: name a `dof_file`, or give `dofs_per_node`";
            return Err(StructureError::argument("casting", expected, "rows without labels"));
        };
        let centre = motions.centre_m.map_err(|(unknown, of)| {
            let found = format!("{unknown} of {of} nodes without");
            StructureError::argument("casting", "coordinates of all nodes: name a `nodes_file`", found)
        })?;
        Ok((Self::around(model, centre), centre, motions.mass_kg))
    }

    fn around(model: &FeModel, centre: [f64; 3]) -> Self {
        let mut nodes: Vec<Node> = Vec::new();
        let mut index: HashMap<i64, usize> = HashMap::new();
        let rows = model.labels().iter().enumerate();
        for (row, label) in rows.clone().filter(|(row, label)| label.dof < DISPLACEMENTS && model.carries(*row)) {
            let Some(place) = model.positions_m().get(&label.node) else { continue };
            let at = *index.entry(label.node).or_insert_with(|| {
                let place_m = [0, 1, 2].map(|axis| place[axis] - centre[axis]);
                nodes.push(Node { place_m, rows: [None; DISPLACEMENTS], rotates: false, repeated: false });
                nodes.len() - 1
            });
            nodes[at].repeated |= nodes[at].rows[label.dof].replace(row).is_some();
        }
        for (_, label) in
            rows.filter(|(row, label)| (DISPLACEMENTS..SCALAR).contains(&label.dof) && model.carries(*row))
        {
            if let Some(at) = index.get(&label.node) {
                nodes[*at].rotates = true;
            }
        }
        let held = model.positions_m().keys().filter(|node| !index.contains_key(node)).copied().collect();
        Self { nodes, index, held }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Node> + Clone {
        self.nodes.iter()
    }

    /// A node by its number.
    fn get(&self, number: i64) -> Result<&Node, String> {
        match self.index.get(&number).and_then(|at| self.nodes.get(*at)) {
            Some(node) if node.repeated => Err(format!(
                "names node {number}, which has a direction twice: CalculiX expands shells and beams to several nodes of \
                 one number; name nodes of solid elements"
            )),
            Some(node) => Ok(node),
            None if self.held.contains(&number) => Err(format!(
                "names node {number}, which has no degrees of freedom: it is fixed, or belongs to no element of the model"
            )),
            None => {
                Err(format!("names node {number}, which the model does not have: use the numbers of the nodes file"))
            }
        }
    }

    /// Rows and weights whose sum is the motion of a point along a direction.
    ///
    /// # Errors
    /// The fault in words: an unknown node, a node without a degree of freedom that the direction needs.
    pub(super) fn motion(&self, point: &WeightedNodes, direction: [f64; 3]) -> Result<Vec<(usize, f64)>, String> {
        let mut out = Vec::new();
        for (number, weight) in point.iter() {
            let Some(rows) = self.get(number)?.along(direction) else {
                return Err(format!(
                    "names node {number}, which has no degree of freedom along ({}, {}, {})",
                    direction[0], direction[1], direction[2]
                ));
            };
            out.extend(rows.into_iter().map(|(row, along)| (row, along * weight)));
        }
        Ok(out)
    }

    /// Place of a point from the centre of mass in m: the weighted mean of its nodes.
    ///
    /// # Errors
    /// The fault in words: an unknown node, a node without degrees of freedom.
    pub fn place_m(&self, point: &WeightedNodes) -> Result<[f64; 3], String> {
        let mut place = [0.0; 3];
        for (number, weight) in point.iter() {
            let node = self.get(number)?;
            place.iter_mut().zip(node.place_m).for_each(|(sum, value)| *sum += weight * value);
        }
        Ok(place)
    }

    /// The node of a point that is one node of a solid mesh: one without rotations. Its flexibility is a property of the mesh.
    pub fn single_solid(&self, point: &WeightedNodes) -> Option<i64> {
        point.single().filter(|number| self.get(*number).is_ok_and(|node| !node.rotates))
    }
}

#[cfg(test)]
mod tests {
    use sprs::TriMat;

    use super::*;
    use crate::structure::label::DofLabel;
    use crate::structure::matrices::ModelMatrices;
    use crate::structure::points::InterfacePoints;

    /// A node with rotations, one without, one that is fixed, one that moves along z alone, one that stands twice in the list of rows.
    fn nodes() -> BodyNodes {
        let dofs = |node: i64, dofs: std::ops::Range<usize>| dofs.map(move |dof| DofLabel { node, dof });
        let all = [dofs(1, 0..6), dofs(2, 0..3), dofs(3, 0..3), dofs(4, 2..3), dofs(5, 0..3), dofs(5, 0..3)];
        let labels: Vec<DofLabel> = all.into_iter().flatten().collect();
        let diagonal = |value: f64| {
            let mut matrix = TriMat::new((labels.len(), labels.len()));
            (0..labels.len()).filter(|row| labels[*row].node != 3).for_each(|row| matrix.add_triplet(row, row, value));
            matrix.to_csr()
        };
        let matrices =
            ModelMatrices { mass: diagonal(1.0), stiffness: diagonal(1e6), damping: None, labels: labels.clone() };
        let model = FeModel::new(matrices, InterfacePoints::default()).expect("valid");
        let places = (1..6).map(|node| (node, [node as f64, 0.0, 0.0])).collect();
        BodyNodes::new(&model.with_positions(places, 1.0)).expect("valid")
    }

    fn point(nodes: &[i64]) -> WeightedNodes {
        WeightedNodes::new(nodes, None).expect("valid")
    }

    #[test]
    fn faults_name_the_node() {
        let nodes = nodes();
        let fault = |node: i64| nodes.place_m(&point(&[1, node])).expect_err("a fault");
        assert!(fault(3).contains("node 3, which has no degrees of freedom"), "{}", fault(3));
        assert!(fault(5).contains("node 5, which has a direction twice"), "{}", fault(5));
        assert!(fault(6).contains("node 6, which the model does not have"), "{}", fault(6));
        let sideways = nodes.motion(&point(&[1, 4]), [1.0, 0.0, 0.0]).expect_err("a fault");
        assert!(sideways.contains("node 4, which has no degree of freedom along (1, 0, 0)"), "{sideways}");
        assert_eq!(nodes.motion(&point(&[1, 4]), [0.0, 0.0, -1.0]), Ok(vec![(2, -0.5), (12, -0.5)]));
    }

    #[test]
    fn places_are_weighted_means_and_shells_rotate() {
        let nodes = nodes();
        let [first, second] = [1, 2].map(|node| nodes.place_m(&point(&[node])).expect("known"));
        assert!((second[0] - first[0] - 1.0).abs() < 1e-15);
        let both = nodes.place_m(&point(&[1, 2])).expect("known");
        assert_eq!(both[0], 0.5 * first[0] + 0.5 * second[0]);
        let solid = [1, 2].map(|node| nodes.single_solid(&point(&[node])));
        assert_eq!((solid, nodes.single_solid(&point(&[1, 2]))), ([None, Some(2)], None));
    }
}
