//! No operator of a network takes more memory or time than a driver may, whatever the sizes of its inputs are.
#![cfg(target_os = "linux")]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::onnx_file;
use crate::program::error;
use crate::unbreakable::limited;

/// The sizes `n` of inputs: the last ones are beyond what a driver may use.
const SIZES: [i64; 4] = [16, 256, 1024, 4096];
/// The number of networks that one process reads.
const TOGETHER: usize = 12;

/// Every operator that the runtime has for networks, with its inputs and attributes. `N` stands for a size, `f` for floats and `i` for whole
/// numbers: `fNxN` is a matrix of zeros, `i[1 2]` a constant, `_` an input that is left out.
const OPERATORS: &str = "
Abs fNxN | Acos fNxN | Acosh fNxN | Add fNxN f1xN | Add fNx1xN f1xNxN | And iNxN iNx1 | ArgMax fNxN axis=1 | ArgMin fNxN axis=0 | Asin fNxN
Asinh fNxN | Atan fNxN | Atanh fNxN | Attention f1x1xNxN f1x1xNxN f1x1xNxN | AveragePool f1x1xNxN kernel_shape=3,3 strides=1,1
AveragePool f1x1xNxN kernel_shape=N,N pads=N,N,N,N strides=1,1 | BatchNormalization f1xNxNx1 fN fN fN fN
BatchNormalization f1x1xNxN f1 f1 f1 f1 | Cast fNxN to=6 | CastLike fNxN i1 | Ceil fNxN | Clip fNxN | Concat fNxN fNxN axis=0
Concat fNxN fNxN fNxN fNxN axis=1 | Conv f1x1xNxN f1x1x3x3 strides=1,1 dilations=1,1 pads=0,0,0,0
Conv f1x4xNxN f4x4x3x3 strides=1,1 dilations=1,1 pads=0,0,0,0 | Conv f1xNx4x4 fNxNx1x1 strides=1,1 dilations=1,1 pads=0,0,0,0
Conv f1x1xNxN f1x1x3x3 pads=N,N,N,N strides=1,1 dilations=1,1 | Conv f1x1xNxN f1x1x3x3 dilations=N,N pads=N,N,N,N strides=1,1
ConvTranspose f1x1xNxN f1x1x3x3 strides=1,1 dilations=1,1 pads=0,0,0,0
ConvTranspose f1x1xNxN f1x1x2x2 strides=64,64 dilations=1,1 pads=0,0,0,0
ConvTranspose f1x1x4x4 f1x1xNxN strides=N,N dilations=1,1 pads=0,0,0,0 | ConstantOfShape i[N N] | ConstantOfShape i[N N N] | Cos fNxN
Cosh fNxN | CumSum fNxN i[1] | DepthToSpace f1xNxNx1 blocksize=2 | DequantizeLinear iNxN f[1] | Div fNxN fNx1 | DynamicQuantizeLinear fNxN
Einsum fNxN fNxN equation=ij,jk->ik | Einsum fN fN fN equation=i,j,k->ijk | Einsum fNxN fNxN equation=ij,kl->ijkl | Elu fNxN
Equal fNxN f1xN | Erf fNxN | Exp fNxN | Expand fNx1 i[N N] | Expand f1x1x1 i[N N N] | EyeLike fNxN | Flatten fNxN | Floor fNxN
Gather fNxN iN | Gather fNxN iNxN | GatherElements fNxN iNxN | GatherND fNxN iNx1 | GatherND fNxN iNxNx2 | Gelu fNxN | Gemm fNxN fNxN
Gemm fNxN fNxN transA=1 transB=1 | GlobalAveragePool f1x1xNxN | GlobalMaxPool f1xNxNx1 | Greater fNxN fNx1 | GreaterOrEqual fNxN f1
GridSample f1x1xNxN f1xNxNx2 | GRU fNx1x4 f1x12x4 f1x12x4 hidden_size=4 linear_before_reset=1 | HardSigmoid fNxN | HardSwish fNxN
Identity fNxN | InstanceNormalization f1x1xNxN f1 f1 | IsInf fNxN | IsNaN fNxN | LayerNormalization fNxN fN | LeakyRelu fNxN | Less fNxN f1
LessOrEqual fNxN f1 | Log fNxN | LogSoftmax fNxN | LpNormalization fNxN | LSTM fNx1x4 f1x16x4 f1x16x4 hidden_size=4 | MatMul fNxN fNxN
MatMul fNx1xN f1xNx1 | MatMul fNxNx1 fNx1xN | Max fNxN fNx1 | MaxPool f1x1xNxN kernel_shape=3,3 strides=1,1
MaxPool f1x1xNxN kernel_shape=N,N strides=1,1 | Mean fNxN fNx1 | Min fNxN f1xN | Mod iNxN i[3] | Mul fNxN f1 | Neg fNxN
NonMaxSuppression f1xNx4 f1x1xN i[N] | Not iNxN | NonZero i[1 0 1] | OneHot iNxN i[16] f[0 1] | OneHot iN i[N] f[0 1] | Or iNxN i1
Pad fNxN i[N N N N] | Pad fNxN i[1 0 0 1] mode=reflect | Pow fNxN f[2] | PRelu fNxN f[0.1] | QuantizeLinear fNxN f[1] u1
RMSNormalization fNxN fN | Range i[0] i[N] i[1] | Reciprocal fNxN | ReduceL1 fNxN i[1] | ReduceL2 fNxN i[0] | ReduceLogSum fNxN i[1]
ReduceLogSumExp fNxN i[1] | ReduceMax fNxN i[0 1] | ReduceMean fNxN i[1] | ReduceMin fNxN i[0] | ReduceProd fNxN i[1] | ReduceSum fNxN i[0]
ReduceSum fNxNx1 i[1] | ReduceSumSquare fNxN i[1] | Relu fNxN | Reshape fNxN i[-1] | Resize f1x1xNxN _ f[1 1 2 2]
Resize f1x1xNxN _ _ i[1 1 N 16] mode=linear | Resize f1x1x4x4 _ _ i[1 1 N N] mode=cubic | ReverseSequence fNxN iN | Round fNxN
RotaryEmbedding f1x1xNx64 fNx32 fNx32 i1xN | Scatter fNxN iNxN fNxN | ScatterElements fNxN iNxN fNxN | ScatterND fNxN iNx1 fNxN | Shape fNxN
Sigmoid fNxN | Sign fNxN | Sin fNxN | Sinh fNxN | Size fNxN | Slice fNxN i[0] i[2] i[0] | Softmax fNxN | Softmax fNxN axis=0 | Softplus fNxN
Softsign fNxN | Split fNxN i[1 N-1] | Sqrt fNxN | Squeeze f1xNxN i[0] | Sub fNxN f1 | Sum fNxN fNx1 f1xN | Swish fNxN | Tan fNxN | Tanh fNxN
Tile fNxN i[2 3] | Tile fNxN i[N N] | TopK fNxN i[3] | TopK fNxN i[N] | Transpose fNxN | Transpose fNxNx4 perm=2,0,1 | Trilu fNxN
Unsqueeze fNxN i[0] | Upsample f1x1xNxN f[1 1 2 2] | Where iNxN fNx1 f1xN | Xor iNxN i1
ConvInteger uNx1x4x4 u1x1x3x3 strides=1,1 dilations=1,1 pads=0,0,0,0 | MatMulInteger uNxN uNxN | BitCast fNxN to=6
";

/// Operators that this runtime has not, or that are refused by name.
const REFUSED: [&str; 12] = [
    "DFT",
    "Dropout",
    "If",
    "Loop",
    "Multinomial",
    "RandomNormal",
    "RandomNormalLike",
    "RandomUniform",
    "RandomUniformLike",
    "SequenceAt",
    "SplitToSequence",
    "STFT",
];

/// The bytes of a network with an operator of [`OPERATORS`] at a size.
fn network(operator: &str, size: i64) -> Vec<u8> {
    let (mut parts, mut inputs, mut attributes) = (Vec::new(), Vec::new(), Vec::new());
    // A constant may hold blanks, so they are put in other words.
    let (mut words, mut inside) = (String::new(), false);
    for letter in operator.chars() {
        inside = inside && letter != ']' || letter == '[';
        words.push(if inside && letter == ' ' { ';' } else { letter });
    }
    let mut words = words.split_whitespace();
    let kind = words.next().unwrap();
    let sized = |text: &str| match text {
        "N" => size,
        "N-1" => size - 1,
        text => text.parse().unwrap(),
    };
    for (place, word) in words.enumerate() {
        let name = format!("x{place}");
        if let Some((attribute, value)) = word.split_once('=') {
            let named = onnx_file::field(1, attribute.as_bytes());
            let is_number = |text: &str| text == "N" || text.parse::<i64>().is_ok();
            attributes.push(if !value.split(',').all(is_number) {
                [named, onnx_file::field(4, value.as_bytes()), onnx_file::number(20, 3)].concat()
            } else if value.contains(',') {
                let all: Vec<u8> = value.split(',').flat_map(|text| onnx_file::number(8, sized(text))).collect();
                [named, all, onnx_file::number(20, 7)].concat()
            } else {
                [named, onnx_file::number(3, sized(value)), onnx_file::number(20, 2)].concat()
            });
        } else if word == "_" {
            inputs.push(String::new());
        } else if let Some(constant) = word[1..].strip_prefix('[') {
            let all: Vec<&str> = constant.trim_end_matches(']').split(';').collect();
            let (kind, raw): (i64, Vec<u8>) = if word.starts_with('i') {
                (7, all.iter().flat_map(|text| sized(text).to_le_bytes()).collect())
            } else {
                (1, all.iter().flat_map(|text| text.parse::<f32>().unwrap().to_le_bytes()).collect())
            };
            // These take one number without a place.
            let shape = if ["Range", "CumSum"].contains(&kind_of(operator)) { vec![] } else { vec![all.len() as i64] };
            parts.push(onnx_file::field(5, &onnx_file::tensor(&name, &shape, kind, &raw)));
            inputs.push(name);
        } else {
            let shape: Vec<i64> = word[1..].split('x').map(sized).collect();
            let (element, bytes): (i64, &[u8]) = match &word[..1] {
                "f" => (1, &[0; 4]),
                "i" => (7, &[0; 8]),
                _ => (2, &[0; 1]),
            };
            let raw: Vec<u8> = shape.iter().flat_map(|size| size.to_le_bytes()).collect();
            parts.push(onnx_file::field(
                5,
                &onnx_file::tensor(&format!("{name}_shape"), &[shape.len() as i64], 7, &raw),
            ));
            let value = onnx_file::field(5, &onnx_file::tensor("", &[1], element, bytes));
            let value = [onnx_file::field(1, b"value"), value, onnx_file::number(20, 4)].concat();
            parts.push(onnx_file::node("ConstantOfShape", &[format!("{name}_shape")], &name, &[value]));
            inputs.push(name);
        }
    }
    parts.push(onnx_file::node(kind, &inputs, "r", &attributes));
    onnx_file::driving(&parts)
}

fn kind_of(operator: &str) -> &str {
    operator.split(' ').next().unwrap()
}

fn operators() -> Vec<&'static str> {
    OPERATORS.lines().flat_map(|line| line.split('|')).map(str::trim).filter(|operator| !operator.is_empty()).collect()
}

/// Writes networks and a scenario with a driver for each.
fn write(operators: &[&str], size: i64, folder: &Path) {
    let mut text = "edition 1\n".to_owned();
    for (place, operator) in operators.iter().enumerate() {
        fs::write(folder.join(format!("{place}.onnx")), network(operator, size)).unwrap();
        writeln!(text, "// {operator}\npolicy p{place} = onnx(model: \"{place}.onnx\")").unwrap();
    }
    fs::write(folder.join("all.scn"), text).unwrap();
}

/// Reads networks in one process within the limits. The message has what is refused, with the number of the driver.
fn read(operators: &[&str], size: i64) -> Result<String, String> {
    let place = tempfile::tempdir().unwrap();
    write(operators, size, place.path());
    // The time is that of the processor, on two cores, with a reserve for a machine that does other work.
    let output = limited("ulimit -v 1000000; ulimit -t 50", &["check", "all.scn"], place.path());
    match output.status.code() {
        Some(0 | 3) => Ok(error(&output)),
        _ => Err(format!("{:?}: {}", output.status, error(&output))),
    }
}

#[test]
fn every_operator_runs_when_its_inputs_are_small() {
    let unusable: Vec<(&str, String)> = operators()
        .chunks(TOGETHER)
        .filter(|together| read(together, SIZES[0]).unwrap().contains("error"))
        .flat_map(|together| together.iter().map(|operator| (*operator, read(&[operator], SIZES[0]).unwrap())))
        .filter(|(_, said)| said.contains("error"))
        .collect();
    assert!(unusable.is_empty(), "{unusable:#?}");
    for kind in REFUSED {
        let said = read(&[kind], SIZES[0]).unwrap();
        assert!(said.contains("error"), "{kind}: {said}");
    }
}

#[test]
fn no_operator_takes_the_machine_when_its_inputs_are_large() {
    let mut refused = 0;
    for size in &SIZES[1..] {
        for operators in operators().chunks(TOGETHER) {
            let together = read(operators, *size);
            let said = together.unwrap_or_else(|_| {
                // Whichever it was is found alone.
                let alone = operators.iter().map(|operator| (operator, read(&[operator], *size)));
                panic!("size {size}: {:#?}", alone.filter(|(_, read)| read.is_err()).collect::<Vec<_>>())
            });
            assert!(!said.contains("panicked") && !said.contains("inputs explain"), "{said}");
            refused += said.matches("error").count();
        }
    }
    assert!(refused > 50, "the largest inputs are beyond the limits: {refused}");
}
