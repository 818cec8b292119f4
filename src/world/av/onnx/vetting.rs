//! Checks of an ONNX file before the runtime sees it: the runtime takes the lengths and sizes in a file for true.

use std::collections::BTreeMap;

use super::encoding::{Content, Refusal, fields, text, whole_numbers};
use base::contained::contained;

/// Maximum number of elements of a constant.
const MAX_ELEMENTS: u64 = 1 << 26;
/// Maximum number of operators of a network.
const MAX_OPERATORS: usize = 20_000;

/// Operators that have graphs of their own, or make lists of tensors.
const UNBOUNDED: [&str; 8] = [
    "If",
    "Loop",
    "Scan",
    "SequenceInsert",
    "SequenceConstruct",
    "SequenceEmpty",
    "SplitToSequence",
    "ConcatFromSequence",
];
/// Operators that draw random numbers, and what to export instead.
const RANDOM: [(&str, &str); 7] = [
    ("Dropout", "export it in evaluation mode (torch: `model.eval()`)"),
    ("RandomNormal", WITHOUT_SAMPLING),
    ("RandomNormalLike", WITHOUT_SAMPLING),
    ("RandomUniform", WITHOUT_SAMPLING),
    ("RandomUniformLike", WITHOUT_SAMPLING),
    ("Multinomial", WITHOUT_SAMPLING),
    ("Bernoulli", WITHOUT_SAMPLING),
];
const WITHOUT_SAMPLING: &str = "export the action without sampling (stable-baselines3: `deterministic=True`)";
/// Attributes that are sizes.
const SIZES: [&str; 9] =
    ["pads", "repeats", "shape", "kernel_shape", "scales", "strides", "dilations", "output_padding", "output_shape"];

/// A message of the format, by its kind.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Model,
    Graph,
    Node,
    Tensor,
    Value,
    Type,
    TensorType,
    Shape,
    Dimension,
    Operators,
    Entry,
}

/// Checks a file. All evaluations of a network that passes have results of the same sizes.
///
/// # Errors
/// A length that does not fit, a tensor without its data, or an operator whose result has no constant size.
///
/// # Source
/// `onnx.proto` of the ONNX project; the encoding of protocol buffers.
fn vet(bytes: &[u8]) -> Result<(), Refusal> {
    let mut vetting = Vetting::default();
    vetting.message(Kind::Model, bytes)?;
    vetting.sizes_are_constant()
}

/// Checks and loads a file.
///
/// # Errors
/// It is not ONNX, does not pass, or has operators that are not supported here.
pub(super) fn load(bytes: Vec<u8>) -> Result<rten::Model, Refusal> {
    vet(&bytes)?;
    rten::Model::load(bytes).map_err(|error| error.to_string())
}

/// The output with this name; without a name, the only one. Those that are carried are none.
///
/// # Errors
/// There is no such output, or there are several: their names.
pub(super) fn output(
    network: &rten::Model,
    wanted: Option<&str>,
    carried: &[rten::NodeId],
) -> Result<rten::NodeId, Refusal> {
    let all = network.output_ids().iter().copied().zip(output_names(network));
    let (ids, names): (Vec<_>, Vec<_>) = all.filter(|(id, _)| !carried.contains(id)).unzip();
    let all = || names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    match (wanted, ids.as_slice()) {
        (None, [only]) => Ok(*only),
        (None, _) => Err(format!(
            "it has {} outputs ({}): choose one, as `output: \"{}\"`",
            ids.len(),
            all(),
            names.first().map_or("", String::as_str)
        )),
        (Some(wanted), _) => {
            let place = names.iter().position(|name| name == wanted);
            place.map(|place| ids[place]).ok_or_else(|| format!("it has no output `{wanted}`; it has {}", all()))
        }
    }
}

/// The names of the outputs of a network.
fn output_names(network: &rten::Model) -> Vec<String> {
    let name =
        |id: &rten::NodeId| network.node_info(*id).and_then(|info| info.name().map(str::to_string)).unwrap_or_default();
    network.output_ids().iter().map(name).collect()
}

/// The names of the outputs of the network in a file, which is not run; none of a file that cannot be loaded.
pub fn outputs(bytes: Vec<u8>) -> Vec<String> {
    contained(|| load(bytes)).ok().and_then(Result::ok).map_or_else(Vec::new, |network| output_names(&network))
}

/// What was found on the way.
#[derive(Default)]
struct Vetting {
    graphs: usize,
    /// In the order of the file.
    operators: Vec<Operator>,
    /// The values at the start, by name: whether they are the same in all evaluations. An input with the name of a constant is that constant.
    values: BTreeMap<String, bool>,
}

/// An operator with the names of its inputs and outputs; an empty name stands for one that is left out.
#[derive(Default)]
struct Operator {
    kind: String,
    inputs: Vec<String>,
    outputs: Vec<String>,
}

impl Operator {
    /// The places of the inputs whose numbers set the size of the results.
    fn sizing(&self) -> &'static [usize] {
        match self.kind.as_str() {
            "ConstantOfShape" | "NonZero" => &[0],
            "Expand" | "Tile" | "Upsample" | "OneHot" | "Reshape" | "Split" | "Squeeze" | "Unsqueeze" | "TopK" => &[1],
            "Pad" => &[1, 3],
            "Range" => &[0, 1, 2],
            "Resize" => &[1, 2, 3],
            "Slice" => &[1, 2, 3, 4],
            "NonMaxSuppression" => &[0, 1, 2, 3, 4],
            kind if kind.starts_with("Reduce") => &[1],
            _ => &[],
        }
    }
}

/// The parts of a tensor that its size follows from.
#[derive(Default)]
struct Tensor {
    name: String,
    dimensions: Vec<i64>,
    kind: u64,
    raw: u64,
    /// The number of elements in a typed list.
    listed: u64,
}

impl Vetting {
    fn message(&mut self, kind: Kind, bytes: &[u8]) -> Result<(), Refusal> {
        self.graphs += usize::from(kind == Kind::Graph);
        if self.graphs > 1 {
            return Err("it has more than one graph".into());
        }
        fields(bytes, &mut |number, content| match (inner(kind, number), content) {
            (None, _) => Ok(()),
            (Some(_), Content::Number(_)) => Err("a part of it has the wrong type".into()),
            (Some(Kind::Tensor), Content::Bytes(bytes)) => {
                let name = tensor(bytes)?;
                self.values.insert(name, true);
                Ok(())
            }
            (Some(Kind::Node), Content::Bytes(bytes)) => self.node(bytes),
            (Some(inner), Content::Bytes(bytes)) => {
                if (kind, number) == (Kind::Graph, 11) {
                    self.input(bytes)?;
                }
                self.message(inner, bytes)
            }
        })
    }

    /// Reads the name of an input of the network.
    fn input(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        fields(bytes, &mut |number, content| {
            if let (1, Content::Bytes(name)) = (number, content) {
                self.values.entry(text(name)).or_insert(false);
            }
            Ok(())
        })
    }

    fn node(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        if self.operators.len() == MAX_OPERATORS {
            return Err(format!("it has more than {MAX_OPERATORS} operators"));
        }
        let mut operator = Operator::default();
        fields(bytes, &mut |number, content| {
            match (number, content) {
                (1, Content::Bytes(name)) => operator.inputs.push(text(name)),
                (2, Content::Bytes(name)) => operator.outputs.push(text(name)),
                (4, Content::Bytes(name)) => operator.kind = text(name),
                (5, Content::Bytes(bytes)) => attribute(bytes)?,
                (1..=5, Content::Number(_)) => return Err("a part of it has the wrong type".into()),
                _ => {}
            }
            Ok(())
        })?;
        if UNBOUNDED.contains(&operator.kind.as_str()) {
            return Err(format!("its operator {} has graphs or lists inside; export it without", operator.kind));
        }
        if let Some((kind, instead)) = RANDOM.iter().find(|(kind, _)| operator.kind == *kind) {
            return Err(format!("the network draws random numbers (operator {kind}): {instead}"));
        }
        self.operators.push(operator);
        Ok(())
    }

    fn sizes_are_constant(mut self) -> Result<(), Refusal> {
        for operator in &self.operators {
            let kind = &operator.kind;
            let is_constant = |name: &String| {
                let known = if name.is_empty() { Some(true) } else { self.values.get(name).copied() };
                known.ok_or_else(|| {
                    format!("its operator {kind} has the input `{name}`, which no operator before it makes")
                })
            };
            let constant: Vec<bool> = operator.inputs.iter().map(is_constant).collect::<Result<_, _>>()?;
            if operator.sizing().iter().any(|place| constant.get(*place) == Some(&false)) {
                return Err(format!(
                    "the result of its operator {kind} has a size that is not constant; export it with constant sizes"
                ));
            }
            let constant = ["Shape", "Size"].contains(&kind.as_str()) || !constant.contains(&false);
            for name in operator.outputs.iter().filter(|name| !name.is_empty()) {
                if self.values.insert(name.clone(), constant).is_some() {
                    return Err(format!("two of its values have the name `{name}`"));
                }
            }
        }
        Ok(())
    }
}

fn attribute(bytes: &[u8]) -> Result<(), Refusal> {
    let (mut name, mut numbers) = (String::new(), Vec::new());
    fields(bytes, &mut |number, content| {
        match (number, content) {
            (1, Content::Bytes(bytes)) => name = text(bytes),
            (3 | 8, content) => whole_numbers(content, &mut numbers)?,
            (5 | 10, Content::Bytes(bytes)) => drop(tensor(bytes)?),
            (6 | 11, Content::Bytes(_)) => return Err("an operator of it has a graph inside; export it without".into()),
            (5 | 6, Content::Number(_)) => return Err("a part of it has the wrong type".into()),
            _ => {}
        }
        Ok(())
    })?;
    if numbers.iter().any(|number| number.unsigned_abs() > MAX_ELEMENTS && *number != i64::MAX && *number != i64::MIN) {
        return Err(format!("the attribute `{name}` has a number beyond {MAX_ELEMENTS}"));
    }
    if SIZES.contains(&name.as_str()) && numbers.iter().any(|number| number.unsigned_abs() > 1 << 16) {
        return Err(format!("the attribute `{name}` has a size beyond {}", 1 << 16));
    }
    Ok(())
}

/// Checks a tensor, and returns its name.
fn tensor(bytes: &[u8]) -> Result<String, Refusal> {
    let mut tensor = Tensor::default();
    fields(bytes, &mut |number, content| {
        match (number, content) {
            (1, content) => whole_numbers(content, &mut tensor.dimensions)?,
            (2, Content::Number(kind)) => tensor.kind = kind,
            (4, Content::Bytes(bytes)) => tensor.listed += bytes.len() as u64 / 4,
            (10, Content::Bytes(bytes)) => tensor.listed += bytes.len() as u64 / 8,
            (5 | 7 | 11, Content::Bytes(bytes)) => {
                let mut numbers = Vec::new();
                whole_numbers(Content::Bytes(bytes), &mut numbers)?;
                tensor.listed += numbers.len() as u64;
            }
            (4 | 5 | 7 | 10 | 11, Content::Number(_)) => tensor.listed += 1,
            (6, Content::Bytes(_)) => tensor.listed += 1,
            (8, Content::Bytes(name)) => tensor.name = text(name),
            (9, Content::Bytes(raw)) => tensor.raw = raw.len() as u64,
            (13, _) => {
                return Err(
                    "a constant of it is in another file; export it as one file (torch: `external_data=False`)".into(),
                );
            }
            (2 | 6 | 8 | 9, _) => return Err("a part of it has the wrong type".into()),
            _ => {}
        }
        Ok(())
    })?;
    let name = &tensor.name;
    let elements = product(&tensor.dimensions).filter(|elements| *elements <= MAX_ELEMENTS);
    let elements = elements
        .ok_or_else(|| format!("the constant `{name}` has more than {MAX_ELEMENTS} elements, or a negative size"))?;
    let bytes = elements.saturating_mul(element_bytes(tensor.kind));
    if tensor.raw.max(tensor.listed.saturating_mul(element_bytes(tensor.kind))) < bytes {
        return Err(format!("the constant `{name}` should have {elements} elements and has fewer"));
    }
    Ok(tensor.name)
}

/// Minimum size of an element in bytes.
fn element_bytes(kind: u64) -> u64 {
    match kind {
        1 | 6 | 12 => 4,
        4 | 5 | 10 | 16 => 2,
        7 | 11 | 13 | 14 => 8,
        15 => 16,
        _ => 1,
    }
}

/// The kind of the message in a field, as far as the runtime reads it.
fn inner(kind: Kind, field: u32) -> Option<Kind> {
    Some(match (kind, field) {
        (Kind::Model, 7) => Kind::Graph,
        (Kind::Model, 8) => Kind::Operators,
        (Kind::Model, 14) => Kind::Entry,
        (Kind::Graph, 1) => Kind::Node,
        (Kind::Graph, 5) => Kind::Tensor,
        (Kind::Graph, 11..=13) => Kind::Value,
        (Kind::Value, 2) => Kind::Type,
        (Kind::Type, 1) => Kind::TensorType,
        (Kind::TensorType, 2) => Kind::Shape,
        (Kind::Shape, 1) => Kind::Dimension,
        _ => return None,
    })
}

/// The product of sizes; `None` if one is negative or the product has more than 64 bits.
fn product(sizes: &[i64]) -> Option<u64> {
    sizes.iter().try_fold(1_u64, |product, size| product.checked_mul(u64::try_from(*size).ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn networks_pass_and_files_that_hang_or_abort_the_runtime_do_not() {
        vet(include_bytes!("../../../../tests/reference/onnx/follow.onnx")).unwrap();
        vet(include_bytes!("../../../../tests/reference/onnx/five.onnx")).unwrap();
        let hang = vet(include_bytes!("../../../../tests/reference/onnx/hang_185_bytes.onnx")).unwrap_err();
        assert_eq!(hang, "it has a number of more than 64 bits");
        let abort = vet(include_bytes!("../../../../tests/reference/onnx/abort_132_bytes.onnx")).unwrap_err();
        assert_eq!(abort, "it ends in the middle of a value");
    }

    /// A message of one field with bytes.
    fn field(number: u8, bytes: &[u8]) -> Vec<u8> {
        [&[number << 3 | 2, bytes.len() as u8], bytes].concat()
    }

    #[test]
    fn sizes_are_checked() {
        let model = |graph: &[Vec<u8>]| field(7, &graph.concat());
        let dimension = |size: u8| vec![1 << 3, size];
        // Two numbers of 32 bits, of which the file has one.
        let tensor = [dimension(2), vec![2 << 3, 1], field(9, &[0; 4]), field(8, b"w")].concat();
        assert_eq!(
            vet(&model(&[field(5, &tensor)])).unwrap_err(),
            "the constant `w` should have 2 elements and has fewer"
        );
        let node =
            |operator: &[u8], input: &[u8]| field(1, &[field(1, input), field(2, b"y"), field(4, operator)].concat());
        for (operator, instead) in RANDOM {
            let said = vet(&model(&[node(operator.as_bytes(), b"x")])).unwrap_err();
            assert!(said.contains("draws random numbers") && said.ends_with(instead), "{said}");
        }
        assert_eq!(
            vet(&model(&[node(b"Loop", b"x")])).unwrap_err(),
            "its operator Loop has graphs or lists inside; export it without"
        );
    }
}
