"""Adapters to drivers, and a pedestrian, of others. What a package is needed for is skipped, with its name, where it is not installed."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from falsify_av.stacks import STACKS
from falsify_av.stacks.__main__ import main
from falsify_av.stacks.batch import Frame, _Segments

VEHICLE = {"length": 4.79, "width": 2.16, "wheelbase": 3.0, "greatest_wheel_angle": 0.86}
STACKS_FOLDER = Path(__file__).with_name("stacks")
ACTORS, POINTS = 2, 20


def needs(stack: str) -> None:
    missing = STACKS[stack].missing()
    if missing is not None:
        pytest.skip(missing)


def frame(worlds: int, speed: float, people: dict[int, tuple[float, float]], start: bool = False, light: tuple[float, float] = (0.0, 0.0)) -> Frame:
    """Straight roads to the east with a person at x, y (m) in some worlds."""
    numbers = np.zeros((worlds, 14 + 8 * ACTORS + 3 * POINTS))
    numbers[:, 0], numbers[:, 2] = np.arange(worlds), 5.0 if start else -1.0
    numbers[:, 6], numbers[:, 7], numbers[:, 8:10], numbers[:, 13] = speed, 13.9, light, POINTS
    numbers[:, 14 + 8 * ACTORS :: 3] = 2.0 * np.arange(POINTS)
    for world, (x, y) in people.items():
        numbers[world, 12], numbers[world, 14:22] = 1, [1.0, x, y, 1.57, 0.0, 0.0, 0.5, 0.5]
    return Frame(numbers, ACTORS, POINTS)


def test_points_are_projected_onto_the_route_and_beyond_its_ends() -> None:
    corner = np.zeros((1, 4, 3))
    corner[0] = [[0, 0, 0], [2, 0, 0], [2, 2, math.pi / 2], [0, 0, 0]]
    segments = _Segments(corner, np.array([3]))
    points = np.array([[1.0, 0.5], [2.5, 1.0], [-3.0, -1.0], [1.0, 9.0]])
    along, left, direction, bend = segments.project(np.zeros(4, np.int64), points)
    assert along == pytest.approx([1.0, 3.0, -3.0, 11.0])
    assert left == pytest.approx([0.5, -0.5, -1.0, 1.0])
    assert direction == pytest.approx([0.0, math.pi / 2, 0.0, math.pi / 2])
    assert bend == pytest.approx([math.pi / 4] * 4), "a quarter of a circle in 2 m"


def test_a_frame_is_steered_along_its_route() -> None:
    seen = frame(2, 10.0, {1: (20.0, -1.0)})
    ahead, left, _ = seen.along(VEHICLE)
    assert (ahead.tolist(), left.tolist(), seen.world_of.tolist()) == ([20.0], [-1.0], [1])
    assert seen.steer(VEHICLE) == pytest.approx([0.0, 0.0])
    seen.ego = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.2]])
    assert (seen.steer(VEHICLE) < 0.0).all(), "it is left of its route, or turned to the left"


def test_the_front_of_a_car_swings_out_in_a_bend() -> None:
    seen = frame(2, 5.0, {0: (10.0, 0.0), 1: (10.0, 0.0)})
    radius, angles = 10.0, 0.2 * np.arange(POINTS)
    arc = np.column_stack([radius * np.sin(angles), radius * (1.0 - np.cos(angles)), angles])
    there = arc[5, :2] + np.array([[2.0, -2.0]]).T * [-math.sin(1.0), math.cos(1.0)]
    numbers = np.zeros((2, 14 + 8 * ACTORS + 3 * POINTS))
    numbers[:, 13], numbers[:, 14], numbers[:, 15:17], numbers[:, 14 + 8 * ACTORS :] = POINTS, 1.0, there, arc.ravel()
    _, left, _ = Frame(numbers, ACTORS, POINTS).along(VEHICLE)
    assert left == pytest.approx([2.0 - 0.11, -2.0 + 0.65], abs=0.05), "inside, and outside"
    assert seen.along(VEHICLE)[1] == pytest.approx([0.0, 0.0])


def test_a_bend_ahead_bounds_the_speed() -> None:
    seen, arc = frame(3, 5.0, {}), 0.2 * np.arange(POINTS)
    seen.route[1, :, 2] = arc
    seen.route[2, 5:, 2] = arc[: POINTS - 5]
    straight, bend, later = seen.bends(lateral=3.0, braking=2.0)
    assert straight > 50.0
    assert (bend, later) == pytest.approx((math.sqrt(30.0), math.sqrt(30.0 + 4.0 * 10.0))), "a radius of 10 m, now and in 10 m"
    seen.points[1] = 1
    assert seen.bends(3.0, 2.0)[1] > 50.0, "no bend is known"


def test_a_lower_limit_ahead_bounds_the_speed() -> None:
    numbers = np.zeros((3, 14 + 9 * ACTORS + 8 * POINTS))
    numbers[:, 7], numbers[:, 13], numbers[2, 13] = 13.9, POINTS, 5
    numbers[:, -5 * POINTS :].reshape(3, POINTS, 5)[:, :, 4] = 13.9
    numbers[1:, -5 * POINTS :].reshape(2, POINTS, 5)[:, 10:, 4] = 5.0
    seen = Frame(numbers, ACTORS, POINTS)
    assert seen.limits(2.0) == pytest.approx([13.9, math.sqrt(25.0 + 4.0 * 20.0), 13.9]), "20 m ahead; beyond the known route"
    assert frame(2, 5.0, {}).limits(2.0).tolist() == [13.9, 13.9], "no lanes are known in revision 1"


def test_a_stack_that_is_not_there_is_named_with_what_installs_it(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("falsify_av.stacks.find_spec", lambda _: None)
    assert main(["--missing", "sumo"]) == 3
    assert capsys.readouterr().err == "SUMO's car-following model needs the Python package libsumo: `pip install libsumo==1.28.0`\n"
    assert main(["--missing", "somo"]) == 2
    assert "'somo' is no driver of others" in capsys.readouterr().err


#: Stands in for the packages of others: each prints when it is imported, as `libsumo` does beside `pyarrow`.
LOUD = """
import importlib.abc, importlib.machinery, os, sys
from unittest.mock import MagicMock

class Loud(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def find_spec(self, name, path=None, target=None):
        theirs = name.partition(".")[0] in ("libsumo", "fiss_planner", "commonroad", "commonroad_dc", "commonroad_rp", "jupedsim", "shapely")
        return importlib.machinery.ModuleSpec(name, self, is_package=True) if theirs else None

    def exec_module(self, module):
        print("Warning!", module.__name__, flush=True)
        os.write(1, b"of C")
        module.__getattr__ = lambda name: MagicMock()

sys.meta_path.insert(0, Loud())
"""


@pytest.mark.parametrize("stack", ["sumo", "fiss", "commonroad", "jupedsim"])
def test_what_a_library_prints_is_no_answer(stack: str, tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(LOUD)
    protocol = "falsify-pedestrian/1" if stack == "jupedsim" else "falsify-av/1"
    hello = {"type": "hello", "protocol": protocol, "tick_s": 0.05, "vehicle": VEHICLE, "worlds": 1, "actors": ACTORS, "route_points": POINTS}
    paths = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", "falsify_av.stacks", stack]
    found = subprocess.run(command, input=json.dumps(hello) + "\n", env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr
    assert json.loads(found.stdout)["protocol"] == protocol
    assert "Warning!" in found.stderr and "of C" in found.stderr


def test_older_versions_of_pip_find_the_extra_of_every_stack() -> None:
    tomllib = pytest.importorskip("tomllib")
    project = tomllib.loads(Path(__file__).parents[1].joinpath("pyproject.toml").read_text(encoding="utf-8"))
    extras = project["project"]["optional-dependencies"]
    assert {name.replace("_", "-") for name in STACKS} <= set(extras)
    assert not [name for name in extras if "_" in name]


def test_sumo_brakes_for_a_person_in_its_way_and_for_no_other() -> None:
    needs("sumo")
    from falsify_av.stacks.sumo import Sumo

    sumo = Sumo({"vehicle": VEHICLE, "tick_s": 0.05, "worlds": 4}, "EIDM")
    people = {1: (15.0, 0.0), 2: (15.0, 1.7), 3: (-10.0, 0.0)}
    found = [sumo.decide(frame(4, 8.0, people, start=tick == 0))[0] for tick in range(4)]
    free, ahead, beside, behind = found[-1]
    assert ahead < -3.0 < 0.0 < free
    assert free == beside == behind, "one world does not change another"
    stops = [sumo.decide(frame(4, 8.0, {}, start=tick == 0, light=(3.0, 15.0)))[0] for tick in range(4)]
    assert (stops[-1] < -1.5).all(), "a red light"


def test_sumo_starts_without_a_word_about_pyarrow() -> None:
    needs("sumo")
    pytest.importorskip("pyarrow")
    hello = json.dumps({"protocol": "falsify-av/1", "vehicle": VEHICLE, "tick_s": 0.05, "worlds": 1, "actors": ACTORS, "route_points": POINTS})
    command = [sys.executable, "-m", "falsify_av.stacks", "sumo"]
    assert "pyarrow" not in subprocess.run(command, input=f"{hello}\n", capture_output=True, text=True, check=True).stderr


def test_openpilots_problem_is_solved_as_by_a_checkout() -> None:
    """The plans were recorded by `python3 -m falsify_av.stacks.openpilot_checkout DIR FILE` with openpilot 0.11.2 (7d325d66)."""
    needs("openpilot_like")
    from falsify_av.stacks.openpilot import Plan, solver
    from falsify_av.stacks.openpilot_checkout import differences

    recorded = json.loads((STACKS_FOLDER / "openpilot_situations.json").read_text(encoding="utf-8"))
    assert len(recorded) == 200
    assert differences(Plan(solver()), recorded)[-1] < 1e-6


def test_openpilot_stops_for_a_person_who_is_shown_as_a_lead() -> None:
    needs("openpilot_like")
    from falsify_av.stacks.openpilot import Openpilot, Plan, solver

    planner, speed, x = Openpilot({"vehicle": VEHICLE, "tick_s": 0.05}, lambda: Plan(solver())), 8.33, 0.0
    least = 0.0
    for tick in range(200):
        acceleration = float(planner.decide(frame(1, speed, {0: (25.0 - x, 0.0)}, start=tick == 0))[0][0])
        least, speed = min(least, acceleration), max(speed + 0.05 * acceleration, 0.0)
        x += 0.05 * speed
    assert speed == 0.0 and -3.51 < least < -1.0
    assert 25.0 - x > VEHICLE["length"] / 2


def test_openpilot_stops_softly_where_the_route_ends() -> None:
    needs("openpilot_like")
    from falsify_av.stacks.openpilot import Openpilot, Plan, solver

    planner, speed, least = Openpilot({"vehicle": VEHICLE, "tick_s": 0.05}, lambda: Plan(solver())), 8.33, 0.0
    for tick in range(300):
        seen = frame(1, speed, {}, start=tick == 0)
        seen.points[:], seen.route[:] = 0, 0.0
        acceleration = float(planner.decide(seen)[0][0])
        least, speed = min(least, acceleration), max(speed + 0.05 * acceleration, 0.0)
    assert speed < 0.1 and least > -2.5


def test_openpilots_problem_is_compiled_before_the_greeting() -> None:
    from falsify_av.stacks.openpilot import Openpilot

    made: list[int] = []
    Openpilot({"vehicle": VEHICLE, "tick_s": 0.05}, lambda: made.append(0))
    assert len(made) == 1, "the first answer does not wait for a compiler"


def test_fiss_gains_speed_on_an_empty_road_and_stops_for_a_person() -> None:
    needs("fiss")
    from falsify_av.stacks.fiss import Driver

    lane = {"width": 3.5, "left": 0, "right": 0, "junction": False, "speed_limit": 8.33}
    person = {"id": 0, "kind": "pedestrian", "x": 60.0, "y": 0.0, "yaw": 1.57, "vx": 0.0, "vy": 0.0, "length": 0.4, "width": 0.4}

    def drive(actors: list[dict[str, Any]], seconds: float) -> tuple[float, float]:
        driver, x, speed = Driver(), 0.0, 4.0
        driver.reset({"vehicle": VEHICLE, "tick_s": 0.05}, 0)
        for tick in range(round(seconds / 0.05)):
            route = [[x + 2.0 * place, 0.0, 0.0] for place in range(40)]
            ego = {"x": x, "y": 0.0, "yaw": 0.0, "speed": speed}
            answer = driver.drive({"tick": tick, "ego": ego, "route": route, "lanes": [lane] * 40, "actors": actors})
            assert abs(answer["steer"]) < 0.02
            speed = max(speed + 0.05 * answer["acceleration"], 0.0)
            x += 0.05 * speed
        return x, speed

    assert 7.5 < drive([], 8.0)[1] < 8.6, "a car that follows half of a plan is at 5 m/s"
    x, speed = drive([person], 20.0)
    assert speed < 0.1 and 45.0 < x + VEHICLE["length"] / 2 < 59.5


@pytest.mark.filterwarnings("ignore")
def test_commonroad_drives_through_a_tight_turn_and_stops_for_a_person_behind_it() -> None:
    needs("commonroad")
    from falsify_av.stacks.commonroad import Driver

    lane = {"width": 3.5, "left": 0, "right": 0, "junction": False, "speed_limit": 8.33}
    # 20 m, a quarter of a circle of 6 m to the right, 60 m: on its line the wheel would have to turn at once.
    bend = np.concatenate([np.zeros(80), np.full(38, -1.0 / 6.0), np.zeros(240)])
    yaw = 0.25 * np.cumsum(bend)
    line = np.column_stack([0.25 * np.cumsum(np.cos(yaw)), 0.25 * np.cumsum(np.sin(yaw)), yaw])

    def drive(actors: list[dict[str, Any]]) -> tuple[Any, float, float]:
        driver, (x, y, yaw), speed, least, place = Driver(), line[0], 6.0, 6.0, 0
        driver.reset({"vehicle": VEHICLE, "tick_s": 0.05}, 0)
        for tick in range(300):
            place += int(np.argmin(np.hypot(*(line[place : place + 20, :2] - [x, y]).T)))
            assert math.dist(line[place, :2], (x, y)) < 1.1, "it is near its line"
            route, ego = line[place::8][:40].tolist(), {"x": x, "y": y, "yaw": yaw, "speed": speed}
            if len(route) < 15:
                break
            answer = driver.drive({"tick": tick, "ego": ego, "route": route, "lanes": [lane] * len(route), "actors": actors})
            speed = max(speed + 0.05 * answer["acceleration"], 0.0)
            least = min(least, speed)
            slip = math.atan(math.tan(answer["steer"] * VEHICLE["greatest_wheel_angle"]) / 2)
            x, y, yaw = x + 0.05 * speed * math.cos(yaw + slip), y + 0.05 * speed * math.sin(yaw + slip), yaw + 0.05 * speed * math.sin(slip) / 1.5
        return (x, y), least, speed

    place, _, speed = drive([])
    assert place[1] < -30.0 and speed > 5.0, "it comes through the turn"
    person = {"id": 0, "kind": "pedestrian", "x": float(line[200, 0]), "y": float(line[200, 1]), "yaw": 0.0, "vx": 0.0, "vy": 0.0, "length": 0.4, "width": 0.4}
    place, least, _ = drive([person])
    assert least < 0.2 and 0.2 < math.dist(place, line[200, :2]) - VEHICLE["length"] / 2 < 8.0


class Names:
    """The shapes of nuPlan's names that the map needs."""

    SemanticMapLayer = SimpleNamespace(LANE="lane", LANE_CONNECTOR="way", ROADBLOCK="roadblock", ROADBLOCK_CONNECTOR="connector", CARPARK_AREA="carpark", INTERSECTION="intersection")

    @staticmethod
    def StateSE2(x: float, y: float, heading: float) -> Any:
        return SimpleNamespace(x=x, y=y, heading=heading)


def test_pdms_map_answers_the_four_calls_of_the_planner() -> None:
    pytest.importorskip("shapely")
    from falsify_av.stacks.pdm import BEHIND, Map, longer

    layers, route = Names.SemanticMapLayer, np.column_stack([np.arange(0.0, 40.0, 2.0), np.zeros(20), np.zeros(20)])
    road = Map(Names, longer(route), 3.5, 8.33, None)
    here = SimpleNamespace(x=0.0, y=1.0)
    assert road.route == ["block1"] and road.get_map_object("block1", layers.ROADBLOCK).interior_edges[0].speed_limit_mps == 8.33
    assert road.get_map_object("block1", layers.ROADBLOCK_CONNECTOR) is None
    near = road.get_proximal_map_objects(here, 50.0, [layers.ROADBLOCK, layers.CARPARK_AREA])
    assert [len(near[layer]) for layer in (layers.ROADBLOCK, layers.CARPARK_AREA)] == [1, 0]
    assert road.is_in_layer(here, layers.ROADBLOCK) and not road.is_in_layer(here, layers.INTERSECTION)
    assert road.get_distance_to_nearest_map_object(SimpleNamespace(x=0.0, y=2.75), layers.ROADBLOCK) == ("block1", pytest.approx(1.0))
    closed = Map(Names, longer(route), 3.5, 8.33, 20.0)
    first, second = (each.interior_edges[0] for each in closed.blocks)
    assert first.outgoing_edges == [second] and second.incoming_edges == [first] and second.get_roadblock_id() == "block2"
    assert first.baseline_path.discrete_path[-1].x == pytest.approx(20.0, abs=2.0)
    assert first.baseline_path.length == pytest.approx(BEHIND + 20.0, abs=2.0)


def recorded_run() -> list[dict[str, Any]]:
    return json.loads((STACKS_FOLDER / "pdm_run.json").read_text(encoding="utf-8"))


def test_a_recorded_plan_of_pdm_is_followed() -> None:
    from falsify_av.stacks.pdm import Driver

    driver = Driver()
    driver.nuplan = SimpleNamespace(planner=lambda: None, VehicleParameters=lambda *_: None)
    driver.reset({"vehicle": VEHICLE, "tick_s": 0.05}, 1)
    for each in recorded_run():
        driver.replan = lambda *_, plan=each["plan"]: np.array(plan)  # type: ignore[method-assign]
        assert driver.drive(each["world"]) == pytest.approx(each["control"])


def test_pdm_plans_as_recorded() -> None:
    """The run was recorded with tuplan_garage b51d5d04 and nuplan-devkit e9241677."""
    needs("pdm_closed")
    if not os.environ.get("FALSIFY_PDM"):
        pytest.skip("FALSIFY_PDM does not name a folder with clones of tuplan_garage and nuplan-devkit")
    from falsify_av.stacks import pdm

    pdm.clones(os.environ["FALSIFY_PDM"])
    driver = pdm.Driver()
    driver.nuplan = pdm.Nuplan()
    driver.reset({"vehicle": VEHICLE, "tick_s": 0.05}, 1)
    for each in recorded_run():
        control = driver.drive(each["world"])
        assert np.allclose(driver.plan[: len(each["plan"])], each["plan"], atol=1e-6)
        assert control == pytest.approx(each["control"], abs=1e-6)


def test_jupedsims_pedestrian_crosses_and_walks_around_a_car() -> None:
    needs("jupedsim")
    from shapely.geometry import Point

    from falsify_av.stacks.jupedsim import Walk, across, hole

    me, ego = {"x": 30.0, "y": -5.0, "yaw": 0.0}, {"x": 0.0, "y": 0.0, "yaw": 0.0, "speed": 0.0}
    assert across(me, ego) == pytest.approx((30.0, 8.0))
    heading, speed = Walk(1, 0.05, 10).choose(me, ego, VEHICLE)
    assert heading == pytest.approx(math.pi / 2, abs=0.01) and 0.5 < speed < 2.2
    walk, standing = Walk(1, 0.05, 10), {"x": 29.0, "y": 0.0, "yaw": 0.0, "speed": 0.0}
    for _ in range(60):
        heading, speed = walk.choose(me, standing, VEHICLE)
        me = {"x": me["x"] + speed * 0.5 * math.cos(heading), "y": me["y"] + speed * 0.5 * math.sin(heading), "yaw": heading}
        assert not hole(standing, VEHICLE, 0.0).contains(Point(me["x"], me["y"]))
    assert me["y"] > 4.0, "it has walked around the standing car"
