//! Rows in, files out: tables, metrics, figures, summary, manifest. The only code that knows polars.
//!
//! Metrics are aggregated in two steps, as in the paper: episodes → run → cell. A "±" is the standard deviation over
//! runs, that is over trainings; an interval is Wilson's over the episodes of all runs together and says nothing about
//! further trainings; [`evidence`] has those that do.

mod tables;
mod metrics;
mod learning_curve;
mod figure;
mod town_map;
mod waypoints;
mod survival;
mod searches;
mod search_summary;
mod summary;
mod avoidable;
mod evidence;
mod manifest;
mod folder;
mod write;

pub use evidence::{
    Between, CellEvidence, CellKey, Change, Comparison, Evidence, Figure, Quantiles, Test, Transfer, evidence,
};
pub use figure::learning_figures;
pub use folder::{ReportFolder, WriteError, write_csv, write_file};
pub use learning_curve::learning_curve;
pub use manifest::{FileRecord, Manifest, TrainingRecord};
pub use metrics::{Cell, Metrics, Spread, metrics};
pub use search_summary::{search_summary, search_table};
pub use searches::{Average, SearchCell, search_cell_table, search_cells, search_failures, searches};
pub use summary::{summary, table};
pub use survival::{MedianTime, median_time};
pub use tables::{episodes, failure_modes};
pub use town_map::{spawn_map, town_map};
pub use waypoints::waypoints;
pub use write::{pedestrian_file, write};
