//! Tasks on disk: finished and unfinished work of campaigns, so that no work is repeated or lost.
//!
//! All campaigns of a folder share `OUT/.falsify`; campaigns of several folders share a cache. A task's name is a digest of everything
//! that its bytes depend on: the code, the seed, the scenario, and for a trained pedestrian its training. So a stored task is the right
//! one, no matter which process made it, and a file with other contents is damaged. Files appear whole. Several processes may work on one
//! folder.

mod id;
mod task_file;
mod store_error;
mod work_folder;
mod place;
mod folder;
mod index;
mod references;
mod campaign_store;
mod import;
mod status;

pub use campaign_store::{CampaignStore, Limits};
pub use folder::{Note, Store};
pub use id::{CODE, Id, Ids, vector_instructions};
pub use import::Taken;
pub use index::{Index, Known, task_name};
pub use references::References;
pub use status::{CampaignStatus, TaskStatus};
pub use store_error::StoreError;
pub use task_file::{Found, Header};
pub use task_file::{decode, encode, head};
