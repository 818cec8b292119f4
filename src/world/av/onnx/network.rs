use std::sync::{Arc, Mutex, PoisonError};

use rten::{DataType, Dimension, NodeId, RunOptions, ValueOrView, ValueType};
use rten_tensor::prelude::*;
use rten_tensor::{Tensor, TensorView};

use super::engine::{Batch, Engine};
use super::vetting::{self, load};
use crate::av::Fault;
use base::contained::contained;

/// Maximum number of inputs that a network takes.
const MAX_NUMBERS: usize = 1 << 16;

/// Why a file contains no network of plain numbers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NetworkError {
    #[error("{0}")]
    Unreadable(String),
    #[error("it needs exactly one input, and has {0}")]
    Inputs(usize),
    #[error("its input must have the shape (1, n) or (batch, n) in 32-bit floats or 64-bit floats")]
    Input,
    #[error("it cannot be run: {0}")]
    Unrunnable(String),
}

/// A network with one input, a row of numbers, and one output.
pub struct Network {
    network: rten::Model,
    input: NodeId,
    output: NodeId,
    inputs: usize,
    outputs: usize,
}

impl Network {
    /// Reads a network from the bytes of an ONNX file, and runs it once on zeros. Numbers of 64 bits are rounded to 32 bits. A
    /// file with several outputs needs the name of one.
    ///
    /// # Errors
    /// It is not ONNX, has operators that are not supported here, or has not exactly one row as input and such an output.
    pub fn read(bytes: Vec<u8>, output: Option<&str>) -> Result<Self, NetworkError> {
        // The file is the user's, and the runtime is a dependency: a panic of the runtime must be an error here, too.
        let panicked = |_| Err(NetworkError::Unreadable("the runtime cannot cope with it".into()));
        contained(|| Self::read_and_try(bytes, output)).unwrap_or_else(panicked)
    }

    fn read_and_try(bytes: Vec<u8>, output: Option<&str>) -> Result<Self, NetworkError> {
        let mut this = Self::of(load(bytes).map_err(NetworkError::Unreadable)?, output)?;
        let zeros = vec![0.0; this.inputs];
        this.outputs = this.answer(&zeros, RunOptions::default()).map_err(NetworkError::Unrunnable)?.len();
        Ok(this)
    }

    /// A network with one row as input and one output.
    fn of(network: rten::Model, output: Option<&str>) -> Result<Self, NetworkError> {
        let &[input] = network.input_ids() else { return Err(NetworkError::Inputs(network.input_ids().len())) };
        let output = vetting::output(&network, output, &[]).map_err(NetworkError::Unreadable)?;
        let inputs = width(&network, input).ok_or(NetworkError::Input)?;
        Ok(Self { network, input, output, inputs, outputs: 0 })
    }

    /// The number of numbers that it takes.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// The number of numbers that it gives.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    fn decide(&self, numbers: &[f32], options: RunOptions) -> Result<Vec<f32>, Fault> {
        let answer = self.answer(numbers, options).map_err(|_| Fault::Answer("the network failed"))?;
        if answer.len() != self.outputs {
            return Err(Fault::Answer("another number of outputs than before"));
        }
        let finite = answer.iter().all(|number| number.is_finite());
        if finite { Ok(answer) } else { Err(Fault::Answer("a number is not finite")) }
    }

    fn answer(&self, numbers: &[f32], options: RunOptions) -> Result<Vec<f32>, String> {
        let row: TensorView<f32> = TensorView::from_data(&[1, self.inputs], numbers);
        let input = vec![(self.input, ValueOrView::from(row.to_tensor()))];
        let [answer] = self.network.run_n(input, [self.output], Some(options)).map_err(|error| error.to_string())?;
        let answer: Tensor<f32> = answer.into_tensor().ok_or("its output is not in 32-bit floats")?;
        Ok(answer.iter().copied().collect())
    }
}

/// The length of the rows that an input takes; `None` if it takes something else.
fn width(network: &rten::Model, id: NodeId) -> Option<usize> {
    let info = network.node_info(id)?;
    let floats = matches!(info.dtype(), None | Some(ValueType::Tensor(DataType::Float)));
    match info.shape()?.as_slice() {
        [Dimension::Fixed(1) | Dimension::Symbolic(_), Dimension::Fixed(width)]
            if floats && (1..=MAX_NUMBERS).contains(width) =>
        {
            Some(*width)
        }
        _ => None,
    }
}

/// A network with the thread that it runs on; copies share both.
#[derive(Clone)]
pub struct Runner {
    engine: Arc<Mutex<Engine>>,
}

impl Runner {
    /// Starts the thread.
    pub fn new(network: Arc<Network>) -> Self {
        let engine = Engine::new(move |numbers, options| network.decide(&numbers[0], options));
        Self { engine: Arc::new(Mutex::new(engine)) }
    }

    /// The network's answer to a row of numbers.
    ///
    /// # Errors
    /// The network fails, or its answer is not finite.
    pub fn run(&self, numbers: Vec<f32>) -> Result<Vec<f32>, Fault> {
        let mut batch = Batch { questions: vec![vec![numbers]], answers: Vec::new() };
        self.engine.lock().unwrap_or_else(PoisonError::into_inner).answer(&mut batch);
        batch.answers.pop().unwrap_or(Err(Fault::Answer("the network failed")))
    }
}
