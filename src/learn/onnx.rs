//! A learned policy as an ONNX graph, for other runtimes.
//!
//! ```text
//! state → (− mean) → (÷ deviation) → clip to ±10 → single precision → (matrix, bias, tanh)… → clip to the bounds → action
//! ```
//!
//! The first three steps are present when the policy normalises its observations.
//!
//! # Source
//! `onnx.proto` of the ONNX project; only the messages and fields that such a graph needs.

use std::collections::BTreeMap;

use prost::Message;

use super::actor_critic::ActorCritic;
use super::mlp::Layer;
use super::moments::LIMIT;
use base::messages;

/// The version of the format, and that of its operators.
const IR_VERSION: i64 = 8;
const OPERATORS: i64 = 17;
/// Numbers of element types.
const FLOAT: i32 = 1;
const DOUBLE: i32 = 11;
/// The number of the type of an attribute that is a whole number.
const INT: i32 = 2;

/// The properties of an ONNX file, by name; empty for other bytes.
pub fn onnx_properties(bytes: &[u8]) -> BTreeMap<String, String> {
    let model = Model::decode(bytes).unwrap_or_default();
    model.metadata.into_iter().map(|entry| (entry.key, entry.value)).collect()
}

messages! {
    Model {
        ir_version: i64 = 1 (int64),
        producer_name: String = 2 (string),
        graph: Option<Graph> = 7 (message, optional),
        operators: Vec<Operators> = 8 (message, repeated),
        metadata: Vec<Entry> = 14 (message, repeated),
    }
    Operators {
        version: i64 = 2 (int64),
    }
    Entry {
        key: String = 1 (string),
        value: String = 2 (string),
    }
    Graph {
        nodes: Vec<Node> = 1 (message, repeated),
        name: String = 2 (string),
        constants: Vec<Tensor> = 5 (message, repeated),
        inputs: Vec<Value> = 11 (message, repeated),
        outputs: Vec<Value> = 12 (message, repeated),
    }
    Node {
        inputs: Vec<String> = 1 (string, repeated),
        outputs: Vec<String> = 2 (string, repeated),
        name: String = 3 (string),
        operator: String = 4 (string),
        attributes: Vec<Attribute> = 5 (message, repeated),
    }
    Attribute {
        name: String = 1 (string),
        value: i64 = 3 (int64),
        kind: i32 = 20 (int32),
    }
    Tensor {
        // Not packed: the format predates that encoding, and not every reader knows it.
        shape: Vec<i64> = 1 (int64, repeated, packed = "false"),
        element: i32 = 2 (int32),
        name: String = 8 (string),
        data: Vec<u8> = 9 (bytes = "vec"),
    }
    Value {
        name: String = 1 (string),
        kind: Option<Kind> = 2 (message, optional),
    }
    Kind {
        tensor: Option<TensorKind> = 1 (message, optional),
    }
    TensorKind {
        element: i32 = 1 (int32),
        shape: Option<Shape> = 2 (message, optional),
    }
    Shape {
        dimensions: Vec<Dimension> = 1 (message, repeated),
    }
    /// A fixed length, or the name of a free one.
    Dimension {
        length: Option<i64> = 1 (int64, optional),
        name: Option<String> = 2 (string, optional),
    }
}

/// The inputs of a policy that gets plain numbers and squashes them itself.
///
/// ```text
/// inputs → flat, in a row → for each list of divisors: ÷ divisors → tanh → in a row → (matrix, bias, tanh)…
/// ```
///
/// So a number appears as often as there are lists of divisors: a small divisor tells small numbers apart, a large one large numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Name and shape of each input, without the first dimension, which is 1.
    pub shapes: Vec<(String, Vec<usize>)>,
    /// Lists of one divisor for each number of all inputs.
    pub divisors: Vec<Vec<f64>>,
}

impl Inputs {
    /// The number of components of an observation.
    pub fn observed(&self) -> usize {
        self.divisors.iter().map(Vec::len).sum()
    }

    /// Writes the observation for the numbers of all inputs in a row.
    pub fn observe(&self, numbers: &[f32], observation: &mut [f64]) {
        let squashed = self.divisors.iter().flat_map(|divisors| {
            numbers.iter().zip(divisors).map(|(number, divisor)| libm::tanh(f64::from(*number / *divisor as f32)))
        });
        observation.iter_mut().zip(squashed).for_each(|(slot, value)| *slot = value);
    }
}

/// A graph that grows node by node.
#[derive(Default)]
struct Draft {
    nodes: Vec<Node>,
    constants: Vec<Tensor>,
    /// The name of the last node's output.
    last: String,
}

impl Draft {
    /// Applies an operator to the last value and some constants.
    fn apply(&mut self, operator: &str, constants: &[&str], attributes: &[(&str, i64)], output: &str) {
        let last = std::mem::replace(&mut self.last, output.to_owned());
        let attribute = |(name, value): &(&str, i64)| Attribute { name: (*name).to_owned(), value: *value, kind: INT };
        self.nodes.push(Node {
            inputs: std::iter::once(last).chain(constants.iter().map(|name| (*name).to_owned())).collect(),
            outputs: vec![output.to_owned()],
            name: output.to_owned(),
            operator: operator.to_owned(),
            attributes: attributes.iter().map(attribute).collect(),
        });
    }

    fn floats(&mut self, name: &str, shape: &[usize], values: impl Iterator<Item = f32>) {
        self.constant(name, FLOAT, shape, values.flat_map(f32::to_le_bytes).collect());
    }

    fn doubles(&mut self, name: &str, shape: &[usize], values: impl Iterator<Item = f64>) {
        self.constant(name, DOUBLE, shape, values.flat_map(f64::to_le_bytes).collect());
    }

    fn constant(&mut self, name: &str, element: i32, shape: &[usize], data: Vec<u8>) {
        let shape = shape.iter().map(|&length| length as i64).collect();
        self.constants.push(Tensor { shape, element, name: name.to_owned(), data });
    }

    /// Joins values along their second dimension.
    fn join(&mut self, values: &[String], output: &str) {
        let (first, others) = values.split_first().expect("there is a value to join");
        self.last.clone_from(first);
        self.apply("Concat", &others.iter().map(String::as_str).collect::<Vec<_>>(), &[("axis", 1)], output);
    }

    /// Clips the last value to bounds; the result is the action.
    fn bound(&mut self, bounds: &[(f64, f64)]) {
        self.floats("low", &[bounds.len()], bounds.iter().map(|bound| bound.0 as f32));
        self.floats("high", &[bounds.len()], bounds.iter().map(|bound| bound.1 as f32));
        self.apply("Max", &["low"], &[], "raised");
        self.apply("Min", &["high"], &[], "action");
    }

    /// The bytes of a model of the graph.
    fn finish(self, inputs: Vec<Value>, output: Value, metadata: &BTreeMap<String, String>) -> Vec<u8> {
        let Self { nodes, constants, .. } = self;
        let graph = Graph { nodes, name: "policy".to_owned(), constants, inputs, outputs: vec![output] };
        let entry = |(key, value): (&String, &String)| Entry { key: key.clone(), value: value.clone() };
        let model = Model {
            ir_version: IR_VERSION,
            producer_name: "falsify".to_owned(),
            graph: Some(graph),
            operators: vec![Operators { version: OPERATORS }],
            metadata: metadata.iter().map(entry).collect(),
        };
        model.encode_to_vec()
    }

    /// Applies one affine map; its weights are column-major, those of the graph row-major.
    fn layer(&mut self, number: usize, layer: &Layer, parameters: &[f32]) {
        let name = |part: &str| format!("{part}.{number}");
        let weight = &parameters[layer.weight.clone()];
        let rows = (0..layer.outputs).flat_map(|row| weight.iter().skip(row).step_by(layer.outputs));
        self.floats(&name("weight"), &[layer.outputs, layer.inputs], rows.copied());
        self.floats(&name("bias"), &[layer.outputs], parameters[layer.bias.clone()].iter().copied());
        self.apply("Gemm", &[&name("weight"), &name("bias")], &[("transB", 1)], &name("layer"));
    }
}

impl ActorCritic {
    /// Encodes the mean of the policy as an ONNX model, normalisation and bounds included.
    ///
    /// The model has one input, `state` (n × observation, double precision), and one output, `action` (n × action, single
    /// precision), which is clipped to `bounds`. After training with `frame_stack` a state is the last observations in a row,
    /// the oldest first, with zeros for those before the start of an episode. `metadata` becomes the model's properties.
    ///
    /// The same policy, bounds and metadata give the same bytes. Actions differ from [`ActorCritic::act`] by rounding, and
    /// by up to a millionth in every hyperbolic tangent, since this crate computes an approximation of it.
    ///
    /// # Panics
    /// When the number of bounds is not the number of components of an action.
    pub fn to_onnx(&self, bounds: &[(f64, f64)], metadata: &BTreeMap<String, String>) -> Vec<u8> {
        assert!(bounds.len() == self.action_dim(), "every component of an action has its bounds");
        let mut draft = Draft { last: "state".to_owned(), ..Draft::default() };
        if let Some(moments) = self.observation_moments() {
            draft.doubles("mean", &[self.obs_dim()], moments.mean.iter().copied());
            draft.doubles("deviation", &[self.obs_dim()], moments.deviations());
            draft.doubles("least", &[], std::iter::once(-LIMIT));
            draft.doubles("most", &[], std::iter::once(LIMIT));
            draft.apply("Sub", &["mean"], &[], "centred");
            draft.apply("Div", &["deviation"], &[], "scaled");
            draft.apply("Clip", &["least", "most"], &[], "normalised");
        }
        draft.apply("Cast", &[], &[("to", i64::from(FLOAT))], "input");
        self.draw_layers(&mut draft, &vec![1.0; bounds.len()]);
        draft.bound(bounds);
        let batch = Dimension { length: None, name: Some("n".to_owned()) };
        let inputs = vec![value("state", DOUBLE, batch.clone(), &[self.obs_dim()])];
        draft.finish(inputs, value("action", FLOAT, batch, &[self.action_dim()]), metadata)
    }

    /// Encodes the mean of the policy as an ONNX model with several inputs, which it scales itself; see [`Inputs`]. All numbers are in single precision.
    ///
    /// The output is (1 × action): the components are multiplied by `scales`, then clipped to `bounds`. A scale that is a power of two rounds nothing.
    ///
    /// # Panics
    /// When the lengths do not fit each other, or when the policy normalises observations.
    pub fn to_onnx_with(
        &self,
        inputs: &Inputs,
        scales: &[f64],
        bounds: &[(f64, f64)],
        metadata: &BTreeMap<String, String>,
    ) -> Vec<u8> {
        assert!([scales.len(), bounds.len()] == [self.action_dim(); 2], "every component of an action has its bounds");
        assert!(self.observation_moments().is_none(), "such a policy scales its inputs itself");
        let mut draft = Draft::default();
        let flat = |name: &str| format!("{name}.flat");
        for (name, _) in &inputs.shapes {
            draft.last.clone_from(name);
            draft.apply("Flatten", &[], &[("axis", 1)], &flat(name));
        }
        draft.join(&inputs.shapes.iter().map(|(name, _)| flat(name)).collect::<Vec<_>>(), "joined");
        let squashed = |number: usize| format!("squashed.{number}");
        for (number, divisors) in inputs.divisors.iter().enumerate() {
            let divisor = format!("divisor.{number}");
            draft.floats(&divisor, &[divisors.len()], divisors.iter().map(|each| *each as f32));
            draft.last = "joined".to_owned();
            draft.apply("Div", &[&divisor], &[], &format!("scaled.{number}"));
            draft.apply("Tanh", &[], &[], &squashed(number));
        }
        draft.join(&(0..inputs.divisors.len()).map(squashed).collect::<Vec<_>>(), "input");
        self.draw_layers(&mut draft, scales);
        draft.bound(bounds);
        let one = || Dimension { length: Some(1), name: None };
        let shapes = inputs.shapes.iter().map(|(name, shape)| value(name, FLOAT, one(), shape)).collect();
        draft.finish(shapes, value("action", FLOAT, one(), &[self.action_dim()]), metadata)
    }

    /// Adds the layers of the actor; the last one is multiplied by `scales`.
    fn draw_layers(&self, draft: &mut Draft, scales: &[f64]) {
        let mut parameters = self.parameters()[self.actor_range()].to_vec();
        let layers = self.actor().layers();
        let head = &layers[layers.len() - 1];
        for place in [head.weight.clone(), head.bias.clone()] {
            let scales = scales.iter().cycle();
            parameters[place].iter_mut().zip(scales).for_each(|(weight, scale)| *weight *= *scale as f32);
        }
        for (number, layer) in layers.iter().enumerate() {
            draft.layer(number, layer, &parameters);
            if number + 1 < layers.len() {
                draft.apply("Tanh", &[], &[], &format!("hidden.{number}"));
            }
        }
    }
}

/// An input or output whose first dimension is this one.
fn value(name: &str, element: i32, first: Dimension, shape: &[usize]) -> Value {
    let rest = shape.iter().map(|length| Dimension { length: Some(*length as i64), name: None });
    let shape = Some(Shape { dimensions: std::iter::once(first).chain(rest).collect() });
    Value { name: name.to_owned(), kind: Some(Kind { tensor: Some(TensorKind { element, shape }) }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moments::RunningMoments;
    use base::seed::Seed;

    const BOUNDS: [(f64, f64); 2] = [(-0.5, 0.25), (0.0, 0.125)];

    fn policy(normalising: bool) -> ActorCritic {
        let mut policy = ActorCritic::new(3, 2, &[5, 4], 0.0, &mut Seed::root(8).stream());
        // Actions of the first weights are small; these are not.
        let head = policy.actor().layers()[2].weight.clone();
        policy.parameters_mut()[head].iter_mut().for_each(|weight| *weight *= 60.0);
        let mut moments = RunningMoments::new(3);
        moments.update([[0.1, 20.0, -3.0], [0.2, 25.0, -3.5]].iter().map(|sample| &sample[..]));
        *policy.observation_moments_mut() = normalising.then_some(moments);
        policy
    }

    fn doubles(tensor: &Tensor) -> Vec<f64> {
        match tensor.element {
            FLOAT => tensor.data.as_chunks().0.iter().map(|bytes| f64::from(f32::from_le_bytes(*bytes))).collect(),
            _ => tensor.data.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect(),
        }
    }

    /// Evaluates a graph of these operators for one state.
    fn run(graph: &Graph, state: &[f64]) -> Vec<f64> {
        let mut values = BTreeMap::from([("state".to_owned(), state.to_vec())]);
        values.extend(graph.constants.iter().map(|tensor| (tensor.name.clone(), doubles(tensor))));
        for node in &graph.nodes {
            let input = |i: usize| &values[&node.inputs[i]];
            let pairs = || input(0).iter().zip(input(1));
            let output: Vec<f64> = match node.operator.as_str() {
                "Sub" => pairs().map(|(a, b)| a - b).collect(),
                "Div" => pairs().map(|(a, b)| a / b).collect(),
                "Clip" => input(0).iter().map(|x| x.clamp(input(1)[0], input(2)[0])).collect(),
                "Cast" => input(0).iter().map(|x| f64::from(*x as f32)).collect(),
                "Gemm" => {
                    let rows = input(1).chunks(input(0).len()).zip(input(2));
                    rows.map(|(row, b)| b + row.iter().zip(input(0)).map(|(w, x)| w * x).sum::<f64>()).collect()
                }
                "Tanh" => input(0).iter().map(|x| libm::tanh(*x)).collect(),
                "Max" => pairs().map(|(a, b)| a.max(*b)).collect(),
                "Min" => pairs().map(|(a, b)| a.min(*b)).collect(),
                other => panic!("the operator {other} is not expected"),
            };
            values.insert(node.outputs[0].clone(), output);
        }
        values.remove("action").expect("the graph gives an action")
    }

    #[test]
    fn the_graph_acts_as_the_policy_does() {
        let (mut inside, mut outside) = (0, 0);
        for normalising in [false, true] {
            let policy = policy(normalising);
            let model = Model::decode(policy.to_onnx(&BOUNDS, &BTreeMap::new()).as_slice()).unwrap();
            let graph = model.graph.unwrap();
            assert_eq!(graph.nodes.len(), if normalising { 11 } else { 8 });
            for i in 0..50 {
                let state = [0.004 * f64::from(i), 20.0 + 0.1 * f64::from(i), -3.0 - 0.01 * f64::from(i)];
                let mut action = [0.0; 2];
                policy.act(&state, &mut action, &mut policy.scratch(1));
                for ((action, found), (low, high)) in action.iter().zip(run(&graph, &state)).zip(BOUNDS) {
                    assert!((action.clamp(low, high) - found).abs() < 3e-6, "{action} against {found}");
                    *if (low..high).contains(action) { &mut inside } else { &mut outside } += 1;
                }
            }
        }
        assert!(inside > 20 && outside > 20, "{inside} and {outside}");
    }

    #[test]
    fn the_same_policy_gives_the_same_bytes_with_its_properties() {
        let named = BTreeMap::from([("town".to_owned(), "harbour".to_owned())]);
        let bytes = policy(true).to_onnx(&BOUNDS, &named);
        assert_eq!(bytes, policy(true).to_onnx(&BOUNDS, &named));
        assert_eq!(Model::decode(bytes.as_slice()).unwrap().metadata.len(), 1);
    }
}
