//! Finds collisions of a self-driving car with a pedestrian that a careful human avoids.
//!
//! A scenario file declares towns, driving policies, spawn places and rewards, and the campaigns that are run with them; `grammar/README.md`
//! describes the language. A [`Session`](session::Session) checks scenario files, runs their campaigns, and reads reports back:
//!
//! ```
//! use std::io;
//! use std::path::Path;
//!
//! use falsify::results::metrics::COLLISION_RATE;
//! use falsify::session::{Input, RunOptions, Session};
//!
//! const SCENARIO: &str = r#"
//! edition 1
//! import "std/paper.scn"
//! import "std/drivers.scn"
//! import "std/towns.scn"
//!
//! campaign crossing {
//!   vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
//!   evaluate { towns: [harbour]  drivers: [blind]  pedestrians: [random, intercept]  episodes: 25 }
//! }
//! "#;
//!
//! // Scenarios come from the disk unless the caller supplies them.
//! let session = Session::default().with_reader(|path: &Path| match path.to_str() {
//!     Some("crossing.scn") => Ok(SCENARIO.to_string()),
//!     _ => Err(io::Error::from(io::ErrorKind::NotFound)),
//! });
//! let input = Input::file("crossing.scn");
//!
//! // Parse and check.
//! let checked = session.check(&input)?;
//! assert!(checked.compiled.diagnostics.is_empty());
//! assert_eq!(checked.plan()?.campaigns[0].all::<compile::Evaluation>().count(), 2);
//!
//! // Run, and write a report.
//! let folder = tempfile::tempdir()?;
//! let run = session.run(&RunOptions { input, out: folder.path().join("reports"), ..RunOptions::default() })?;
//! let report = run.reports().next().expect("the campaign has a report");
//! assert!(report.is_sound() && report.manifest.complete);
//!
//! // Read the tables: means and intervals of each cell of the grid, and a row for each episode.
//! let rates: Vec<Option<f64>> = report.cells.iter().map(|cell| cell.value(&COLLISION_RATE)).collect();
//! assert!(rates.len() == 2 && rates.iter().flatten().all(|rate| (0.0..=1.0).contains(rate)));
//! let episodes = std::fs::read_to_string(report.folder.join("episodes.csv"))?;
//! assert_eq!(episodes.lines().count(), 1 + 2 * 25);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A caller adds kinds of its own to the language: a driving policy with [`Catalog::with_policy`](language::Catalog::with_policy), a town with
//! [`Catalog::with_town`](language::Catalog::with_town), a pedestrian that walks with [`Catalog::with_walker`](language::Catalog::with_walker).
//! [`keys!`](language::keys) declares what a kind takes.
#![doc = include_str!("../ARCHITECTURE.md")]
#![warn(missing_docs)]

use std::ffi::OsString;

#[doc(inline)]
pub use program::session;

/// The command line of `falsify` with a language of the caller: what a program with kinds of its own calls in `main`. `arguments` are those of the
/// process, with the name of the program as the first one; it starts itself with others to try a network, so it hands all of them on.
/// It takes over the process: Ctrl-C asks for a clean end, and a panic of any thread ends the process with a message.
pub fn command_line(
    catalog: fn() -> language::Catalog,
    arguments: impl IntoIterator<Item = OsString>,
) -> std::process::ExitCode {
    program::cli::command_line(catalog, arguments).into()
}

#[cfg(doctest)]
#[doc = include_str!("../docs/src/how-to/rust.md")]
struct RustPage;

/// The scenario language: catalogue, plans and diagnostics.
pub mod language {
    #[doc(inline)]
    pub use base::diagnostic::{Colour, Diagnostic, Severity, Sources, render};
    #[doc(inline)]
    pub use base::signature::{Choice, Keys, Param, Signature, Type};
    #[doc(inline)]
    pub use base::{choice, keys};
    #[doc(inline)]
    pub use compile::{
        Campaign, Catalog, Compiled, Evaluation, ExternalProgram, FalsifierKind, NoRunId, Plan, PolicyKind, RunId,
        Search, Sight, TakenKind, TownKind, Training, TrainingKey, WalkerKind,
    };
    #[doc(inline)]
    pub use lang::{Reader, Unreadable};
}

/// What a driving policy perceives and returns, and the openers that may start one as a program.
pub mod driving {
    #[doc(inline)]
    pub use base::seed::Stream;
    #[doc(inline)]
    pub use process::ProcessOpener;
    #[doc(inline)]
    pub use road::geometry::{Obstacles, Vector, wrap_angle};
    #[doc(inline)]
    pub use world::av::external::{Link, Opener, Program};
    #[doc(inline)]
    pub use world::av::{Actor, Cruise, CruiseKeys, DrivingMode, DrivingPolicy, Fault, Light, Perception};
    #[doc(inline)]
    pub use world::sim::{ActorId, Control, LightColour, ThrottleLine, VehicleBlueprint};
}

/// What a town is made of, and what a driver reads of it.
pub mod towns {
    #[doc(inline)]
    pub use road::design::{BuildingRow, Carriageway, DesignError, Node, Street, StreetProfile, TownDesign};
    #[doc(inline)]
    pub use road::geometry::{OrientedBox, Point, Pose};
    #[doc(inline)]
    pub use road::{
        Connection, Cubic, ForkRule, Geometry, Junction, JunctionIndex, Lane, LaneFilter, LaneId, LaneKind,
        LaneSection, LaneStretch, OpenDriveProblem, OpenDriveWarning, PlanView, Profile, Road, RoadEnd, RoadIndex,
        RoadLink, RoadOption, RoutePlanner, Shape, SpeedSign, Town, TownParts, TrafficLight, Waypoint,
    };
}

/// What a pedestrian that walks gets and returns.
pub mod walking {
    #[doc(inline)]
    pub use episode::Scene;
    #[doc(inline)]
    pub use episode::walker::WalkPolicy;
    #[doc(inline)]
    pub use world::sim::WalkCommand;
}

/// The data of a run, a report and a repeated episode.
pub mod results {
    #[doc(inline)]
    pub use episode::{Outcome, Scenario};
    #[doc(inline)]
    pub use export::{EgoDriver, ExportError, ExportFile, Exporter, Variant, Walking};
    #[doc(inline)]
    pub use results::campaign::{Event as CampaignEvent, Shard, Task};
    #[doc(inline)]
    pub use results::report::{
        Difference, FileRecord, Gate, GateError, Judged, Manifest, ProgramRecord, Rate, ReadError, RunRecord,
        ScenarioFile, SearchCell, Section, StoredReport, TooFewRuns, TrainingRecord, WriteError,
    };
    #[doc(inline)]
    pub use results::store::{Known, Limits, StoreError};
    #[doc(inline)]
    pub use results::tables::{Cell, Cells, Metric, Row, Rows, metrics};
    #[doc(inline)]
    pub use verdict::Verdict;
}
