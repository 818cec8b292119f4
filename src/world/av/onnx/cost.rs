//! The size of the results of an operator and its work, before it runs.

use std::collections::BTreeMap;

/// An operator of a file.
#[derive(Debug, Default)]
pub(super) struct Operator {
    pub kind: String,
    /// The names of its inputs; an empty name is an input that is left out.
    pub inputs: Vec<String>,
    /// The names of its outputs.
    pub outputs: Vec<String>,
    /// Its attributes that are whole numbers.
    pub numbers: BTreeMap<String, Vec<i64>>,
    /// Its attributes that are text.
    pub texts: BTreeMap<String, String>,
}

impl Operator {
    /// The first number of an attribute.
    fn number(&self, name: &str) -> Option<i64> {
        self.numbers.get(name)?.first().copied()
    }

    /// The places of the inputs whose numbers set the size of the results.
    pub fn sizing(&self) -> &'static [usize] {
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

/// An input of an operator.
#[derive(Debug, Clone, Default)]
pub(super) struct Known {
    /// Its sizes.
    pub shape: Vec<u64>,
    /// Its numbers, of inputs that set sizes.
    pub numbers: Vec<f64>,
}

impl Known {
    fn count(&self) -> u64 {
        product(self.shape.iter().copied())
    }

    /// A size, counted from the end for negative places; 1 where there is none.
    fn size(&self, place: i64) -> u64 {
        let rank = self.shape.len() as i64;
        let place = if place < 0 { place + rank } else { place };
        usize::try_from(place).ok().and_then(|place| self.shape.get(place)).copied().unwrap_or(1)
    }
}

/// Upper bounds for an operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cost {
    /// The elements of its results, with what it needs meanwhile.
    pub elements: u64,
    /// Its multiplications, additions and copies.
    pub work: u64,
}

impl Cost {
    fn linear(elements: u64) -> Self {
        Self { elements, work: elements }
    }
}

/// Bounds for an operator. Inputs that are left out have no shape.
///
/// # Source
/// The shapes of results in `Operators.md` of the ONNX project.
pub(super) fn cost(operator: &Operator, inputs: &[Option<Known>]) -> Cost {
    let empty = Known::default();
    let at = |place: usize| inputs.get(place).and_then(Option::as_ref).unwrap_or(&empty);
    let counts = || inputs.iter().flatten().map(Known::count);
    let sum = || counts().fold(0_u64, u64::saturating_add);
    let data = at(0);
    match operator.kind.as_str() {
        "MatMul" | "MatMulInteger" => {
            let (left, right) = (matrix(data, false), matrix(at(1), true));
            let shared = *left.last().unwrap_or(&1);
            let (rows, columns) = (left[left.len() - 2], *right.last().unwrap_or(&1));
            let batches = product(broadcast(&[&left[..left.len() - 2], &right[..right.len() - 2]]));
            let elements = product([batches, rows, columns]);
            Cost { elements, work: elements.saturating_mul(shared) }
        }
        "Gemm" => {
            let turned = |name: &str| operator.number(name).is_some_and(|number| number != 0);
            let (rows, shared) =
                if turned("transA") { (data.size(1), data.size(0)) } else { (data.size(0), data.size(1)) };
            let columns = if turned("transB") { at(1).size(0) } else { at(1).size(1) };
            let elements = rows.saturating_mul(columns);
            Cost { elements, work: product([elements, shared]) }
        }
        "Conv" | "ConvInteger" => {
            let elements = product([data.size(0), at(1).size(0), padded(operator, data)]);
            Cost { elements, work: elements.saturating_mul(at(1).count() / at(1).size(0).max(1)) }
        }
        "ConvTranspose" => {
            let axes = data.shape.len().saturating_sub(2);
            let attribute = |name: &str, axis: usize, other: u64| {
                operator.numbers.get(name).and_then(|list| list.get(axis)).map_or(other, |number| number.unsigned_abs())
            };
            let size = |axis: usize| {
                let (long, kernel) = (data.size(axis as i64 + 2), at(1).size(axis as i64 + 2));
                let strided = long.saturating_mul(attribute("strides", axis, 1));
                let wide = kernel.saturating_mul(attribute("dilations", axis, 1));
                let made = strided.saturating_add(wide).saturating_add(attribute("output_padding", axis, 0));
                made.max(attribute("output_shape", axis, 0))
            };
            let groups = attribute("group", 0, 1).max(1);
            let made = product((0..axes).map(size).chain([data.size(0), at(1).size(1), groups]));
            // Each number of the input is multiplied with all weights of its channel.
            let work = data.count().saturating_mul(at(1).count() / at(1).size(0).max(1));
            Cost { elements: made.saturating_add(work), work: made.saturating_add(work) }
        }
        "MaxPool" | "AveragePool" => {
            let elements = product([data.size(0), data.size(1), padded(operator, data)]);
            let kernel = operator.numbers.get("kernel_shape").map_or(1, |sizes| absolute(sizes));
            Cost { elements: elements.saturating_mul(2), work: elements.saturating_mul(kernel) }
        }
        "Attention" => {
            // Queries, keys and values have the shape [batch, heads, length, depth], or [batch, length, heads * depth].
            let (batch, apart) = (data.size(0), data.shape.len() == 4);
            let heads = if apart { data.size(1) } else { operator.number("q_num_heads").map_or(1, i64::unsigned_abs) };
            let length = |known: &Known| known.size(if known.shape.len() == 4 { 2 } else { 1 });
            let keys = length(at(1)).saturating_add(length(at(4)));
            let scores = product([batch, heads, length(data), keys]);
            let depths = at(1).size(-1).saturating_add(at(2).size(-1));
            // Keys and values that several heads share are copied for each.
            let copied = sum().saturating_mul(heads.max(1));
            let elements = scores.saturating_mul(4).saturating_add(copied.saturating_mul(2));
            Cost { elements, work: scores.saturating_mul(depths.saturating_add(16)).saturating_add(elements) }
        }
        "GRU" | "LSTM" => {
            let steps = data.size(0).saturating_mul(data.size(1));
            let gates = at(1).size(0).saturating_mul(at(1).size(1));
            let weights = at(1).count().saturating_add(at(2).count());
            Cost { elements: product([steps, gates, 2]), work: steps.saturating_mul(weights) }
        }
        "Gather" => {
            let axis = data.size(operator.number("axis").unwrap_or(0)).max(1);
            Cost::linear((data.count() / axis).saturating_mul(at(1).count()))
        }
        "GatherND" => {
            let batches = operator.number("batch_dims").unwrap_or(0);
            let batches = usize::try_from(batches).unwrap_or(0).min(data.shape.len());
            let last = at(1).size(-1).max(1);
            let rest = data.shape[batches..].iter().skip(usize::try_from(last).unwrap_or(usize::MAX));
            Cost::linear((at(1).count() / last).saturating_mul(product(rest.copied())))
        }
        "Tile" => Cost::linear(
            data.count().saturating_mul(sizes(&at(1).numbers)).saturating_mul(attribute(operator, "repeats")),
        ),
        "Expand" => {
            let wanted: Vec<u64> = at(1).numbers.iter().map(|size| whole(*size)).collect();
            Cost::linear(product(broadcast(&[&data.shape, &wanted])))
        }
        "ConstantOfShape" => Cost::linear(product(data.numbers.iter().map(|size| whole(*size)))),
        "Range" => {
            let number = |place: usize| at(place).numbers.first().copied().unwrap_or(f64::NAN);
            Cost::linear(whole((number(1) - number(0)) / number(2)))
        }
        "OneHot" => Cost::linear(data.count().saturating_mul(sizes(&at(1).numbers))),
        "Pad" => {
            let attribute = operator.numbers.get("pads").map(Vec::as_slice).unwrap_or_default();
            let margins: Vec<u64> = at(1)
                .numbers
                .iter()
                .map(|margin| whole(margin.abs()))
                .chain(attribute.iter().map(|margin| margin.unsigned_abs()))
                .collect();
            let all = margins.iter().fold(0_u64, |sum, margin| sum.saturating_add(*margin));
            let rank = data.shape.len();
            // Without a pair for each axis, another input says which axes the margins belong to.
            let paired = margins.len() == 2 * rank;
            let margin = |axis: usize| if paired { margins[axis].saturating_add(margins[axis + rank]) } else { all };
            Cost::linear(product(data.shape.iter().enumerate().map(|(axis, size)| size.saturating_add(margin(axis)))))
        }
        "Resize" | "Upsample" => {
            let factors = if operator.kind == "Upsample" || inputs.len() == 2 { at(1) } else { at(2) };
            let scaled = |(axis, size): (usize, &u64)| {
                let factor = factors.numbers.get(axis).copied().unwrap_or(1.0);
                whole((*size as f64 * factor.abs()).ceil())
            };
            let (rank, wanted) = (data.shape.len(), &at(3).numbers);
            let known = (factors.numbers.len() == rank || factors.numbers.is_empty())
                && (wanted.len() == rank || wanted.is_empty());
            let elements = if !known {
                // Which axes the sizes belong to is an attribute.
                product([data.count(), sizes(&factors.numbers), sizes(wanted)])
            } else if wanted.is_empty() {
                product(data.shape.iter().enumerate().map(scaled))
            } else {
                sizes(wanted)
            };
            Cost { elements, work: elements.saturating_mul(16) }
        }
        "GridSample" => {
            let elements = product([data.size(0), data.size(1), at(1).count()]);
            Cost { elements, work: elements.saturating_mul(16) }
        }
        "NonZero" => Cost::linear(data.count().saturating_mul(data.shape.len() as u64)),
        "Einsum" => {
            let work = summed(operator.texts.get("equation"), inputs).unwrap_or_else(|| product(counts()));
            Cost::linear(work)
        }
        // Their results are as large as the largest of their inputs, or of their sum.
        "Concat"
        | "Reshape"
        | "Transpose"
        | "Slice"
        | "Split"
        | "Squeeze"
        | "Unsqueeze"
        | "Flatten"
        | "Identity"
        | "Cast"
        | "CastLike"
        | "BitCast"
        | "Dropout"
        | "Shape"
        | "Size"
        | "Trilu"
        | "EyeLike"
        | "DepthToSpace"
        | "ReverseSequence"
        | "GatherElements"
        | "Scatter"
        | "ScatterElements"
        | "ScatterND"
        | "CumSum"
        | "ArgMax"
        | "ArgMin"
        | "TopK"
        | "GlobalAveragePool"
        | "GlobalMaxPool"
        | "BatchNormalization"
        | "InstanceNormalization"
        | "LpNormalization"
        | "Softmax"
        | "LogSoftmax"
        | "RotaryEmbedding"
        | "DynamicQuantizeLinear" => Cost { elements: sum().saturating_mul(2), work: sum().saturating_mul(32) },
        kind if kind.starts_with("Reduce") => Cost { elements: sum().saturating_mul(2), work: sum().saturating_mul(2) },
        kind if ELEMENTWISE.contains(&kind) => {
            let shapes: Vec<&[u64]> = inputs.iter().flatten().map(|known| known.shape.as_slice()).collect();
            Cost::linear(product(broadcast(&shapes)))
        }
        // `NonMaxSuppression` and others: each number may meet each number of the other inputs.
        _ => Cost::linear(product(counts().map(|count| count.max(1)))),
    }
}

/// Operators on numbers at the same place of all inputs.
const ELEMENTWISE: [&str; 69] = [
    "Abs",
    "Acos",
    "Acosh",
    "Add",
    "And",
    "Asin",
    "Asinh",
    "Atan",
    "Atanh",
    "Ceil",
    "Clip",
    "Cos",
    "Cosh",
    "DequantizeLinear",
    "Div",
    "Elu",
    "Equal",
    "Erf",
    "Exp",
    "Floor",
    "Gelu",
    "Greater",
    "GreaterOrEqual",
    "HardSigmoid",
    "HardSwish",
    "IsInf",
    "IsNaN",
    "LayerNormalization",
    "LeakyRelu",
    "Less",
    "LessOrEqual",
    "Log",
    "Max",
    "Mean",
    "Min",
    "Mod",
    "Mul",
    "Neg",
    "Not",
    "Or",
    "PRelu",
    "Pow",
    "QuantizeLinear",
    "RMSNormalization",
    "RandomNormalLike",
    "RandomUniformLike",
    "Reciprocal",
    "Relu",
    "Round",
    "Sigmoid",
    "Sign",
    "Sin",
    "Sinh",
    "Softplus",
    "Softsign",
    "Sqrt",
    "Sub",
    "Sum",
    "Swish",
    "Tan",
    "Tanh",
    "Where",
    "Xor",
    "Celu",
    "Selu",
    "Mish",
    "ThresholdedRelu",
    "BitShift",
    "Shrink",
];

/// The sizes of a factor of a matrix product: a vector is a row on the left and a column on the right.
fn matrix(factor: &Known, right: bool) -> Vec<u64> {
    match *factor.shape.as_slice() {
        [] => vec![1, 1],
        [size] if right => vec![size, 1],
        [size] => vec![1, size],
        _ => factor.shape.clone(),
    }
}

/// The product of the sizes after the first two, each with its margins.
fn padded(operator: &Operator, data: &Known) -> u64 {
    let axes = data.shape.len().saturating_sub(2);
    let pads = operator.numbers.get("pads").map(Vec::as_slice).unwrap_or_default();
    let margin = |place: usize| pads.get(place).map_or(0, |margin| margin.unsigned_abs());
    let size = |axis: usize| {
        // One more, where the last step is incomplete.
        data.size(axis as i64 + 2).saturating_add(margin(axis)).saturating_add(margin(axis + axes)).saturating_add(1)
    };
    product((0..axes).map(size))
}

/// The product of the sizes of all labels of a sum.
fn summed(equation: Option<&String>, inputs: &[Option<Known>]) -> Option<u64> {
    let equation: String = equation?.chars().filter(|letter| !letter.is_whitespace()).collect();
    let mut sizes: BTreeMap<char, u64> = BTreeMap::new();
    for (labels, input) in equation.split("->").next()?.split(',').zip(inputs) {
        let input = input.as_ref()?;
        if labels.chars().count() != input.shape.len() || !labels.chars().all(char::is_alphabetic) {
            return None;
        }
        for (label, size) in labels.chars().zip(&input.shape) {
            let known = sizes.entry(label).or_insert(1);
            *known = (*known).max(*size);
        }
    }
    Some(product(sizes.into_values()))
}

/// The shape that shapes are broadcast to: the greatest sizes, counted from the last.
fn broadcast(shapes: &[&[u64]]) -> Vec<u64> {
    let rank = shapes.iter().map(|shape| shape.len()).max().unwrap_or(0);
    let size = |place: usize| {
        let at = |shape: &&[u64]| shape.len().checked_sub(place).map_or(1, |index| shape[index]);
        shapes.iter().map(at).max().unwrap_or(1)
    };
    (1..=rank).rev().map(size).collect()
}

fn product(sizes: impl IntoIterator<Item = u64>) -> u64 {
    sizes.into_iter().fold(1, u64::saturating_mul)
}

/// The product of sizes or factors, each at least 1.
fn sizes(numbers: &[f64]) -> u64 {
    product(numbers.iter().map(|number| whole(number.abs()).max(1)))
}

fn absolute(numbers: &[i64]) -> u64 {
    product(numbers.iter().map(|number| number.unsigned_abs().max(1)))
}

fn attribute(operator: &Operator, name: &str) -> u64 {
    operator.numbers.get(name).map_or(1, |numbers| absolute(numbers))
}

/// A size from a number; the greatest for one that is no size.
fn whole(number: f64) -> u64 {
    if number.is_nan() { u64::MAX } else { number.ceil() as u64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(shape: &[u64], numbers: &[f64]) -> Option<Known> {
        Some(Known { shape: shape.to_vec(), numbers: numbers.to_vec() })
    }

    fn of(kind: &str, inputs: &[Option<Known>]) -> Cost {
        cost(&Operator { kind: kind.to_owned(), ..Operator::default() }, inputs)
    }

    #[test]
    fn the_size_of_a_result_is_known_before_it_is_made() {
        let elements = |kind, inputs: &[Option<Known>]| of(kind, inputs).elements;
        assert_eq!(elements("Add", &[known(&[3, 1], &[]), known(&[2, 1, 4], &[])]), 24);
        assert_eq!(elements("Add", &[known(&[1 << 33, 1], &[]), known(&[1 << 33], &[])]), u64::MAX);
        assert_eq!(of("MatMul", &[known(&[2, 3, 4], &[]), known(&[4, 5], &[])]), Cost { elements: 30, work: 120 });
        assert_eq!(of("MatMul", &[known(&[4], &[]), known(&[4], &[])]), Cost { elements: 1, work: 4 });
        assert_eq!(elements("Expand", &[known(&[3, 1], &[]), known(&[2], &[1.0, 7.0])]), 21);
        assert_eq!(elements("Range", &[known(&[], &[0.0]), known(&[], &[9.0]), known(&[], &[2.0])]), 5);
        assert_eq!(elements("Range", &[known(&[], &[0.0]), known(&[], &[9.0]), known(&[], &[0.0])]), u64::MAX);
        assert_eq!(elements("Range", &[known(&[], &[0.0]), known(&[], &[0.0]), known(&[], &[0.0])]), u64::MAX);
        assert_eq!(elements("ConstantOfShape", &[known(&[2], &[6.0, 7.0])]), 42);
        assert_eq!(elements("Gather", &[known(&[5, 6], &[]), known(&[7], &[])]), 42);
        assert_eq!(elements("Tile", &[known(&[5], &[]), known(&[1], &[3.0])]), 15);
        assert_eq!(elements("Pad", &[known(&[5, 2], &[]), known(&[4], &[1.0, 0.0, 1.0, 3.0])]), 35);
        let scales = [known(&[1, 1, 4, 4], &[]), None, known(&[4], &[1.0, 1.0, 2.0, 2.5])];
        assert_eq!(elements("Resize", &scales), 80);
        let convolution = [known(&[1, 3, 8, 8], &[]), known(&[4, 3, 3, 3], &[])];
        assert_eq!(of("Conv", &convolution), Cost { elements: 4 * 81, work: 4 * 81 * 27 });
    }

    #[test]
    fn a_sum_over_labels_counts_each_label_once() {
        let operator = Operator {
            kind: "Einsum".to_owned(),
            texts: BTreeMap::from([("equation".to_owned(), "bij,bjk->bik".to_owned())]),
            ..Operator::default()
        };
        assert_eq!(cost(&operator, &[known(&[2, 3, 4], &[]), known(&[2, 4, 5], &[])]).work, 2 * 3 * 4 * 5);
    }
}
