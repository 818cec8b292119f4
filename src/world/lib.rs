//! The simulated world: cars and pedestrians that move on roads, driving policies and their perception.

pub mod sim;
pub mod av;
