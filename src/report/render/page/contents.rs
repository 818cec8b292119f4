use polars::prelude::DataFrame;

use super::{ModeCard, Tally};
use crate::campaign::TrainingResult;
use crate::compile::Campaign;
use crate::report::{Beside, Cell, Manifest, SearchCell};

/// A table that the page shows as it is, in a section of its own.
#[derive(Debug, Clone)]
pub struct ComparisonSection {
    /// Its section's `id`, and the stem of its files.
    pub id: &'static str,
    /// The heading.
    pub title: &'static str,
    /// What it says and how to read it.
    pub lead: &'static str,
    /// The table.
    pub table: DataFrame,
}

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
    /// The falsifiers compared.
    pub searches: &'a [SearchCell],
    /// Further tables, each a section.
    pub extras: &'a [ComparisonSection],
    /// What others have published, beside ours.
    pub published: &'a [Beside<'a>],
    /// The other files of the report that the page may link to.
    pub files: &'a [String],
}
