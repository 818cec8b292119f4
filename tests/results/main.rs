//! Tests of campaigns, without the program.

#[path = "../common/repository.rs"]
mod repository;

mod candidates;
mod covers;
mod estimates;
mod gates;
mod hardening;
mod hunters;
mod searches;

use repository::repository;
