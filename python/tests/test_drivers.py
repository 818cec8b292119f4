"""Drivers under test that are Python objects."""

import inspect
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import falsify_av
from falsify_av import drivers

REPOSITORY = Path(__file__).resolve().parents[2]
CHOICE = {"campaign": "short", "town": "harbour", "driver": "behavior", "task": "train"}


def test_a_class_answers_as_the_protocol_says():
    class Standing:
        def reset(self, hello, seed):
            self.seed = (hello["tick_s"], seed)

        def drive(self, world):
            return {"brake": 1, "steer": self.seed[1], "mode": "emergency_stop"}

    answer = drivers._Answers(Standing)
    assert json.loads(answer(b'{"type":"hello","tick_s":0.05}')) == {"protocol": "falsify-av/1", "name": "falsify_av"}
    first = b'{"type":"step","worlds":[{"id":4,"tick":0,"seed":7},{"id":5,"tick":0,"seed":8}]}'
    action = {"brake": 1.0, "mode": "emergency_stop"}
    assert json.loads(answer(first)) == {"actions": [{"id": 4, "steer": 7.0, **action}, {"id": 5, "steer": 8.0, **action}]}
    # Each world has a driver of its own, which keeps what it was given.
    later = b'{"type":"step","worlds":[{"id":4,"tick":1}]}'
    assert json.loads(answer(later)) == {"actions": [{"id": 4, "steer": 7.0, **action}]}

    class Silent:
        def drive(self, world):
            return None

    with pytest.raises(TypeError, match="drive returned NoneType"):
        drivers._Answers(Silent)(later)


def test_the_angle_of_the_wheels_takes_the_place_of_steer():
    checked = drivers._checked({"acceleration": 1, "wheel_angle": -0.2})
    assert checked == {"acceleration": 1.0, "wheel_angle": -0.2}
    with pytest.raises(ValueError, match="both steer and wheel_angle"):
        drivers._checked({"brake": 1, "steer": 0.0, "wheel_angle": 0.0})
    with pytest.raises(ValueError, match="`wheel_angle` is inf, which is not finite"):
        drivers._checked({"brake": 1, "wheel_angle": math.inf})


@pytest.mark.parametrize("file", ["scenarios/external/my_av.py", "scenarios/external/tuned_av.py", "tests/external/follower.py", "tests/external/braking.py"])
def test_a_shipped_driver_brakes_where_the_road_ends_and_steers_within_its_range(file):
    hello = {"type": "hello", "protocol": "falsify-av/1"}
    ego = {"x": 208.3, "y": 0.0, "yaw": 0.0, "speed": 8.0}
    world = {"tick": 9, "ego": ego, "speed_limit": 8.33, "light": None, "actors": []}
    routes = [[], [[199.9, 0.0, 0.0]], [[208.0, 30.0, 1.6]]]
    step = {"type": "step", "worlds": [{"id": number, "route": route, **world} for number, route in enumerate(routes)]}
    said = subprocess.check_output([sys.executable, REPOSITORY / file], input=f"{json.dumps(hello)}\n{json.dumps(step)}\n", text=True)
    ended, *others = json.loads(said.splitlines()[1])["actions"]
    assert ended == {"id": 0, "acceleration": -2, "steer": 0}
    assert all(-1 <= action["steer"] <= 1 for action in others)


class Cruise:
    """Drives along the road at the speed limit, and brakes for who is near."""

    revision = 2

    def reset(self, hello, seed):
        self.wheelbase, self.weakness = hello["vehicle"]["wheelbase"], seed % 7 / 7

    def drive(self, world):
        ego = world["ego"]
        far = world["route"][min(4, len(world["route"]) - 1)]
        turn = math.remainder(math.atan2(far[1] - ego["y"], far[0] - ego["x"]) - ego["yaw"], 2 * math.pi)
        near = any(math.hypot(each["x"] - ego["x"], each["y"] - ego["y"]) < 6 + 4 * self.weakness for each in world["actors"])
        wanted = -4.0 if near else world["lanes"][0]["speed_limit"] - ego["speed"]
        return {"acceleration": wanted, "steer": max(-1.0, min(1.0, turn * self.wheelbase / 2)), "mode": "yield" if near else "follow"}


def walk(env, episodes):
    """The ends of episodes in which the pedestrian walks to the car."""
    for episode in range(episodes):
        env.reset(seed=3, options={"episode": episode})
        over = False
        while not over:
            *_, terminated, truncated, info = env.step(env.suggested("homing"))
            over = terminated or truncated
        yield info


def test_a_driver_in_process_drives_as_the_same_program(tmp_path):
    source = inspect.getsource(Cruise)
    (tmp_path / "mine.py").write_text(f"import math\nfrom falsify_av import drivers\n\n{source}\ndrivers.serve(Cruise)\n")
    text = Path(__file__).with_name("short.scn").read_text()
    named = f'driver mine = external(command: "{sys.executable} mine.py", timeout: 60 s, start_timeout: 60 s)\nepisode ten'
    (tmp_path / "mine.scn").write_text(text.replace("episode ten", named, 1).replace("[behavior, blind]", "[mine]", 1))
    program = falsify_av.make(tmp_path / "mine.scn", campaign="short", town="harbour", task="train", allow_external=True)
    inside = falsify_av.make(Path(__file__).with_name("short.scn"), own_driver=Cruise, **CHOICE)
    compared = list(zip(walk(program, 8), walk(inside, 8)))
    for one, two in compared:
        assert one["error"] == "" and one["ticks"] > 5, one
        assert one["digest"] == two["digest"], (one, two)
    assert {one["outcome"] for one, _ in compared} >= {"collision"}
    assert {one["driving_mode"] for one, _ in compared} <= {"yield", "follow"}


def test_a_driver_is_reset_with_the_seed_of_the_episode(scenario):
    made = []

    class Standing:
        def __init__(self):
            self.resets = []
            made.append(self)

        def reset(self, hello, seed):
            assert hello["vehicle"]["length"] > 3.0
            self.resets.append(seed)

        def drive(self, world):
            return {"brake": 1.0, "mode": "emergency_stop"}

    env = falsify_av.make(scenario, own_driver=Standing, **CHOICE)
    ends = list(walk(env, 4))
    assert all(end["driving_mode"] == "emergency_stop" for end in ends)
    [driver] = made
    assert len(set(driver.resets)) == 4
    env.reset(seed=3)
    env.step(np.zeros(2, np.float32))
    assert driver.resets[4:] == driver.resets[:1], "the same episode has the same seed"


def test_each_world_has_a_driver_and_the_numbers_of_single_ones(scenario):
    vector = falsify_av.make_vec(scenario, 3, own_driver=Cruise, **CHOICE)
    singles = [falsify_av.make(scenario, seed=1 + world, own_driver=Cruise, **CHOICE) for world in range(3)]
    states, _ = vector.reset(seed=1)
    assert np.array_equal(states, np.stack([env.reset(seed=1 + world)[0] for world, env in enumerate(singles)]))
    actions = np.zeros((3, 2), np.float32)
    over, steps = False, 0
    while not over:
        states, _, terminated, truncated, _ = vector.step(actions)
        assert np.array_equal(states, np.stack([env.step(actions[0])[0] for env in singles]))
        over, steps = np.any(terminated | truncated), steps + 1
    assert steps > 1


def test_a_driver_is_evaluated(scenario):
    def standing(states):
        return np.zeros((len(states), 2))

    class Blind:
        def drive(self, world):
            return {"throttle": 0.8}

    rows = falsify_av.evaluate(standing, scenario, episodes=8, num_envs=4, own_driver=Blind, **CHOICE)
    again = falsify_av.evaluate(standing, scenario, episodes=8, num_envs=1, own_driver=Blind, **CHOICE)
    assert [row["digest"] for row in rows] == [row["digest"] for row in again]
    other = falsify_av.evaluate(standing, scenario, episodes=8, **CHOICE)
    assert [row["digest"] for row in rows] != [row["digest"] for row in other]


def test_exceptions_of_a_driver_are_its_own(scenario):
    class Broken:
        def drive(self, world):
            raise ZeroDivisionError("no brakes")

    env = falsify_av.make(scenario, own_driver=Broken, **CHOICE)
    for _ in range(3):
        with pytest.raises(ZeroDivisionError, match="no brakes"):
            env.reset(seed=1)
            env.step(np.zeros(2, np.float32))

    class Silent:
        def drive(self, world):
            return None

    env = falsify_av.make_vec(scenario, 2, own_driver=Silent, **CHOICE)
    with pytest.raises(TypeError, match="drive returned NoneType"):
        env.reset(seed=1)
        env.step(np.zeros((2, 2), np.float32))

    class Unready:
        def __init__(self):
            raise OSError("no weights")

        def drive(self, world):
            return {}

    with pytest.raises(OSError, match="no weights"):
        env = falsify_av.make(scenario, own_driver=Unready, **CHOICE)
        env.reset(seed=1)
        env.step(np.zeros(2, np.float32))
    with pytest.raises(TypeError, match="give a class"):
        falsify_av.make(scenario, own_driver="behavior", **CHOICE)


@pytest.mark.parametrize(
    ("control", "error", "text"),
    [
        ({"throtle": 1.0}, ValueError, "no key `throtle`; did you mean `throttle`?"),
        ({"throttle": 0.3, "steering": 0.1}, ValueError, "no key `steering`; did you mean `steer`?"),
        ({"brake": 1.0, "horn": 1}, ValueError, "no key `horn`; there is throttle, brake, acceleration, steer, wheel_angle, mode"),
        ({"brake": 1.0, "mode": "cruize"}, ValueError, "there is no mode `cruize`; did you mean `cruise`?"),
        ({}, ValueError, "neither throttle, brake nor acceleration"),
        ({"steer": 0.1}, ValueError, "neither throttle, brake nor acceleration"),
        ({"brake": 1.0, "acceleration": 1.0}, ValueError, "both acceleration and pedals"),
        ({"acceleration": math.nan}, ValueError, "`acceleration` is nan, which is not finite"),
        ({"brake": "1.0"}, TypeError, "`brake` is '1.0', which is not a number"),
        ({"brake": [1.0]}, TypeError, "`brake` is of the type list, which is not a number"),
        ({"brake": 1.0, "mode": 3}, TypeError, "`mode` is 3, which is not a text"),
    ],
)
def test_wrong_answers_are_exceptions_that_name_the_key(scenario, control, error, text):
    class Mistaken:
        def drive(self, world):
            return control

    def standing(states):
        return np.zeros((len(states), 2))

    env = falsify_av.make(scenario, own_driver=Mistaken, **CHOICE)
    env.reset(seed=1)
    with pytest.raises(error) as raised:
        env.step(np.zeros(2, np.float32))
    assert str(raised.value).startswith("the driver gave a wrong answer: ") and text in str(raised.value)
    with pytest.raises(error):
        falsify_av.evaluate(standing, scenario, episodes=3, own_driver=Mistaken, **CHOICE)


def test_a_driver_that_cannot_be_greeted_is_an_exception(scenario):
    class Newer(Cruise):
        revision = 3

    env = falsify_av.make(scenario, own_driver=Newer, **CHOICE)
    env.reset(seed=1)
    with pytest.raises(ValueError, match="the driver greeted wrongly"):
        env.step(np.zeros(2, np.float32))

    class Idle:
        pass

    env = falsify_av.make(scenario, own_driver=Idle, **CHOICE)
    env.reset(seed=1)
    with pytest.raises(TypeError, match="the driver is Idle, which has no method `drive`"):
        env.step(np.zeros(2, np.float32))


def test_a_network_drives_as_in_the_language(tmp_path):
    pytest.importorskip("onnxruntime")
    model = REPOSITORY / "tests/reference/onnx/follow.onnx"
    text = Path(__file__).with_name("short.scn").read_text()
    text = text.replace("episode ten", f'driver net = onnx(model: "{model}")\nepisode ten', 1).replace("[behavior, blind]", "[net]", 1)
    (tmp_path / "net.scn").write_text(text)
    choice = {**CHOICE, "driver": "net"}
    ours = list(walk(falsify_av.make(tmp_path / "net.scn", **choice), 5))
    other = list(walk(falsify_av.make(tmp_path / "net.scn", own_driver=lambda: drivers.OnnxDriver(model), **choice), 5))
    assert [end["outcome"] for end in ours] == [end["outcome"] for end in other]
    for one, two in zip(ours, other):
        assert one["least_gap_m"] == pytest.approx(two["least_gap_m"], abs=0.05)


def test_a_network_gets_the_car_s_view():
    pytest.importorskip("onnxruntime")
    driver = drivers.OnnxDriver(REPOSITORY / "tests/reference/onnx/follow.onnx")
    world = {
        "ego": {"x": 10.0, "y": 5.0, "yaw": 0.5, "speed": 4.0},
        "speed_limit": 8.0,
        "light": {"colour": "red", "distance": 30.0},
        "actors": [{"x": 12.0, "y": 5.0, "yaw": 0.5, "vx": 1.0, "vy": 0.0, "length": 0.4, "width": 0.4}],
        "route": [[10.0, 5.0, 0.5], [12.0, 6.0, 0.5]],
    }
    assert np.allclose(driver._input("ego", [1, 4], world), [[4.0, 8.0, 3.0, 30.0]])
    actors = driver._input("actors", [1, 2, 8], world)
    sin, cos = np.sin(0.5), np.cos(0.5)
    assert np.allclose(actors, [[[1, 2 * cos, -2 * sin, 0, cos, -sin, 0.4, 0.4], [0] * 8]])
    route = driver._input("route", [1, 3, 3], world)
    assert np.allclose(route[0, 0], 0) and np.array_equal(route[0, 1], route[0, 2])
    assert set(driver.drive(world)) in ({"acceleration", "steer"}, {"throttle", "brake", "steer"})


def test_a_network_walks_as_a_program_as_it_is_evaluated(program, tmp_path):
    pytest.importorskip("onnxruntime")
    onnx = pytest.importorskip("onnx")
    parquet = pytest.importorskip("pyarrow.parquet")
    from onnx import TensorProto, helper

    # It gets 32-bit floats or fails: those that do not fit 32 bits would also give other digests.
    constants = [
        helper.make_tensor("weights", TensorProto.FLOAT, [4, 2], [0.7, 0.0, 0.01, 0.1, 0.3, 0.2, 0.0, 0.01]),
        helper.make_tensor("bias", TensorProto.FLOAT, [2], [0.1, 2.0]),
    ]
    graph = helper.make_graph(
        [helper.make_node("Gemm", ["states", "weights", "bias"], ["actions"])],
        "walker",
        [helper.make_tensor_value_info("states", TensorProto.FLOAT, ["worlds", 4])],
        [helper.make_tensor_value_info("actions", TensorProto.FLOAT, ["worlds", 2])],
        constants,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    onnx.save(model, tmp_path / "walker.onnx")
    (tmp_path / "network.py").write_text('import falsify_av\nfalsify_av.pedestrians.serve(falsify_av.onnx("walker.onnx"))\n')
    (tmp_path / "plain.py").write_text(
        "import falsify_av, numpy as np\n"
        "def choose(states):\n"
        "    assert states.dtype == np.float32, states.dtype\n"
        "    return states[:, :2] * np.float32(0.7) + np.array([0.1, 2.0], np.float32)\n"
    )
    (tmp_path / "served.py").write_text("import falsify_av, plain\nfalsify_av.pedestrians.serve(plain.choose)\n")
    command = f"{sys.executable} NAME.py"
    (tmp_path / "a.scn").write_text(
        'edition 1\nimport "std/paper.scn"\nimport "std/drivers.scn"\nimport "std/towns.scn"\n'
        f'pedestrian network = external(command: "{command.replace("NAME", "network")}", timeout: 60 s)\n'
        f'pedestrian plain = external(command: "{command.replace("NAME", "served")}", timeout: 60 s)\n'
        "episode brief { ticks: 100 }\n"
        "campaign a { vehicle: model3 body: suicidal spawn: ahead episode: brief\n"
        "evaluate { towns: [harbour] drivers: [behavior] pedestrians: [network, plain] episodes: 4 } }\n"
    )
    falsify_av.run(tmp_path / "a.scn", out=tmp_path / "out", seed=5, allow_external=True)
    table = parquet.read_table(tmp_path / "out/a/episodes.parquet").to_pylist()
    sys.path.insert(0, str(tmp_path))
    try:
        import plain
    finally:
        sys.path.remove(str(tmp_path))
    for name, choose in {"network": falsify_av.onnx(tmp_path / "walker.onnx"), "plain": plain.choose}.items():
        rows = falsify_av.evaluate(choose, tmp_path / "a.scn", episodes=4, seed=5, allow_external=True)
        assert [row["digest"] for row in rows] == [row["digest"] for row in table if row["pedestrian"] == name], name


def test_drivers_and_pedestrians_serve_as_programs(program, tmp_path):
    served = {
        "driver.py": "from falsify_av import drivers\nclass Stop:\n    def drive(self, world):\n        return {'brake': 1}\ndrivers.serve(Stop)\n",
        "walker.py": "import numpy as np\nfrom falsify_av import pedestrians\n"
        "pedestrians.serve(lambda states: np.stack([states[:, 0] * 0, states[:, 0] * 0 + 3.5], axis=1))\n",
    }
    for name, text in served.items():
        (tmp_path / name).write_text(text)
    python = sys.executable
    (tmp_path / "a.scn").write_text(
        'edition 1\nimport "std/paper.scn"\nimport "std/drivers.scn"\nimport "std/towns.scn"\n'
        f'driver mine = external(command: "{python} driver.py", timeout: 60 s)\n'
        f'pedestrian own = external(command: "{python} walker.py", timeout: 60 s)\n'
        "episode brief { ticks: 100 }\n"
        "campaign a { vehicle: model3 body: suicidal spawn: ahead episode: brief\n"
        "evaluate { towns: [harbour] drivers: [mine, behavior] pedestrians: [own, homing] episodes: 6 } }\n"
    )
    command = [program, "run", "--allow-external", "--out", tmp_path / "out", tmp_path / "a.scn"]
    ended = subprocess.run(command, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    pytest.importorskip("pyarrow")
    rows = falsify_av.program.reports(tmp_path / "out")["a"].table("episodes").to_pylist()
    digests = {who: [row["digest"] for row in rows if row["pedestrian"] == who] for who in ("own", "homing")}
    assert len(digests["own"]) == 12 and digests["own"] == digests["homing"], json.dumps(digests)
