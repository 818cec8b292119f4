//! Writing of an ONNX file: fields with bytes and with numbers, as protocol buffers have them.

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
fn field(number: u8, bytes: &[u8]) -> Vec<u8> {
    [varint(u64::from(number) << 3 | 2), varint(bytes.len() as u64), bytes.to_vec()].concat()
}

/// A field with a number.
fn number(field: u8, number: i64) -> Vec<u8> {
    [varint(u64::from(field) << 3), varint(number as u64)].concat()
}

/// A tensor of a type of elements, which are given as bytes.
fn tensor(name: &str, shape: &[i64], kind: i64, raw: &[u8]) -> Vec<u8> {
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
fn node(kind: &str, inputs: &[impl AsRef<str>], output: &str, attributes: &[Vec<u8>]) -> Vec<u8> {
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
fn driving(parts: &[Vec<u8>]) -> Vec<u8> {
    let drives = [floats("w", &[4, 2], &[0.5; 8]), plain("MatMul", &["ego", "w"], "y")];
    model(&[parts, &drives].concat())
}

/// A network that has a tensor of this size, made in an evaluation, and whose answer depends on the sum of what operators make of it.
fn with_sum_of(size: &[i64], operators: &[Vec<u8>]) -> Vec<u8> {
    let before = [sizes("size", size), plain("ConstantOfShape", &["size"], "a")].concat();
    let after = [
        plain("ReduceSum", &["z"], "sum"),
        floats("w", &[4, 2], &[0.5; 8]),
        plain("MatMul", &["ego", "w"], "driven"),
        plain("Add", &["driven", "sum"], "y"),
    ];
    model(&[before, operators.concat(), after.concat()])
}

/// Checks a scenario with a network in a process with little memory, and returns its exit code and its messages.
#[cfg(target_os = "linux")]
fn checked(network: &[u8]) -> (Option<i32>, String) {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("a.onnx"), network).unwrap();
    let text = "edition 1\ndriver p = onnx(model: \"a.onnx\")\npedestrian c = onnx(model: \"a.onnx\")\n";
    std::fs::write(place.path().join("a.scn"), text).unwrap();
    // The time is that of the processor and does not count that of the trial.
    let output = crate::unbreakable::limited("ulimit -v 700000; ulimit -t 20", &["check", "a.scn"], place.path());
    (output.status.code(), crate::program::error(&output))
}

#[cfg(target_os = "linux")]
#[test]
fn networks_that_take_the_machine_are_refused() {
    assert_eq!(checked(&driving(&[])), (Some(0), String::new()));
    let relu = [plain("Relu", &["a"], "z")];
    // Six million million steps.
    let product = |place: usize| {
        let name = |place: usize| if place == 3000 { "z".to_owned() } else { format!("p{place}") };
        let before = if place == 1 { "a".to_owned() } else { name(place - 1) };
        plain("MatMul", &[&before, "a"], &name(place))
    };
    let products: Vec<Vec<u8>> = (1..=3000).map(product).collect();
    let broadcast = [plain("Transpose", &["a"], "b"), plain("Add", &["a", "b"], "z")];
    let endless = [
        floats("from", &[], &[0.0]),
        floats("to", &[], &[1.0]),
        floats("by", &[], &[0.0]),
        plain("Range", &["from", "to", "by"], "r"),
        plain("Add", &["r", "a"], "z"),
    ];
    for (name, network, reason) in [
        ("memory", with_sum_of(&[1 << 30], &relu), "MiB of memory"),
        ("more memory than there is", with_sum_of(&[1 << 40], &relu), "MiB of memory"),
        ("broadcast", with_sum_of(&[1 << 16, 1], &broadcast), "MiB of memory"),
        ("time", with_sum_of(&[1000, 1000], &products), "takes more than 1 s"),
        ("endless range", with_sum_of(&[1], &endless), "cannot use the model"),
        ("negative", with_sum_of(&[-1, 1 << 62], &relu), "cannot use the model"),
    ] {
        let (code, said) = checked(&network);
        assert_eq!(code, Some(3), "{name}: {said}");
        assert!(said.contains(reason) && !said.contains("panic"), "{name}: {said}");
    }
}

#[test]
fn results_without_a_constant_size_are_refused_before_they_run() {
    Model::read(driving(&[]), None).unwrap();
    let shaped = [plain("Relu", &["ego"], "later"), plain("ConstantOfShape", &["later"], "r")];
    for (name, parts, reason) in [
        ("numbers", vec![plain("NonZero", &["ego"], "r")], "NonZero"),
        ("sizes", vec![plain("ConstantOfShape", &["ego"], "r")], "ConstantOfShape"),
        ("sizes made of numbers", shaped.to_vec(), "ConstantOfShape"),
        ("order", vec![plain("Relu", &["later"], "r"), plain("Relu", &["ego"], "later")], "later"),
        ("twice", vec![plain("Relu", &["ego"], "r"), plain("Abs", &["ego"], "r")], "two of its values"),
        ("loop", vec![plain("Loop", &["ego"], "r")], "Loop"),
        ("branches", vec![plain("If", &["ego"], "r")], "If"),
    ] {
        let refused = Model::read(driving(&parts), None).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(refused.contains(reason), "{name}: {refused:?}");
    }
}

#[test]
fn one_of_several_outputs_is_chosen_by_its_name() {
    let file = driving(&[plain("Relu", &["ego"], "z"), field(12, &field(1, b"z"))]);
    let refused = |output| Model::read(file.clone(), output).err().map(|error| error.to_string()).unwrap_or_default();
    assert_eq!(refused(None), "it has 2 outputs (`z`, `y`): choose one, as `output: \"z\"`");
    assert_eq!(refused(Some("x")), "it has no output `x`; it has `z`, `y`");
    assert!(refused(Some("z")).contains("4 numbers"), "{}", refused(Some("z")));
    assert_eq!(refused(Some("y")), "");
    assert_eq!(world::av::onnx::outputs(file.clone()), ["z", "y"]);
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
    Model::read(model(&parts), None).unwrap();
}
