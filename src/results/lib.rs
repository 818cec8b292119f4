//! What a campaign leaves behind: tasks, rows of episodes, stored results, reports and their pages.

pub mod record;
pub mod tables;
pub mod campaign;
pub mod jobs;
pub mod parallel;
pub mod failure;
pub mod report;
pub mod store;
