//! Classification trees: which questions about some numbers tell the outcome. The only code that knows smartcore.

use serde::Deserialize;
use smartcore::linalg::basic::matrix::DenseMatrix;
use smartcore::tree::decision_tree_classifier::{
    DecisionTreeClassifier, DecisionTreeClassifierParameters, SplitCriterion,
};

/// A split with its two branches, or a leaf.
#[derive(Debug, Clone, PartialEq)]
pub enum Node {
    /// Whether a feature is at most a value, and the next node for either answer.
    Split { feature: usize, value: f64, at_most: usize, above: usize },
    /// The more frequent outcome.
    Leaf(bool),
}

/// A classification tree (CART, Gini); node 0 is the root.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassificationTree {
    pub nodes: Vec<Node>,
}

/// smartcore hides the nodes of a tree; this is their serialised form.
#[derive(Deserialize)]
struct Written {
    nodes: Vec<WrittenNode>,
}

#[derive(Deserialize)]
struct WrittenNode {
    output: usize,
    split_feature: usize,
    split_value: Option<f64>,
    true_child: Option<usize>,
    false_child: Option<usize>,
}

impl ClassificationTree {
    /// Learns a tree of at most this depth, with at least this number of rows in a leaf, from rows of equal length and whether each is a hit. A mere root
    /// if all have the same outcome.
    pub fn learn(rows: &[Vec<f64>], hits: &[bool], depth: u16, min_rows: usize) -> Self {
        Self::fitted(rows, hits, depth, min_rows)
            .unwrap_or_else(|| Self { nodes: vec![Node::Leaf(hits.first() == Some(&true))] })
    }

    /// The ways to the leaves that say `true`: each split with whether its feature is at most the value.
    pub fn hits(&self) -> Vec<Vec<(usize, f64, bool)>> {
        let (mut found, mut open) = (Vec::new(), vec![(0, Vec::new())]);
        while let Some((node, way)) = open.pop() {
            match self.nodes[node] {
                Node::Split { feature, value, at_most, above } => {
                    let next = |is_at_most| [way.clone(), vec![(feature, value, is_at_most)]].concat();
                    open.extend([(above, next(false)), (at_most, next(true))]);
                }
                Node::Leaf(true) => found.push(way),
                Node::Leaf(false) => {}
            }
        }
        found
    }

    fn fitted(rows: &[Vec<f64>], hits: &[bool], depth: u16, min_rows: usize) -> Option<Self> {
        if hits.iter().all(|hit| *hit == hits[0]) {
            return None;
        }
        let parameters = DecisionTreeClassifierParameters {
            criterion: SplitCriterion::Gini,
            // smartcore counts the root as a level.
            max_depth: Some(depth + 1),
            min_samples_leaf: min_rows,
            min_samples_split: 2 * min_rows,
            seed: Some(0),
        };
        let classes: Vec<u32> = hits.iter().map(|hit| u32::from(*hit)).collect();
        let matrix = DenseMatrix::from_2d_vec(&rows.to_vec()).ok()?;
        let tree = DecisionTreeClassifier::fit(&matrix, &classes, parameters).ok()?;
        let written: Written = serde_json::from_value(serde_json::to_value(&tree).ok()?).ok()?;
        let node = |node: &WrittenNode| match (node.split_value, node.true_child, node.false_child) {
            (Some(value), Some(at_most), Some(above)) => {
                Node::Split { feature: node.split_feature, value, at_most, above }
            }
            // Both outcomes are there: `false` is the first class.
            _ => Node::Leaf(node.output == 1),
        };
        Some(Self { nodes: written.nodes.iter().map(node).collect() })
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    fn numbers(value: &Value) -> Vec<f64> {
        value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
    }

    /// The splits, depth first.
    fn walked(tree: &ClassificationTree, at: usize, splits: &mut Vec<(usize, f64)>) {
        if let Node::Split { feature, value, at_most, above } = tree.nodes[at] {
            splits.push((feature, value));
            walked(tree, at_most, splits);
            walked(tree, above, splits);
        }
    }

    /// Also checks the serialised form of smartcore's trees, which smartcore does not guarantee. With a bound on the leaves the two
    /// libraries differ: smartcore splits only between rows of different outcome, where the best split is when there is no bound.
    #[test]
    fn a_tree_is_the_one_of_scikit_learn() {
        let record = include_str!("../../tests/reference/classification_tree/values.json");
        let record: Value = serde_json::from_str(record).unwrap();
        let rows: Vec<Vec<f64>> = record["rows"].as_array().unwrap().iter().map(numbers).collect();
        let hits: Vec<bool> = numbers(&record["hits"]).iter().map(|hit| *hit > 0.0).collect();
        let mut splits = Vec::new();
        walked(&ClassificationTree::learn(&rows, &hits, 3, 1), 0, &mut splits);
        let wanted: Vec<Vec<f64>> = record["splits"].as_array().unwrap().iter().map(numbers).collect();
        assert_eq!(splits.len(), wanted.len(), "{splits:?}");
        for (found, wanted) in splits.iter().zip(&wanted) {
            // scikit-learn stores features in 32 bits.
            assert!(found.0 == wanted[0] as usize && (found.1 - wanted[1]).abs() < 1e-4, "{splits:?}");
        }
        let one = ClassificationTree::learn(&rows, &vec![true; rows.len()], 3, 15);
        let tree = ClassificationTree::learn(&rows, &hits, 40, 1);
        let is_on = |way: &Vec<(usize, f64, bool)>, row: &[f64]| {
            way.iter().all(|(feature, value, at_most)| (row[*feature] <= *value) == *at_most)
        };
        let said = rows.iter().map(|row| tree.hits().iter().any(|way| is_on(way, row)));
        let wrong = said.zip(&hits).filter(|(said, hit)| said != *hit).count();
        assert_eq!(wrong, 0, "a deep tree tells all rows that it learnt");
        assert_eq!(one.nodes, [Node::Leaf(true)], "one outcome makes a mere root");
    }
}
