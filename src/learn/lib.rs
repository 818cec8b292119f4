//! Reinforcement learning: proximal policy optimisation and its parts. It does not depend on cars or traffic.
//!
//! An [`Env`] is the task, a [`PpoConfig`] holds the settings, and [`train`] turns both into an [`ActorCritic`] and its
//! learning curve. A [`Trainer`] does the same update by update and can be saved in between. The algorithm is that of
//! stable-baselines3's `PPO` for continuous actions, with the same order of operations: collect a rollout, estimate
//! advantages, then several epochs of minibatches, each with its own gradient step. Its schedules, early stopping, stacked
//! observations, and normalised observations and rewards are included. Observations are stacked first, then normalised.
//!
//! All random numbers come from named streams, and parallel environments have streams of their own. The same seed therefore
//! gives the same bits on any number of threads. This is true between processors that agree in whether they have AVX2 and
//! fused multiply-add: if available, these instructions compute the minibatches, and they round differently. With
//! [`PpoConfig::portable_bits`] they are not used, and the bits are the same on all processors. Acting never uses them: a
//! trained policy acts the same everywhere.
//!
//! Networks compute in `f32`; rewards, advantages, densities and losses are `f64`. Matrices are column-major, one sample
//! per column. Acting and learning allocate nothing except the report of each update.

mod env;
mod schedule;
mod frame_stack;
mod shaping;

mod normal;
mod arithmetic;
mod tanh;
mod real;
mod product;
mod mlp;
mod init;
mod moments;
mod gaussian;
mod actor_critic;

mod checkpoint_error;
mod archive;
mod checkpoint;
mod onnx;

mod config;
mod train_error;
mod log;
mod gae;
mod rollout;
mod lane;
mod collector;
mod minibatch;
mod loss;
mod adam;
mod learner;
mod recorded;
mod cloning;
mod curve;
mod trained;
mod trainer;
mod train_state;

pub use actor_critic::{ActorCritic, Scratch};
pub use arithmetic::Real;
pub use checkpoint_error::CheckpointError;
pub use cloning::{Fitted, fit};
pub use config::{ADAM_EPS, Credit, FirstNetworks, Policies, PpoConfig, UnsuitableNetworks};
pub use env::{Agent, Env, Step};
pub use frame_stack::FrameStack;
pub use log::{FinishedEpisode, UpdateLog};
pub use moments::RunningMoments;
pub use normal::standard_normal;
pub use onnx::{Inputs, onnx_properties};
pub use recorded::{RecordedRollout, RecordedUpdate, update_on_recorded};
pub use schedule::Schedule;
pub use shaping::shaping;
pub use train_error::{Quantity, TrainError};
pub use trained::Trained;
pub use trainer::{Experience, Trainer, first_networks, train};
