//! From the language to the simulation: the forms and kinds that a scenario may use, and HIR → [`Plan`].
//!
//! Every form has a file with its keys, its [`Form`](base::signature::Form), which the checker and the reference read, and a `lower` that turns
//! the values of the keys into something that runs. Kinds of drivers, pedestrians and searches own their keys themselves. Each kind is a line of a
//! table with its keys and its constructor; a [`Catalog`] holds those of the caller, too.

mod fingerprint;
mod run_id;
mod noting;
mod reached;
mod programs;

mod town;
mod vehicle;
mod adversary;
mod sector;
mod target_walk;
mod given_path;
mod spawn;
mod sensor_suites;
mod sensors;
mod policy_kind;
mod falsifier;
mod walker;
mod catalog;
mod reference;
mod interface_pages;
mod explain;

mod lowering;
mod digest;
mod requirement;
mod reward;
mod training;
mod outside;
mod driver_parts;
mod plan;
mod policy;
mod controller;
mod role;
mod published;
mod campaign;
mod grid;
mod external_world;
mod jobs;

mod builtin;
mod run_names;
mod variants;
mod whole_plan;
mod lower;

pub use catalog::{Catalog, NetworkTrial, TakenKind};
pub use episode::HERE;
pub use external_world::{Misfit, Staging};
pub use falsifier::FalsifierKind;
pub use fingerprint::Fingerprint;
pub use jobs::*;
pub use lower::{Compiled, Overrides, compile, compile_with};
pub use outside::{BRIDGES, bridge_command};
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
pub use walker::{UNTRAINED, WalkerKind};
