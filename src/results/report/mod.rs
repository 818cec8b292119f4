//! Rows in, files out: tables, figures, summary, page, manifest.
//!
//! Four jobs, a folder each: `aggregate` makes runs and cells of episodes, `infer` their evidence for further trainings, `render`
//! text and pictures, and `read` reads a report back. The rest writes files.

mod actors;
mod aggregate;
mod infer;
mod failure_change;
mod failure_table;
mod compare;
mod recheck;
mod alike;
mod distinct;
mod render;
mod read;
mod catalogue;
mod caution;
mod cell_table;
mod manifest;
mod scenario_files;
mod parquet;
mod table_stream;
mod text_forms;
mod staging;
mod folder;
mod overview;
mod off_road;
mod price;
mod findings;
mod answer;
mod grouped;
mod metric_table;
mod repeats;
mod replayed;
mod held_programs;
mod dossier;
mod reference_answers;
mod judgement;
mod write;

// What was found: rates, cells, drivers, searches.
pub use crate::tables::Rate;
pub use actors::CastFailure;
pub(crate) use aggregate::search_table;
pub use aggregate::{
    Aggregates, Colour, DriverResult, Episodes, Failures, Run, SearchCell, aggregate_episodes, all_of_searches, beside,
    driver_results, search_cell_reference, search_cells, searches, ticks, worst_failure,
};
pub use answer::answer;
pub use catalogue::catalogue;
pub use caution::Caution;
pub use distinct::{DistinctFailure, MAX_SHRUNK, first_of_each};
pub use failure_change::{FailureChange, SideCollision, SideEnd};
pub use failure_table::{ListedFailure, failure_list, failure_table, read_failures};
pub use findings::Findings;
pub use infer::{BeatsUntrained, Doubt, Learning, Reason, Untrained, doubts};
pub use metric_table::{METRICS, metric_references};

// Reports side by side, and old failures with a new driver.
pub use compare::{
    Caveat, ComparedCell, ComparedSearch, CountedEvent, PairedRate, ReportComparison, Side, compare_reports,
    compared_cells, compared_search_table, comparison_reference,
};
pub use overview::{Overview, Variant};
pub use recheck::{
    CrossedStarts, Encounter, Encounters, Recheck, RecheckNote, RecheckedFailures, RerunOutcome, WalkedBy,
    crossed_reference, crossed_table, rechecked_reference, rechecked_table,
};

// Text and pictures.
pub use judgement::{
    JudgedMeeting, JudgedRecording, Unjudged, counted_reference, counted_table, judgement_lines, meetings_for_terminal,
    meetings_table,
};
pub use reference_answers::ReferenceAnswers;
pub use render::{
    ChangeReport, Group, MapPage, Narrative, PlayedPair, Replay, SMOKE, Section, SectionMaker, StartLayer, Starts,
    Suite, Tally, TownView, animation, change_page, change_text, comparison_report, failures_for_terminal,
    judgement_page, junit, map_page, narrative, overview_for_terminal, overview_page, recheck_report, sections,
    spawn_map, strip, worsening,
};
pub use text_forms::{csv_text, json_rows};

// Files: writing a report, reading one back.
pub use folder::{
    DOSSIER, FIGURES, Formats, ReportFolder, WriteError, write_csv, write_file, write_new_file, write_table,
};
pub use held_programs::ProgramCopy;
pub use manifest::{Call, FileRecord, Manifest, ProgramRecord, RunRecord, ScenarioFile, TrainingRecord};
pub use read::{
    Difference, Gate, GateError, Judged, ReadError, StoredReport, TooFewRuns, differences, divergence, requirements_in,
};
pub use scenario_files::{MAX_HELD_BYTES, held_places};
pub use staging::staging_file;
pub use write::write;

/// A table before it is written.
pub(crate) type Table = polars::prelude::DataFrame;

// What the modules here share.
pub(crate) use aggregate::{
    ProtocolCell, PublishedComparison, SearchFailures, SearchPair, layer_cells, score, search_pairs,
};
pub(crate) use infer::{CellEvidence, Comparison, Evidence, EvidenceBuilder, Test};
pub(crate) use recheck::NOT_MET;
pub(crate) use render::{search_section, svg, table, town_map};
pub(crate) use replayed::PlayedFailure;
pub(crate) use table_stream::TableStream;

/// A row of a table, or several.
pub type Row = polars::prelude::DataFrame;
