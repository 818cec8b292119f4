//! Classification trees: which questions about some numbers tell the outcome.

/// A classification tree.
///
/// # Source
/// CART (Breiman et al. 1984) with Gini's impurity. A split is half-way between two rows.
#[derive(Debug, Clone, PartialEq)]
pub enum ClassificationTree {
    /// Whether a feature is at most a value, and the tree for either answer.
    Split { feature: usize, value: f64, at_most: Box<Self>, above: Box<Self> },
    /// The more frequent outcome.
    Leaf(bool),
}

impl ClassificationTree {
    /// Learns a tree of at most this depth, with at least this number of rows in a leaf, from rows of equal length and whether each is a hit. A mere leaf
    /// if all have the same outcome.
    pub fn learn(rows: &[Vec<f64>], hits: &[bool], depth: u16, min_rows: usize) -> Self {
        Self::of(rows.iter().map(Vec::as_slice).zip(hits.iter().copied()).collect(), depth, min_rows)
    }

    fn of(rows: Vec<(&[f64], bool)>, depth: u16, min_rows: usize) -> Self {
        match best_split(rows.clone(), min_rows).filter(|_| depth > 0) {
            Some((feature, value)) => {
                let (at_most, above) = rows.into_iter().partition(|(row, _)| row[feature] <= value);
                let [at_most, above] = [at_most, above].map(|rows| Self::of(rows, depth - 1, min_rows).into());
                Self::Split { feature, value, at_most, above }
            }
            None => Self::Leaf(2 * rows.iter().filter(|(_, hit)| *hit).count() > rows.len()),
        }
    }

    /// The ways to the leaves that say `true`: each split with whether its feature is at most the value.
    pub fn hits(&self) -> Vec<Vec<(usize, f64, bool)>> {
        match self {
            Self::Split { feature, value, at_most, above } => {
                let behind = |tree: &Self, answer| {
                    let ways = tree.hits().into_iter();
                    ways.map(move |way| [vec![(*feature, *value, answer)], way].concat()).collect::<Vec<_>>()
                };
                [behind(at_most, true), behind(above, false)].concat()
            }
            Self::Leaf(true) => vec![Vec::new()],
            Self::Leaf(false) => Vec::new(),
        }
    }
}

/// The feature and the value that leave the least impurity; `None` if no split leaves enough rows on both sides, or if all have the same outcome.
fn best_split(mut rows: Vec<(&[f64], bool)>, min_rows: usize) -> Option<(usize, f64)> {
    let (all, all_hits) = (rows.len(), rows.iter().filter(|(_, hit)| *hit).count());
    let impurity = |rows: usize, hits: usize| (hits * (rows - hits)) as f64 / rows as f64;
    if all_hits == 0 || all_hits == all {
        return None;
    }
    let (mut best, mut least) = (None, f64::INFINITY);
    for feature in 0..rows.first()?.0.len() {
        rows.sort_by(|(a, _), (b, _)| a[feature].total_cmp(&b[feature]));
        let mut hits = 0;
        for (count, pair) in (1..).zip(rows.windows(2)) {
            let ((row, hit), (next, _)) = (pair[0], pair[1]);
            hits += usize::from(hit);
            if row[feature] < next[feature] && min_rows <= count && min_rows <= all - count {
                let left = impurity(count, hits) + impurity(all - count, all_hits - hits);
                if left < least {
                    (best, least) = (Some((feature, (row[feature] + next[feature]) / 2.0)), left);
                }
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    fn numbers(value: &Value) -> Vec<f64> {
        value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
    }

    /// The splits, depth first.
    fn splits(tree: &ClassificationTree) -> Vec<(usize, f64)> {
        match tree {
            ClassificationTree::Split { feature, value, at_most, above } => {
                [vec![(*feature, *value)], splits(at_most), splits(above)].concat()
            }
            ClassificationTree::Leaf(_) => Vec::new(),
        }
    }

    #[test]
    fn a_tree_is_the_one_of_scikit_learn() {
        let record = include_str!("../../tests/reference/classification_tree/values.json");
        let record: Value = serde_json::from_str(record).unwrap();
        let rows: Vec<Vec<f64>> = record["rows"].as_array().unwrap().iter().map(numbers).collect();
        let hits: Vec<bool> = numbers(&record["hits"]).iter().map(|hit| *hit > 0.0).collect();
        for (min_rows, record) in [(1, &record["splits"]), (8, &record["bounded"])] {
            let splits = splits(&ClassificationTree::learn(&rows, &hits, 3, min_rows));
            let wanted: Vec<Vec<f64>> = record.as_array().unwrap().iter().map(numbers).collect();
            assert_eq!(splits.len(), wanted.len(), "{splits:?}");
            for (found, wanted) in splits.iter().zip(&wanted) {
                // scikit-learn stores features in 32 bits.
                assert!(found.0 == wanted[0] as usize && (found.1 - wanted[1]).abs() < 1e-4, "{splits:?}");
            }
        }
        let one = ClassificationTree::learn(&rows, &vec![true; rows.len()], 3, 15);
        let tree = ClassificationTree::learn(&rows, &hits, 40, 1);
        let is_on = |way: &Vec<(usize, f64, bool)>, row: &[f64]| {
            way.iter().all(|(feature, value, at_most)| (row[*feature] <= *value) == *at_most)
        };
        let said = rows.iter().map(|row| tree.hits().iter().any(|way| is_on(way, row)));
        let wrong = said.zip(&hits).filter(|(said, hit)| said != *hit).count();
        assert_eq!(wrong, 0, "a deep tree tells all rows that it learnt");
        assert_eq!(one, ClassificationTree::Leaf(true), "one outcome makes a mere leaf");
    }
}
