"""PDM-Closed, the winner of nuPlan's planning challenge of 2023, as a driver under test.

It comes from clones of yours of ``tuplan_garage`` and ``nuplan-devkit``: neither is on PyPI. ``--clones DIR`` names the folder that holds both; without it
the environment variable ``FALSIFY_PDM`` does. The planner gets what nuPlan would give it: a map with the lane along the route (and a lane beyond a red light, which is closed), the
road users in sight with their kinds, and its own state. It plans at its own 10 Hz; the car follows the plan's speeds and path. Its map is made again for
each plan, so it searches its centre line again each time.

``docs/src/how-to/stacks/pdm_closed.md`` says how to install it, what it sees and what it was not made for.
"""

from __future__ import annotations

import importlib
import math
import os
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..drivers import serve
from .batch import AHEAD, Array
from .pursuit import limit, pursue

EVERY, STEP = 2, 0.1  # ticks, s: between two plans
BRAKE, PULL = -8.0, 3.0  # m/s^2
BEHIND, BEYOND = 24.0, 60.0  # m: so far the lane goes on straight, behind the car and beyond the route
ROOM = 1.5  # m: beside the lane in junctions
SOON = 0.5  # s: within which the car reaches the plan's speed
CLONES = {"tuplan_garage": "tuplan_garage/planning", "nuplan-devkit": "nuplan/planning"}
PLANNER = "tuplan_garage.planning.simulation.planner.pdm_planner"

# The settings of its authors (`pdm_closed_planner.yaml`): s and poses, shares of the limit, m/s, m, s, m/s^2, m.
INTERVAL, PLANNED, PROPOSED = 0.1, 80, 40
POLICIES = {
    "speed_limit_fraction": [0.2, 0.4, 0.6, 0.8, 1.0],
    "fallback_target_velocity": 15.0,
    "min_gap_to_lead_agent": 1.0,
    "headway_time": 1.5,
    "accel_max": 1.5,
    "decel_max": 3.0,
}
OFFSETS, RADIUS = [-1.0, 1.0], 50


def clones(folder: str | None) -> None:
    """Make both clones importable.

    Raises:
        SystemExit: A sentence that says what is missing.
    """
    if folder is None:
        raise SystemExit(
            "PDM-Closed comes from two clones, which are not on PyPI: clone autonomousvision/tuplan_garage and motional/nuplan-devkit into one folder "
            "and name it with `--clones DIR` or in FALSIFY_PDM"
        )
    for name, inside in CLONES.items():
        place = Path(folder) / name
        if not (place / inside).is_dir():
            raise SystemExit(f"there is no clone of {name} in {folder}: {place / inside} is not a folder")
        sys.path.insert(0, str(place))


class Nuplan:
    """The names of both clones that this adapter uses."""

    def __init__(self) -> None:
        found: dict[str, Any] = {}
        for module, names in {
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
            "nuplan.planning.simulation.trajectory.trajectory_sampling": "TrajectorySampling",
            f"{PLANNER}.pdm_closed_planner": "PDMClosedPlanner",
            f"{PLANNER}.proposal.batch_idm_policy": "BatchIDMPolicy",
        }.items():
            try:
                loaded = importlib.import_module(module)
            except ModuleNotFoundError as error:
                raise SystemExit(f"PDM-Closed's clones need the Python package {error.name}: `pip install {error.name}` installs it") from error
            found.update({name: getattr(loaded, name) for name in names.split()})
        self.__dict__.update(found)

    def planner(self) -> Any:
        """PDM-Closed with the settings of its authors."""
        made: Any = self
        sampling = [made.TrajectorySampling(num_poses=poses, interval_length=INTERVAL) for poses in (PLANNED, PROPOSED)]
        return made.PDMClosedPlanner(*sampling, made.BatchIDMPolicy(**POLICIES), OFFSETS, RADIUS)


class Map:
    """nuPlan's map of the lane along the route, by the four calls that the planner makes.

    The lane has two parts if a red light is ahead: the second begins at the light, and the planner takes it for closed.
    """

    def __init__(self, nuplan: Any, line: Array, width: float, speed: float, light: float | None) -> None:
        self.layers = nuplan.SemanticMapLayer
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])
        cut = len(line) if light is None else int(np.searchsorted(along, light + BEHIND))
        parts = [line[: cut + 1], line[cut:]] if 2 <= cut <= len(line) - 2 else [line]
        self.lanes = [lane(nuplan, str(number + 1), part, width, speed) for number, part in enumerate(parts)]
        self.blocks = [block(each) for each in self.lanes]
        for one, two in zip(self.blocks, self.blocks[1:]):
            one.outgoing_edges, two.incoming_edges = [two], [one]
            one.interior_edges[0].outgoing_edges, two.interior_edges[0].incoming_edges = two.interior_edges, one.interior_edges

    @property
    def route(self) -> list[str]:
        """The ids of the blocks along the route."""
        return [each.id for each in self.blocks]

    def _of(self, layer: Any) -> list[Any]:
        """The blocks of a layer: the part beyond a light is a connector."""
        return {self.layers.ROADBLOCK: self.blocks[:1], self.layers.ROADBLOCK_CONNECTOR: self.blocks[1:]}.get(layer, [])

    def get_map_object(self, number: str, layer: Any) -> Any:
        """A block by its id, or none."""
        return next((each for each in self._of(layer) if each.id == number), None)

    def get_proximal_map_objects(self, point: Any, radius: float, layers: list[Any]) -> dict[Any, list[Any]]:
        """The blocks near a point (m), by layer."""
        from shapely.geometry import Point

        near = Point(point.x, point.y).buffer(radius)
        return {layer: [each for each in self._of(layer) if each.polygon.intersects(near)] for layer in layers}

    def is_in_layer(self, point: Any, layer: Any) -> bool:
        """Whether a point is in a layer. The map has no intersections: a lane has no edges there, and the route is all that is known."""
        from shapely.geometry import Point

        return any(each.polygon.contains(Point(point.x, point.y)) for each in self._of(layer))

    def get_distance_to_nearest_map_object(self, point: Any, layer: Any) -> tuple[str | None, float]:
        """The nearest block of a layer and its distance (m)."""
        from shapely.geometry import Point

        here = Point(point.x, point.y)
        found = min(((each.polygon.distance(here), each.id) for each in self._of(layer)), default=(math.inf, None))
        return found[1], found[0]


def lane(nuplan: Any, number: str, line: Array, width: float, speed: float) -> Any:
    """A lane along a line of poses."""
    from shapely.geometry import Point, Polygon

    aside = np.column_stack([-np.sin(line[:, 2]), np.cos(line[:, 2])]) * width / 2
    polygon = Polygon(np.vstack([line[:, :2] + aside, (line[:, :2] - aside)[::-1]])).buffer(0)
    path = SimpleNamespace(discrete_path=[nuplan.StateSE2(*pose) for pose in line], length=float(np.hypot(*np.diff(line[:, :2], axis=0).T).sum()))
    return SimpleNamespace(
        id=number,
        polygon=polygon,
        baseline_path=path,
        speed_limit_mps=speed,
        incoming_edges=[],
        outgoing_edges=[],
        get_roadblock_id=lambda: f"block{number}",
        contains_point=lambda point: polygon.contains(Point(point.x, point.y)),
    )


def block(inside: Any) -> Any:
    """The block of one lane."""
    return SimpleNamespace(id=f"block{inside.id}", interior_edges=[inside], incoming_edges=[], outgoing_edges=[], polygon=inside.polygon)


def longer(route: Array) -> Array:
    """The route with poses a metre apart that goes on straight behind the car and beyond its end."""

    def beyond(pose: Array, distances: Array) -> Array:
        return np.column_stack([pose[0] + distances * math.cos(pose[2]), pose[1] + distances * math.sin(pose[2]), np.full(len(distances), pose[2])])

    line = np.vstack([beyond(route[0], np.arange(-BEHIND, 0.0, 1.0)), route, beyond(route[-1], np.arange(1.0, BEYOND, 1.0))])
    line[:, 2] = np.unwrap(line[:, 2])
    return line


class Driver:
    """The planner of one world."""

    revision = 2
    nuplan: Any = None

    def reset(self, hello: dict[str, Any], _seed: int) -> None:
        """Forget the last episode."""
        car = hello["vehicle"]
        half, axle = car["length"] / 2, car["wheelbase"] / 2
        self.hello, self.planner, self.acceleration, self.plan = hello, self.nuplan.planner(), 0.0, np.zeros((0, 3))
        self.parameters = self.nuplan.VehicleParameters(car["width"], half + axle, half - axle, axle, car["wheelbase"], "car", "car", 1.5)

    def drive(self, world: dict[str, Any]) -> dict[str, float]:
        """The answer to a tick."""
        ego, route, tick = world["ego"], np.array(world["route"]), world["tick"]
        if len(route) < 4:
            return {"acceleration": -PULL, "steer": 0.0}
        if tick % EVERY == 0:
            self.plan = self.replan(world, route)
        # The speed that the plan has soon: the first poses of a plan still hold what the car did before.
        soon = (tick % EVERY) * self.hello["tick_s"] + SOON
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
        nuplan, lanes, light = self.nuplan, world["lanes"], world["light"]
        width = lanes[0]["width"] + (ROOM if any(each["junction"] for each in lanes) else 0.0)
        red = light["distance"] if light and light["colour"] != "green" else None
        road = Map(nuplan, longer(route), width, limit(world, route), red)
        state = self.state(world)
        closed = nuplan.TrafficLightStatusData(nuplan.TrafficLightStatusType.RED, 2, state.time_us)
        seen = nuplan.DetectionsTracks(nuplan.TrackedObjects([self.tracked(actor, state.time_us) for actor in world["actors"]]))
        history = nuplan.SimulationHistoryBuffer.initialize_from_list(1, [state], [seen], STEP)
        iteration = nuplan.SimulationIteration(state.time_point, 0)
        self.planner.initialize(nuplan.PlannerInitialization(road.route, nuplan.StateSE2(*route[-1]), road))
        found = self.planner.compute_planner_trajectory(nuplan.PlannerInput(iteration, history, [closed] if len(road.lanes) > 1 else []))
        states = found.get_sampled_trajectory()
        # Only its poses are planned: nuPlan's tracker takes the speeds from them, too.
        places = np.array([(each.center.x, each.center.y) for each in states])
        speeds = np.hypot(*np.diff(places, axis=0).T) / STEP
        return np.column_stack([places[:-1], speeds])

    def state(self, world: dict[str, Any]) -> Any:
        """nuPlan's state of the car."""
        nuplan, ego, back = self.nuplan, world["ego"], self.parameters.rear_axle_to_center
        rear = nuplan.StateSE2(ego["x"] - back * math.cos(ego["yaw"]), ego["y"] - back * math.sin(ego["yaw"]), ego["yaw"])
        time = nuplan.TimePoint(round(1e6 * self.hello["tick_s"] * world["tick"]))
        speed, change = (nuplan.StateVector2D(value, 0.0) for value in (ego["speed"], self.acceleration))
        return nuplan.EgoState.build_from_rear_axle(rear, speed, change, 0.0, time, self.parameters)

    def tracked(self, actor: dict[str, Any], time: int) -> Any:
        """nuPlan's agent of a road user, with its kind."""
        nuplan, number = self.nuplan, actor["id"]
        kind = nuplan.TrackedObjectType.PEDESTRIAN if actor["kind"] == "pedestrian" else nuplan.TrackedObjectType.VEHICLE
        box = nuplan.OrientedBox(nuplan.StateSE2(actor["x"], actor["y"], actor["yaw"]), actor["length"], actor["width"], 1.7)
        name = nuplan.SceneObjectMetadata(time, str(number), number, str(number))
        return nuplan.Agent(kind, box, nuplan.StateVector2D(actor["vx"], actor["vy"]), name)


def look() -> None:
    """End with a sentence if the clones are not there."""
    clones(os.environ.get("FALSIFY_PDM") or None)


def main(words: list[str]) -> None:
    """Serve the planner; `--clones DIR` names the folder with both clones."""
    if words and (len(words) != 2 or words[0] != "--clones"):
        raise SystemExit(f"{' '.join(words)!r} is not an option of this driver; it has --clones DIR")
    clones(words[1] if words else os.environ.get("FALSIFY_PDM") or None)
    Driver.nuplan = Nuplan()
    serve(Driver)
