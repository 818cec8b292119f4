"""Networks in ONNX files: the files of the program's reports, and files that it refuses."""

import csv
import json
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import falsify_av
from falsify_av import drivers

REPOSITORY = Path(__file__).resolve().parents[2]
pytest.importorskip("onnxruntime")


def network(path, inputs, width, kind="FLOAT"):
    """Writes a network whose output is the sum of the numbers of its first input, `width` times."""
    onnx = pytest.importorskip("onnx")
    from onnx import TensorProto, helper

    kind = getattr(TensorProto, kind)
    nodes = [helper.make_node("ReduceSum", [name], [f"{name}_sum"], keepdims=0) for name in inputs]
    nodes.append(helper.make_node("Expand", [f"{next(iter(inputs))}_sum", "shape"], ["out"]))
    given = [helper.make_tensor_value_info(name, kind, shape) for name, shape in inputs.items()]
    shape = helper.make_tensor("shape", TensorProto.INT64, [2], [1, width])
    graph = helper.make_graph(nodes, "sums", given, [helper.make_tensor_value_info("out", kind, [1, width])], [shape])
    onnx.save(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8), path)
    return path


def test_a_pedestrian_of_a_report_walks_in_python(program, tmp_path):
    (tmp_path / "a.scn").write_text(
        'edition 1\nimport "std/paper.scn"\nimport "std/drivers.scn"\nimport "std/towns.scn"\n'
        "training brisk = ppo(steps: 300, normalize_observations: true)\n"
        "spawn near { ego_speed: 4 m/s .. 8 m/s  bearing: -60 deg .. 60 deg  distance: 7 m .. 20 m }\n"
        "episode brief { ticks: 100 }\n"
        "campaign a { vehicle: model3 body: suicidal spawn: near episode: brief training: brisk\n"
        "train { towns: [harbour] drivers: [behavior] rewards: [r2] runs: 1 }\n"
        "evaluate { towns: [harbour] drivers: [behavior] pedestrians: [trained] episodes: 20 } }\n"
    )
    report = falsify_av.run(tmp_path / "a.scn", out=tmp_path / "out")["a"].folder
    [file] = report.glob("pedestrians/*.onnx")
    with open(report / "episodes.csv", encoding="utf-8") as table:
        recorded = list(csv.DictReader(table))
    found = falsify_av.evaluate(falsify_av.onnx(file), tmp_path / "a.scn", episodes=20, task="evaluate")
    assert [row["outcome"] for row in found] == [row["outcome"] for row in recorded]
    assert [row["least_gap_m"] for row in found] == pytest.approx([float(row["least_gap_m"]) for row in recorded], abs=0.01)
    assert {row["outcome"] for row in found} >= {"collision", "timeout"}
    # The program's file takes any number of states; one that takes a single state says the same.
    states = np.random.default_rng(0).uniform(-1, 1, (5, 4)).astype(np.float32)
    pedestrian = falsify_av.onnx(file)
    assert np.allclose(pedestrian(states), np.concatenate([pedestrian(state[None]) for state in states]))
    with pytest.raises(ValueError, match="takes 4 numbers, and a state of this scenario has 8"):
        pedestrian(np.zeros((1, 8), np.float32))


def test_a_network_of_one_pedestrian_moves_each_of_a_cast(tmp_path):
    each = falsify_av.onnx(network(tmp_path / "each.onnx", {"state": [1, 4]}, 2))
    cast = tmp_path / "cast.scn"
    cast.write_text(
        'edition 1\nimport "std/paper.scn"\nimport "std/drivers.scn"\nimport "std/towns.scn"\n'
        "campaign three { vehicle: model3 body: suicidal spawn: ahead episode: thirty_seconds\n"
        "cast { anna: pedestrian() others: pedestrian(count: 2, beside: anna, distance: 5 m .. 9 m) }\n"
        "evaluate { towns: [harbour] drivers: [idm] pedestrians: [random] episodes: 2 } }\n"
    )
    each.check(falsify_av.make(cast))
    states = np.arange(24, dtype=np.float32).reshape(2, 12)
    sums = states.reshape(2, 3, 4).sum(axis=2)
    assert each(states).tolist() == np.repeat(sums, 2, axis=1).tolist()
    assert len(falsify_av.evaluate(each, cast, episodes=2)) == 2


def test_the_shipped_pedestrian_walks_in_python_as_in_the_program(program, tmp_path):
    (tmp_path / "a.scn").write_text(
        'edition 1\nimport "std/pedestrians.scn"\nimport "std/drivers.scn"\nimport "std/towns.scn"\n'
        "spawn ahead { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }\n"
        "episode brief { hold: 10 ticks: 240 end_when: ahead < -6 m }\n"
        "campaign a { vehicle: model3 body: pursuer spawn: ahead episode: brief\n"
        "evaluate { towns: [harbour] drivers: [behavior] pedestrians: [hunter] episodes: 60 } }\n"
    )
    report = falsify_av.run(tmp_path / "a.scn", out=tmp_path / "out")["a"].folder
    with open(report / "episodes.csv", encoding="utf-8") as table:
        recorded = [row["outcome"] for row in csv.DictReader(table)]
    for worlds in (1, 60):
        found = falsify_av.evaluate(falsify_av.hunter(), tmp_path / "a.scn", episodes=60, num_envs=worlds)
        # The two runtimes have other last bits.
        assert sum(row["outcome"] == outcome for row, outcome in zip(found, recorded)) >= 57
    assert recorded.count("collision") >= 6
    # In another body, or at another time of a decision, it is another pedestrian.
    text = (tmp_path / "a.scn").read_text()
    (tmp_path / "b.scn").write_text(text.replace("pursuer", "plausible").replace("[hunter]", "[random]"))
    with pytest.raises(ValueError, match="trained with other frames or units of state and action; give its campaign the `body`"):
        falsify_av.evaluate(falsify_av.hunter(), tmp_path / "b.scn", episodes=1)
    (tmp_path / "c.scn").write_text(text.replace("hold: 10", "hold: 20"))
    with pytest.warns(UserWarning, match="decided every 0.5 s, and here every 1 s"):
        falsify_av.hunter().check(falsify_av.make(tmp_path / "c.scn"))
    with pytest.raises(ValueError, match="no trained pedestrian has the body 'dog'"):
        falsify_av.hunter("dog")
    with pytest.raises(ValueError, match="takes several states: call `begin`"):
        falsify_av.hunter()(np.zeros((1, 4), np.float32))


@pytest.mark.parametrize("kind", ["FLOAT", "DOUBLE"])
def test_a_network_for_one_state_walks_in_many_worlds(scenario, tmp_path, kind):
    single = falsify_av.onnx(network(tmp_path / "single.onnx", {"state": [1, 4]}, 2, kind))
    states = np.arange(12, dtype=np.float32).reshape(3, 4)
    assert single(states).tolist() == [[6.0, 6.0], [22.0, 22.0], [38.0, 38.0]]
    choice = {"campaign": "short", "town": "harbour", "driver": "blind", "task": "train"}
    many, alone = (falsify_av.evaluate(single, scenario, episodes=6, num_envs=worlds, **choice) for worlds in (6, 1))
    assert [row["digest"] for row in many] == [row["digest"] for row in alone]


def test_a_served_pedestrian_with_memory_remembers_each_world(tmp_path):
    file = network(tmp_path / "memory.onnx", {"states": [1, 8]}, 2)
    mine = tmp_path / "mine.py"
    mine.write_text(f"import falsify_av\nfalsify_av.pedestrians.serve(falsify_av.onnx({str(file)!r}))\n")
    hello = {"type": "hello", "protocol": "falsify-pedestrian/1"}
    # World, tick and the numbers of the state, which the network adds to those of the state before.
    asked = [(0, 0, 1.0), (1, 0, 10.0), (0, 10, 2.0), (1, 10, 20.0), (0, 20, 3.0), (0, 0, 5.0), (1, 20, 30.0)]
    steps = [{"type": "step", "worlds": [{"id": world, "tick": tick, "state": [number] * 4}]} for world, tick, number in asked]
    steps.append({"type": "step", "worlds": [{"id": world, "tick": 30, "state": [0.0] * 4} for world in (1, 0)]})
    said = "".join(json.dumps(message) + "\n" for message in [hello, *steps])
    done = subprocess.run([sys.executable, str(mine)], input=said, capture_output=True, text=True)
    answers = [json.loads(line) for line in done.stdout.splitlines()[1:]]
    found = [(each["id"], each["action"]) for answer in answers for each in answer["actions"]]
    sums = [(0, 4), (1, 40), (0, 12), (1, 120), (0, 20), (0, 20), (1, 200), (1, 120), (0, 20)]
    assert found == [(world, [float(total)] * 2) for world, total in sums], done.stderr


def test_a_pedestrian_is_pickled_with_what_it_has_seen(tmp_path):
    walkers = [falsify_av.hunter(), falsify_av.onnx(network(tmp_path / "three.onnx", {"state": [1, 12]}, 2))]
    states = np.arange(8, dtype=np.float32).reshape(2, 4)
    for walker in walkers:
        walker.begin(np.ones(2, np.bool_))
        walker(states)
        again = pickle.loads(pickle.dumps(walker))
        assert np.array_equal(again(states), walker(states))
    import onnxruntime

    session = onnxruntime.InferenceSession(str(tmp_path / "three.onnx"))
    with pytest.raises(TypeError, match="make it of the file"):
        pickle.dumps(falsify_av.onnx(session))


def test_the_shipped_pedestrian_is_served_to_a_campaign(program, tmp_path):
    (tmp_path / "mine.py").write_text("import falsify_av\nfalsify_av.pedestrians.serve(falsify_av.hunter())\n")
    (tmp_path / "a.scn").write_text(
        'edition 1\nimport "std/pedestrians.scn"\nimport "std/drivers.scn"\nimport "std/towns.scn"\n'
        "spawn ahead { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }\n"
        "episode brief { hold: 10 ticks: 240 end_when: ahead < -6 m }\n"
        f'pedestrian served = external(command: "{sys.executable} mine.py", files: ["mine.py"])\n'
        "campaign a { vehicle: model3 body: pursuer spawn: ahead episode: brief\n"
        "evaluate { towns: [harbour] drivers: [behavior] pedestrians: [hunter, served] episodes: 60 } }\n"
    )
    report = falsify_av.run(tmp_path / "a.scn", out=tmp_path / "out", allow_external=True)["a"].folder
    with open(report / "episodes.csv", encoding="utf-8") as table:
        outcomes = {name: [] for name in ("hunter", "served")}
        for row in csv.DictReader(table):
            outcomes[row["pedestrian"]].append(row["outcome"])
    # The two runtimes have other last bits.
    assert sum(one == other for one, other in zip(*outcomes.values())) >= 57
    assert outcomes["served"].count("collision") >= 6


@pytest.mark.parametrize(
    ("inputs", "kind", "text"),
    [
        ({"state": [3, 4]}, "FLOAT", "one input, of the shape"),
        ({"state": [4]}, "FLOAT", "one input, of the shape"),
        ({"state": [1, "n"]}, "FLOAT", "one input, of the shape"),
        ({"state": [1, 4], "more": [1, 4]}, "FLOAT", "one input, of the shape"),
        ({"state": [1, 4]}, "INT64", "input `state` is a tensor\\(int64\\)"),
    ],
)
def test_other_networks_are_no_pedestrians(tmp_path, inputs, kind, text):
    file = network(tmp_path / "other.onnx", inputs, 2, kind)
    with pytest.raises(ValueError, match=text):
        falsify_av.onnx(file)


@pytest.mark.parametrize(
    ("inputs", "width", "text"),
    [
        ({"ego": [1, 4]}, 5, "output has 5 numbers instead of two"),
        ({"ego": [1, 4]}, 1, "output has 1 numbers instead of two"),
        ({"ego": [1, 4], "actors": [1, "K", 8]}, 2, r"`actors` must have the shape \(1, K, 8\) with K from 1 to 64, and has \(1, 'K', 8\)"),
        ({"actors": [1, 65, 8]}, 2, "`actors` must have the shape"),
        ({"route": [1, 41, 3]}, 2, r"`route` must have the shape \(1, R, 3\) with R from 1 to 40"),
        ({"ego": [2, 4]}, 2, r"`ego` must have the shape \(1, 4\), and has \(2, 4\)"),
        ({"ego": [1, 5]}, 2, "`ego` must have the shape"),
        ({"lidar": [1, 4]}, 2, "input `lidar` is none of `ego`, `actors`, `route`"),
    ],
)
def test_networks_that_the_program_refuses_are_no_drivers(tmp_path, inputs, width, text):
    file = network(tmp_path / "other.onnx", inputs, width)
    with pytest.raises(ValueError, match=text):
        drivers.OnnxDriver(file)


def recurrent(path, counter=(1, 1)):
    """Writes a network that counts ticks, adds up the speeds, and drives with both."""
    import onnx
    from onnx import TensorProto, helper

    tensor = lambda name, shape: helper.make_tensor_value_info(name, TensorProto.FLOAT, shape)
    constant = lambda name, shape, numbers: helper.make_tensor(name, TensorProto.FLOAT, shape, numbers)
    nodes = [
        helper.make_node("Add", ["ticks_in", "one"], ["ticks_out"]),
        helper.make_node("MatMul", ["ego", "first"], ["speed"]),
        helper.make_node("Add", ["sum_in", "speed"], ["sum_out"]),
        helper.make_node("Concat", ["ticks_out", "sum_out"], ["control"], axis=1),
    ]
    inputs = [tensor("ego", [1, 4]), tensor("ticks_in", counter), tensor("sum_in", ["batch", 1])]
    outputs = [tensor("sum_out", ["batch", 1]), tensor("control", [1, 2]), tensor("ticks_out", [1, 1])]
    constants = [constant("one", [1, 1], [1.0]), constant("first", [4, 1], [1.0, 0.0, 0.0, 0.0])]
    model = helper.make_model(helper.make_graph(nodes, "recurrent", inputs, outputs, constants), opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.save(model, path)
    return path


def test_a_recurrent_network_carries_its_state_and_forgets_it_with_the_episode(tmp_path):
    driver = drivers.OnnxDriver(recurrent(tmp_path / "recurrent.onnx"))
    world = lambda speed: {**drivers._NOTHING, "ego": {**drivers._NOTHING["ego"], "speed": speed}}
    drive = lambda: [tuple(driver.drive(world(speed)).values()) for speed in (2.0, 3.0, 5.0)]
    for _ in range(2):
        driver.reset({}, 7)
        assert drive() == [(1.0, 2.0), (2.0, 5.0), (3.0, 10.0)]
    assert drive()[0] == (4.0, 12.0), "without a reset it goes on"


def test_a_pedestrian_has_no_state(tmp_path):
    with pytest.raises(ValueError, match="exactly one output, and has 3 and 3"):
        falsify_av.onnx(recurrent(tmp_path / "recurrent.onnx"))


def test_a_network_of_64_bits_drives(tmp_path):
    import onnxruntime

    world = {**drivers._NOTHING, "speed_limit": 3.0}
    files = [network(tmp_path / f"{kind}.onnx", {"ego": ["batch", 4]}, 3, kind) for kind in ("FLOAT", "DOUBLE")]
    for model in [*files, onnxruntime.InferenceSession(str(files[1]))]:
        assert drivers.OnnxDriver(model).drive(world) == {"throttle": 3.0, "brake": 3.0, "steer": 3.0}
    with pytest.raises(ValueError, match="output has 5 numbers"):
        drivers.OnnxDriver(REPOSITORY / "tests/reference/onnx/five.onnx")
