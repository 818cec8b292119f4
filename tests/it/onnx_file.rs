//! Writing of an ONNX file: fields with bytes and with numbers, as protocol buffers have them.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, compile};
use episode::walker::Random;
use episode::{Draw, Outcome, Phase, Scenario, Simulation, Trace, evaluate_observed};
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

/// The declaration of an input (11) or an output (12) of a network.
fn value(place: u8, name: &str, shape: [i64; 2]) -> Vec<u8> {
    let dimensions: Vec<u8> = shape.iter().flat_map(|size| field(1, &number(1, *size))).collect();
    let tensor = [number(1, 1), field(2, &dimensions)].concat();
    field(place, &[field(1, name.as_bytes()), field(2, &field(1, &tensor))].concat())
}

/// A network from `ego` to `y` with these parts of its graph.
fn model(parts: &[Vec<u8>]) -> Vec<u8> {
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

/// A gated recurrent unit of two cells, which steers by half of the second, and a counter: the acceleration is 0.1 of the ticks up to now.
fn recurrent() -> Vec<u8> {
    let gate = |kind: &str, gate: &str| {
        let [seen, kept, sum] = ["x", "h", "s"].map(|part| format!("{part}{gate}"));
        [
            plain("MatMul", &["ego", "w"], &seen),
            plain("MatMul", &["cell_in", "u"], &kept),
            plain("Add", &[&seen, &kept], &sum),
            plain(kind, &[&sum], gate),
        ]
        .concat()
    };
    model(&[
        floats("w", &[4, 2], &[0.1; 8]),
        floats("u", &[2, 2], &[0.2; 4]),
        floats("one", &[1, 1], &[1.0]),
        floats("push", &[1, 2], &[0.1, 0.0]),
        floats("turn", &[1, 2], &[0.0, 0.5]),
        gate("Sigmoid", "z"),
        gate("Tanh", "n"),
        plain("Sub", &["n", "cell_in"], "way"),
        plain("Mul", &["z", "way"], "step"),
        plain("Add", &["cell_in", "step"], "cell_out"),
        plain("Add", &["ticks_in", "one"], "ticks_out"),
        plain("Mul", &["ticks_out", "push"], "pushed"),
        plain("Mul", &["cell_out", "turn"], "turned"),
        plain("Add", &["pushed", "turned"], "y"),
        value(11, "cell_in", [1, 2]),
        value(11, "ticks_in", [1, 1]),
        value(12, "cell_out", [1, 2]),
        value(12, "ticks_out", [1, 1]),
    ])
}

/// A car at rest with nobody ahead, driven by the network in `a.onnx` for a second.
const SECOND: &str = "\
edition 1
town plain { street along { through: [(0 m, 0 m), (100 m, 0 m), (200 m, 0 m)] } }
driver learnt = onnx(model: \"a.onnx\", worlds: WORLDS)
vehicle car = generic()
body walker { }
spawn behind { ego_speed: 0 m/s  bearing: 180 deg  distance: 30 m }
episode brief { ticks: 20  hold: 10 }
campaign c {
  vehicle: car  body: walker  spawn: behind  episode: brief
  evaluate { towns: [plain]  drivers: [learnt]  pedestrians: [random]  episodes: 3 }
}
";

fn driven(folder: &Path, worlds: &str) -> Arc<Scenario> {
    let file = folder.join("a.scn");
    std::fs::write(folder.join("a.onnx"), recurrent()).unwrap();
    std::fs::write(&file, SECOND.replace("WORLDS", worlds)).unwrap();
    let compiled = compile(&[file], &Catalog::builtin(), &program::session::Disk, &mut Sources::default()).unwrap();
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    plan.campaigns[0].nth::<compile::Evaluation>(0).scenario.clone()
}

/// Speed after 20 ticks of 0.05 s with 0.1, 0.2, … 2 m/s².
const AFTER_A_SECOND: f64 = 0.05 * 0.1 * 210.0;

#[test]
fn a_recurrent_network_carries_its_state_from_tick_to_tick_and_not_into_the_next_episode() {
    let place = tempfile::tempdir().unwrap();
    for worlds in ["1", "2"] {
        let scenario = driven(place.path(), worlds);
        let seed = Seed::root(3);
        let mut note = |_: u32, outcome: &Outcome, trace: &Trace| {
            assert_eq!((outcome.fault(), outcome.ticks), (None, 20));
            let frames = trace.vehicle(0);
            assert!((frames[20].state.speed - AFTER_A_SECOND).abs() < 1e-5, "{}", frames[20].state.speed);
            let limit = 30.0 / 3.6;
            let mut cell = 0.0_f64;
            for (before, after) in frames.iter().zip(&frames[1..]) {
                let sum = 0.1 * (before.state.speed + limit) + 0.2 * (cell + cell);
                cell += (libm::tanh(sum) - cell) / (1.0 + libm::exp(-sum));
                assert!(
                    (after.driven.control.steer - 0.5 * cell).abs() < 1e-6,
                    "{} and {cell}",
                    after.driven.control.steer
                );
            }
            // It remembers: with the state of the start the cell is less.
            assert!(cell > 0.7 && frames[1].driven.control.steer < 0.25, "{cell}");
        };
        let go_on = &mut |_| ControlFlow::Continue(());
        let all = evaluate_observed(&mut Random::default(), &scenario, 0..3, &seed, &seed, &mut note, go_on);
        assert_eq!(all.len(), 3);
    }
}

#[test]
fn the_state_of_a_recurrent_network_is_part_of_a_snapshot() {
    let place = tempfile::tempdir().unwrap();
    let mut simulation = driven(place.path(), "1").simulation();
    simulation.start(Draw::new(&Seed::root(3), 0));
    let drive = |simulation: &mut dyn Simulation, ticks: u32| {
        while simulation.scene().world.ticks < ticks {
            if simulation.phase() == Phase::Decision {
                let commands = simulation.scene().commands().to_vec();
                simulation.decide(&commands);
            }
            simulation.tick();
        }
        simulation.scene().world.ego().state
    };
    drive(&mut *simulation, 7);
    let mut copy = simulation.snapshot().unwrap();
    let ended = drive(&mut *copy, 20);
    assert!((ended.speed - AFTER_A_SECOND).abs() < 1e-5, "{}", ended.speed);
    assert_eq!(drive(&mut *simulation, 20), ended);
}

#[test]
fn a_check_says_what_a_network_carries() {
    let place = tempfile::tempdir().unwrap();
    driven(place.path(), "1");
    let output = crate::program::falsify(&["check", "a.scn"], place.path());
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let said =
        "driver learnt carries `cell` [1, 2], `ticks` [1, 1] from tick to tick, from 0 at the start of an episode\n";
    assert!(output.status.success() && text.contains(said), "{text}");
}

#[test]
fn states_that_do_not_fit_are_refused() {
    let refused = |file: Vec<u8>| Model::read(file, None).err().map(|error| error.to_string()).unwrap_or_default();
    assert_eq!(refused(recurrent()), "");
    // One is added to two numbers, and the output has the shape of both.
    let wide = [floats("two", &[1, 2], &[1.0; 2]), plain("Add", &["a_in", "two"], "a_out")].concat();
    let wide = [wide, value(11, "a_in", [1, 1]), value(12, "a_out", [1, 2])].concat();
    let said = "it cannot be run: its state `a_in` has the shape [1, 1], and `a_out` [1, 2]";
    assert_eq!(refused(driving(&[wide])), said);
    let huge =
        [plain("Relu", &["a_in"], "a_out"), value(11, "a_in", [300, 300]), value(12, "a_out", [300, 300])].concat();
    let said = "its input `a_in` is none of `ego`, `actors`, `route`, and no state: at most 65536 numbers `NAME_in` with an output `NAME_out`";
    assert_eq!(refused(driving(&[huge])), said);
    let lonely = value(11, "a_in", [1, 1]);
    assert_eq!(refused(driving(&[lonely])), said);
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
