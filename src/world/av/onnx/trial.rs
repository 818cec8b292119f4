//! The first evaluation of a network, operator by operator. Each operator runs only if the size of its results and its work are small.
//!
//! The inputs of a network have fixed sizes, and numbers that set the size of a result may not depend on them. So all later evaluations
//! have the sizes of the first one.

use std::collections::{BTreeMap, BTreeSet};

use rten::{Model, ModelOptions, NodeId, RunOptions, Value, ValueOrView, ValueView};
use rten_tensor::prelude::*;

use super::cost::{Cost, Known, Operator, cost};

/// The most numbers in all results together: 64 MB.
const MOST_NUMBERS: u64 = 1 << 24;
/// The most multiplications, additions and copies of an evaluation.
const MOST_WORK: u64 = 1 << 28;
/// The most numbers that set the size of a result.
const MOST_SIZES: u64 = 64;

/// Loads a file, as it is or optimized. To optimize a network, the runtime evaluates the operators on constants, so it is evaluated within
/// bounds before that.
///
/// # Errors
/// It is not ONNX, or has operators that are not supported here.
pub(super) fn load(bytes: Vec<u8>, optimized: bool) -> Result<Model, String> {
    let mut options = ModelOptions::with_all_ops();
    options.enable_optimization(optimized).load(bytes).map_err(|error| error.to_string())
}

/// Evaluates a network that was loaded as it is in its file.
///
/// # Errors
/// An operator that makes too many numbers or needs too much work, whose result has no constant size, or that fails.
pub(super) fn evaluate(network: &Model, operators: &[Operator], inputs: Vec<(NodeId, Value)>) -> Result<(), String> {
    let made = operators.iter().filter(|operator| operator.kind != "Constant").flat_map(|operator| &operator.outputs);
    let made = made.map(String::as_str).collect();
    let mut trial = Trial { network, made, varying: BTreeSet::new(), results: BTreeMap::new(), numbers: 0, work: 0 };
    for (id, value) in inputs {
        let name = network.node_info(id).and_then(|info| info.name().map(str::to_owned)).unwrap_or_default();
        trial.varying.insert(name.clone());
        trial.results.insert(name, value);
    }
    operators.iter().try_for_each(|operator| trial.step(operator))?;
    let missing = network.output_ids().iter().find(|id| {
        let name = network.node_info(**id).and_then(|info| info.name().map(str::to_owned)).unwrap_or_default();
        !trial.results.contains_key(&name)
    });
    missing.map_or(Ok(()), |_| Err("its output is the result of no operator".to_owned()))
}

/// The results so far.
struct Trial<'a> {
    network: &'a Model,
    /// The results of all operators.
    made: BTreeSet<&'a str>,
    /// Values that depend on the inputs of the network.
    varying: BTreeSet<String>,
    results: BTreeMap<String, Value>,
    numbers: u64,
    work: u64,
}

impl Trial<'_> {
    fn step(&mut self, operator: &Operator) -> Result<(), String> {
        let kind = &operator.kind;
        let named = operator.outputs.iter().filter(|name| !name.is_empty());
        let ids: Vec<(&String, NodeId)> =
            named.filter_map(|name| self.network.find_node(name).map(|id| (name, id))).collect();
        if ids.iter().any(|(name, _)| self.results.contains_key(*name)) {
            return Err(format!("two results of its operators have the name `{}`", operator.outputs[0]));
        }
        // A constant is in the file.
        if kind == "Constant" || ids.is_empty() {
            return Ok(());
        }
        let known = operator.inputs.iter().enumerate().map(|(place, name)| self.known(operator, place, name));
        let known: Vec<Option<Known>> = known.collect::<Result<_, _>>()?;
        let Cost { elements, work } = cost(operator, &known);
        (self.numbers, self.work) = (self.numbers.saturating_add(elements), self.work.saturating_add(work));
        if self.numbers > MOST_NUMBERS {
            return Err(format!("with its operator {kind} it makes more than {MOST_NUMBERS} numbers"));
        }
        if self.work > MOST_WORK {
            return Err(format!("with its operator {kind} an evaluation has more than {MOST_WORK} steps"));
        }
        let inputs: BTreeMap<&String, &Value> =
            operator.inputs.iter().filter_map(|name| Some((name, self.results.get(name)?))).collect();
        let varies =
            !["Shape", "Size"].contains(&kind.as_str()) && inputs.keys().any(|name| self.varying.contains(*name));
        let inputs = inputs
            .into_iter()
            .filter_map(|(name, value)| Some((self.network.find_node(name)?, ValueOrView::from(value.as_view()))))
            .collect();
        let outputs: Vec<NodeId> = ids.iter().map(|(_, id)| *id).collect();
        let made =
            self.network.run(inputs, &outputs, Some(RunOptions::default())).map_err(|error| error.to_string())?;
        let numbers: u64 =
            made.iter().map(|value| value.as_view().shape().iter().map(|size| *size as u64).product::<u64>()).sum();
        if numbers > elements {
            return Err(format!("its operator {kind} made {numbers} numbers, and its inputs explain {elements}"));
        }
        for ((name, _), value) in ids.into_iter().zip(made) {
            if varies {
                self.varying.insert(name.clone());
            }
            self.results.insert(name.clone(), value);
        }
        Ok(())
    }

    /// An input of an operator; none if it is left out.
    fn known(&self, operator: &Operator, place: usize, name: &str) -> Result<Option<Known>, String> {
        if name.is_empty() {
            return Ok(None);
        }
        let kind = &operator.kind;
        let sizing = operator.sizing().contains(&place);
        if sizing && self.varying.contains(name) {
            return Err(format!(
                "the result of its operator {kind} has a size that is not constant; export it with constant sizes"
            ));
        }
        let constant = || {
            let id = self.network.find_node(name).filter(|_| !self.made.contains(name));
            id.ok_or_else(|| format!("its operator {kind} has the input `{name}`, which no operator before it makes"))
        };
        let shape: Vec<u64> = match self.results.get(name) {
            Some(value) => value.as_view().shape().iter().map(|size| *size as u64).collect(),
            None => {
                let info = self.network.node_info(constant()?).and_then(|info| info.shape()).unwrap_or_default();
                let size = |size: &rten::Dimension| match size {
                    rten::Dimension::Fixed(size) => *size as u64,
                    rten::Dimension::Symbolic(_) => 1,
                };
                info.iter().map(size).collect()
            }
        };
        let mut known = Known { shape, numbers: Vec::new() };
        if sizing && operator.kind != "NonZero" {
            if known.shape.iter().product::<u64>() > MOST_SIZES {
                return Err(format!(
                    "the sizes of the result of its operator {kind} are more than {MOST_SIZES} numbers"
                ));
            }
            known.numbers = match self.results.get(name) {
                Some(value) => numbers(&value.as_view()),
                None => {
                    let made = self.network.run(Vec::new(), &[constant()?], Some(RunOptions::default()));
                    let made = made.map_err(|error| error.to_string())?;
                    made.first().map(|value| numbers(&value.as_view())).unwrap_or_default()
                }
            };
        }
        Ok(Some(known))
    }
}

fn numbers(value: &ValueView) -> Vec<f64> {
    match value {
        ValueView::FloatTensor(tensor) => tensor.iter().map(|number| f64::from(*number)).collect(),
        ValueView::Int32Tensor(tensor) => tensor.iter().map(|number| f64::from(*number)).collect(),
        ValueView::Int8Tensor(tensor) => tensor.iter().map(|number| f64::from(*number)).collect(),
        ValueView::UInt8Tensor(tensor) => tensor.iter().map(|number| f64::from(*number)).collect(),
        _ => Vec::new(),
    }
}
