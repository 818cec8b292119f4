use polars::prelude::DataFrame;

use super::{ModeCard, Tally};
use crate::campaign::TrainingResult;
use crate::compile::Campaign;
use crate::report::render::table::Section;
use crate::report::{Cell, Doubt, Manifest, PublishedComparison};

/// The data of a page.
#[derive(Debug, Clone)]
pub struct Contents<'a> {
    /// The plan.
    pub campaign: &'a Campaign,
    /// The manifest of the run.
    pub manifest: &'a Manifest,
    /// The cells.
    pub cells: &'a [Cell],
    /// The table of runs.
    pub runs: &'a DataFrame,
    /// The counts of the episodes.
    pub tally: &'a Tally,
    /// The counts of the episodes.
    pub trainings: &'a [TrainingResult],
    /// The kinds of collisions.
    pub modes: &'a [ModeCard],
    /// Tables that the summary has, too, each a section.
    pub sections: &'a [Section],
    /// The doubts about the trainings.
    pub doubts: &'a [Doubt],
    /// Tables that are also in the summary, each as a section.
    pub published_section: Option<Section>,
    /// The published figures, for the diamonds in the results.
    pub published: &'a [PublishedComparison<'a>],
    /// The other files of the report that the page may link to.
    pub files: &'a [String],
}
