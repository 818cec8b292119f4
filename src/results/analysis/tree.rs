use serde::Deserialize;
use smartcore::linalg::basic::matrix::DenseMatrix;
use smartcore::tree::decision_tree_classifier::{
    DecisionTreeClassifier, DecisionTreeClassifierParameters, SplitCriterion,
};

use super::Cases;

/// A split with its two branches, or a leaf.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Node {
    /// Whether a feature is at most a value, and the next node for either answer.
    Split {
        feature: usize,
        value: f64,
        at_most: usize,
        above: usize,
    },
    Leaf,
}

/// A classification tree (CART, Gini); node 0 is the root.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
}

/// smartcore hides the nodes of a tree; this is their serialised form.
#[derive(Deserialize)]
struct Written {
    nodes: Vec<WrittenNode>,
}

#[derive(Deserialize)]
struct WrittenNode {
    split_feature: usize,
    split_value: Option<f64>,
    true_child: Option<usize>,
    false_child: Option<usize>,
}

impl Tree {
    /// Learns a tree of at most this depth from some of the cases; only a root when these all have the same outcome.
    pub(super) fn learn(cases: &Cases, places: &[usize], depth: u16, least: usize) -> Self {
        Self::fitted(cases, places, depth, least).unwrap_or(Self { nodes: vec![Node::Leaf] })
    }

    fn fitted(cases: &Cases, places: &[usize], depth: u16, least: usize) -> Option<Self> {
        let rows: Vec<Vec<f64>> = places.iter().map(|place| cases.rows[*place].clone()).collect();
        let classes: Vec<u32> = places.iter().map(|place| u32::from(cases.hits[*place])).collect();
        if classes.iter().all(|class| *class == classes[0]) {
            return None;
        }
        let parameters = DecisionTreeClassifierParameters {
            criterion: SplitCriterion::Gini,
            // smartcore counts the root as a level.
            max_depth: Some(depth + 1),
            min_samples_leaf: least,
            min_samples_split: 2 * least,
            seed: Some(0),
        };
        let tree = DecisionTreeClassifier::fit(&DenseMatrix::from_2d_vec(&rows).ok()?, &classes, parameters).ok()?;
        let written: Written = serde_json::from_value(serde_json::to_value(&tree).ok()?).ok()?;
        let node = |node: &WrittenNode| match (node.split_value, node.true_child, node.false_child) {
            (Some(value), Some(at_most), Some(above)) => {
                Node::Split { feature: node.split_feature, value, at_most, above }
            }
            _ => Node::Leaf,
        };
        Some(Self { nodes: written.nodes.iter().map(node).collect() })
    }

    pub(super) fn leaf(&self, row: &[f64]) -> usize {
        let mut at = 0;
        while let Node::Split { feature, value, at_most, above } = self.nodes[at] {
            at = if row[feature] <= value { at_most } else { above };
        }
        at
    }

    /// Removes splits between two leaves that are not distinct by `differ`, until there are none.
    pub(super) fn prune(&mut self, differ: &dyn Fn(&Self, usize, usize) -> bool) {
        loop {
            let useless = self.nodes.iter().position(|node| match *node {
                Node::Split { at_most, above, .. } => {
                    let leaves = self.nodes[at_most] == Node::Leaf && self.nodes[above] == Node::Leaf;
                    leaves && !differ(self, at_most, above)
                }
                Node::Leaf => false,
            });
            let Some(useless) = useless else { return };
            self.nodes[useless] = Node::Leaf;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{numbers, recorded};
    use super::super::{Feature, Scale};
    use super::*;

    fn recorded_cases(record: &serde_json::Value) -> Cases {
        let rows: Vec<Vec<f64>> = record["rows"].as_array().unwrap().iter().map(numbers).collect();
        Cases {
            features: vec![Feature { name: "x", scale: Scale::Number("m") }; 3],
            episodes: (0..).take(rows.len()).collect(),
            hits: numbers(&record["hits"]).iter().map(|hit| *hit > 0.0).collect(),
            rows,
        }
    }

    /// The splits and the leaves, depth first.
    fn walked(tree: &Tree, at: usize, splits: &mut Vec<(usize, f64)>, leaves: &mut Vec<usize>) {
        match tree.nodes[at] {
            Node::Split { feature, value, at_most, above } => {
                splits.push((feature, value));
                walked(tree, at_most, splits, leaves);
                walked(tree, above, splits, leaves);
            }
            Node::Leaf => leaves.push(at),
        }
    }

    /// Also checks the serialised form of smartcore's trees, which smartcore does not guarantee. With a bound on the leaves the two
    /// libraries differ: smartcore splits only between rows of different outcome, where the best split is when there is no bound.
    #[test]
    fn a_tree_is_the_one_of_scikit_learn() {
        let record = &recorded()["tree"];
        let cases = recorded_cases(record);
        let all: Vec<usize> = (0..cases.rows.len()).collect();
        let tree = Tree::learn(&cases, &all, 3, 1);
        let (mut splits, mut leaves) = (Vec::new(), Vec::new());
        walked(&tree, 0, &mut splits, &mut leaves);
        let wanted: Vec<Vec<f64>> = record["splits"].as_array().unwrap().iter().map(numbers).collect();
        assert_eq!(splits.len(), wanted.len(), "{splits:?}");
        for (found, wanted) in splits.iter().zip(&wanted) {
            // scikit-learn stores features in 32 bits.
            assert!(found.0 == wanted[0] as usize && (found.1 - wanted[1]).abs() < 1e-4, "{splits:?}");
        }
        for (leaf, wanted) in leaves.iter().zip(record["leaves"].as_array().unwrap()) {
            let members: Vec<usize> = all.iter().copied().filter(|row| tree.leaf(&cases.rows[*row]) == *leaf).collect();
            let (hits, rows) = cases.count(&members);
            assert_eq!(vec![hits as f64, rows as f64], numbers(wanted));
        }
    }

    #[test]
    fn one_outcome_makes_a_bare_root_and_pruning_comes_to_one() {
        let mut cases = recorded_cases(&recorded()["tree"]);
        let all: Vec<usize> = (0..cases.rows.len()).collect();
        let mut tree = Tree::learn(&cases, &all, 3, 15);
        tree.prune(&|_, _, _| false);
        assert_eq!(tree.nodes[0], Node::Leaf);
        cases.hits.fill(true);
        assert_eq!(Tree::learn(&cases, &all, 3, 15).nodes, [Node::Leaf]);
    }
}
