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

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::super::{Model, ModelError};

    fn varint(mut number: u64) -> Vec<u8> {
        let mut bytes = Vec::new();
        while number >= 0x80 {
            bytes.push(number as u8 | 0x80);
            number >>= 7;
        }
        bytes.push(number as u8);
        bytes
    }

    /// A field with bytes, and one with a number.
    fn field(number: u8, bytes: &[u8]) -> Vec<u8> {
        [vec![number << 3 | 2], varint(bytes.len() as u64), bytes.to_vec()].concat()
    }

    fn number(field: u8, number: u64) -> Vec<u8> {
        [vec![field << 3], varint(number)].concat()
    }

    /// A constant of whole numbers, and one of floats.
    fn sizes(name: &str, sizes: &[i64]) -> Vec<u8> {
        let raw: Vec<u8> = sizes.iter().flat_map(|size| size.to_le_bytes()).collect();
        field(5, &[number(1, sizes.len() as u64), number(2, 7), field(9, &raw), field(8, name.as_bytes())].concat())
    }

    fn scalar(name: &str, value: f32) -> Vec<u8> {
        field(5, &[number(2, 1), field(9, &value.to_le_bytes()), field(8, name.as_bytes())].concat())
    }

    fn floats(name: &str, shape: &[u64], values: &[f32]) -> Vec<u8> {
        let raw: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let shape: Vec<u8> = shape.iter().flat_map(|size| number(1, *size)).collect();
        field(5, &[shape, number(2, 1), field(9, &raw), field(8, name.as_bytes())].concat())
    }

    fn node(kind: &str, inputs: &[&str], output: &str) -> Vec<u8> {
        let inputs: Vec<u8> = inputs.iter().flat_map(|name| field(1, name.as_bytes())).collect();
        field(1, &[inputs, field(2, output.as_bytes()), field(4, kind.as_bytes())].concat())
    }

    /// A network from `ego` to `y`.
    fn model(parts: &[Vec<u8>]) -> Result<(), ModelError> {
        let value = |place: u8, name: &str, shape: [u64; 2]| {
            let dimensions: Vec<u8> = shape.iter().flat_map(|size| field(1, &number(1, *size))).collect();
            let tensor = [number(1, 1), field(2, &dimensions)].concat();
            field(place, &[field(1, name.as_bytes()), field(2, &field(1, &tensor))].concat())
        };
        let graph = [parts.concat(), value(11, "ego", [1, 4]), value(12, "y", [1, 2])].concat();
        let opset = field(8, &number(2, 17));
        Model::read([number(1, 8), field(7, &graph), opset].concat()).map(|_| ())
    }

    #[test]
    fn operators_that_take_the_machine_are_refused_before_they_run() {
        let last = || node("MatMul", &["ego", "w"], "y");
        let weights = || floats("w", &[4, 2], &[0.5; 8]);
        let drives = |parts: &[Vec<u8>]| model(&[parts.to_vec(), vec![weights(), last()]].concat());
        drives(&[]).unwrap();
        let made = |name: &str, size: &[i64]| {
            vec![sizes(&format!("{name}_size"), size), node("ConstantOfShape", &[&format!("{name}_size")], name)]
        };
        let with = |parts: [Vec<Vec<u8>>; 2], operator: Vec<u8>| [parts.concat(), vec![operator]].concat();
        let range =
            vec![scalar("from", 0.0), scalar("to", 1e9), scalar("by", 1.0), node("Range", &["from", "to", "by"], "r")];
        let endless =
            vec![scalar("from", 0.0), scalar("to", 1.0), scalar("by", 0.0), node("Range", &["from", "to", "by"], "r")];
        let resized = vec![floats("scales", &[2], &[1.0, 1e9]), node("Resize", &["ego", "", "scales"], "r")];
        for (name, parts, reason) in [
            (
                "broadcast",
                with([made("a", &[1 << 16, 1]), made("b", &[1, 1 << 16])], node("Add", &["a", "b"], "c")),
                "Add",
            ),
            ("constant", made("a", &[1 << 40]), "ConstantOfShape"),
            ("negative", made("a", &[-1, 1 << 62]), "invalid"),
            ("expand", vec![sizes("s", &[1 << 30, 4]), node("Expand", &["ego", "s"], "r")], "Expand"),
            ("tile", vec![sizes("s", &[1 << 20, 1 << 20]), node("Tile", &["ego", "s"], "r")], "Tile"),
            ("pad", vec![sizes("s", &[0, 0, 0, 1 << 40]), node("Pad", &["ego", "s"], "r")], "Pad"),
            ("range", range, "Range"),
            ("endless range", endless, "Range"),
            ("resize", resized, "Resize"),
            ("product", with([made("a", &[1000, 1000]), Vec::new()], node("MatMul", &["a", "a"], "c")), "MatMul"),
            ("varying", vec![node("NonZero", &["ego"], "r")], "NonZero"),
            ("varying size", vec![node("ConstantOfShape", &["ego"], "r")], "ConstantOfShape"),
            ("order", vec![node("Relu", &["later"], "r"), node("Relu", &["ego"], "later")], "later"),
            ("loop", vec![node("Loop", &["ego"], "r")], "Loop"),
            ("branches", vec![node("If", &["ego"], "r")], "If"),
        ] {
            let begun = Instant::now();
            let refused = drives(&parts).err();
            let text = refused.map(|error| error.to_string()).unwrap_or_default();
            assert!(text.contains(reason), "{name}: {text:?}");
            // On a busy machine and without optimization; it separates a refusal from an evaluation.
            assert!(begun.elapsed() < Duration::from_secs(20), "{name}: {:?}", begun.elapsed());
        }
    }

    #[test]
    fn sizes_may_follow_from_shapes() {
        let parts = [
            floats("w", &[4, 2], &[0.5; 8]),
            node("Shape", &["ego"], "shape"),
            node("ConstantOfShape", &["shape"], "zeros"),
            node("Add", &["ego", "zeros"], "sum"),
            node("MatMul", &["sum", "w"], "y"),
        ];
        model(&parts).unwrap();
    }
}
