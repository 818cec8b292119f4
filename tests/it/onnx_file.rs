//! Writing of an ONNX file: fields with bytes and with numbers, as protocol buffers have them.

use std::time::{Duration, Instant};

use world::av::onnx::Model;

fn varint(mut number: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
    bytes
}

/// A field with bytes.
pub fn field(number: u8, bytes: &[u8]) -> Vec<u8> {
    [varint(u64::from(number) << 3 | 2), varint(bytes.len() as u64), bytes.to_vec()].concat()
}

/// A field with a number.
pub fn number(field: u8, number: i64) -> Vec<u8> {
    [varint(u64::from(field) << 3), varint(number as u64)].concat()
}

/// A tensor of a type of elements, which are given as bytes.
pub fn tensor(name: &str, shape: &[i64], kind: i64, raw: &[u8]) -> Vec<u8> {
    let shape: Vec<u8> = shape.iter().flat_map(|size| number(1, *size)).collect();
    [shape, number(2, kind), field(9, raw), field(8, name.as_bytes())].concat()
}

/// A constant of whole numbers.
fn sizes(name: &str, sizes: &[i64]) -> Vec<u8> {
    let raw: Vec<u8> = sizes.iter().flat_map(|size| size.to_le_bytes()).collect();
    field(5, &tensor(name, &[sizes.len() as i64], 7, &raw))
}

/// A constant of floats.
fn floats(name: &str, shape: &[i64], values: &[f32]) -> Vec<u8> {
    let raw: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    field(5, &tensor(name, shape, 1, &raw))
}

/// An operator with attributes.
pub fn node(kind: &str, inputs: &[impl AsRef<str>], output: &str, attributes: &[Vec<u8>]) -> Vec<u8> {
    let inputs: Vec<u8> = inputs.iter().flat_map(|name| field(1, name.as_ref().as_bytes())).collect();
    let attributes: Vec<u8> = attributes.iter().flat_map(|attribute| field(5, attribute)).collect();
    field(1, &[inputs, field(2, output.as_bytes()), field(4, kind.as_bytes()), attributes].concat())
}

/// An operator without attributes.
fn plain(kind: &str, inputs: &[&str], output: &str) -> Vec<u8> {
    node(kind, inputs, output, &[])
}

/// A network from `ego` to `y` with these parts of its graph.
fn model(parts: &[Vec<u8>]) -> Vec<u8> {
    let value = |place: u8, name: &str, shape: [i64; 2]| {
        let dimensions: Vec<u8> = shape.iter().flat_map(|size| field(1, &number(1, *size))).collect();
        let tensor = [number(1, 1), field(2, &dimensions)].concat();
        field(place, &[field(1, name.as_bytes()), field(2, &field(1, &tensor))].concat())
    };
    let graph = [parts.concat(), value(11, "ego", [1, 4]), value(12, "y", [1, 2])].concat();
    [number(1, 8), field(7, &graph), field(8, &number(2, 21))].concat()
}

/// A network that drives, with further parts.
pub fn driving(parts: &[Vec<u8>]) -> Vec<u8> {
    let drives = [floats("w", &[4, 2], &[0.5; 8]), plain("MatMul", &["ego", "w"], "y")];
    model(&[parts, &drives].concat())
}

#[test]
fn operators_that_take_the_machine_are_refused_before_they_run() {
    let drives = |parts: &[Vec<u8>]| Model::read(driving(parts));
    drives(&[]).unwrap();
    let made = |name: &str, size: &[i64]| {
        vec![sizes(&format!("{name}_size"), size), plain("ConstantOfShape", &[&format!("{name}_size")], name)]
    };
    let with = |parts: [Vec<Vec<u8>>; 2], operator: Vec<u8>| [parts.concat(), vec![operator]].concat();
    let range = vec![
        floats("from", &[], &[0.0]),
        floats("to", &[], &[1e9]),
        floats("by", &[], &[1.0]),
        plain("Range", &["from", "to", "by"], "r"),
    ];
    let endless = vec![
        floats("from", &[], &[0.0]),
        floats("to", &[], &[1.0]),
        floats("by", &[], &[0.0]),
        plain("Range", &["from", "to", "by"], "r"),
    ];
    let resized = vec![floats("scales", &[2], &[1.0, 1e9]), plain("Resize", &["ego", "", "scales"], "r")];
    for (name, parts, reason) in [
        (
            "broadcast",
            with([made("a", &[1 << 16, 1]), made("b", &[1, 1 << 16])], plain("Add", &["a", "b"], "c")),
            "Add",
        ),
        ("constant", made("a", &[1 << 40]), "ConstantOfShape"),
        ("negative", made("a", &[-1, 1 << 62]), "invalid"),
        ("expand", vec![sizes("s", &[1 << 30, 4]), plain("Expand", &["ego", "s"], "r")], "Expand"),
        ("tile", vec![sizes("s", &[1 << 20, 1 << 20]), plain("Tile", &["ego", "s"], "r")], "Tile"),
        ("pad", vec![sizes("s", &[0, 0, 0, 1 << 40]), plain("Pad", &["ego", "s"], "r")], "Pad"),
        ("range", range, "Range"),
        ("endless range", endless, "Range"),
        ("resize", resized, "Resize"),
        ("product", with([made("a", &[1000, 1000]), Vec::new()], plain("MatMul", &["a", "a"], "c")), "MatMul"),
        ("varying", vec![plain("NonZero", &["ego"], "r")], "NonZero"),
        ("varying size", vec![plain("ConstantOfShape", &["ego"], "r")], "ConstantOfShape"),
        ("order", vec![plain("Relu", &["later"], "r"), plain("Relu", &["ego"], "later")], "later"),
        ("loop", vec![plain("Loop", &["ego"], "r")], "Loop"),
        ("branches", vec![plain("If", &["ego"], "r")], "If"),
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
        plain("Shape", &["ego"], "shape"),
        plain("ConstantOfShape", &["shape"], "zeros"),
        plain("Add", &["ego", "zeros"], "sum"),
        plain("MatMul", &["sum", "w"], "y"),
    ];
    Model::read(model(&parts)).unwrap();
}
