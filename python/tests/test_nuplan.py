"""The adapter to planners of nuPlan, with a stand-in for nuPlan's devkit, and with the devkit where FALSIFY_PDM names a folder with its clone."""

from __future__ import annotations

import csv
import json
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from falsify_av.stacks import nuplan, nuplan_map

FOLDER = Path(__file__).with_name("stacks")
sys.path.insert(0, str(FOLDER))
import nuplan_stand_in as names  # noqa: E402

CLONE = os.path.join(os.environ.get("FALSIFY_PDM", ""), "nuplan-devkit")
VEHICLE = {"length": 4.79, "width": 2.16, "wheelbase": 3.0, "greatest_wheel_angle": 0.86}
LANE = {"width": 3.5, "left": 0, "right": 0, "junction": False, "speed_limit": 8.33}
PERSON = {"id": 0, "kind": "pedestrian", "x": 60.0, "y": 0.0, "yaw": 1.57, "vx": 0.0, "vy": 1.0, "length": 0.4, "width": 0.4}


@pytest.fixture(scope="session", params=["stand-in", "devkit"])
def place(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a planner, and where nuPlan is found from there."""
    folder = tmp_path_factory.mktemp("planner")
    shutil.copy(FOLDER / "nuplan_planner.py", folder)
    if request.param == "stand-in":
        names.install(folder, nuplan.NAMES)
    elif not os.path.isdir(CLONE):
        pytest.skip("FALSIFY_PDM names no folder with a clone of nuplan-devkit")
    else:
        (folder / "nuplan").symlink_to(os.path.join(CLONE, "nuplan"))
    return folder


def command(*words: str) -> list[str]:
    return [sys.executable, "-m", "falsify_av.stacks", "nuplan", *words]


class Car:
    """A planner that drives a car along a straight road, as a program."""

    def __init__(self, place: Path, *words: str, **hello: Any) -> None:
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        self.process = subprocess.Popen(command(*words), cwd=place, text=True, **pipes)  # type: ignore[call-overload]
        self.x, self.speed, self.tick = 0.0, 6.0, 0
        self.greeting = self.ask({"type": "hello", "protocol": "falsify-av/1", "tick_s": 0.05, "town": "road", "vehicle": VEHICLE, **hello})

    def ask(self, message: dict[str, Any]) -> dict[str, Any]:
        self.process.stdin.write(json.dumps(message) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        return json.loads(line) if line else {}

    def drive(self, seconds: float, **world: Any) -> dict[str, Any]:
        """Drive for some time; the last answer."""
        for _ in range(round(seconds / 0.05)):
            route = [[self.x + 2.0 * point, 0.0, 0.0] for point in range(40)]
            light = world.get("light") and {"colour": world["light"][0], "distance": world["light"][1] - self.x}
            seen = {"actors": [], "route": route, "lanes": [LANE] * len(route), **world, "light": light}
            ego = {"x": self.x, "y": 0.0, "yaw": 0.0, "speed": self.speed}
            seed = {"seed": 7} if self.tick == 0 else {}
            said = self.ask({"type": "step", "worlds": [{"id": 0, "tick": self.tick, "ego": ego, **seed, **seen}]})
            if not said:
                return {}
            [answer] = said["actions"]
            self.speed = max(self.speed + 0.05 * answer["acceleration"], 0.0)
            self.x, self.tick = self.x + 0.05 * self.speed, self.tick + 1
        return dict(answer)


@pytest.fixture
def cars(place: Path) -> Iterator[Any]:
    """Makes cars, and ends their programs."""
    made: list[Car] = []

    def make(*words: str, **hello: Any) -> Car:
        made.append(Car(place, *words, **hello))
        return made[-1]

    yield make
    for car in made:
        car.process.communicate(timeout=30)


def test_a_planner_keeps_its_speed_stops_for_a_person_and_at_a_red_light(cars: Any) -> None:
    car = cars("nuplan_planner:Keeper")
    assert car.greeting == {"protocol": "falsify-av/1", "name": "falsify_av", "revision": 2}
    answer = car.drive(6.0)
    assert car.speed == pytest.approx(8.33, abs=0.4) and abs(answer["steer"]) < 0.01
    car.drive(12.0, actors=[{**PERSON, "x": car.x + 50.0}])
    assert car.speed < 0.2
    car.drive(4.0)
    assert car.speed > 5.0
    at = car.x + 40.0
    car.drive(8.0, light=("red", at))
    assert car.speed < 0.2 and at - 12.0 < car.x < at - 3.0
    car.drive(3.0, light=("green", at))
    assert car.speed > 3.0


def test_where_the_route_ends_the_car_stops(cars: Any) -> None:
    car = cars("nuplan_planner:Keeper")
    for route in ([], [[0.0, 0.0, 0.0]]):
        assert car.drive(0.1, route=route, lanes=[LANE] * len(route)) == {"id": 0, "acceleration": -3.0, "steer": 0.0}


def test_settings_and_parameters_are_the_arguments_of_the_constructor(cars: Any) -> None:
    car = cars("nuplan_planner:Keeper", "--set", "room=20", "braking=2.0", parameters={"room": 12.0})
    car.drive(15.0, actors=[PERSON])
    assert 60.0 - car.x == pytest.approx(12.0 - 1.5, abs=2.0), "its rear axle stops there"
    wrong = cars("nuplan_planner:Keeper", "--set", "rom=20")
    assert wrong.drive(0.05) == {}
    said = wrong.process.communicate()[1]
    assert said.startswith("nuplan_planner:Keeper could not be made: TypeError: ") and "'rom'" in said
    assert said.endswith("; give the arguments of its constructor with `--set key=value`\n")


def test_a_planner_that_fails_ends_with_its_traceback_and_a_sentence(cars: Any) -> None:
    car = cars("nuplan_planner:Keeper", "--set", "fails_within=3")
    car.drive(1.0)
    assert car.drive(0.1, actors=[PERSON]) == {}
    *lines, last = car.process.communicate()[1].splitlines()
    assert any("nuplan_planner.py" in line for line in lines)
    assert last.startswith("nuplan_planner:Keeper failed at tick 20: RuntimeError: a person is near; the lines above say where.")


@pytest.mark.parametrize(("words", "text"), [
    ("", "nuplan drives with a planner of yours: "),
    ("Keeper", "'Keeper' names no planner: give the module and the class, as my_planner:MyPlanner"),
    ("keeper:Keeper", "Python finds no module keeper: it is looked for in "),
    ("nuplan_planner:keeper", "the module nuplan_planner has no keeper; did you mean `Keeper`?"),
    ("nuplan_planner:math", "nuplan_planner:math is module; give a class, or a function that makes a planner"),
    ("wrong:Half", "wrong:Half is no planner of nuPlan, since it has no method compute_planner_trajectory; "),
    ("wrong:Oracle", "wrong:Oracle cannot drive here: it needs nuPlan's scenario, a recording, and there is none; "),
    ("needy:Any", "the module needy needs the Python package no_such_package, which is not installed; install it for "),
    ("nuplan_planner:Keeper --path nowhere", "--path nowhere: there is no such folder in "),
    ("nuplan_planner:Keeper --set room", "'room' is no argument of a constructor: give key=value, as horizon=8.0"),
])  # fmt: skip
def test_what_is_wrong_with_a_name_is_a_sentence(place: Path, words: str, text: str) -> None:
    (place / "needy.py").write_text("import no_such_package\n")
    half = "class Half:\n    def initialize(self, start): pass\n"
    (place / "wrong.py").write_text(f"{half}class Oracle(Half):\n    requires_scenario = True\n    def compute_planner_trajectory(self, given): pass\n")
    ended = subprocess.run(command(*words.split()), cwd=place, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    assert ended.returncode != 0 and text in ended.stderr and "Traceback" not in ended.stderr, ended.stderr


def test_without_the_devkit_it_is_said_how_to_get_it(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("class Mine:\n    def initialize(self, start): pass\n    def compute_planner_trajectory(self, given): pass\n")
    (tmp_path / "nuplan.py").write_text("")
    ended = subprocess.run(command("mine:Mine"), cwd=tmp_path, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    assert ended.returncode == 1 and ended.stderr.startswith("nuPlan's devkit needs the Python package nuplan.common, which is not installed; ")
    assert "clone motional/nuplan-devkit" in ended.stderr


class Recorder:
    """Keeps what it is given, and plans to stand."""

    def __init__(self) -> None:
        self.starts: list[Any] = []
        self.given: list[Any] = []

    def initialize(self, start: Any) -> None:
        self.starts.append(start)

    def compute_planner_trajectory(self, given: Any) -> Any:
        self.given.append(given)
        here = given.history.ego_states[-1]
        return names.InterpolatedTrajectory([here, SimpleNamespace(time_us=here.time_us + 1_000_000, center=here.center)])


def recorded(worlds: list[dict[str, Any]], names: Any = names) -> Recorder:
    """What a planner is given in these ticks."""
    recorder = Recorder()

    class Driver(nuplan.Driver):
        make = staticmethod(lambda: recorder)

    Driver.nuplan = names
    driver = Driver()
    driver.reset({"vehicle": VEHICLE, "tick_s": 0.05, "town": "village"}, 1)
    for world in worlds:
        driver.drive(world)
    return recorder


def world(tick: int, yaw: float = 0.0, **more: Any) -> dict[str, Any]:
    route = [[2.0 * point, 0.0, 0.0] for point in range(20)]
    lanes = [{**LANE, "junction": 10 <= point < 15} for point in range(20)]
    ego = {"x": 0.05 * 8.0 * tick, "y": 0.0, "yaw": yaw, "speed": 8.0}
    return {"tick": tick, "ego": ego, "light": None, "actors": [PERSON], "route": route, "lanes": lanes, **more}


def test_a_planner_gets_two_seconds_of_history_at_its_own_rate() -> None:
    found = recorded([world(tick, yaw=0.02 * tick) for tick in range(5)])
    assert [given.iteration.index for given in found.given] == [0, 1, 2], "it plans every second tick"
    history = found.given[0].history
    assert len(history.ego_states) == len(history.observations) == 22 and history.sample_interval == 0.1
    times = [state.time_us for state in history.ego_states]
    assert set(np.diff(times)) == {100_000} and found.given[1].history.ego_states[-1].time_us == times[-1] + 100_000
    assert history.ego_states[0].center.x == pytest.approx(-2.1 * 8.0), "before the first tick at constant velocity"
    [before], [now] = (each.tracked_objects.tracked_objects for each in (history.observations[0], history.observations[-1]))
    assert before.tracked_object_type is names.TrackedObjectType.PEDESTRIAN and (before.center.y, now.center.y) == pytest.approx((-2.1, 0.0))
    last = found.given[2].history.ego_states[-1]
    assert last.angular_velocity == pytest.approx(0.4) and last.tire_steering_angle == pytest.approx(math.atan(3.0 * 0.4 / 8.0))


def test_a_planner_gets_the_lane_along_the_route_and_the_light() -> None:
    found = recorded([world(0), world(2, light={"colour": "yellow", "distance": 15.0})])
    road, lit = (start.map_api for start in found.starts)
    layers = names.SemanticMapLayer
    assert found.starts[0].route_roadblock_ids == ["block1", "block2", "block3", "block4"] and road.map_name == "village"
    assert [lane.connects for lane in road.lanes] == [False, True, False, False], "before, in and behind the junction, and where no route is known"
    before, inside = road.lanes[:2]
    assert before.outgoing_edges == [inside] and inside.incoming_edges == [before] and inside.parent().id == "block2"
    assert before.baseline_path.length == pytest.approx(24.0 + 20.0) and before.speed_limit_mps == pytest.approx(8.33)
    assert (before.left_boundary.discrete_path[0].y, inside.right_boundary.discrete_path[0].y) == pytest.approx((1.75, -2.5))
    assert road.get_map_object("2", layers.LANE_CONNECTOR) is inside and road.get_map_object("2", layers.LANE) is None
    assert found.given[0].traffic_light_data == [] and found.starts[0].mission_goal.x == 38.0
    [light] = found.given[1].traffic_light_data
    assert light.status == names.TrafficLightStatusType.YELLOW and light.lane_connector_id == 2
    assert lit.lanes[1].baseline_path.discrete_path[0].x == pytest.approx(16.0) and lit.lanes[2].baseline_path.discrete_path[0].x == pytest.approx(30.0)


def test_a_light_beyond_the_known_route_is_there_too() -> None:
    [given] = recorded([world(0, light={"colour": "red", "distance": 50.0})]).given
    [light] = given.traffic_light_data
    assert light.lane_connector_id == 5


def test_what_the_map_does_not_have_is_named() -> None:
    [start] = recorded([world(0)]).starts
    assert start.map_api.get_all_map_objects is not None and not hasattr(start.map_api, "get_raster_map")
    for thing, name in ((start.map_api, "get_raster_map"), (start.map_api.lanes[0], "stop_lines"), (start.map_api.blocks[0], "intersection")):
        with pytest.raises(AttributeError, match=f"has no `{name}`: the simulator does not tell a driver that"):
            getattr(thing, name)


def test_a_map_answers_what_planners_ask_of_places() -> None:
    pytest.importorskip("shapely")
    [start] = recorded([world(0)]).starts
    road, layers = start.map_api, names.SemanticMapLayer
    here, beside, inside = names.Point2D(0.0, 1.0), names.Point2D(0.0, 3.0), names.Point2D(24.0, 0.0)
    assert [lane.id for lane in road.get_all_map_objects(here, layers.LANE)] == ["1"]
    assert road.get_one_map_object(inside, layers.ROADBLOCK_CONNECTOR).id == "block2" and road.get_one_map_object(beside, layers.LANE) is None
    assert road.get_distance_to_nearest_map_object(beside, layers.LANE) == ("1", pytest.approx(1.25))
    assert road.is_in_layer(here, layers.LANE) and not road.is_in_layer(here, layers.INTERSECTION)
    assert [len(each) for each in road.get_proximal_map_objects(here, 25.0, [layers.LANE, layers.LANE_CONNECTOR, layers.CROSSWALK]).values()] == [1, 1, 0]
    pose = road.lanes[0].baseline_path.get_nearest_pose_from_position(here)
    assert (pose.x, pose.y) == pytest.approx((0.0, 0.0)) and road.lanes[0].is_same_roadblock(road.lanes[0])


def test_nuplans_devkit_takes_the_map_for_one_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    if not os.path.isdir(CLONE):
        pytest.skip("FALSIFY_PDM names no folder with a clone of nuplan-devkit")
    monkeypatch.syspath_prepend(CLONE)
    found = recorded([world(0, light={"colour": "red", "distance": 15.0})], nuplan.Nuplan())
    [start], [given] = found.starts, found.given
    from nuplan.planning.training.preprocessing.feature_builders import vector_builder_utils as features

    here = given.history.ego_states[-1].center.point
    middle, _, _, lanes, blocks = features.get_neighbor_vector_map(start.map_api, here, 100.0)
    lights, routes = features.get_traffic_light_encoding(lanes, given.traffic_light_data), features.get_on_route_status(start.route_roadblock_ids, blocks)
    assert len(middle.to_vector()) == 24 + 19 + 59 and len(set(lights.traffic_lights)) == 2 and set(routes.on_route_status) == {(1, 0)}


def test_a_plan_is_sampled_ten_times_a_second() -> None:
    states = [SimpleNamespace(time_us=5_000_000 + 500_000 * step, center=names.Point2D(4.0 * step, 0.0)) for step in range(3)]
    plan = nuplan.sampled(names.InterpolatedTrajectory(states), 5_000_000)
    assert plan.shape == (10, 3) and plan[:, 2] == pytest.approx(8.0) and plan[5, 0] == pytest.approx(4.0)
    for wrong in (states[:1], states[1:], states[::-1], []):
        with pytest.raises(ValueError, match="it needs two or more, from now to 0.2 s or later"):
            nuplan.sampled(names.InterpolatedTrajectory(wrong), 5_000_000)
    states[1].center = names.Point2D(math.nan, 0.0)
    with pytest.raises(ValueError, match="not finite"):
        nuplan.sampled(names.InterpolatedTrajectory(states), 5_000_000)


def test_between_two_plans_the_last_one_is_held() -> None:
    plans = np.column_stack([np.arange(30.0), np.zeros(30), np.arange(30.0)])
    driver = nuplan.Driver()
    driver.nuplan = names
    driver.make = Recorder
    driver.reset({"vehicle": VEHICLE, "tick_s": 0.025}, 1)
    asked: list[int] = []
    driver.replan = lambda given, _: asked.append(given["tick"]) or plans  # type: ignore[func-returns-value, method-assign]
    speeds = [8.0 + 0.5 * driver.drive(world(tick))["acceleration"] for tick in range(6)]
    assert asked == [0, 4] and speeds == pytest.approx([5.0, 5.25, 5.5, 5.75, 5.0, 5.25])


def test_longer_lines_go_on_straight() -> None:
    line = nuplan_map.longer(np.array([[0.0, 0.0, 3.1], [0.0, 2.0, -3.1]]))
    assert len(line) == 24 + 2 + 59 and np.abs(np.diff(line[:, 2])).max() < 0.1


def test_a_planner_that_fails_costs_an_episode(place: Path, program: str) -> None:
    (place / "a.scn").write_text(
        'edition 1\nimport "std/pedestrians.scn"\nimport "std/drivers.scn"\nimport "std/towns.scn"\n'
        'driver mine = external(command: "python3 -m falsify_av.stacks nuplan nuplan_planner:Keeper --set fails_within=2", '
        "timeout: 60 s, start_timeout: 60 s, route_points: 40, worlds: 1)\n"
        "spawn ahead { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }\n"
        "episode brief { tick: 0.05 s hold: 10 ticks: 100 end_when: ahead < -6 m }\n"
        "campaign a { vehicle: model3 body: pursuer spawn: ahead episode: brief\n"
        "evaluate { towns: [harbour] drivers: [mine] pedestrians: [natural] episodes: 6 } }\n"
    )
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    words = [str(Path(program).resolve()), "run", "--allow-external", "--fresh", "--replace", "--progress", "none", "--out", "out", "a.scn"]
    ended = subprocess.run(words, cwd=place, env={**os.environ, "PATH": path}, capture_output=True, text=True)
    assert ended.returncode == 5, ended.stderr
    table = next((place / "out").glob("a*/episodes.csv"))
    rows = list(csv.DictReader(table.read_text().splitlines()))
    errors = [row["error"] for row in rows if row["outcome"] == "error"]
    assert len(rows) == 6 and 0 < len(errors) < 6 and not any("restarted" in error for error in errors), errors
    assert "nuplan_planner:Keeper failed at tick" in ended.stderr
