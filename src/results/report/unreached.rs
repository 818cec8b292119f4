use std::collections::BTreeMap;
use std::fmt;

use super::aggregate::Cell;

/// Above this share of starts that a driver does not reach, its figures say little.
const MOST: f64 = 0.05;

/// A driver that often does not reach the starts of its episodes, as one that does not follow its route.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unreached {
    pub policy: String,
    pub town: String,
    /// Starts that it did not reach within the time of a run-up.
    pub placed: u64,
    /// All its episodes there.
    pub episodes: u64,
}

impl fmt::Display for Unreached {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { policy, town, placed, episodes } = self;
        write!(
            f,
            "`{policy}` did not reach its start in {placed} of {episodes} run-ups in {town}, and was placed there at rest: see whether it follows its route, \
             its figures there say little"
        )
    }
}

/// The drivers that do not reach more than a twentieth of their starts in a town.
pub fn unreached(cells: &[Cell]) -> Vec<Unreached> {
    let mut sums: BTreeMap<(&str, &str), (u64, u64)> = BTreeMap::new();
    for cell in cells {
        let (placed, episodes) = sums.entry((&cell.key.policy, &cell.key.town)).or_default();
        *placed += u64::from(cell.placed);
        *episodes += u64::from(cell.episodes);
    }
    let often = |(_, (placed, episodes)): &(_, (u64, u64))| *placed as f64 > MOST * *episodes as f64;
    let found = sums.into_iter().filter(often);
    found
        .map(|((policy, town), (placed, episodes))| Unreached {
            policy: policy.into(),
            town: town.into(),
            placed,
            episodes,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::CellKey;

    #[test]
    fn a_driver_that_misses_more_than_a_twentieth_of_its_starts_is_named_once() {
        let cell = |policy: &str, controller: &str, placed: u32| Cell {
            key: CellKey {
                policy: policy.into(),
                town: "a".into(),
                controller: controller.into(),
                ..CellKey::default()
            },
            placed,
            episodes: 100,
            ..Cell::default()
        };
        let cells = [cell("lost", "random", 100), cell("lost", "homing", 90), cell("good", "random", 5)];
        let found = unreached(&cells);
        assert_eq!(found.len(), 1);
        assert!(found[0].to_string().starts_with("`lost` did not reach its start in 190 of 200 run-ups in a"));
    }
}
