"""The reactive planner of CommonRoad as a driver under test: a sampling-based planner in Frenet coordinates with kinematic checks.

It plans every sixth tick (3.3 Hz) and follows the speeds of the plan in between; it steers along the route. A plan that fails means hard braking.
Other road users are forecast at constant velocity and enlarged by 0.5 m on each side. Lanes and limits are those of revision 2 of the protocol.

Source: Würsching and Althoff, "Sampling-Based Optimal Trajectory Generation for Autonomous Vehicles Using Reachable Sets", IEEE ITSC 2021.
Install it with `pip install commonroad-reactive-planner==2025.1`.
"""

from __future__ import annotations

import logging
import math
import sys
from typing import Any

import numpy as np
from commonroad.scenario.lanelet import Lanelet, LaneletNetwork
from commonroad.scenario.scenario import Scenario, ScenarioID
from commonroad_clcs.config import CLCSParams
from commonroad_dc import pycrcc
from commonroad_rp.reactive_planner import ReactivePlanner
from commonroad_rp.state import ReactivePlannerState
from commonroad_rp.utility.config import ReactivePlannerConfiguration
from commonroad_rp.utility.utils_coordinate_system import CoordinateSystem

from ..drivers import serve
from .pursuit import APART, limit, only_answers, pursue

EVERY, STEP, STEPS = 6, 0.1, 30  # ticks, s, steps
BRAKE, FULL, PULL = -6.0, -8.0, 3.0  # m/s^2
MARGIN = 0.5  # m: around others
AHEAD = 2.0, 0.4  # m and s: the place on the route that it steers to
SLOWEST = 0.1  # m/s: the planner fails for a car at rest


def settings() -> Any:
    """The planner's settings."""
    made = ReactivePlannerConfiguration()
    made.planning.dt, made.planning.time_steps_computation = STEP, STEPS
    made.planning.planning_horizon = STEP * STEPS
    made.debug.multiproc, made.debug.logging_level = False, "CRITICAL"
    made.sampling.d_min, made.sampling.d_max, made.sampling.max_deceleration_ratio = -0.5, 0.5, 0.3
    return made


def longer(route: Any) -> Any:
    """The route as a line of points that reaches 24 m behind the car and 30 m beyond its end."""

    def beyond(pose: Any, distances: tuple[float, ...]) -> list[Any]:
        return [pose[:2] + distance * np.array([math.cos(pose[2]), math.sin(pose[2])]) for distance in distances]

    return np.vstack([beyond(route[0], (-24, -18, -12, -6)), route[:, :2], beyond(route[-1], (6, 12, 18, 24, 30))])


def road(line: Any, width: float) -> Any:
    """One lane along a line."""
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    aside = np.column_stack([-along[:, 1], along[:, 0]]) * width / 2
    made = Scenario(STEP, ScenarioID())
    made.add_objects(LaneletNetwork.create_from_lanelet_list([Lanelet(line + aside, line, line - aside, 1)]))
    return made


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

    def __init__(self) -> None:
        self.acceleration, self.wheel, self.age = 0.0, 0.0, 0
        self.plan: Any = None
        self.planner: Any = None

    def replan(self, world: dict[str, Any], route: Any, vehicle: dict[str, float]) -> None:
        """Plan from where the car is."""
        ego, line, made = world["ego"], longer(route), settings()
        made.scenario, made.planning_problem = road(line, world["lanes"][0]["width"]), None
        speed, back = max(ego["speed"], SLOWEST), vehicle["wheelbase"] / 2
        rear = np.array([ego["x"] - back * math.cos(ego["yaw"]), ego["y"] - back * math.sin(ego["yaw"])])
        state = ReactivePlannerState(
            # A plan that starts from the full brake of a car at rest would lead backwards, and none would ever be found again.
            time_step=0, position=rear, orientation=ego["yaw"], velocity=speed, acceleration=max(self.acceleration, -speed),
            yaw_rate=speed * math.tan(self.wheel) / vehicle["wheelbase"], steering_angle=self.wheel,
        )
        checker = forecasts(world["actors"])
        self.plan, self.age = None, 0
        try:
            self.planner = self.planner or ReactivePlanner(made)
            # Its own `set_reference_path` needs parameters that it does not have.
            place = CoordinateSystem(line, clcs_params=CLCSParams())
            self.planner.set_collision_checker(collision_checker=checker)
            self.planner.reset(config=made, initial_state_cart=state, collision_checker=checker, coordinate_system=place)
            self.planner.set_desired_velocity(desired_velocity=limit(world, route), current_speed=speed)
            found = self.planner.plan()
        except Exception as error:  # It raises many kinds; without a plan the car brakes.
            print(f"no plan: {error!r}", file=sys.stderr)
            return
        if found is not None:
            self.plan = np.array([(each.velocity, each.acceleration) for each in found[0].state_list])

    def accelerate(self, speed: float, tick: float) -> float:
        """The acceleration that follows the plan (m/s^2)."""
        if self.plan is None:
            wanted = BRAKE
        else:
            self.age += 1
            planned, change = self.plan[min(len(self.plan) - 1, int(self.age * tick / STEP))]
            wanted = float(change + 2.0 * (planned - speed))
        self.acceleration = max(FULL, min(PULL, wanted))
        return self.acceleration


class Driver:
    """The planner of one world, which follows its speeds and steers along the route."""

    revision = 2

    def reset(self, hello: dict[str, Any], _seed: int) -> None:
        """Forget the last episode."""
        self.hello, self.state = hello, World()

    def drive(self, world: dict[str, Any]) -> dict[str, float]:
        """The answer to a tick."""
        ego, route, vehicle = world["ego"], np.array(world["route"]), self.hello["vehicle"]
        if len(route) < 6:
            return {"acceleration": -PULL, "steer": 0.0}
        if world["tick"] % EVERY == 0:
            self.state.replan(world, route, vehicle)
        acceleration = self.state.accelerate(ego["speed"], self.hello["tick_s"])
        place = min(math.ceil((AHEAD[0] + AHEAD[1] * ego["speed"]) / APART), len(route) - 1)
        x, y = route[place, 0] - ego["x"], route[place, 1] - ego["y"]
        steer = pursue(x, y, ego["yaw"], vehicle)
        self.state.wheel = steer * vehicle["greatest_wheel_angle"]
        return {"acceleration": acceleration, "steer": steer}


def main(_words: list[str]) -> None:
    """Serve the planner."""
    logging.disable(logging.CRITICAL)
    with only_answers():
        serve(Driver)
