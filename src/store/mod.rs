//! Tasks on disk: what campaigns have finished or begun, so that nothing is done twice and nothing is lost.
//!
//! `OUT/.falsify` is shared by all campaigns of a folder, a cache by those of several. A task's name is a digest of all that its bytes depend on: the code, the
//! seed, the scenario, and for a trained pedestrian its training. So a task is either there as it should be or not there, whoever made it,
//! and a file that says otherwise is damaged. Files appear whole; several processes may work on one folder.

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
pub use task_file::{Found, Header, State};
#[cfg(any(fuzzing, test))]
pub use task_file::{decode, encode, head};
