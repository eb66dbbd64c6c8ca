//! Points that are nodes of a finite element model.

use std::collections::HashSet;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::parameter::short;

/// Weights whose sum is 1 up to this error stay as they are: the weights of another point give the same bits.
const SUM_ERROR: f64 = 1e-12;

/// Nodes with weights: a point that moves by `u = sum w_i u_i`. A force on it acts on the nodes with the same weights.
///
/// Weights are positive and sum to 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WeightedNodes(Vec<(i64, f64)>);

/// Nodes of a point as a study gives them: `12`, `[12, 13]` or `{ nodes = [12, 13], weights = [1, 2] }`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a node, a list of nodes, or `{ nodes = [12, 13], weights = [1, 2] }`")]
pub enum NodesEntry {
    /// One node.
    One(i64),
    /// Nodes with equal weights.
    Equal(Vec<i64>),
    /// Nodes, each with its weight.
    Weighted {
        /// Numbers of the nodes.
        nodes: Vec<i64>,
        /// Weights of the nodes, positive. Only their ratios matter.
        weights: Vec<f64>,
    },
}

impl NodesEntry {
    /// The nodes with their weights.
    ///
    /// # Errors
    /// As for [`WeightedNodes::new`].
    pub fn weighted(&self) -> Result<WeightedNodes, String> {
        match self {
            Self::One(node) => WeightedNodes::new(&[*node], None),
            Self::Equal(nodes) => WeightedNodes::new(nodes, None),
            Self::Weighted { nodes, weights } => WeightedNodes::new(nodes, Some(weights)),
        }
    }
}

impl WeightedNodes {
    /// Nodes with weights of any sum, which are divided by it; without weights all nodes have the same.
    ///
    /// # Errors
    /// The fault in words: no node, a node twice, another number of weights than nodes, a weight that is not positive.
    pub fn new(nodes: &[i64], weights: Option<&[f64]>) -> Result<Self, String> {
        if nodes.is_empty() {
            return Err("needs at least one node".to_owned());
        }
        let mut seen = HashSet::new();
        if let Some(twice) = nodes.iter().find(|node| !seen.insert(**node)) {
            return Err(format!("has node {twice} twice: name each node once"));
        }
        let weights = weights.map_or_else(|| vec![1.0; nodes.len()], <[f64]>::to_vec);
        if weights.len() != nodes.len() {
            return Err(format!("has {} nodes but {} weights: give one weight per node", nodes.len(), weights.len()));
        }
        let is_weight = |weight: f64| weight.is_finite() && weight > 0.0;
        let fault = |at: usize| {
            let (weight, node) = (short(weights[at]), nodes[at]);
            format!("has the weight {weight} of node {node}: expected a positive number, not too far from the others")
        };
        if let Some(at) = weights.iter().position(|weight| !is_weight(*weight)) {
            return Err(fault(at));
        }
        let sum: f64 = weights.iter().sum();
        let share = |weight: &f64| if (sum - 1.0).abs() <= SUM_ERROR { *weight } else { weight / sum };
        let shares: Vec<f64> = weights.iter().map(share).collect();
        // The sum of huge weights is not finite, and beside them a small share is 0.
        match shares.iter().position(|share| !is_weight(*share)) {
            Some(at) => Err(fault(at)),
            None => Ok(Self(nodes.iter().copied().zip(shares).collect())),
        }
    }

    /// Numbers and weights of the nodes.
    pub fn iter(&self) -> impl Iterator<Item = (i64, f64)> {
        self.0.iter().copied()
    }

    /// The node, if it is only one.
    pub fn single(&self) -> Option<i64> {
        match self.0[..] {
            [(node, _)] => Some(node),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_keep_their_bits() {
        let shares = |nodes: &WeightedNodes| nodes.iter().map(|(_, share)| share).collect::<Vec<_>>();
        let equal = WeightedNodes::new(&[12, 13, 14, 15], None).expect("valid");
        assert_eq!((shares(&equal), equal.single()), (vec![0.25; 4], None));
        let given = WeightedNodes::new(&[12, -13], Some(&[1.0, 3.0])).expect("valid");
        assert_eq!(given.iter().collect::<Vec<_>>(), [(12, 0.25), (-13, 0.75)]);
        assert_eq!(WeightedNodes::new(&[7], Some(&[0.3])).expect("valid").iter().next(), Some((7, 1.0)));
        // Ten times 0.1 add up to a little less than 1.
        let tenths = [0.1; 10];
        assert!(tenths.iter().sum::<f64>() != 1.0);
        let again = WeightedNodes::new(&(0..10).collect::<Vec<_>>(), Some(&tenths)).expect("valid");
        assert_eq!(shares(&again), tenths);
    }

    #[test]
    fn faults_of_nodes_and_weights() {
        let fails = |nodes: &[i64], weights: Option<&[f64]>, wanted: &str| {
            let fault = WeightedNodes::new(nodes, weights).expect_err(wanted);
            assert!(fault.contains(wanted), "{fault}");
        };
        fails(&[], None, "at least one node");
        fails(&[1, 2, 1], None, "node 1 twice");
        fails(&[1, 2], Some(&[1.0]), "2 nodes but 1 weights");
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            fails(&[1, 2], Some(&[1.0, bad]), "of node 2: expected a positive number");
        }
        // Their sum overflows; a share is lost.
        fails(&[1, 2], Some(&[1e308, 1e308]), "the weight 1e308 of node 1");
        fails(&[1, 2], Some(&[1e300, 1e-300]), "of node 2");
    }
}
