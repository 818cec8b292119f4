//! A learnt driver: a network in an ONNX file.
//!
//! The network has some of these inputs, distinguished by their names, in 32-bit floats. All are in the ego's frame (x ahead, y to
//! the left, angles counter-clockwise), in m, m/s, rad:
//!
//! | input | shape | numbers |
//! |---|---|---|
//! | `ego` | (1, 4) | speed, speed limit, light ahead (0 none, 1 green, 2 yellow, 3 red), distance to it |
//! | `actors` | (1, K, 8) | of each of the K nearest in sight: 1 (0 when there are fewer), x, y, heading, velocity x and y, length, width |
//! | `route` | (1, R, 3) | of R points, 2 m apart: x, y, heading; the last one again where the road ends |
//!
//! A pair of an input `NAME_in` and an output `NAME_out` of one shape is state: 0 at the first tick of an episode, and then what the tick before gave.
//! Its one other output, or the one that is named, holds two numbers, acceleration (m/s²) and steer, or three: throttle, brake, steer. K and R are read from the
//! file; the first dimension is 1 or free.
//!
//! A file goes through `vetting`, which trusts no length in it and refuses results whose sizes are not constant. So all evaluations take the
//! memory and about the time of the first one, which has no bound here: a caller that reads untrusted files tries them in another process first.
//!
//! A [`Network`] is a network of plain numbers, without the meaning that a driver's have: a pedestrian is one.

mod inputs;
mod model;
mod encoding;
mod vetting;
mod engine;
mod driver;
mod network;

pub use driver::control;
pub use driver::{Onnx, OnnxKeys};
pub use inputs::Input;
pub use model::{Model, ModelError};
pub use network::{Network, NetworkError, Runner};
pub use vetting::outputs;
