//! Rows in, files out: tables, metrics, figures, summary, page, manifest.
//!
//! Four jobs, a folder each: `aggregate` makes runs and cells of episodes, `infer` their evidence for further trainings, `render`
//! text and pictures, and `read` reads a report back. `failure_modes` finds kinds of collisions. The rest writes files.

mod aggregate;
mod infer;
mod failure_change;
mod compare;
mod recheck;
mod failure_modes;
mod render;
mod read;
mod catalogue;
mod caution;
mod manifest;
mod scenario_files;
mod parquet;
mod table_stream;
mod text_forms;
mod draft;
mod folder;
mod overview;
mod lost;
mod findings;
mod listed_failure;
mod metric_table;
mod played;
mod write;

pub use aggregate::{
    Agreement, Average, COVERS, Cell, CellRequirement, Colour, CoverRow, DriverResult, Episodes, Failures, Gathered,
    MedianTime, Metrics, ProtocolCell, PublishedComparison, Run, SEARCH_COMPARISONS, SearchCell, SearchComparison,
    SearchFailures, SearchKind, Spread, Wanted, beside, cover_in_words, driver_results, estimate_doubts, failure_table,
    gather, hardened_in_words, layer_cells, learning_curve, learning_curve_lines, metrics, no_verdict, published,
    search_cell_table, search_cells, search_comparison_table, search_comparisons, search_failures, search_kind_table,
    search_kinds, searches, ticks, unit_of, worst_failure, write_ticks,
};
pub use catalogue::{catalogue, column_reference};
pub use caution::Caution;
pub use compare::{
    Caveat, Changed, ComparedCell, ComparedSearch, Incomparable, ReportComparison, Side, compare_reports,
    compared_cells, compared_search_reference, compared_search_table, comparison_reference,
};
pub use draft::draft_in;
pub use failure_change::{FailureChange, SideCollision, SideEnd};
pub use failure_modes::FailureModes;
pub use findings::Findings;
pub use folder::{Formats, ReportFolder, WriteError, write_csv, write_file, write_new_file, write_table};
pub use infer::{
    Baseline, CellEvidence, Change, Comparison, Doubt, Evidence, Figure, Gathering, Learning, Learnt, Quantiles,
    Reason, Test, TrainingDifference, Transfer, Untrained, doubts, evident_cells,
};
pub use listed_failure::{FailureClass, FailureOrder, ListedFailure};
pub use lost::LostDriver;
pub use manifest::{Call, FileRecord, Manifest, ProgramRecord, RunRecord, ScenarioFile, TrainingRecord};
pub use metric_table::{METRICS, metric_references};
pub use overview::{Found, Overview, OverviewRow, RateOfRow, Variant};
pub use played::PlayedFailure;
pub use read::{
    Difference, Gate, GateError, Judged, ReadError, StoredFailure, StoredReport, TooFewRuns, differences, divergence,
    failure, failure_list,
};
pub use recheck::{
    CrossedStarts, Encounter, FoundIn, Met, Recheck, RecheckNote, RecheckedFailures, StartFaults, WalkedBy,
    crossed_reference, crossed_table, rechecked_reference, rechecked_table,
};
pub use render::{ChangeReport, PlayedPair, Replay, change_page, change_text, comparison_report, recheck_report};
pub use render::{
    MapPage, Narrative, StartLayer, Starts, Suite, Tally, TownView, animation, covers_for_terminal,
    drivers_for_terminal, estimates_for_terminal, failures_for_terminal, hardened_for_terminal, junit, map_page,
    narrative, overview_for_terminal, overview_page, protocol_for_terminal, requirements_for_terminal,
    results_for_terminal, searches_for_terminal, shown, spawn_map, strip, town_map,
};
pub use scenario_files::{MOST_HELD_BYTES, held_places};
pub use table_stream::TableStream;
pub use text_forms::{csv_text, json_rows};
pub use write::{pedestrian_file, write, write_failure_modes};

/// A row of a table, or several.
pub type Row = polars::prelude::DataFrame;
