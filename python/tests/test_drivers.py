"""Drivers under test that are Python objects."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import falsify_av
from falsify_av import drivers

REPOSITORY = Path(__file__).resolve().parents[2]


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
        f'policy mine = external(command: "{python} driver.py", timeout: 60 s)\n'
        f'controller own = external(command: "{python} walker.py", timeout: 60 s)\n'
        "episode brief { ticks: 100 }\n"
        "campaign a { vehicle: model3 adversary: suicidal spawn: ahead episode: brief\n"
        "evaluate { towns: [harbour] policies: [mine, behavior] pedestrians: [own, homing] episodes: 6 } }\n"
    )
    command = [program, "run", "--allow-external", "--out", tmp_path / "out", tmp_path / "a.scn"]
    ended = subprocess.run(command, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    pytest.importorskip("pyarrow")
    rows = falsify_av.program.reports(tmp_path / "out")["a"].table("episodes").to_pylist()
    digests = {who: [row["digest"] for row in rows if row["controller"] == who] for who in ("own", "homing")}
    assert len(digests["own"]) == 12 and digests["own"] == digests["homing"], json.dumps(digests)
