"""Any planner of nuPlan as a driver under test: a class with the methods of nuPlan's ``AbstractPlanner``, named by its module.

``python3 -m falsify_av.stacks nuplan my_planner:MyPlanner --set horizon=8.0`` makes one for each episode, with the values of ``--set`` and the parameters of
the scenario as the arguments of its constructor. It plans at 10 Hz, and the car follows the last plan between two: it reaches the speed that the plan has
half a second later, and steers to a point of the plan.

A planner gets what nuPlan would give it, as far as a driver is told that: its own state and the road users in sight, now and in the two seconds before,
the light ahead, and a map with the lane along the route. The map is made again for each plan, since the route goes on as the car does, and ``initialize`` is
called with it each time. ``docs/src/how-to/stacks/nuplan.md`` says what is not there.
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import json
import math
import os
import sys
import traceback
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ..drivers import serve
from ..suggestion import suggested
from .batch import AHEAD, Array
from .nuplan_map import BEHIND, Map, Part, longer
from .pursuit import END, limit, pursue

STEP = 0.1  # s: between two plans, and between two poses of a plan
PAST = 22  # states of the history, as in nuPlan's simulation: two seconds
BRAKE, PULL = -8.0, 3.0  # m/s^2
ROOM = 1.5  # m: beside the lane in junctions
SOON = 0.5  # s: within which the car reaches the plan's speed
SLOW = 0.5  # m/s: below it the wheel is taken for straight
SHORT = 4  # points: a shorter route is its end
LANE, JUNCTION, LIT, UNKNOWN = range(4)  # kinds of parts of the road; a lit one lies beyond a light
METHODS = ("initialize", "compute_planner_trajectory")
DEVKIT = "it is not on PyPI: clone motional/nuplan-devkit, and install the clone or name its folder with `--path DIR`"
#: The names of nuPlan that the adapter uses, by module.
NAMES = {
    "nuplan.common.actor_state.state_representation": "Point2D StateSE2 StateVector2D TimePoint",
    "nuplan.common.actor_state.ego_state": "EgoState",
    "nuplan.common.actor_state.vehicle_parameters": "VehicleParameters",
    "nuplan.common.actor_state.oriented_box": "OrientedBox",
    "nuplan.common.actor_state.agent": "Agent",
    "nuplan.common.actor_state.scene_object": "SceneObjectMetadata",
    "nuplan.common.actor_state.tracked_objects": "TrackedObjects",
    "nuplan.common.actor_state.tracked_objects_types": "TrackedObjectType",
    "nuplan.common.maps.maps_datatypes": "SemanticMapLayer TrafficLightStatusData TrafficLightStatusType",
    "nuplan.planning.simulation.history.simulation_history_buffer": "SimulationHistoryBuffer",
    "nuplan.planning.simulation.observation.observation_type": "DetectionsTracks",
    "nuplan.planning.simulation.planner.abstract_planner": "PlannerInitialization PlannerInput",
    "nuplan.planning.simulation.simulation_time_controller.simulation_iteration": "SimulationIteration",
}


class Nuplan:
    """The names of nuPlan that an adapter uses."""

    def __init__(self, names: dict[str, str] = NAMES, whose: str = "nuPlan's devkit") -> None:
        found: dict[str, Any] = {}
        for module, of_it in names.items():
            try:
                loaded = importlib.import_module(module)
            except ModuleNotFoundError as error:
                absent = error.name or module
                how = DEVKIT if absent.partition(".")[0] == "nuplan" else f"`pip install {absent}` installs it"
                raise SystemExit(f"{whose} needs the Python package {absent}, which is not installed; {how}") from error
            found.update({name: getattr(loaded, name) for name in of_it.split()})
        self.__dict__.update(found)


def named(name: str) -> Callable[..., Any]:
    """The class, or the function that makes a planner, with a name ``module:Class``.

    Raises:
        SystemExit: A sentence that says what is wrong and what to do.
    """
    module, colon, inside = name.partition(":")
    if not (module and colon and inside):
        raise SystemExit(f"{name!r} names no planner: give the module and the class, as my_planner:MyPlanner")
    try:
        loaded = importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name and not f"{module}.".startswith(f"{error.name}."):
            how = DEVKIT if error.name.partition(".")[0] == "nuplan" else f"install it for {sys.executable}"
            raise SystemExit(f"the module {module} needs the Python package {error.name}, which is not installed; {how}") from error
        where = f"it is looked for in {os.getcwd()}, where the scenario is, and among the installed packages"
        how = DEVKIT if error.name == "nuplan" else "name its folder with `--path DIR`"
        raise SystemExit(f"Python finds no module {error.name}: {where}; {how}") from error
    if not hasattr(loaded, inside):
        classes = [word for word, each in vars(loaded).items() if inspect.isclass(each) and each.__module__ == module]
        hint = suggested(inside, classes) if classes else "it has no class"
        raise SystemExit(f"the module {module} has no {inside}; {hint}")
    made: Callable[..., Any] = getattr(loaded, inside)
    if inspect.isclass(made):
        checked(name, made)
    elif not callable(made):
        raise SystemExit(f"{name} is {type(made).__name__}; give a class, or a function that makes a planner")
    return made


def checked(name: str, planner: Any) -> None:
    """See whether a class, or an object, is a planner that can drive here.

    Raises:
        SystemExit: A sentence that says why not.
    """
    missing = [each for each in METHODS if not callable(getattr(planner, each, None))]
    if missing:
        raise SystemExit(f"{name} is no planner of nuPlan, since it has no method {' and no method '.join(missing)}; derive it from nuPlan's AbstractPlanner")
    if getattr(planner, "requires_scenario", False):
        raise SystemExit(f"{name} cannot drive here: it needs nuPlan's scenario, a recording, and there is none; give a planner whose requires_scenario is false")


def value(text: str) -> Any:
    """What a text of ``--set`` says: JSON, or the text itself."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def setting(word: str) -> tuple[str, Any]:
    """A ``key=value`` of ``--set``."""
    key, equals, text = word.partition("=")
    if not (equals and key.isidentifier()):
        raise argparse.ArgumentTypeError(f"{word!r} is no argument of a constructor: give key=value, as horizon=8.0")
    return key, value(text)


def parts(route: Array, lanes: list[dict[str, Any]], speed: float, light: float | None) -> tuple[list[Part], int | None]:
    """The lane along the route in parts, and which of them lies beyond a light so far ahead (m), from 1.

    A part is a junction, or the lane between two. The way from a light to the end of the junction behind it is one, too. Behind the end of the known route
    the lane goes on straight, as a part by itself.
    """
    line, before, count = longer(route), round(BEHIND), len(route)
    point = np.clip(np.arange(len(line)) - before, 0, count - 1)
    kinds = np.where([lanes[each]["junction"] for each in point], JUNCTION, LANE)
    if light is not None:
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])
        first = min(int(np.searchsorted(along, light + BEHIND)), len(line) - 2)
        last = np.flatnonzero((kinds[first:-1] == JUNCTION) & (kinds[first + 1 :] == LANE))
        kinds[first : first + last[0] + 1 if len(last) else len(line)] = LIT
    kinds[before + count :] = np.where(kinds[before + count :] == LIT, LIT, UNKNOWN)
    cuts = [0, *(1 + np.flatnonzero(kinds[1:] != kinds[:-1])), len(line) - 1]
    pieces = [(one, two) for one, two in zip(cuts, cuts[1:]) if one < two]
    found = [part(line[one : two + 1], lanes[point[one]]["width"], speed, kinds[one]) for one, two in pieces]
    return found, next((number for number, (one, _) in enumerate(pieces, 1) if kinds[one] == LIT), None)


def part(line: Array, width: float, speed: float, kind: int) -> Part:
    """A part of a kind; junctions are wider, since lanes have no edges there."""
    connects = kind in (JUNCTION, LIT)
    return Part(line, width + (ROOM if connects else 0.0), speed, connects)


class Driver:
    """The planner of one world."""

    revision = 2
    nuplan: Any = None
    #: What makes a planner, and its name.
    make: Callable[..., Any]
    name = "the planner"

    def reset(self, hello: dict[str, Any], _seed: int) -> None:
        """Forget the last episode."""
        car = hello["vehicle"]
        half, axle = car["length"] / 2, car["wheelbase"] / 2
        self.hello, self.acceleration, self.plan, self.plans = hello, 0.0, np.zeros((0, 3)), 0
        self.every = max(1, round(STEP / hello["tick_s"]))
        self.apart = self.every * hello["tick_s"]
        self.parameters = self.nuplan.VehicleParameters(car["width"], half + axle, half - axle, axle, car["wheelbase"], "car", "car", 1.5)
        self.past: deque[tuple[Any, Any]] = deque(maxlen=PAST)
        self.yaw: float | None = None
        self.planner = self.made()

    def made(self) -> Any:
        """A planner for an episode."""
        try:
            planner = self.make(**self.hello.get("parameters", {}))
        except Exception as error:
            if error.__traceback__ and error.__traceback__.tb_next:  # It is not that the arguments are wrong.
                traceback.print_exc()
            said = f"{self.name} could not be made: {type(error).__name__}: {error}"
            raise SystemExit(f"{said}; give the arguments of its constructor with `--set key=value`") from error
        checked(self.name, planner)
        return planner

    def drive(self, world: dict[str, Any]) -> dict[str, float]:
        """The answer to a tick."""
        ego, route, age = world["ego"], np.array(world["route"]), world["tick"] % self.every
        if len(route) < SHORT:
            self.acceleration = END
            return {"acceleration": END, "steer": 0.0}
        if age == 0 or not len(self.plan):
            self.plan = self.replan(world, route)
        # The speed that the plan has soon: the first poses of a plan still hold what the car did before.
        soon = age * self.hello["tick_s"] + SOON
        wanted = np.interp(soon / STEP, np.arange(len(self.plan)), self.plan[:, 2])
        self.acceleration = float(np.clip((wanted - ego["speed"]) / SOON, BRAKE, PULL))
        x, y = self.target(ego, route) - (ego["x"], ego["y"])
        return {"acceleration": self.acceleration, "steer": pursue(float(x), float(y), ego["yaw"], self.hello["vehicle"])}

    def target(self, ego: dict[str, float], route: Array) -> Array:
        """The place that it steers to: on its plan if that is long enough, or on the route."""
        reach = AHEAD[0] + AHEAD[1] * ego["speed"]
        for points in (self.plan[:, :2], route[:, :2]):
            far = np.flatnonzero(np.hypot(points[:, 0] - ego["x"], points[:, 1] - ego["y"]) >= reach)
            if len(far):
                return np.asarray(points[far[0]])
        return np.asarray(route[-1, :2])

    def replan(self, world: dict[str, Any], route: Array) -> Array:
        """Plan from where the car is; returns x, y of the middle of the car (m) and its speed (m/s) every 0.1 s."""
        nuplan = self.nuplan
        road, lights = self.road(world, route)
        self.remember(world)
        states, seen = zip(*self.past)
        history = nuplan.SimulationHistoryBuffer.initialize_from_list(len(states), list(states), list(seen), self.apart)
        iteration = nuplan.SimulationIteration(states[-1].time_point, self.plans)
        start, given = nuplan.PlannerInitialization(road.route, nuplan.StateSE2(*route[-1]), road), nuplan.PlannerInput(iteration, history, lights)
        self.plans += 1
        try:
            self.planner.initialize(start)
            return sampled(self.planner.compute_planner_trajectory(given), states[-1].time_us)
        except Exception as error:
            traceback.print_exc()
            said = f"{self.name} failed at tick {world['tick']}: {type(error).__name__}: {error}"
            raise SystemExit(f"{said}; the lines above say where. The episode is an error, and the planner is started again") from error

    def road(self, world: dict[str, Any], route: Array) -> tuple[Map, list[Any]]:
        """The map of the lane along the route, and the light ahead as nuPlan has it."""
        nuplan, light = self.nuplan, world["light"]
        found, beyond = parts(route, world["lanes"], limit(world, route), light["distance"] if light else None)
        road = Map(nuplan, found, self.hello.get("town", ""))
        if beyond is None:
            return road, []
        return road, [nuplan.TrafficLightStatusData(getattr(nuplan.TrafficLightStatusType, light["colour"].upper()), beyond, self.time(world["tick"]))]

    def remember(self, world: dict[str, Any]) -> None:
        """Add this tick to the history. Before the first one everybody has moved at constant velocity."""
        steps = range(PAST - 1, -1, -1) if not self.past else [0]
        rate, wheel = self.turning(world)
        for back in steps:
            ago = self.apart * back
            time = self.time(world["tick"]) - round(1e6 * ago)
            tracks = self.nuplan.TrackedObjects([self.tracked(actor, time, ago) for actor in world["actors"]])
            state = self.state(world["ego"], time, ago, rate, wheel)
            self.past.append((state, self.nuplan.DetectionsTracks(tracks)))

    def time(self, tick: int) -> int:
        """nuPlan's time of a tick (µs); its times are not negative, so the first tick is after the history."""
        return int(round(1e6 * (PAST * self.apart + self.hello["tick_s"] * tick)))

    def turning(self, world: dict[str, Any]) -> tuple[float, float]:
        """How fast the car turns (rad/s), and the angle of the front wheels (rad) that makes it turn so: of the last two plans' poses."""
        ego, before = world["ego"], self.yaw
        self.yaw = ego["yaw"]
        if before is None or ego["speed"] < SLOW:
            return 0.0, 0.0
        rate = math.remainder(ego["yaw"] - before, math.tau) / self.apart
        return rate, math.atan(self.hello["vehicle"]["wheelbase"] * rate / ego["speed"])

    def state(self, ego: dict[str, float], time: int, ago: float, rate: float, wheel: float) -> Any:
        """nuPlan's state of the car, some seconds ago."""
        nuplan, back = self.nuplan, self.parameters.rear_axle_to_center + ego["speed"] * ago
        rear = nuplan.StateSE2(ego["x"] - back * math.cos(ego["yaw"]), ego["y"] - back * math.sin(ego["yaw"]), ego["yaw"])
        speed, change = (nuplan.StateVector2D(value, 0.0) for value in (ego["speed"], self.acceleration))
        return nuplan.EgoState.build_from_rear_axle(rear, speed, change, wheel, nuplan.TimePoint(time), self.parameters, angular_vel=rate)

    def tracked(self, actor: dict[str, Any], time: int, ago: float) -> Any:
        """nuPlan's agent of a road user, with its kind, some seconds ago."""
        nuplan, number = self.nuplan, actor["id"]
        kind = nuplan.TrackedObjectType.PEDESTRIAN if actor["kind"] == "pedestrian" else nuplan.TrackedObjectType.VEHICLE
        pose = nuplan.StateSE2(actor["x"] - actor["vx"] * ago, actor["y"] - actor["vy"] * ago, actor["yaw"])
        box = nuplan.OrientedBox(pose, actor["length"], actor["width"], 1.7)
        name = nuplan.SceneObjectMetadata(time, str(number), number, str(number))
        return nuplan.Agent(kind, box, nuplan.StateVector2D(actor["vx"], actor["vy"]), name)


def sampled(trajectory: Any, now: int) -> Array:
    """A trajectory of nuPlan from a time on (µs): x, y of the middle of the car (m) and its speed (m/s) every 0.1 s.

    Only its poses are planned: nuPlan's tracker takes the speeds from them, too.

    Raises:
        ValueError: It is too short, or a number of it is not finite.
    """
    states = trajectory.get_sampled_trajectory()
    times = np.array([each.time_us - now for each in states])
    places = np.array([(each.center.x, each.center.y) for each in states])
    step = round(1e6 * STEP)
    if len(states) < 2 or times[0] > step or times[-1] < 2 * step or (np.diff(times) <= 0).any():
        has = f"from {times[0] / 1e6:.2f} s to {times[-1] / 1e6:.2f} s after now" if len(states) else "at no time"
        raise ValueError(f"its trajectory has {len(states)} states {has}; it needs two or more, from now to 0.2 s or later, in the order of time")
    if not np.isfinite(places).all():
        raise ValueError("a place of its trajectory is not finite")
    asked = step * np.arange(times[-1] // step + 1)
    poses = np.column_stack([np.interp(asked, times, column) for column in places.T])
    return np.column_stack([poses[:-1], np.hypot(*np.diff(poses, axis=0).T) / STEP])


def options(words: list[str]) -> argparse.Namespace:
    """The planner and its settings."""
    if not words:
        look()
    usage = "python3 -m falsify_av.stacks nuplan MODULE:CLASS [--set KEY=VALUE ...] [--path DIR]"
    parser = argparse.ArgumentParser(prog="nuplan", usage=usage, description="Serve a planner of nuPlan.")
    parser.add_argument("planner", metavar="MODULE:CLASS", help="the class of the planner, or a function that makes one")
    parser.add_argument("--set", metavar="KEY=VALUE", nargs="+", action="extend", type=setting, default=[], help="arguments of its constructor, in JSON")
    parser.add_argument("--path", metavar="DIR", action="append", default=[], help="a folder with Python packages, as a clone of nuplan-devkit")
    return parser.parse_args(words)


def look() -> None:
    """End with a sentence: the adapter drives only with a planner."""
    raise SystemExit("nuplan drives with a planner of yours: try it with `falsify check -- python3 -m falsify_av.stacks nuplan my_planner:MyPlanner`")


def main(words: list[str]) -> None:
    """Serve the planner that is named."""
    chosen = options(words)
    for folder in chosen.path:
        if not os.path.isdir(folder):
            raise SystemExit(f"--path {folder}: there is no such folder in {os.getcwd()}")
        sys.path.insert(0, os.path.abspath(folder))
    make = named(chosen.planner)
    Driver.nuplan, Driver.name, Driver.make = Nuplan(), chosen.planner, staticmethod(partial(make, **dict(chosen.set)))
    serve(Driver)
