use polars::prelude::DataFrame;

use super::{ModeCard, Players, Tally};
use crate::jobs::{CoverResult, EstimateResult, TrainingResult};
use crate::report::render::table::Section;
use crate::report::{Caution, Cell, CoverRow, Doubt, DriverResult, Failures, Manifest, PublishedComparison};
use compile::Campaign;

/// The data of a page.
#[derive(Debug, Clone)]
pub struct Contents<'a> {
    /// The plan.
    pub campaign: &'a Campaign,
    /// The manifest of the run.
    pub manifest: &'a Manifest,
    pub cells: &'a [Cell],
    /// What was found about each driver, the worst first.
    pub drivers: &'a [DriverResult],
    /// The worst failures of each driver.
    pub failures: &'a Failures,
    /// The failures that can be played.
    pub players: &'a Players,
    /// The table of runs.
    pub runs: &'a DataFrame,
    /// The counts of the episodes.
    pub tally: &'a Tally,
    pub trainings: &'a [TrainingResult],
    /// The kinds of collisions.
    pub modes: &'a [ModeCard],
    /// The covers, and what they show.
    pub covered: &'a [CoverResult],
    pub covers: &'a [CoverRow],
    /// Tables that the summary has, too, each a section.
    pub sections: &'a [Section],
    /// The estimates of how likely failures are.
    pub estimates: &'a [EstimateResult],
    /// What a reader must know first.
    pub cautions: &'a [Caution],
    /// The doubts about the trainings.
    pub doubts: &'a [Doubt],
    /// The comparison with published figures, which the summary has, too.
    pub published_section: Option<Section>,
    /// The published figures, for the diamonds in the results.
    pub published: &'a [PublishedComparison<'a>],
    /// The other files of the report that the page may link to.
    pub files: &'a [String],
}
