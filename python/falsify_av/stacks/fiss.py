"""FISS+ as a driver under test: a sampling-based planner in Frenet coordinates that its authors publish as `fiss-planner`.

It is the whole pipeline of its authors with their settings: `LocalPlanner` stitches plans, keeps the last plan or looks less far when none is found, and brakes only then; their
controller follows the plan, its path as well as its speed. It plans every second tick (10 Hz). Other road users have their size and are forecast at constant velocity. Their
numbers, the lanes ahead and the speed limits ahead are those of revision 2 of the protocol: it may use a second lane of its direction, and it slows down before a lower limit.

Source: Sun et al., "FISS: A Trajectory Planning Framework Using Fast Iterative Search and Sampling Strategy for Autonomous Driving", IEEE
RA-L 2022; "FISS+", IROS 2023. Install it with `pip install fiss-planner==1.0.0`.
"""

from __future__ import annotations

import math
from typing import Any

import fiss_planner
import numpy as np

from ..drivers import serve
from .pursuit import APART, END, limit

EVERY, STEP = 2, 0.1  # ticks, s
ROOM = 1.5  # m: beside the lane in junctions, where lanes have no edges and the rear of a long car cuts the corner
BEHIND = 6  # points of the route behind the car
BRAKE = -8.0  # m/s^2: the hardest braking that is passed on


class World:
    """The planner's memory of one world."""

    def __init__(self, vehicle: dict[str, float], tick: float) -> None:
        params = fiss_planner.VehicleParams()
        for key in ("length", "width", "wheelbase"):
            setattr(params, key, vehicle[key])
        params.rear_axle_to_center, params.max_steer = vehicle["wheelbase"] / 2, vehicle["greatest_wheel_angle"]
        self.params, self.tick, self.settings = params, tick, fiss_planner.LocalPlannerConfig()
        self.settings.planner.type = fiss_planner.PlannerType.FISS_PLUS
        self.settings.stitching.latency = tick
        self.planner = fiss_planner.LocalPlanner(self.settings, params)
        self.controller = fiss_planner.make_controller("mpc" if fiss_planner.has_optimizers() else "stanley", params)
        self.horizon = self.settings.planner.sampling.max_t + 0.5
        self.past: list[Any] = []
        self.plan: Any = None
        self.since, self.speed, self.yaw = 0.0, 0.0, 0.0

    def path(self, route: Any) -> Any:
        """The route with some points behind the car, since a plan starts at its middle."""
        if not self.past:
            x, y, yaw = route[0]
            self.past = [np.array([x - APART * back * math.cos(yaw), y - APART * back * math.sin(yaw)]) for back in range(BEHIND, 0, -1)]
        line = np.vstack([self.past, route[:, :2]])
        if np.hypot(*(route[0, :2] - self.past[-1])) >= 2 * APART:
            self.past = [*self.past[1:], route[0, :2] - APART * np.array([math.cos(route[0, 2]), math.sin(route[0, 2])])]
        return line

    def replan(self, world: dict[str, Any], route: Any, ego: Any, time: float) -> None:
        """Plan from where the car is."""
        lanes, way = world["lanes"], self.settings.path
        # A lane beside its own counts if it goes on as far as the route is known.
        left, right = (min(lane[side] for lane in lanes) for side in ("left", "right"))
        width = lanes[0]["width"] + (ROOM if any(lane["junction"] for lane in lanes) else 0.0)
        if (way.lane_width, way.num_left_lanes, way.num_right_lanes) != (width, left, right):
            way.lane_width, way.num_left_lanes, way.num_right_lanes = width, left, right
            self.planner.request_config(self.settings)
        line = self.path(route)
        self.planner.set_reference_path(line[:, 0], line[:, 1])
        found = self.planner.step(time, ego, [obstacle(actor, self.horizon) for actor in world["actors"]], limit(world, route))
        if len(found.trajectory) >= 2:
            self.plan, self.since = found.trajectory, time

    def state(self, ego: dict[str, float]) -> Any:
        """The car as the planner knows it: its middle, with the acceleration and the curvature of the last tick."""
        change = (ego["speed"] - self.speed) / self.tick
        turned = math.remainder(ego["yaw"] - self.yaw, math.tau) / self.tick
        self.speed, self.yaw = ego["speed"], ego["yaw"]
        return fiss_planner.EgoState(ego["x"], ego["y"], ego["yaw"], ego["speed"], change, turned / ego["speed"] if ego["speed"] > 1.0 else 0.0)


def obstacle(actor: dict[str, Any], horizon: float) -> Any:
    """A forecast at constant velocity."""
    speed = math.hypot(actor["vx"], actor["vy"])
    heading = math.atan2(actor["vy"], actor["vx"]) if speed > 0.05 else actor["yaw"]
    return fiss_planner.predict_constant_velocity(
        actor["id"] + 1, actor["x"], actor["y"], heading, speed, actor["length"], actor["width"], horizon, STEP
    )


class Driver:
    """The planner and the controller of one world."""

    revision = 2

    def reset(self, hello: dict[str, Any], _seed: int) -> None:
        """Forget the last episode."""
        self.hello, self.state = hello, World(hello["vehicle"], hello["tick_s"])

    def drive(self, world: dict[str, Any]) -> dict[str, float]:
        """The answer to a tick."""
        ego, route, state = world["ego"], np.array(world["route"]), self.state
        if len(route) < 4:
            return {"acceleration": END, "steer": 0.0}
        if world["tick"] == 0:
            state.speed, state.yaw = ego["speed"], ego["yaw"]
        time = world["tick"] * state.tick
        known = state.state(ego)
        if world["tick"] % EVERY == 0:
            state.replan(world, route, known, time)
        if state.plan is None:
            return {"acceleration": BRAKE, "steer": 0.0}
        command = state.controller.compute(known, state.plan, time - state.since)
        wheel = command.steer / self.hello["vehicle"]["greatest_wheel_angle"]
        return {"acceleration": max(BRAKE, float(command.accel)), "steer": max(-1.0, min(1.0, float(wheel)))}


def main(_words: list[str]) -> None:
    """Serve the planner."""
    serve(Driver)
