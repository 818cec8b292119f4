//! Reinforcement learning: proximal policy optimisation and what it needs. Knows no car.
//!
//! An [`Env`] is what there is to learn, a [`PpoConfig`] how, and [`train`] turns both into an [`ActorCritic`] and its
//! learning curve. The algorithm is that of stable-baselines3's `PPO` for continuous actions, with the same order of
//! operations: collect a rollout, estimate advantages, then several epochs of minibatches, each with its own gradient
//! step. Everything random comes from named streams and training is sequential, so that the same seed gives the same bits.
//! This holds between processors that agree in whether they have AVX and fused multiply-add: the general matrix product
//! uses what it finds, which rounds differently.
//!
//! Networks compute in `f32`; rewards, advantages, densities and losses are `f64`. Matrices are column-major, one sample
//! per column.

mod config;
mod env;

mod actor_critic;
mod checkpoint;
mod gaussian;
mod init;
mod mlp;
mod normal;
mod product;
mod real;
mod tanh;

mod adam;
mod collector;
mod gae;
mod log;
mod loss;
mod minibatch;
mod ppo;
mod rollout;

pub use actor_critic::{ActorCritic, Scratch};
pub use checkpoint::CheckpointError;
pub use config::PpoConfig;
pub use env::{Env, Step};
pub use log::{FinishedEpisode, UpdateLog};
pub use ppo::{Quantity, TrainError, Trained, train};
pub use real::Real;
