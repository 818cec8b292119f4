use std::collections::BTreeMap;
use std::fmt;

use crate::jobs::SearchResult;
use crate::record::columns::{DRIVER, TOWN, WORLD};
use crate::record::in_world;
use crate::tables::metrics::{ALL_EPISODES, LEFT_OUT_EPISODES, LEFT_ROAD_EPISODES, PLACED_STARTS, ROAD_END_EPISODES};
use crate::tables::{Cells, Metric};

/// Above this fraction of episodes in which a driver is off the road, its figures say little.
const MAX_FRACTION: f64 = 0.05;

/// A driver that often does not reach the starts of its episodes or leaves the road, as one that does not follow its route.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct OffRoadDriver {
    pub policy: String,
    /// The town, with the simulator if that is another one.
    pub place: String,
    /// Its episodes in evaluations there.
    pub episodes: u64,
    /// The number of these whose start it did not reach within the time of a run-up.
    pub placed: u64,
    /// The number of these in which its car left the road.
    pub left_road: u64,
    /// The number of these in which its car drove past the end of the road.
    pub road_end: u64,
    /// The number of these that are in no rate.
    pub left_out: u64,
    /// The same of the episodes of searches, and the number of all of these.
    pub searched: (u64, u64),
}

impl OffRoadDriver {
    /// Whether one of its shares is above a twentieth.
    fn is_often_off_road(&self) -> bool {
        let often = |part: u64, whole: u64| part as f64 > MAX_FRACTION * whole as f64;
        often(self.placed.max(self.left_road), self.episodes) || often(self.searched.0, self.searched.1)
    }
}

impl fmt::Display for OffRoadDriver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { policy, place, episodes, placed, left_road, road_end, left_out, searched } = self;
        let mut what = Vec::new();
        if *placed > 0 {
            what.push(format!("did not reach its start in {placed} of {episodes} run-ups"));
        }
        if left_road > road_end {
            what.push(format!("left the road in {} of {episodes} episodes", left_road - road_end));
        }
        if *road_end > 0 {
            what.push(format!("drove past the end of the road in {road_end} of {episodes} episodes"));
        }
        if searched.0 > 0 {
            what.push(format!(
                "was lost before it could see a pedestrian in {} of {} episodes of searches",
                searched.0, searched.1
            ));
        }
        let advice = if 2 * road_end > *left_road {
            "make the road longer, or start farther from its end"
        } else {
            "see whether it follows its route"
        };
        write!(f, "`{policy}` in {place} {}: {advice}", what.join(" and "))?;
        let is_mostly_lost = 2 * left_road.max(placed) > *episodes;
        match (left_out, episodes - left_out) {
            (0, _) if is_mostly_lost => write!(f, "; its figures there say little"),
            (0, _) => Ok(()),
            (_, 0) => write!(f, "; none of its episodes counts, so it has no rates there"),
            (_, counted) => write!(f, "; its rates there are those of the {counted} episodes that count"),
        }?;
        // A car in a ditch hits nobody.
        if left_road > road_end && episodes > left_out {
            let joint = if *left_out == 0 && !is_mostly_lost { ";" } else { ", and" };
            write!(f, "{joint} to leave the road is not a failure in them: `left_road_rate > 0.05` is a gate")?;
        }
        Ok(())
    }
}

/// The drivers that are lost in more than a twentieth of their episodes in a town: of evaluations or of searches.
pub fn off_road(cells: &Cells, searches: &[SearchResult]) -> Vec<OffRoadDriver> {
    let mut sums: BTreeMap<(String, String), OffRoadDriver> = BTreeMap::new();
    let mut at = |policy: &String, place: String, add: &dyn Fn(&mut OffRoadDriver)| {
        let none = OffRoadDriver { policy: policy.clone(), place: place.clone(), ..OffRoadDriver::default() };
        add(sums.entry((policy.clone(), place)).or_insert(none));
    };
    const COUNTS: [&Metric; 5] =
        [&ALL_EPISODES, &PLACED_STARTS, &LEFT_ROAD_EPISODES, &ROAD_END_EPISODES, &LEFT_OUT_EPISODES];
    for row in cells.sums(&[DRIVER, TOWN, WORLD], &COUNTS).iter() {
        let [episodes, placed, left_road, road_end, left_out] = COUNTS.map(|count| row.whole_number(count.name));
        at(&row.text(&DRIVER), in_world(&row.text(&TOWN), &row.text(&WORLD)), &|driver| {
            *driver = OffRoadDriver { episodes, placed, left_road, road_end, left_out, ..driver.clone() };
        });
    }
    for SearchResult { key, spent, .. } in searches {
        at(&key.policy, key.town.clone(), &|driver| {
            driver.searched.0 += spent.left_out;
            driver.searched.1 += spent.left_out + spent.episodes;
        });
    }
    sums.into_values().filter(OffRoadDriver::is_often_off_road).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::CellKey;
    use crate::tables::Cell;

    #[test]
    fn a_driver_that_is_lost_in_more_than_a_twentieth_of_its_episodes_is_named_once() {
        let cell = |world: &str, policy: &str, controller: &str, [placed, left_road, road_end]: [u32; 3]| {
            let [policy, town, controller, world] = [policy, "a", controller, world].map(String::from);
            let key = CellKey { policy, town, controller, world, ..CellKey::default() };
            let counts = [
                (&ALL_EPISODES, 100),
                (&PLACED_STARTS, placed),
                (&LEFT_ROAD_EPISODES, left_road),
                (&ROAD_END_EPISODES, road_end),
                (&LEFT_OUT_EPISODES, placed.max(road_end)),
            ];
            Cell::example(key, &counts, &[])
        };
        let cells = Cells::example(&[
            cell("", "lost", "random", [100, 0, 0]),
            cell("", "lost", "homing", [90, 6, 0]),
            cell("", "good", "random", [5, 5, 0]),
            cell("there", "good", "random", [0, 7, 0]),
            cell("", "stray", "random", [0, 6, 0]),
            cell("", "far", "random", [0, 10, 9]),
        ]);
        let found: Vec<String> = off_road(&cells, &[]).iter().map(ToString::to_string).collect();
        assert_eq!(
            found,
            [
                "`far` in a left the road in 1 of 100 episodes and drove past the end of the road in 9 of 100 episodes: make the road longer, or start \
                 farther from its end; its rates there are those of the 91 episodes that count, and to leave the road is not a failure in them: \
                 `left_road_rate > 0.05` is a gate",
                "`good` in a (there) left the road in 7 of 100 episodes: see whether it follows its route; to leave the road is not a failure in \
                 them: `left_road_rate > 0.05` is a gate",
                "`lost` in a did not reach its start in 190 of 200 run-ups and left the road in 6 of 200 episodes: see whether it follows its \
                 route; its rates there are those of the 10 episodes that count, and to leave the road is not a failure in them: `left_road_rate > 0.05` is a \
                 gate",
                "`stray` in a left the road in 6 of 100 episodes: see whether it follows its route; to leave the road is not a \
                 failure in them: `left_road_rate > 0.05` is a gate",
            ]
        );
    }
}
