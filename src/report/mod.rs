//! Rows in, files out: tables, metrics, figures, summary, manifest. The only code that knows polars.
//!
//! Metrics are aggregated in two steps, as in the paper: episodes → run → cell. A "±" is the standard deviation over
//! runs, that is over trainings; an interval is Wilson's over the episodes of all runs together and says nothing about
//! further trainings; `evidence` has those that do.

mod episodes;
mod metrics;
mod learning_curve;
mod waypoints;
mod survival;
mod searches;
mod published;
mod evidence;
mod manifest;
mod table_stream;
mod folder;
mod gathered;
mod write;
mod stored;
mod parting;
mod ticks;
mod tick_file;
mod failure_modes;
mod gate;
mod render;

pub use episodes::{Episodes, Run};
pub use evidence::{Between, CellEvidence, Change, Comparison, Evidence, Figure, Gathering, Quantiles, Test, Transfer};
pub use failure_modes::FailureModes;
pub use folder::{Formats, ReportFolder, WriteError, write_csv, write_file, write_table};
pub use gate::{Gate, GateError, Judged};
pub use gathered::{Gathered, gather};
pub use learning_curve::learning_curve;
pub use manifest::{Call, FileRecord, Manifest, TrainingRecord};
pub use metrics::{Cell, Metrics, Spread, metrics};
pub use parting::parting;
pub use published::{Agreement, Beside, beside, published};
pub use render::{
    Narrative, Starts, Suite, Tally, animation, junit, narrative, results_for_terminal, searches_for_terminal, shown,
    spawn_map, strip, town_map,
};
pub use searches::{Average, SearchCell, search_cell_table, search_cells, search_failures, searches};
pub use stored::{Difference, ReadError, StoredFailure, StoredReport, differences, failure};
pub use survival::{MedianTime, median_time};
pub use table_stream::TableStream;
pub use tick_file::{Wanted, write_ticks};
pub use ticks::ticks;
pub use waypoints::waypoints;
pub use write::{pedestrian_file, write, write_failure_modes};

/// A row of a table, or several.
pub type Row = polars::prelude::DataFrame;
