use std::fmt;

use super::aggregate::{DriverResult, SearchCell};
use super::off_road::{OffRoadDriver, off_road};
use super::price::DriverPrice;
use crate::jobs::SearchResult;
use crate::record::columns::{TOWN, WORLD};
use crate::record::in_world;
use crate::tables::metrics::{COLLISIONS, MACHINE_PREVENTABLE_COLLISIONS, UNPREVENTABLE_COLLISIONS};
use crate::tables::{Cells, Metric, Row};

/// Fewer collisions than this say nothing about the starts.
const MIN_COLLISIONS: u64 = 10;
/// Below this progress a driver is as good as parked.
pub(super) const CRAWLS: f64 = 0.5;
/// Above this share of unpreventable collisions a caution is due.
const MAX_UNAVOIDABLE: f64 = 0.9;

/// What a reader must know before the figures of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Caution {
    /// A driver often does not reach its starts, or leaves the road.
    OffRoad(OffRoadDriver),
    /// A driver hardly moves without anybody.
    Crawls { driver: String, progress: String },
    /// Hardly any collision of any driver in a town could have been avoided: the starts leave a careful human no chance.
    NoChance {
        town: String,
        /// The collisions there in evaluations, and those that no careful human avoids.
        collisions: u64,
        unavoidable: u64,
    },
    /// A search had no episode.
    EmptySearch {
        /// Its method, town and driver.
        search: String,
        /// Simulator ticks that each run might use.
        budget: u64,
    },
}

impl fmt::Display for Caution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OffRoad(driver) => driver.fmt(f),
            Self::Crawls { driver, progress } => write!(
                f,
                "{driver} drives {progress} of the way that limits and bends allow, without anybody: that it has few faults says little"
            ),
            Self::NoChance { town, collisions, unavoidable } => write!(
                f,
                "no careful human avoids {unavoidable} of the {collisions} collisions in {town}: most starts are unavoidable at that speed, so few \
                 faults say little about a driver; let the pedestrian start farther away"
            ),
            Self::EmptySearch { search, budget } => write!(
                f,
                "{search} searched nothing: none of its episodes fits into a `budget` of {budget} ticks, so nothing is known; give a greater one"
            ),
        }
    }
}

/// All of them: of drivers, of towns, of searches.
pub fn cautions(
    cells: &Cells,
    results: &[SearchResult],
    searches: &[SearchCell],
    drivers: &[DriverResult],
    prices: &[(String, DriverPrice)],
) -> Vec<Caution> {
    // Episodes that are left out fitted into the budget; why they are is said of the driver. So is why a search ended early.
    let is_lost = |search: &SearchCell| {
        let mut own = results.iter().filter(|result| result.key.is_of_same_cell(&search.key));
        own.any(|result| result.spent.left_out > 0 || result.error.is_some())
    };
    let empty = searches.iter().filter(|search| search.is_empty() && !is_lost(search));
    let empty = empty.map(|search| Caution::EmptySearch { search: search.in_full(), budget: search.budget() });
    // Of a driver without any episode that counts it is said why.
    let is_unknown = |name: &str| drivers.iter().any(|result| result.driver.name == name && result.episodes == 0);
    let crawls = prices.iter().filter(|(name, price)| price.progress < CRAWLS && !is_unknown(name));
    let crawls = crawls.map(|(driver, price)| Caution::Crawls {
        driver: driver.clone(),
        progress: format!("{:.0} %", 100.0 * price.progress),
    });
    let off_road = off_road(cells, results).into_iter().map(Caution::OffRoad);
    off_road.chain(crawls).chain(no_chance(cells)).chain(empty).collect()
}

/// The towns in which nearly all collisions are beyond careful drivers, for every driver under test. A baseline that sees no pedestrian collides also where others
/// would not, so beside one there is seldom such a town.
fn no_chance(cells: &Cells) -> Vec<Caution> {
    const COUNTS: [&Metric; 3] = [&COLLISIONS, &MACHINE_PREVENTABLE_COLLISIONS, &UNPREVENTABLE_COLLISIONS];
    let caution = |town: &Row<()>| {
        let [collisions, machine, unpreventable] = COUNTS.map(|count| town.whole_number(count.name));
        let unavoidable = machine + unpreventable;
        let nearly_all = collisions >= MIN_COLLISIONS && unavoidable as f64 > MAX_UNAVOIDABLE * collisions as f64;
        let town = in_world(&town.text(&TOWN), &town.text(&WORLD));
        nearly_all.then_some(Caution::NoChance { town, collisions, unavoidable })
    };
    cells.sums(&[WORLD, TOWN], &COUNTS).iter().filter_map(caution).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::CellKey;
    use crate::tables::Cell;

    #[test]
    fn a_town_whose_collisions_no_careful_human_avoids_is_named() {
        let cell = |town: &str, collisions: u32, unavoidable: u32| {
            let key = CellKey { town: town.into(), ..CellKey::default() };
            Cell::example(key, &[(&COLLISIONS, collisions), (&UNPREVENTABLE_COLLISIONS, unavoidable)], &[])
        };
        let cells = Cells::example(&[cell("bend", 9, 9), cell("bend", 9, 8), cell("few", 9, 9), cell("fair", 20, 15)]);
        let said: Vec<String> = cautions(&cells, &[], &[], &[], &[]).iter().map(ToString::to_string).collect();
        let [said] = &said[..] else { panic!("{said:?}") };
        assert!(said.starts_with("no careful human avoids 17 of the 18 collisions in bend"), "{said}");
    }
}
