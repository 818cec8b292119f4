use polars::prelude::DataFrame;

use super::{ModeCard, Tally};
use crate::campaign::TrainingResult;
use crate::compile::Campaign;
use crate::report::render::table::Section;
use crate::report::{Cell, Manifest, PublishedComparison};

/// All that a page shows.
#[derive(Debug, Clone)]
pub struct Contents<'a> {
    /// What was planned.
    pub campaign: &'a Campaign,
    /// How it was run.
    pub manifest: &'a Manifest,
    /// The cells.
    pub cells: &'a [Cell],
    /// The table of runs.
    pub runs: &'a DataFrame,
    /// What was gathered of the episodes.
    pub tally: &'a Tally,
    /// The trainings.
    pub trainings: &'a [TrainingResult],
    /// The kinds of collisions.
    pub modes: &'a [ModeCard],
    /// Tables that the summary has, too, each a section.
    pub sections: &'a [Section],
    /// The published figures, as a table.
    pub published_section: Option<Section>,
    /// The published figures, for the diamonds in the results.
    pub published: &'a [PublishedComparison<'a>],
    /// The other files of the report that the page may link to.
    pub files: &'a [String],
}
