"""The bridges to other simulators: what they say of themselves, and that they move cars and pedestrians as they are told."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from falsify_av.bridges import BRIDGES, chosen, state
from falsify_av.bridges.__main__ import main

TICK = 0.05
VEHICLE = {"length": 4.79, "width": 2.16, "wheelbase": 3.0, "full_brake": 7.0}
# A street of 400 m along x, with a lane of 3.5 m in each direction.
LANE = '<lane id="{0}" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'
MAP = (
    '<OpenDRIVE><header revMajor="1" revMinor="7"/><road name="" length="400" id="1" junction="-1">'
    '<type s="0" type="town"><speed max="50" unit="km/h"/></type>'
    '<planView><geometry s="0" x="100" y="-50" hdg="0" length="400"><line/></geometry></planView><lanes><laneSection s="0">'
    f'<left>{LANE.format(1)}</left><center><lane id="0" type="none"/></center><right>{LANE.format(-1)}</right>'
    "</laneSection></lanes></road></OpenDRIVE>"
)
START = {"x": 150.0, "y": -51.75, "yaw": 0.0, "speed": 8.0}


class Bridge:
    """A bridge as a child process."""

    #: Those of the running test.
    running: list[subprocess.Popen[str]] = []

    def __init__(self, *words: str) -> None:
        missing = BRIDGES[words[0]].missing()
        if missing is not None:
            pytest.skip(missing)
        command = [sys.executable, "-m", "falsify_av.bridges", *words]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.running.append(self.process)
        self.about = self.ask({"type": "hello", "protocol": "falsify-world/1"})
        self.loaded = self.ask({
            "type": "load", "town": "street", "map": MAP, "tick_s": TICK, "vehicle": VEHICLE,
            "pedestrians": [{"radius": 0.2, "height": 1.8}], "lanes": [[200.0, -51.75], [300.0, -48.25]],
        })  # fmt: skip

    def ask(self, message: dict[str, Any]) -> dict[str, Any]:
        """The answer to a message."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(json.dumps(message) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def episode(self, ticks: int, walker: Any, control: dict[str, float], driver: str | None = None) -> list[dict[str, Any]]:
        """The states of an episode; `walker` gives the place of the pedestrian at a tick."""

        def pedestrians(tick: int) -> list[dict[str, float]]:
            (x, y), (next_x, next_y) = walker(tick), walker(tick + 1)
            return [{"x": x, "y": y, "yaw": 0.0, "vx": (next_x - x) / TICK, "vy": (next_y - y) / TICK}]

        route = [[x, -51.75, 0.0] for x in range(150, 490)]
        begin = {"type": "begin", "seed": 7, "ego": START, "driver": driver, "speed_limit": 13.9, "route": route, "pedestrians": pedestrians(0)}
        states = [self.ask(begin)]
        states += [self.ask({"type": "step", "tick": tick, "control": control, "pedestrians": pedestrians(tick)}) for tick in range(1, ticks + 1)]
        for tick, state in enumerate(states):
            assert state["tick"] == tick
            assert math.dist(state["pedestrians"][0], walker(tick)) < 1e-3
        return states


@pytest.fixture(autouse=True)
def ended() -> Any:
    """Ends the bridges of a test."""
    yield
    for process in Bridge.running:
        process.communicate(timeout=30)
    Bridge.running.clear()


def crossing(at: float, first: float) -> Any:
    """A pedestrian that crosses the lane at 1.4 m/s."""
    return lambda tick: (at, first - 1.4 * TICK * tick)


@pytest.mark.parametrize("name", ["metadrive", "sumo"])
def test_a_bridge_says_what_it_needs_and_what_it_is(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--missing", name]) in (0, 3)
    assert main(["nobody"]) == 2
    assert f"names: {', '.join(BRIDGES)}" in capsys.readouterr().err
    bridge = Bridge(name)
    assert bridge.about["name"] == name and bridge.about["version"] and bridge.about["drivers"]
    places = bridge.loaded["lanes"]
    assert math.dist(places[0], (200.0, -51.75)) < 0.1 and math.dist(places[1], (300.0, -48.25)) < 0.1


@pytest.mark.parametrize(("words", "message"), [
    ("mended=no", "mended=no is not valid: give mended without a value, once"),
    ("substeps=0", "substeps=0 is not valid: give substeps=1..100, once"),
    ("substeps=x", "substeps=x is not valid: give substeps=1..100, once"),
    ("exact=no", "exact=no is not valid: give exact=WORD, one of speed, path, once"),
    ("mended mended", "mended is not valid"),
    ("mend", "metadrive has no option mend; it has mended, substeps, exact"),
])  # fmt: skip
def test_a_wrong_option_is_a_line_with_its_value_and_what_is_allowed(words: str, message: str) -> None:
    options: dict[str, Any] = {"mended": None, "substeps": range(1, 101), "exact": ("speed", "path")}
    assert chosen("metadrive", ["mended", "substeps=7"], **options) == {"mended": True, "substeps": 7}
    with pytest.raises(SystemExit, match=message):
        chosen("metadrive", words.split(), **options)


def test_metadrive_carries_out_what_our_drivers_command() -> None:
    bridge = Bridge("metadrive")
    still = lambda _: (300.0, -40.0)
    straight = bridge.episode(20, still, {"acceleration": -3.0, "wheel_angle": 0.0})
    speeds = [state["ego"]["speed"] for state in straight]
    assert speeds[0] == pytest.approx(8.0, abs=1e-3) and speeds[-1] == pytest.approx(5.0, abs=0.05)
    left = bridge.episode(20, still, {"acceleration": 0.0, "wheel_angle": 0.1})
    turned = 8.0 * math.tan(0.1) / VEHICLE["wheelbase"]
    assert left[-1]["ego"]["yaw"] == pytest.approx(turned, rel=0.15) and left[-1]["ego"]["y"] > -51.75
    assert bridge.episode(20, still, {"acceleration": -3.0, "wheel_angle": 0.0}) == straight, "episodes do not depend on earlier ones"


def test_a_car_that_rolls_back_has_a_negative_speed() -> None:
    assert [state(0.0, 0.0, 0.0, speed, [])["ego"]["speed"] for speed in (-1.0, -0.01, 2.0)] == [-1.0, 0.0, 2.0]
    bridge = Bridge("metadrive")
    ego, walker = {**START, "speed": -3.0}, [{"x": 300.0, "y": -40.0, "yaw": 0.0, "vx": 0.0, "vy": 0.0}]
    begun = bridge.ask({"type": "begin", "seed": 7, "ego": ego, "driver": None, "speed_limit": 13.9, "route": [], "pedestrians": walker})
    control = {"acceleration": 2.0, "wheel_angle": 0.0}
    after = [bridge.ask({"type": "step", "tick": tick, "control": control, "pedestrians": walker}) for tick in range(1, 21)][-1]
    assert begun["ego"]["speed"] == pytest.approx(-3.0, abs=1e-3) and after["ego"]["speed"] == pytest.approx(-1.0, abs=0.1)
    assert after["ego"]["x"] == pytest.approx(START["x"] - 2.0, abs=0.1)


def test_a_pedestrian_blinds_the_idm_of_metadrive_and_a_mended_one_does_not() -> None:
    control = {"acceleration": 0.0, "wheel_angle": 0.0}
    standing = lambda _: (205.0, -51.75)
    # 120 ticks end before the front of the car reaches the pedestrian.
    blind, mended = (Bridge(*words).episode(120, standing, control, "IDMPolicy")[-1]["ego"] for words in (("metadrive",), ("metadrive", "mended")))
    assert blind["speed"] > 8.3 and 199.0 < blind["x"] < 202.0
    assert mended["speed"] < 3.0 and mended["x"] < blind["x"] - 5.0
    assert Bridge("metadrive").episode(160, standing, control, "TrajectoryIDMPolicy")[-1]["ego"]["speed"] < 2.0


def test_the_expert_of_metadrive_drives_along_its_route() -> None:
    bridge, control = Bridge("metadrive"), {"acceleration": 0.0, "wheel_angle": 0.0}
    alone = bridge.episode(120, lambda _: (300.0, -40.0), control, "ExpertPolicy")
    assert alone[-1]["ego"]["x"] > 200.0 and all(abs(state["ego"]["y"] + 51.75) < 1.0 for state in alone)
    met = bridge.episode(120, lambda _: (205.0, -51.75), control, "ExpertPolicy")
    assert met[-1] != alone[-1], "it sees the pedestrian"
    assert bridge.episode(120, lambda _: (300.0, -40.0), control, "ExpertPolicy") == alone, "the seed is all that it draws from"


def test_a_car_of_metadrive_may_have_our_speed_and_path() -> None:
    control = {"acceleration": -2.0, "wheel_angle": 0.1}
    ends = {what: Bridge("metadrive", f"exact={what}").episode(20, lambda _: (300.0, -40.0), control)[-1]["ego"] for what in ("both", "speed", "path")}
    x, y, yaw, speed = START["x"], START["y"], START["yaw"], START["speed"]
    slip = math.atan(math.tan(0.1) / 2)
    for _ in range(20):
        x, y = x + speed * TICK * math.cos(yaw + slip), y + speed * TICK * math.sin(yaw + slip)
        yaw, speed = yaw + speed * TICK * math.sin(slip) / (VEHICLE["wheelbase"] / 2), speed - 2.0 * TICK
    assert ends["both"] == pytest.approx({"x": x, "y": y, "yaw": yaw, "speed": speed}, abs=1e-3)
    assert ends["speed"]["speed"] == pytest.approx(speed, abs=1e-3) and ends["path"]["yaw"] == pytest.approx(yaw, rel=0.05)
    assert ends["speed"]["yaw"] != pytest.approx(yaw, abs=1e-4) and ends["path"]["speed"] != pytest.approx(speed, abs=1e-4)


@pytest.mark.parametrize("model", ["EIDM", "IDM", "Krauss"])
def test_a_model_of_sumo_brakes_for_a_person_on_its_lane(model: str) -> None:
    bridge, control = Bridge("sumo"), {"acceleration": 0.0, "wheel_angle": 0.0}
    assert bridge.about["controls"] is False
    met = bridge.episode(160, lambda _: (205.0, -51.75), control, model)
    assert met[-1]["ego"]["speed"] < 2.0 and met[-1]["ego"]["x"] < 205.0
    assert bridge.episode(160, lambda _: (205.0, -51.75), control, model) == met, "the seed is all that it draws from"
    assert bridge.episode(120, crossing(300.0, -40.0), control, model)[-1]["ego"]["speed"] > 8.0


def test_the_bridges_that_ship_are_files_of_the_package() -> None:
    folder = Path(sys.modules["falsify_av.bridges"].__file__ or "").parent
    assert all((folder / f"{name}.py").exists() for name in BRIDGES)


#: Stands in for the module of a bridge: it prints when it is imported, and when it makes its world.
LOUD = """
import os, sys
from importlib.machinery import ModuleSpec

class Loud:
    about = {"name": "loud"}

    def find_spec(self, name, path=None, target=None):
        return ModuleSpec(name, self) if name == "falsify_av.bridges.esmini" else None

    def create_module(self, spec):
        return None

    def exec_module(self, module):
        os.write(1, b"of C")
        print("imported", flush=True)
        module.world = lambda words: print("made", flush=True) or self

sys.meta_path.insert(0, Loud())
"""


def test_what_a_simulator_prints_is_no_answer(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(LOUD)
    hello = json.dumps({"type": "hello", "protocol": "falsify-world/1"}) + "\n"
    paths = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", "falsify_av.bridges", "esmini"]
    found = subprocess.run(command, input=hello, env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True)
    assert json.loads(found.stdout) == {"protocol": "falsify-world/1", "name": "loud"}, found.stderr
    assert all(said in found.stderr for said in ("of C", "imported", "made"))
