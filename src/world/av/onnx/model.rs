use rten::{Dimension, NodeId, RunOptions, ValueOrView};
use rten_tensor::prelude::*;
use rten_tensor::{Tensor, TensorView};

use super::inputs::Input;
use super::vetting::{self, load};
use crate::av::Fault;
use crate::av::view::View;
use base::contained::contained;

/// Maximum number of actors and of points of the route in a network's inputs.
const MAX_ACTORS: usize = 64;
const MAX_POINTS: usize = 40;
/// Maximum number of numbers of a state.
const MAX_STATE: usize = 1 << 16;

/// Why a file contains no driver.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    #[error("{0}")]
    Unreadable(String),
    #[error(
        "its input `{0}` is none of `ego`, `actors`, `route`, and no state: at most {MAX_STATE} numbers `NAME_in` with an output `NAME_out`"
    )]
    UnknownInput(String),
    #[error("its input `{name}` must have the shape {wanted}")]
    Shape { name: &'static str, wanted: &'static str },
    #[error("it has no input")]
    NoInput,
    #[error("its output has {0} numbers instead of two (acceleration, steer) or three (throttle, brake, steer)")]
    Output(usize),
    #[error("it cannot be run: {0}")]
    Unrunnable(String),
}

/// Numbers that are carried from tick to tick: an input, and the output that becomes it.
struct State {
    name: String,
    input: NodeId,
    output: NodeId,
    shape: Vec<usize>,
    size: usize,
}

/// A network that drives.
pub struct Model {
    network: rten::Model,
    inputs: Vec<(NodeId, Input)>,
    states: Vec<State>,
    output: NodeId,
    numbers: usize,
}

impl Model {
    /// Reads a network from the bytes of an ONNX file, and evaluates it once. A file with several outputs needs the name of one.
    ///
    /// # Errors
    /// It is not ONNX, has operators that are not supported here, or does not fit the contract of this module.
    pub fn read(bytes: Vec<u8>, output: Option<&str>) -> Result<Self, ModelError> {
        // The file is the user's, and the runtime is a dependency: a panic of the runtime must be an error here, too.
        let panicked = |_| Err(ModelError::Unreadable("the runtime cannot cope with it".into()));
        contained(|| Self::read_and_try(bytes, output)).unwrap_or_else(panicked)
    }

    fn read_and_try(bytes: Vec<u8>, output: Option<&str>) -> Result<Self, ModelError> {
        let mut this = Self::of(load(bytes).map_err(ModelError::Unreadable)?, output)?;
        let empty = this.encode(&View::default(), &vec![0.0; this.carried()]);
        let answer = this.answer(&empty, RunOptions::default()).map_err(ModelError::Unrunnable)?;
        this.numbers = answer.len() - this.carried();
        if [2, 3].contains(&this.numbers) { Ok(this) } else { Err(ModelError::Output(this.numbers)) }
    }

    /// A network whose inputs and output have the names and shapes of the contract.
    fn of(network: rten::Model, output: Option<&str>) -> Result<Self, ModelError> {
        let (mut inputs, mut states) = (Vec::new(), Vec::new());
        for id in network.input_ids() {
            match state(&network, *id) {
                Some(state) => states.push(state),
                None => inputs.push((*id, input(&network, *id)?)),
            }
        }
        if inputs.is_empty() {
            return Err(ModelError::NoInput);
        }
        let carried: Vec<NodeId> = states.iter().map(|state| state.output).collect();
        let output = vetting::output(&network, output, &carried).map_err(ModelError::Unreadable)?;
        Ok(Self { network, inputs, states, output, numbers: 0 })
    }

    /// Maximum number of actors and of points of the route that it receives.
    pub(super) fn room(&self) -> (usize, usize) {
        let mut room = (0, 0);
        for (_, input) in &self.inputs {
            match input {
                Input::Ego => {}
                Input::Actors(rows) => room.0 = *rows,
                Input::Route(rows) => room.1 = *rows,
            }
        }
        room
    }

    /// How many numbers it carries from tick to tick: all its states, one after the other.
    pub(super) fn carried(&self) -> usize {
        self.states.iter().map(|state| state.size).sum()
    }

    /// What it carries from tick to tick, in words.
    pub fn carries(&self) -> Option<String> {
        let all: Vec<String> = self.states.iter().map(|state| format!("`{}` {:?}", state.name, state.shape)).collect();
        let state = all.join(", ");
        (!all.is_empty()).then(|| format!("carries {state} from tick to tick, from 0 at the start of an episode"))
    }

    /// The numbers for each of its inputs, and for each of its states.
    pub(super) fn encode(&self, view: &View, mut memory: &[f32]) -> Vec<Vec<f32>> {
        let states = self.states.iter().filter_map(|state| memory.split_off(..state.size)).map(<[f32]>::to_vec);
        self.inputs.iter().map(|(_, input)| input.numbers(view)).chain(states).collect()
    }

    /// Its answer to numbers made by [`Model::encode`]: two or three numbers, and then what it carries.
    pub(super) fn decide(&self, inputs: &[Vec<f32>], options: RunOptions) -> Result<Vec<f32>, Fault> {
        let answer = self.answer(inputs, options).map_err(|_| Fault::Answer("the network failed"))?;
        if answer.len() != self.numbers + self.carried() {
            return Err(Fault::Answer("another number of outputs than before"));
        }
        let finite = answer.iter().all(|number| number.is_finite());
        if finite { Ok(answer) } else { Err(Fault::Answer("a control or a state is not finite")) }
    }

    fn answer(&self, inputs: &[Vec<f32>], options: RunOptions) -> Result<Vec<f32>, String> {
        let value = |id: NodeId, shape: &[usize], numbers: &Vec<f32>| {
            let view: TensorView<f32> = TensorView::from_data(shape, numbers.as_slice());
            (id, ValueOrView::from(view.to_tensor()))
        };
        let (seen, carried) = inputs.split_at(self.inputs.len());
        let seen = self.inputs.iter().zip(seen).map(|((id, input), numbers)| {
            let (shape, rank) = input.shape();
            value(*id, &shape[..rank], numbers)
        });
        let carried = self.states.iter().zip(carried).map(|(state, numbers)| value(state.input, &state.shape, numbers));
        let mut wanted = vec![self.output];
        wanted.extend(self.states.iter().map(|state| state.output));
        let answers = self.network.run(seen.chain(carried).collect(), &wanted, Some(options));
        let mut all = Vec::new();
        for (place, answer) in answers.map_err(|error| error.to_string())?.into_iter().enumerate() {
            let answer: Tensor<f32> = answer.into_tensor().ok_or("its output is not in 32-bit floats")?;
            let state = place.checked_sub(1).map(|place| &self.states[place]);
            if let Some(State { name, shape, .. }) = state.filter(|state| answer.shape() != state.shape) {
                let given = answer.shape();
                return Err(format!("its state `{name}_in` has the shape {shape:?}, and `{name}_out` {given:?}"));
            }
            all.extend(answer.iter().copied());
        }
        Ok(all)
    }
}

/// The state that an input and an output carry; `None` for an input that is no part of one.
fn state(network: &rten::Model, id: NodeId) -> Option<State> {
    let info = network.node_info(id)?;
    let name = info.name()?.strip_suffix("_in")?.to_owned();
    let output = network.find_node(&format!("{name}_out")).filter(|output| network.output_ids().contains(output))?;
    // A free length is a number of worlds, each of which has a state of its own.
    let length = |size| if let Dimension::Fixed(length) = size { length } else { 1 };
    let shape: Vec<usize> = info.shape()?.into_iter().map(length).collect();
    let size = shape.iter().try_fold(1_usize, |size, length| size.checked_mul(*length))?;
    (1..=MAX_STATE).contains(&size).then_some(State { name, input: id, output, shape, size })
}

/// The content of an input, by its name and shape.
fn input(network: &rten::Model, id: NodeId) -> Result<Input, ModelError> {
    let info = network.node_info(id);
    let name = info.as_ref().and_then(|info| info.name()).unwrap_or_default().to_string();
    let shape = info.as_ref().and_then(|info| info.shape()).unwrap_or_default();
    let single = |size: &Dimension| matches!(size, Dimension::Fixed(1) | Dimension::Symbolic(_));
    let rows = |width: usize, most: usize| match shape.as_slice() {
        [first, Dimension::Fixed(rows), Dimension::Fixed(last)]
            if single(first) && *last == width && (1..=most).contains(rows) =>
        {
            Some(*rows)
        }
        _ => None,
    };
    match name.as_str() {
        "ego" => match shape.as_slice() {
            [first, Dimension::Fixed(4)] if single(first) => Ok(Input::Ego),
            _ => Err(ModelError::Shape { name: "ego", wanted: "(1, 4)" }),
        },
        "actors" => {
            let wrong = ModelError::Shape { name: "actors", wanted: "(1, K, 8) with K from 1 to 64" };
            rows(8, MAX_ACTORS).map(Input::Actors).ok_or(wrong)
        }
        "route" => {
            let wrong = ModelError::Shape { name: "route", wanted: "(1, R, 3) with R from 1 to 40" };
            rows(3, MAX_POINTS).map(Input::Route).ok_or(wrong)
        }
        _ => Err(ModelError::UnknownInput(name)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_network_answers_as_it_does_in_onnxruntime() {
        let model = Model::read(include_bytes!("../../../../tests/reference/onnx/follow.onnx").to_vec(), None).unwrap();
        assert_eq!((model.room(), model.numbers), ((2, 4), 2));
        let recorded: serde_json::Value =
            serde_json::from_str(include_str!("../../../../tests/reference/onnx/follow.json")).unwrap();
        for case in recorded["cases"].as_array().unwrap() {
            let numbers = |key: &str| -> Vec<f32> {
                case[key].as_array().unwrap().iter().map(|number| number.as_f64().unwrap() as f32).collect()
            };
            let answer = model.decide(&["ego", "actors", "route"].map(numbers), RunOptions::default()).unwrap();
            for (mine, wanted) in answer.iter().zip(numbers("control")) {
                assert!((mine - wanted).abs() < 1e-5, "{answer:?} instead of {wanted}");
            }
        }
    }
}
