//! From the language to the simulation: the forms and kinds that a scenario may use, and HIR → [`Plan`].
//!
//! Every form has a file with its keys, its [`Form`](base::signature::Form), which the checker and the reference read, and a `lower` that turns
//! the values of the keys into something that runs. Kinds of drivers, pedestrians and searches own their keys themselves. Each kind is a line of a
//! table with its keys and its constructor; a [`Catalog`] holds those of the caller, too.

mod catalog;
mod reference;
mod explain;
mod interface_pages;
mod town;
mod vehicle;
mod policy_kind;
mod policy;
mod driver_parts;
mod outside;
mod programs;
mod sensors;
mod sensor_suites;
mod adversary;
mod spawn;
mod target_walk;
mod given_path;
mod sector;
mod reward;
mod requirement;
mod training;
mod walker;
mod role;
mod external_world;
mod falsifier;
mod published;
mod controller;
mod campaign;
mod plan;
mod jobs;
mod noting;
mod lowering;
mod fingerprint;
mod digest;
mod run_id;
mod run_names;
mod reached;
mod variants;
mod whole_plan;
mod lower;
mod grid;

pub use catalog::{Catalog, NetworkTrial, TakenKind};
pub use episode::HERE;
pub use external_world::{BRIDGES, Misfit, Staging, bridge_command};
pub use falsifier::FalsifierKind;
pub use fingerprint::Fingerprint;
pub use jobs::*;
pub use lower::{Compiled, Overrides, compile, compile_with};
pub use plan::{
    Campaign, Documented, Driver, NamedDriver, NamedTown, OutsideSetting, Plan, Published, PublishedCell,
    PublishedFigure,
};
pub use policy_kind::{PolicyKind, Sight};
pub use programs::{ExternalProgram, Programs, changed_files};
pub use published::published_columns;
pub use reference::{block, key, short_key};
pub use run_id::{NoRunId, RunId};
pub use town::TownKind;
pub use walker::WalkerKind;
