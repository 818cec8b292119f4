//! The tests of the language's layout.

#[path = "../common/repository.rs"]
mod repository;
#[path = "../common/samples.rs"]
mod samples;
#[path = "../common/shipped.rs"]
mod shipped;

mod format;

use repository::repository;
