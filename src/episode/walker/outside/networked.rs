use std::collections::BTreeMap;
use std::sync::Arc;

use super::carry_out;
use crate::walker::WalkPolicy;
use crate::{Cast, EpisodeRule, ObservationSpec, Scene};
use base::keys;
use base::seed::Stream;
use learn::FrameStack;
use world::av::Fault;
use world::av::onnx::{Network, Runner};
use world::sim::WalkCommand;

keys! {
    /// A network in an ONNX file with one input, the state (1, 4; more with `road`, `rays` and `others`), and one output, the action: heading and speed. A report
    /// writes its trained pedestrians as such files.
    pub struct NetworkedKeys = "onnx" {
        /// The file.
        model: String as Path,
        /// The output that is the action, where the file has several, as one of stable-baselines3's guide has.
        output: Option<String>,
    }
}

/// The properties that must be those of the scenario.
const FRAMES: [&str; 3] = ["state", "state_frame", "action_frame"];

/// Why a network cannot control one pedestrian.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnsuitableNetwork {
    #[error(
        "its input has {0} numbers, and a state of a pedestrian has 4, or with `road`, `rays` and `others` a multiple of 4; several states are a multiple of that"
    )]
    Input(usize),
    #[error("its output has {0} numbers instead of 2: heading and speed")]
    Output(usize),
}

/// Checks whether a network can control the pedestrians of a cast that are left to it, by what its file says, and the numbers of its input.
///
/// # Errors
/// Why it cannot, as a part of a sentence.
pub fn network_fits(
    interface: &BTreeMap<String, String>,
    inputs: usize,
    cast: &Cast,
    rule: &EpisodeRule,
) -> Result<(), &'static str> {
    if !inputs.is_multiple_of(cast.obs_dim()) {
        return Err("its network does not fit the states of the body");
    }
    let present = cast.interface(rule);
    let is_other = |(name, value): &(&str, String)| {
        FRAMES.contains(name) && interface.get(*name).is_some_and(|known| known != value)
    };
    match present.iter().any(is_other) {
        true => Err("its network was trained with other frames or units of state and action"),
        false => Ok(()),
    }
}

/// How episodes differ from those of the training of a network that [fits](network_fits), as a part of a sentence; `None` as far as its file says.
pub fn network_differs(interface: &BTreeMap<String, String>, cast: &Cast, rule: &EpisodeRule) -> Option<String> {
    let differs = |(name, now): (&'static str, String)| {
        let then = interface.get(name).filter(|then| **then != now)?;
        match name {
            "body" => Some(format!("its body was {then}, and here it is {now}")),
            "decision_s" => Some(format!("it decided every {then} s, and here every {now} s")),
            _ => None,
        }
    };
    let found: Vec<String> = cast.interface(rule).into_iter().filter_map(differs).collect();
    (!found.is_empty()).then(|| found.join("; "))
}

/// A controller that is a network in an ONNX file.
///
/// It gets as many of the last states as its input holds, the oldest first, with zeros for those before the start of an episode, as a network
/// that was trained with `frame_stack`. All numbers are in the units of the adversary.
pub struct Networked {
    runner: Runner,
    /// What its file says about its states and actions, as [`Cast::interface`](crate::Cast::interface) names it.
    interface: Arc<BTreeMap<String, String>>,
    stack: FrameStack,
    state: Vec<f64>,
    action: Vec<f64>,
    /// Whether the first decision of the episode has been taken.
    begun: bool,
    fault: Option<Fault>,
}

impl Networked {
    /// Checks whether a network can control a pedestrian.
    ///
    /// # Errors
    /// The reason why it cannot.
    pub fn check(network: &Network) -> Result<(), UnsuitableNetwork> {
        match (network.inputs(), network.outputs()) {
            (inputs, _) if !inputs.is_multiple_of(ObservationSpec::DIM) => Err(UnsuitableNetwork::Input(inputs)),
            (_, 2) => Ok(()),
            (_, outputs) => Err(UnsuitableNetwork::Output(outputs)),
        }
    }

    /// Makes one of a network that passes [`Networked::check`], with the properties of its file. Where the states of an episode do not fit its input,
    /// or are in other frames than those of its training, it fails.
    pub fn new(network: Arc<Network>, interface: Arc<BTreeMap<String, String>>) -> Self {
        let stack = FrameStack::new(ObservationSpec::DIM, network.inputs() / ObservationSpec::DIM);
        let action = vec![0.0; network.outputs()];
        Self::within(Runner::new(network), interface, stack, action)
    }

    fn within(runner: Runner, interface: Arc<BTreeMap<String, String>>, stack: FrameStack, action: Vec<f64>) -> Self {
        Self { runner, interface, stack, state: vec![0.0; ObservationSpec::DIM], action, begun: false, fault: None }
    }
}

impl WalkPolicy for Networked {
    fn fits(&self, cast: &Cast, rule: &EpisodeRule) -> Result<(), &'static str> {
        network_fits(&self.interface, self.stack.as_slice().len(), cast, rule)
    }

    fn differs(&self, cast: &Cast, rule: &EpisodeRule) -> Option<String> {
        network_differs(&self.interface, cast, rule)
    }

    fn begin(&mut self, _: Stream) {
        (self.begun, self.fault) = (false, None);
    }

    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        if !self.begun
            && let Err(reason) = self.fits(&scene.cast(), &scene.scenario.episode)
        {
            self.fault = Some(Fault::Answer(reason));
            return;
        }
        let (numbers, inputs) = (scene.obs_dim(), self.stack.as_slice().len());
        if numbers != self.state.len() {
            self.state.resize(numbers, 0.0);
            self.stack = FrameStack::new(numbers, inputs / numbers);
        }
        scene.write_state(&mut self.state);
        if std::mem::replace(&mut self.begun, true) {
            self.stack.push(&self.state);
        } else {
            self.stack.begin(&self.state);
        }
        let answer = self.runner.run(self.stack.as_slice().iter().map(|number| *number as f32).collect());
        let action = answer.map(|answer| {
            self.action.iter_mut().zip(answer).for_each(|(number, given)| *number = f64::from(given));
            self.action.as_mut_slice()
        });
        self.fault = carry_out(scene, action, commands);
    }

    fn fault(&self) -> Option<Fault> {
        self.fault
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(Self::within(
            self.runner.clone(),
            self.interface.clone(),
            self.stack.clone(),
            self.action.clone(),
        )))
    }
}
