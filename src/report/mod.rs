//! Rows in, files out: tables, metrics, figures, summary, manifest. The only code that knows polars.
//!
//! Metrics are aggregated in two steps, as in the paper: episodes → run → cell. A "±" is the standard deviation over
//! runs, that is over trainings; an interval is Wilson's over the episodes of all runs together and says nothing about
//! further trainings.

mod tables;
mod episodes;
mod wilson;
mod metrics;
mod learning_curve;
mod figure;
mod town_map;
mod waypoints;
mod student;
mod survival;
mod searches;
mod search_summary;
mod summary;
mod avoidable;
mod manifest;
mod table_stream;
mod folder;
mod gathered;
mod write;

pub use episodes::{Chunk, Chunks, Episodes, Run, decode, encode};
pub use figure::learning_figures;
pub use folder::{Formats, ReportFolder, WriteError, write_csv, write_file};
pub use gathered::{Gathered, MOST_COLLISIONS, gather};
pub use learning_curve::learning_curve;
pub use manifest::{FileRecord, Manifest, TrainingRecord};
pub use metrics::{Cell, Metrics, Spread, metrics};
pub use search_summary::{search_summary, search_table};
pub use searches::{Average, SearchCell, search_cell_table, search_cells, search_failures, searches};
pub use summary::{summary, table};
pub use survival::{MedianTime, median_time};
pub use table_stream::TableStream;
pub use tables::{episodes, failure_modes};
pub use town_map::{Starts, spawn_map, town_map};
pub use waypoints::waypoints;
pub use wilson::wilson;
pub use write::{pedestrian_file, write};
