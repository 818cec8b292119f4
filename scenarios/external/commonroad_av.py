"""The reactive planner of CommonRoad as a driver under test: a sampling-based planner in Frenet coordinates with kinematic checks.

It plans every sixth tick (3.3 Hz) and follows the speeds of the plan in between; it steers along the route. A plan that fails means hard braking.
Other road users are forecast at constant velocity and enlarged by 0.5 m on each side. Lanes and limits are those of revision 2 of the protocol.

Source: Würsching and Althoff, "Sampling-Based Optimal Trajectory Generation for Autonomous Vehicles Using Reachable Sets", IEEE ITSC 2021.
Install it with `pip install commonroad-reactive-planner==2025.1`.
"""

import json
import logging
import math
import sys

import numpy as np
from commonroad.scenario.lanelet import Lanelet, LaneletNetwork
from commonroad.scenario.scenario import Scenario, ScenarioID
from commonroad_clcs.config import CLCSParams
from commonroad_dc import pycrcc
from commonroad_rp.reactive_planner import ReactivePlanner
from commonroad_rp.state import ReactivePlannerState
from commonroad_rp.utility.config import ReactivePlannerConfiguration
from commonroad_rp.utility.utils_coordinate_system import CoordinateSystem

EVERY, STEP, STEPS = 6, 0.1, 30  # ticks, s, steps
BRAKE, FULL, PULL = -6.0, -8.0, 3.0  # m/s^2
MARGIN, APART, COMFORT, LATERAL = 0.5, 2.0, 2.0, 2.0  # m, m, m/s^2, m/s^2
SLOWEST = 0.1  # m/s: the planner fails for a car at rest


def settings():
    made = ReactivePlannerConfiguration()
    made.planning.dt, made.planning.time_steps_computation = STEP, STEPS
    made.planning.planning_horizon = STEP * STEPS
    made.debug.multiproc, made.debug.logging_level = False, "CRITICAL"
    made.sampling.d_min, made.sampling.d_max, made.sampling.max_deceleration_ratio = -0.5, 0.5, 0.3
    return made


def longer(route):
    """The route as a line of points that reaches 24 m behind the car and 30 m beyond its end."""
    def beyond(pose, distances):
        return [pose[:2] + distance * np.array([math.cos(pose[2]), math.sin(pose[2])]) for distance in distances]

    return np.vstack([beyond(route[0], (-24, -18, -12, -6)), route[:, :2], beyond(route[-1], (6, 12, 18, 24, 30))])


def road(line, width):
    """One lane along a line."""
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    aside = np.column_stack([-along[:, 1], along[:, 0]]) * width / 2
    made = Scenario(STEP, ScenarioID())
    made.add_objects(LaneletNetwork.create_from_lanelet_list([Lanelet(line + aside, line, line - aside, 1)]))
    return made


def forecasts(actors):
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


def limit(world, route):
    """The greatest speed from which comfortable braking keeps every limit and takes every bend ahead."""
    turns = [math.remainder(after - before, math.tau) for before, after in zip(route[:-1, 2], route[1:, 2])]
    bends = [math.sqrt(LATERAL * APART / max(abs(turn), 1e-3)) for turn in turns] + [math.inf]
    allowed = (min(lane["speed_limit"], bend) for lane, bend in zip(world["lanes"], bends))
    return min(math.sqrt(speed**2 + 2 * COMFORT * APART * place) for place, speed in enumerate(allowed))


class World:
    """The planner's memory of one world."""

    def __init__(self):
        self.acceleration, self.plan, self.age, self.planner = 0.0, None, 0, None

    def replan(self, world, route, vehicle):
        ego, line, made = world["ego"], longer(route), settings()
        made.scenario, made.planning_problem = road(line, world["lanes"][0]["width"]), None
        speed, back = max(ego["speed"], SLOWEST), vehicle["wheelbase"] / 2
        rear = np.array([ego["x"] - back * math.cos(ego["yaw"]), ego["y"] - back * math.sin(ego["yaw"])])
        state = ReactivePlannerState(
            time_step=0, position=rear, orientation=ego["yaw"], velocity=speed, acceleration=self.acceleration, yaw_rate=0.0, steering_angle=0.0
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

    def accelerate(self, speed, tick):
        if self.plan is None:
            wanted = BRAKE
        else:
            self.age += 1
            planned, change = self.plan[min(len(self.plan) - 1, int(self.age * tick / STEP))]
            wanted = float(change + 2.0 * (planned - speed))
        self.acceleration = max(FULL, min(PULL, wanted))
        return self.acceleration


def drive(world, memory, hello):
    """The answer for one world."""
    if world["tick"] == 0 or world["id"] not in memory:
        memory[world["id"]] = World()
    state, ego, route, vehicle = memory[world["id"]], world["ego"], np.array(world["route"]), hello["vehicle"]
    if len(route) < 6:
        return {"id": world["id"], "acceleration": -PULL, "steer": 0.0}
    if world["tick"] % EVERY == 0:
        state.replan(world, route, vehicle)
    acceleration = state.accelerate(ego["speed"], hello["tick_s"])
    x, y = route[4, 0] - ego["x"], route[4, 1] - ego["y"]  # pure pursuit
    angle = math.remainder(math.atan2(y, x) - ego["yaw"], math.tau)
    wheel = math.atan2(2.0 * vehicle["wheelbase"] * math.sin(angle), math.hypot(x, y))
    steer = max(-1.0, min(1.0, wheel / vehicle["greatest_wheel_angle"]))
    return {"id": world["id"], "acceleration": acceleration, "steer": steer}


def main():
    logging.disable(logging.CRITICAL)
    # The planner prints; only answers belong into the output.
    answers, sys.stdout = sys.stdout, sys.stderr
    memory, hello = {}, None
    for line in sys.stdin:
        message = json.loads(line)
        if message["type"] == "hello":
            hello, answer = message, {"protocol": "falsify-av/1", "name": "commonroad_rp", "revision": 2}
        else:
            answer = {"actions": [drive(world, memory, hello) for world in message["worlds"]]}
        print(json.dumps(answer), file=answers, flush=True)


main()
