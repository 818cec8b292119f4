use std::fmt;

use super::tree::{Node, Tree};
use super::{Cases, Feature, Scale};

/// Largest depth of the tree.
const DEPTH: u16 = 3;
/// A rule covers at least this share and this number of the episodes.
const LEAST: (f64, usize) = (0.05, 15);
/// Number of episodes of either outcome that learning needs.
const FEW: u64 = 20;
/// Two sides of a split are distinct if their χ² with one degree of freedom exceeds this. It is the value of 0.1 %, since the split is the
/// best of many.
const TOLD_APART: f64 = 10.83;

/// One side of a split.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    pub feature: Feature,
    /// The feature is above this; minus infinity when there is no bound.
    pub above: f64,
    /// The feature is at most this; infinity when there is no bound.
    pub at_most: f64,
}

/// Words it as `distance <= 15.0 m`, or as `hidden at the start`.
impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.feature.name;
        match self.feature.scale {
            Scale::Truth(_) if self.above > f64::NEG_INFINITY => f.write_str(name),
            Scale::Truth(not) => f.write_str(not),
            Scale::Number(unit) if self.above == f64::NEG_INFINITY => write!(f, "{name} <= {:.1} {unit}", self.at_most),
            Scale::Number(unit) if self.at_most == f64::INFINITY => write!(f, "{name} > {:.1} {unit}", self.above),
            Scale::Number(unit) => write!(f, "{name} {:.1} to {:.1} {unit}", self.above, self.at_most),
        }
    }
}

/// The expected outcome of some starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Which ones: all of these hold.
    pub conditions: Vec<Condition>,
    /// Hits and episodes from which it was learnt.
    pub learnt: (u64, u64),
    /// Hits and episodes of the other half.
    pub held_out: (u64, u64),
}

/// Words its conditions; `always` without conditions.
impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<String> = self.conditions.iter().map(Condition::to_string).collect();
        f.write_str(if words.is_empty() { "always" } else { "" })?;
        f.write_str(&words.join(" and "))
    }
}

/// The starts that end in the outcome to explain, as a small tree. It is learnt from episodes with even numbers and tested on those with
/// odd ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Explanation {
    /// Hits and episodes of both halves.
    pub overall: (u64, u64),
    /// The leaves of the tree, the most dangerous first: each start satisfies one of them.
    pub rules: Vec<Rule>,
    /// Share of the held-out episodes whose outcome the tree predicts.
    pub accuracy: f64,
    /// Share of them that is predicted by always naming the more frequent outcome of the learning half.
    pub majority: f64,
    /// Share of the held-out outcomes' variance that the rules' rates explain (Brier skill). It is 0 or less when they explain nothing.
    pub skill: f64,
}

impl Explanation {
    /// Explains; `None` if there are too few episodes of either outcome to learn from or to test on.
    ///
    /// # Source
    /// Breiman et al., *Classification and Regression Trees*, 1984.
    pub fn new(cases: &Cases) -> Option<Self> {
        let (learn, test) = cases.halves();
        let few = |places: &[usize]| {
            let (hits, all) = cases.count(places);
            hits < FEW || all - hits < FEW
        };
        if few(&learn) || few(&test) {
            return None;
        }
        let least = ((learn.len() as f64 * LEAST.0) as usize).max(LEAST.1);
        let mut tree = Tree::learn(cases, &learn, DEPTH, least);
        tree.prune(&|tree, a, b| {
            let side = |leaf| {
                let there: Vec<usize> =
                    learn.iter().copied().filter(|place| tree.leaf(&cases.rows[*place]) == leaf).collect();
                cases.count(&there)
            };
            chi_squared(side(a), side(b)) >= TOLD_APART
        });
        let forecast = Forecast::new(&tree, cases, &learn);
        let mut rules = rules(&tree, cases, &learn, &test);
        let rate = |rule: &Rule| rule.learnt.0 as f64 / rule.learnt.1 as f64;
        rules.sort_by(|a, b| rate(b).total_cmp(&rate(a)));
        let rows: Vec<&[f64]> = test.iter().map(|place| cases.rows[*place].as_slice()).collect();
        let hits: Vec<bool> = test.iter().map(|place| cases.hits[*place]).collect();
        let (learnt_hits, learnt) = cases.count(&learn);
        let commoner = learnt_hits * 2 > learnt;
        let right = |told: &dyn Fn(&[f64]) -> bool| {
            let right = rows.iter().zip(&hits).filter(|(row, hit)| told(row) == **hit).count();
            right as f64 / rows.len() as f64
        };
        let (hit, all) = (cases.count(&learn), cases.count(&test));
        Some(Self {
            overall: (hit.0 + all.0, hit.1 + all.1),
            rules,
            accuracy: right(&|row| forecast.rate(row) > 0.5),
            majority: right(&|_| commoner),
            skill: forecast.skill(&rows, &hits),
        })
    }
}

/// A tree with the rate of hits at each of its leaves.
struct Forecast<'a> {
    tree: &'a Tree,
    rates: Vec<f64>,
}

impl<'a> Forecast<'a> {
    fn new(tree: &'a Tree, cases: &Cases, places: &[usize]) -> Self {
        let mut counts = vec![(0.0, 0.0); tree.nodes.len()];
        for place in places {
            let count = &mut counts[tree.leaf(&cases.rows[*place])];
            count.0 += f64::from(u8::from(cases.hits[*place]));
            count.1 += 1.0;
        }
        Self { tree, rates: counts.iter().map(|(hits, all)| hits / f64::max(*all, 1.0)).collect() }
    }

    fn rate(&self, row: &[f64]) -> f64 {
        self.rates[self.tree.leaf(row)]
    }

    fn skill(&self, rows: &[&[f64]], hits: &[bool]) -> f64 {
        let outcome = |hit: &bool| f64::from(u8::from(*hit));
        let mean = hits.iter().map(outcome).sum::<f64>() / hits.len() as f64;
        let variance: f64 = hits.iter().map(|hit| (outcome(hit) - mean).powi(2)).sum();
        let error: f64 = rows.iter().zip(hits).map(|(row, hit)| (outcome(hit) - self.rate(row)).powi(2)).sum();
        1.0 - error / variance
    }
}

/// The leaves of a tree with the conditions that lead to them.
fn rules(tree: &Tree, cases: &Cases, learn: &[usize], test: &[usize]) -> Vec<Rule> {
    let mut open = vec![(0, Vec::<(usize, f64, f64)>::new())];
    let mut rules = Vec::new();
    while let Some((at, path)) = open.pop() {
        match tree.nodes[at] {
            Node::Split { feature, value, at_most, above } => {
                open.push((above, narrowed(&path, feature, value, f64::INFINITY)));
                open.push((at_most, narrowed(&path, feature, f64::NEG_INFINITY, value)));
            }
            Node::Leaf => {
                let there = |places: &[usize]| {
                    let there: Vec<usize> =
                        places.iter().copied().filter(|place| tree.leaf(&cases.rows[*place]) == at).collect();
                    cases.count(&there)
                };
                let condition = |(feature, above, at_most): &(usize, f64, f64)| Condition {
                    feature: cases.features[*feature],
                    above: *above,
                    at_most: *at_most,
                };
                rules.push(Rule {
                    conditions: path.iter().map(condition).collect(),
                    learnt: there(learn),
                    held_out: there(test),
                });
            }
        }
    }
    rules
}

/// The conditions with one more; those of one feature become one range.
fn narrowed(path: &[(usize, f64, f64)], feature: usize, above: f64, at_most: f64) -> Vec<(usize, f64, f64)> {
    let mut path = path.to_vec();
    match path.iter_mut().find(|bounds| bounds.0 == feature) {
        Some(bounds) => *bounds = (feature, bounds.1.max(above), bounds.2.min(at_most)),
        None => path.push((feature, above, at_most)),
    }
    path
}

/// Pearson's χ² of two shares, without correction.
fn chi_squared(a: (u64, u64), b: (u64, u64)) -> f64 {
    let (hits_a, all_a, hits_b, all_b) = (a.0 as f64, a.1 as f64, b.0 as f64, b.1 as f64);
    let (hits, all) = (hits_a + hits_b, all_a + all_b);
    let spread = all_a * all_b * hits * (all - hits);
    if spread > 0.0 { all * (hits_a * (all_b - hits_b) - hits_b * (all_a - hits_a)).powi(2) / spread } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use base::seed::Seed;

    const FEATURES: [Feature; 3] = [
        Feature { name: "distance", scale: Scale::Number("m") },
        Feature { name: "noise", scale: Scale::Number("m/s") },
        Feature { name: "hidden", scale: Scale::Truth("in sight") },
    ];

    /// Starts with a hit rate that depends on distance and sight, or on chance alone.
    fn cases(rate: fn(f64, bool) -> f64) -> Cases {
        let mut stream = Seed::root(3).stream();
        let mut all = Cases { features: FEATURES.to_vec(), rows: vec![], episodes: vec![], hits: vec![] };
        for episode in 0..1000 {
            let (distance, noise) = (stream.random_range(7.0..30.0), stream.random_range(0.0..9.0));
            let hidden = stream.random_range(0.0..1.0) < 0.5;
            all.rows.push(vec![distance, noise, f64::from(u8::from(hidden))]);
            all.episodes.push(episode);
            all.hits.push(stream.random_range(0.0..1.0) < rate(distance, hidden));
        }
        all
    }

    #[test]
    fn planted_rules_are_found_and_hold_for_the_other_half() {
        let found = Explanation::new(&cases(|d, hidden| {
            if d > 15.0 {
                0.1
            } else if hidden {
                0.95
            } else {
                0.5
            }
        }))
        .unwrap();
        let words: Vec<String> = found.rules.iter().map(Rule::to_string).collect();
        assert_eq!(found.rules.len(), 3, "{words:?}");
        assert!(words[0].starts_with("distance <= 1") && words[0].ends_with(" m and hidden"), "{words:?}");
        assert!(words[1].ends_with("and in sight") && words[2].starts_with("distance > 1"), "{words:?}");
        for (rule, wanted) in found.rules.iter().zip([0.95, 0.5, 0.1]) {
            let (hits, all) = rule.held_out;
            let rate = hits as f64 / all as f64;
            assert!((rate - wanted).abs() < 3.0 * (0.25 / all as f64).sqrt(), "{rule}: {rate} of {all}");
        }
        assert!(found.accuracy > found.majority + 0.08 && found.skill > 0.3, "{found:?}");
        let counted = found.rules.iter().fold((0, 0), |sum, rule| {
            (sum.0 + rule.learnt.0 + rule.held_out.0, sum.1 + rule.learnt.1 + rule.held_out.1)
        });
        assert_eq!(counted, found.overall, "the rules part the starts");
    }

    #[test]
    fn chance_is_not_explained_and_few_failures_are_not_looked_at() {
        let chance = Explanation::new(&cases(|_, _| 0.4)).unwrap();
        assert_eq!((chance.rules.len(), chance.rules[0].to_string().as_str()), (1, "always"), "{chance:?}");
        assert!(chance.skill.abs() < 0.02);
        assert_eq!(Explanation::new(&cases(|_, _| 0.01)), None);
    }

    #[test]
    fn the_difference_of_shares_is_pearsons() {
        // By hand: 30 of 100 and 45 of 100, expected 37.5: 4 · 7.5²/… = 4.8.
        assert!((chi_squared((30, 100), (45, 100)) - 4.8).abs() < 1e-9);
        assert_eq!(chi_squared((0, 10), (0, 20)), 0.0);
    }
}
