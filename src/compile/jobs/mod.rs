//! The jobs of a campaign. A kind is a file or a folder with the keys of its block, the jobs that a block adds, and what the plan says about them:
//! [`Planned`].

mod planned;
mod job_block;
mod training;
mod drive;
mod evaluation;
mod search;
mod estimate;
mod cover;
mod harden;
mod price;
mod job;
mod absent;
mod campaign;

pub(crate) use campaign::BLOCKS;
pub use cover::Cover;
pub use estimate::Estimation;
pub use evaluation::{CHUNK, ControllerKind, Evaluation, episodes_seed};
pub use harden::{Harden, VariedKey, WrittenPolicy};
pub use job::Job;
pub(crate) use job_block::JobBlock;
pub use planned::{Origin, Originated, Planned};
pub use price::Pricing;
pub use search::{Search, SearchKey};
pub use training::{NO_REWARD, Training, TrainingKey};
