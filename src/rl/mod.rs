//! Reinforcement learning: proximal policy optimisation and what it needs. Knows no car.
//!
//! An [`Env`] is what there is to learn, a [`PpoConfig`] how, and [`train`] turns both into an [`ActorCritic`] and its
//! learning curve. The algorithm is that of stable-baselines3's `PPO` for continuous actions, with the same order of
//! operations: collect a rollout, estimate advantages, then several epochs of minibatches, each with its own gradient
//! step. Everything random comes from named streams, so that the same seed gives the same bits; training is sequential.
//!
//! Networks compute in `f32`; rewards, advantages, densities and losses are `f64`. Matrices are column-major, one sample
//! per column.

mod env;
mod config;

mod real;
mod tanh;
mod normal;
mod product;
mod mlp;
mod init;
mod gaussian;
mod actor_critic;
mod checkpoint;

mod collector;
mod gae;
mod rollout;
mod minibatch;
mod loss;
mod adam;
mod ppo;
mod log;

pub use actor_critic::{ActorCritic, Scratch};
pub use checkpoint::CheckpointError;
pub use config::PpoConfig;
pub use env::{Env, Step};
pub use log::{FinishedEpisode, UpdateLog};
pub use ppo::{Quantity, TrainError, Trained, train};
pub use real::Real;
