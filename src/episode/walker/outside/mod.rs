//! Controllers that are not part of the program: a [`Programmed`] one is a separate program, a [`Networked`] one is a network in an ONNX file.
//!
//! Both get the state of the controlled pedestrians and give an action, as a trained policy does.

mod message;
mod networked;
mod programmed;

pub use message::PROTOCOL;
pub use networked::{Networked, NetworkedKeys, UnsuitableNetwork, network_differs, network_fits};
pub use programmed::{Programmed, ProgrammedKeys};

use crate::Scene;
use world::av::Fault;
use world::sim::WalkCommand;

/// Writes the commands for an action, cut to its bounds; without one the pedestrians stand.
fn carry_out(scene: &Scene<'_>, action: Result<&mut [f64], Fault>, commands: &mut [WalkCommand]) -> Option<Fault> {
    match action {
        Ok(action) => {
            for (number, (low, high)) in action.iter_mut().zip(scene.bounds()) {
                *number = number.clamp(*low, *high);
            }
            scene.write_commands(action, commands);
            None
        }
        Err(fault) => {
            commands.copy_from_slice(scene.commands());
            Some(fault)
        }
    }
}
