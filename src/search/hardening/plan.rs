use std::sync::Arc;

use super::traffic_rule::TrafficRule;
use super::tunable::Tunable;
use crate::Falsifier;
use episode::Scenario;
use episode::walker::Controller;

/// A falsifier with its name, and the scenario of each town with its reward.
pub type Attack = (String, Arc<dyn Falsifier>, Vec<Arc<Scenario>>);

#[derive(Debug, Clone)]
pub struct Hardening {
    pub driver: Tunable,
    /// The towns of the rounds, with their names.
    pub towns: Vec<(String, Arc<Scenario>)>,
    /// Who attacks; their scenarios are in the order of `towns`.
    pub attacks: Vec<Attack>,
    /// Ticks of each search of a round.
    pub budget: u64,
    pub rounds: u32,
    /// Values of the keys that a round tries out.
    pub candidates: u32,
    /// Episodes with each pedestrian that a search ended up with, for each candidate.
    pub lessons: u32,
    /// Natural encounters in each town, for each candidate.
    pub traffic: u32,
    pub natural: Controller,
    pub rule: TrafficRule,
    pub test_towns: Vec<(String, Arc<Scenario>)>,
    /// Who walks in the test.
    pub walkers: Vec<Controller>,
    /// Who searches in the test; their scenarios are in the order of `test_towns`.
    pub rivals: Vec<Attack>,
    /// Episodes of the test, for each town and pedestrian.
    pub episodes: u32,
}
