"""FISS+ as a driver under test: a sampling-based planner in Frenet coordinates that its authors publish as `fiss-planner`.

It plans every second tick (10 Hz) and follows the plan in between, its path as well as its speed. A plan that fails means full braking. Other
road users are forecast at constant velocity and enlarged by 0.4 m. Their numbers, the lanes ahead and the speed limits ahead are those of
revision 2 of the protocol: it may use a second lane of its direction, and it slows down before a lower limit.

Source: Sun et al., "FISS: A Trajectory Planning Framework Using Fast Iterative Search and Sampling Strategy for Autonomous Driving", IEEE
RA-L 2022; "FISS+", IROS 2023. Install it with `pip install fiss-planner==1.0.0`.
"""

from __future__ import annotations

import math
from typing import Any

import fiss_planner
import numpy as np

from ..drivers import serve
from .pursuit import limit, pursue

EVERY, STEP, HORIZON = 2, 0.1, 6.0  # ticks, s, s
BRAKE, PULL = -8.0, 3.0  # m/s^2
ROOM = 1.5  # m: beside the lane in junctions
MARGIN = 0.4  # m: around others
AHEAD = 3.0, 0.6  # m and s: the place on its path that it steers to


class World:
    """The planner's memory of one world."""

    def __init__(self, vehicle: dict[str, float]) -> None:
        params = fiss_planner.VehicleParams()
        for key in ("length", "width", "wheelbase"):
            if hasattr(params, key):
                setattr(params, key, vehicle[key])
        params.max_steer = vehicle["greatest_wheel_angle"]
        self.planner = fiss_planner.make_planner(fiss_planner.make_config("fiss_plus"), params)
        self.acceleration, self.age = 0.0, 0
        self.plan: list[Any] | None = None

    def replan(self, world: dict[str, Any], route: Any) -> None:
        """Plan from where the car is."""
        ego, here = world["ego"], world["lanes"][0]
        line = fiss_planner.ReferenceLine(np.ascontiguousarray(route[:, 0]), np.ascontiguousarray(route[:, 1]))
        # A lane beside its own counts if it goes on as far as the route is known.
        left, right = (min(lane[side] for lane in world["lanes"]) for side in ("left", "right"))
        # Lanes have no edges in junctions, and the rear of a long car cuts the corner there.
        width = here["width"] + (ROOM if any(lane["junction"] for lane in world["lanes"]) else 0.0)
        corridor = fiss_planner.Corridor.parallel_lanes(0.0, line.length, width, left, right)
        obstacles = [obstacle(actor) for actor in world["actors"]]
        # A plan that starts from the full brake of a car at rest would lead backwards, and none would ever be found again.
        acceleration = max(self.acceleration, -ego["speed"])
        state = line.to_frenet(fiss_planner.EgoState(ego["x"], ego["y"], ego["yaw"], ego["speed"], acceleration), 0.0)
        # The wheels follow the plan, so the path does not start with a sideways acceleration.
        state.s, state.d_dd = max(state.s, 0.1), 0.0
        found = self.planner.plan(state, line, corridor, obstacles, target_speed=limit(world, route))
        self.plan, self.age = None, 0
        if found.success:
            path = found.trajectory
            self.plan = [np.array(each) for each in (path.t, path.v, path.a, path.x, path.y)]

    def accelerate(self, speed: float, tick: float) -> float:
        """The acceleration that follows the plan (m/s^2)."""
        if self.plan is None:
            self.acceleration = BRAKE
        else:
            times, speeds, accelerations, _, _ = self.plan
            self.age += 1
            now = self.age * tick
            wanted = np.interp(now, times[: len(speeds)], speeds)
            planned = np.interp(now, times[: len(accelerations)], accelerations)
            self.acceleration = float(0.75 * (wanted - speed) / max(4 * tick, STEP) + 0.5 * planned)
        return max(BRAKE, min(PULL, self.acceleration))

    def target(self, ego: dict[str, float], route: Any) -> Any:
        """The place that it steers to: on its path if that is long enough, or on the route."""
        reach = AHEAD[0] + AHEAD[1] * ego["speed"]
        path = route[:, :2] if self.plan is None else np.column_stack(self.plan[3:])
        for points in (path, route[:, :2]):
            far = np.flatnonzero(np.hypot(points[:, 0] - ego["x"], points[:, 1] - ego["y"]) >= reach)
            if len(far):
                return points[far[0]]
        return route[-1, :2]


def obstacle(actor: dict[str, Any]) -> Any:
    """A forecast at constant velocity."""
    speed = math.hypot(actor["vx"], actor["vy"])
    heading = math.atan2(actor["vy"], actor["vx"]) if speed > 0.05 else actor["yaw"]
    size = actor["length"] + MARGIN, actor["width"] + MARGIN
    return fiss_planner.predict_constant_velocity(
        actor["id"] + 1, actor["x"], actor["y"], heading, speed, *size, HORIZON, STEP
    )


class Driver:
    """The planner of one world, with the route that it steers along."""

    revision = 2

    def reset(self, hello: dict[str, Any], _seed: int) -> None:
        """Forget the last episode."""
        self.hello, self.state = hello, World(hello["vehicle"])

    def drive(self, world: dict[str, Any]) -> dict[str, float]:
        """The answer to a tick."""
        ego, route, vehicle = world["ego"], np.array(world["route"]), self.hello["vehicle"]
        if len(route) < 4:
            return {"acceleration": -PULL, "steer": 0.0}
        if world["tick"] % EVERY == 0:
            self.state.replan(world, route)
        acceleration = self.state.accelerate(ego["speed"], self.hello["tick_s"])
        x, y = self.state.target(ego, route) - (ego["x"], ego["y"])
        return {"acceleration": acceleration, "steer": pursue(x, y, ego["yaw"], vehicle)}


def main(_words: list[str]) -> None:
    """Serve the planner."""
    serve(Driver)
