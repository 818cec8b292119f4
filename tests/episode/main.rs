//! Requirements on episodes: their definition, and two independent programs.

#[path = "../common/repository.rs"]
mod repository;

mod robustness;

use repository::repository;
