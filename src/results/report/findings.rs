use std::collections::BTreeMap;

use super::actors::{CastFailure, cast_failures};
use super::caution::{Caution, cautions};
use super::distinct::listed_findings;
use super::price::DriverPrice;
use super::{
    Aggregates, CellEvidence, DistinctFailure, Doubt, DriverResult, ProtocolCell, PublishedComparison, all_of_searches,
    beside, doubts, driver_results, layer_cells, search_cells, search_pairs,
};
use crate::campaign::Finished;
use crate::jobs::{SearchResult, price_columns};
use crate::record::CellKey;
use crate::tables::{Cell, Cells, Rows};
use base::seed::Seed;
use compile::{Campaign, SearchKey};

/// What a campaign found. Files, page, summary and gates read it and compute nothing of it again.
#[derive(Debug)]
pub struct Findings<'a> {
    pub campaign: &'a Campaign,
    pub finished: &'a Finished,
    /// What one pass over the episodes gave.
    pub gathered: Aggregates,
    /// The cells, without those that differ from an earlier one in the reward of an untrained pedestrian alone.
    pub cells: Cells,
    /// What was found about each driver, the worst first.
    pub drivers: Vec<DriverResult>,
    /// The distinct ones among the worst failures.
    pub distinct: Vec<DistinctFailure>,
    /// The listed failures of a campaign with a cast, and which actors they need.
    pub cast_failures: Vec<CastFailure>,
    /// The places of the evidence on cells.
    evidence: BTreeMap<CellKey, usize>,
    /// Published figures beside ours.
    pub published: Vec<PublishedComparison<'a>>,
    /// The results in the tests of a protocol within its layers.
    pub layers: Vec<ProtocolCell>,
    /// Searches over their runs.
    pub searches: Rows<SearchKey>,
    /// Pairs of these, run by run.
    pub search_pairs: Rows<u64>,
    /// Doubts about trainings; none of a smoke run, which is too short for any.
    pub doubts: Vec<Doubt>,
    /// What a reader must know first.
    pub cautions: Vec<Caution>,
}

impl<'a> Findings<'a> {
    /// Works them out.
    pub fn new(campaign: &'a Campaign, finished: &'a Finished, gathered: Aggregates, seed: &Seed, smoke: bool) -> Self {
        let (cells, evidence) = (gathered.cells.clone(), &gathered.evidence.cells);
        let results = finished.all::<SearchResult>();
        let searched = all_of_searches(results);
        let (searches, search_pairs) = (search_cells(results, &searched), search_pairs(&searched));
        let layers = layer_cells(campaign, results);
        let mut drivers = driver_results(&campaign.drivers, &cells, &gathered.failures, &searched, &gathered.tests);
        let prices = price_columns().frame(&finished.found().collect::<Vec<_>>());
        let prices = DriverPrice::all(&prices).expect("a bug: a table of prices has its columns");
        for result in &mut drivers {
            result.price = prices.iter().find(|(name, _)| *name == result.driver.name).map(|(_, price)| *price);
        }
        if !layers.is_empty() {
            // The cases of a test are no sample of episodes.
            let searched = drivers.iter_mut().filter_map(|result| result.searched.as_mut());
            searched.for_each(|found| found.injury_per_thousand = None);
        }
        let places = evidence.iter().enumerate().map(|(place, found)| (found.key.clone(), place)).collect();
        let mut found = Self {
            evidence: places,
            distinct: Vec::new(),
            cast_failures: Vec::new(),
            published: beside(&campaign.published, &cells, evidence),
            layers,
            cautions: cautions(&cells, results, &searches, &drivers, &prices),
            search_pairs,
            searches,
            drivers,
            doubts: if smoke { Vec::new() } else { doubts(evidence) },
            campaign,
            finished,
            cells,
            gathered,
        };
        found.distinct = listed_findings(&found, seed);
        found.cast_failures = cast_failures(&found, seed);
        found
    }

    /// The evidence on a cell; `None` without a run of it.
    pub fn evidence(&self, cell: &Cell) -> Option<&CellEvidence> {
        self.evidence.get(&cell.key).map(|place| &self.gathered.evidence.cells[*place])
    }
}
