//! One episode for people: in words, as a strip of frames, as an animation.

mod narrative;
mod view;
mod scene;
mod sheet;
mod strip;
mod animation;

pub use animation::animation;
pub use narrative::{Narrative, in_short, narrative};
pub use strip::strip;
use view::EpisodeView;
