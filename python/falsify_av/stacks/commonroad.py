"""The reactive planner of CommonRoad as a driver under test: a sampling-based planner in Frenet coordinates with kinematic checks.

It plans every sixth tick (3.3 Hz), as its authors do, and goes on from its last plan while the car follows it; the adapter follows the plan's speeds and its path. When it finds
none, the car keeps the last plan while that meets no one, and otherwise brakes hard. Its reference path is the route, smoothed as its authors smooth theirs: a plan must not turn
the wheel faster than 0.4 rad/s, and no path does that on a line whose bends begin at once. Other road users are forecast at constant velocity and enlarged by 0.3 m on each
side. Lanes and limits are those of revision 2 of the protocol.

Source: Würsching and Althoff, "Sampling-Based Optimal Trajectory Generation for Autonomous Vehicles Using Reachable Sets", IEEE ITSC 2021.
Install it with `pip install commonroad-reactive-planner==2025.1`.
"""

from __future__ import annotations

import logging
import math
import sys
import warnings
from typing import Any

import numpy as np
from commonroad.scenario.scenario import Scenario, ScenarioID
from commonroad_dc import pycrcc
from commonroad_rp.reactive_planner import ReactivePlanner
from commonroad_rp.state import ReactivePlannerState
from commonroad_rp.utility.config import ReactivePlannerConfiguration, VehicleConfiguration
from commonroad_rp.utility.utils_coordinate_system import create_coordinate_system

from ..drivers import serve
from .pursuit import APART, END, limit, pursue

EVERY, STEP, STEPS = 6, 0.1, 30  # ticks, s, steps
BRAKE, FULL, PULL = -6.0, -8.0, 3.0  # m/s^2
MARGIN = 0.3  # m: around others
AHEAD = 2.0, 0.4  # m and s: the place on the plan that it steers to
SLOWEST = 0.1  # m/s: the planner fails for a car at rest
SOON = 1.5  # s: half of a plan
BEHIND = 24.0  # m: of the way behind the car
ASTRAY = 0.5, 1.0  # m and m/s: a car that is farther from its plan starts a new one from where it is


def settings(vehicle: dict[str, float]) -> Any:
    """The planner's settings, for a car of this size."""
    made, axle = ReactivePlannerConfiguration(), vehicle["wheelbase"] / 2
    made.vehicle = VehicleConfiguration(length=vehicle["length"], width=vehicle["width"], wb_front_axle=axle, wb_rear_axle=axle)
    made.planning.dt, made.planning.time_steps_computation = STEP, STEPS
    made.planning.planning_horizon = STEP * STEPS
    made.debug.multiproc, made.debug.logging_level = False, "CRITICAL"
    made.sampling.d_min, made.sampling.d_max, made.sampling.max_deceleration_ratio = -0.5, 0.5, 0.3
    made.scenario, made.planning_problem = Scenario(STEP, ScenarioID()), None
    return made


def beyond(pose: Any, distances: Any) -> Any:
    """Points that lie this far (m) straight ahead of a pose."""
    return pose[:2] + np.outer(distances, [math.cos(pose[2]), math.sin(pose[2])])


def forecasts(actors: list[dict[str, Any]]) -> Any:
    """The others at constant velocity."""
    checker = pycrcc.CollisionChecker()
    for actor in actors:
        moves = math.hypot(actor["vx"], actor["vy"]) > 0.05
        heading = math.atan2(actor["vy"], actor["vx"]) if moves else actor["yaw"]
        forecast = pycrcc.TimeVariantCollisionObject(0)
        for step in range(STEPS + 1):
            x, y = actor["x"] + actor["vx"] * STEP * step, actor["y"] + actor["vy"] * STEP * step
            half = actor["length"] / 2 + MARGIN, actor["width"] / 2 + MARGIN
            forecast.append_obstacle(pycrcc.RectOBB(*half, heading, x, y))
        checker.add_collision_object(forecast)
    return checker


class World:
    """The planner's memory of one world."""

    def __init__(self, vehicle: dict[str, float]) -> None:
        self.vehicle, self.settings = vehicle, settings(vehicle)
        self.planner = ReactivePlanner(self.settings)
        self.acceleration, self.wheel, self.age = 0.0, 0.0, 0.0
        self.plan: list[Any] | None = None
        self.past: Any = None

    def line(self, route: Any) -> Any:
        """The way behind the car, the route, and 30 m straight beyond its end."""
        if self.past is None:
            self.past = beyond(route[0], np.arange(-BEHIND, 0.0, APART))
        line = np.vstack([self.past, route[:, :2], beyond(route[-1], np.arange(APART, 30.0, APART))])
        if math.dist(route[0, :2], self.past[-1]) >= 2 * APART:
            self.past = np.vstack([self.past[1:], beyond(route[0], [-APART])])
        return line

    def rear(self, ego: dict[str, float]) -> Any:
        """The middle of the rear axle."""
        back = self.vehicle["wheelbase"] / 2
        return np.array([ego["x"] - back * math.cos(ego["yaw"]), ego["y"] - back * math.sin(ego["yaw"])])

    def start(self, ego: dict[str, float]) -> Any:
        """Where a plan starts: where the last one is now, or where the car is if that is elsewhere."""
        speed, rear = ego["speed"], self.rear(ego)
        if self.plan is not None:
            planned = self.plan[round(self.age)]
            near = math.dist(planned.position, rear) < ASTRAY[0] and abs(planned.velocity - speed) < ASTRAY[1]
            if near and planned.velocity > SLOWEST:
                planned.time_step = 0
                return planned
        speed = max(speed, SLOWEST)
        return ReactivePlannerState(
            # A plan that starts from the full brake of a car at rest would lead backwards, and none would ever be found again.
            time_step=0, position=rear, orientation=ego["yaw"], velocity=speed, acceleration=max(self.acceleration, -speed),
            yaw_rate=speed * math.tan(self.wheel) / self.vehicle["wheelbase"], steering_angle=self.wheel,
        )

    def wanted(self, world: dict[str, Any], route: Any) -> float:
        """The speed of a plan (m/s): what the road allows now and where the car soon is, since a plan reaches its speed at its end."""
        soon = min(round(SOON * world["ego"]["speed"] / APART), len(route) - 1)
        return min(limit(world, route), limit({"lanes": world["lanes"][soon:]}, route[soon:]))

    def replan(self, world: dict[str, Any], route: Any) -> None:
        """Plan from where the car is."""
        state, line, planner = self.start(world["ego"]), self.line(route), self.planner
        checker, found = forecasts(world["actors"]), None
        try:
            # Its `reset` takes the form of the start from the speed of the last plan, and `plan` from that of this one.
            planner._low_vel_mode = bool(state.velocity < self.settings.planning.low_vel_mode_threshold)
            place = create_coordinate_system(line)
            planner.reset(config=self.settings, initial_state_cart=state, collision_checker=checker, coordinate_system=place)
            planner.set_desired_velocity(desired_velocity=self.wanted(world, route), current_speed=state.velocity)
            found = planner.plan()
        except Exception as error:  # It raises many kinds.
            print(f"no plan: {error!r}", file=sys.stderr)
        if found is not None:
            self.plan, self.age = found[0].state_list, 0.0
        elif self.plan is not None and not self.is_free(checker):
            self.plan = None

    def is_free(self, checker: Any) -> bool:
        """Whether the rest of the last plan is there and meets no one."""
        left = (self.plan or [])[round(self.age) :]
        half, ahead = (self.vehicle["length"] / 2, self.vehicle["width"] / 2), self.vehicle["wheelbase"] / 2
        for step, state in enumerate(left):
            (x, y), yaw = state.position, state.orientation
            body = pycrcc.RectOBB(*half, yaw, x + ahead * math.cos(yaw), y + ahead * math.sin(yaw))
            if checker.time_slice(step).collide(body):
                return False
        return len(left) * STEP >= SOON

    def accelerate(self, speed: float, tick: float) -> float:
        """The acceleration that follows the plan (m/s^2)."""
        if self.plan is None:
            wanted = BRAKE
        else:
            self.age = min(self.age + tick / STEP, len(self.plan) - 1.0)
            planned = self.plan[int(self.age)]
            wanted = float(planned.acceleration + 2.0 * (planned.velocity - speed))
        self.acceleration = max(FULL, min(PULL, wanted))
        return self.acceleration

    def steer(self, ego: dict[str, float], route: Any) -> float:
        """Steering from the rear axle to a place on the plan, or beyond its end on the route."""
        rear, reach = self.rear(ego), AHEAD[0] + AHEAD[1] * ego["speed"]
        planned = [] if self.plan is None else [state.position for state in self.plan[int(self.age) :]]
        places = [*planned, *route[:, :2]]
        x, y = next((place for place in places if math.dist(place, rear) >= reach), places[-1]) - rear
        steer = pursue(float(x), float(y), ego["yaw"], self.vehicle)
        self.wheel = steer * self.vehicle["greatest_wheel_angle"]
        return steer


class Driver:
    """The planner of one world, which follows its plans."""

    revision = 2

    def reset(self, hello: dict[str, Any], _seed: int) -> None:
        """Forget the last episode."""
        self.tick, self.state = hello["tick_s"], World(hello["vehicle"])

    def drive(self, world: dict[str, Any]) -> dict[str, float]:
        """The answer to a tick."""
        ego, route = world["ego"], np.array(world["route"])
        if len(route) < 6:
            return {"acceleration": END, "steer": 0.0}
        if world["tick"] % EVERY == 0:
            self.state.replan(world, route)
        return {"acceleration": self.state.accelerate(ego["speed"], self.tick), "steer": self.state.steer(ego, route)}


def main(_words: list[str]) -> None:
    """Serve the planner."""
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")
    serve(Driver)
