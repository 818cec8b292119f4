"""FISS+ as a driver under test: a sampling-based planner in Frenet coordinates that its authors publish as `fiss-planner`.

It plans every second tick (10 Hz) and follows the plan in between. A plan that fails means full braking. Other road users are forecast at
constant velocity and enlarged by 0.4 m. The speed stays within the limit.

Source: Sun et al., "FISS: A Trajectory Planning Framework Using Fast Iterative Search and Sampling Strategy for Autonomous Driving", IEEE
RA-L 2022; "FISS+", IROS 2023. Install it with `pip install fiss-planner==1.0.0`.
"""

import json
import math
import sys

import fiss_planner
import numpy as np

EVERY, STEP, HORIZON = 2, 0.1, 6.0  # ticks, s, s
BRAKE, PULL = -8.0, 3.0  # m/s^2
MARGIN, LANE = 0.4, 3.5  # m


class World:
    """The planner's memory of one world."""

    def __init__(self, vehicle):
        params = fiss_planner.VehicleParams()
        for key in ("length", "width", "wheelbase"):
            if hasattr(params, key):
                setattr(params, key, vehicle[key])
        self.planner = fiss_planner.make_planner(fiss_planner.make_config("fiss_plus"), params)
        self.acceleration, self.plan, self.age = 0.0, None, 0

    def replan(self, world, route):
        ego, start = world["ego"], route[0]
        line = fiss_planner.ReferenceLine(np.ascontiguousarray(route[:, 0]), np.ascontiguousarray(route[:, 1]))
        corridor = fiss_planner.Corridor.parallel_lanes(0.0, line.length, LANE, 0, 0)
        obstacles = [obstacle(number + 1, actor) for number, actor in enumerate(world["actors"])]
        x, y, turn = ego["x"] - start[0], ego["y"] - start[1], ego["yaw"] - start[2]
        state = fiss_planner.FrenetState()
        state.s, state.s_dd = 0.1, self.acceleration
        state.s_d, state.d_d = ego["speed"] * math.cos(turn), ego["speed"] * math.sin(turn)
        state.d = math.cos(start[2]) * y - math.sin(start[2]) * x
        found = self.planner.plan(state, line, corridor, obstacles, target_speed=world["speed_limit"])
        self.plan, self.age = None, 0
        if found.success:
            path = found.trajectory
            self.plan = np.array(path.t), np.array(path.v), np.array(path.a)

    def accelerate(self, speed, tick):
        if self.plan is None:
            self.acceleration = BRAKE
        else:
            times, speeds, accelerations = self.plan
            self.age += 1
            now = self.age * tick
            wanted = np.interp(now, times[: len(speeds)], speeds)
            planned = np.interp(now, times[: len(accelerations)], accelerations)
            self.acceleration = float(0.75 * (wanted - speed) / max(4 * tick, STEP) + 0.5 * planned)
        return max(BRAKE, min(PULL, self.acceleration))


def obstacle(number, actor):
    """A forecast at constant velocity."""
    speed = math.hypot(actor["vx"], actor["vy"])
    heading = math.atan2(actor["vy"], actor["vx"]) if speed > 0.05 else actor["yaw"]
    size = actor["length"] + MARGIN, actor["width"] + MARGIN
    return fiss_planner.predict_constant_velocity(
        number, actor["x"], actor["y"], heading, speed, *size, HORIZON, STEP
    )


def drive(world, memory, hello):
    """The answer for one world."""
    if world["tick"] == 0 or world["id"] not in memory:
        memory[world["id"]] = World(hello["vehicle"])
    state, ego, route = memory[world["id"]], world["ego"], np.array(world["route"])
    if len(route) < 4:
        return {"id": world["id"], "acceleration": PULL * -1.0, "steer": 0.0}
    if world["tick"] % EVERY == 0:
        state.replan(world, route)
    acceleration = state.accelerate(ego["speed"], hello["tick_s"])
    # Pure pursuit of the fourth point of the route.
    x, y = route[min(4, len(route) - 1), :2] - (ego["x"], ego["y"])
    angle = math.remainder(math.atan2(y, x) - ego["yaw"], math.tau)
    vehicle = hello["vehicle"]
    wheel = math.atan2(2.0 * vehicle["wheelbase"] * math.sin(angle), math.hypot(x, y))
    steer = max(-1.0, min(1.0, wheel / vehicle["greatest_wheel_angle"]))
    return {"id": world["id"], "acceleration": acceleration, "steer": steer}


def main():
    memory, hello = {}, None
    for line in sys.stdin:
        message = json.loads(line)
        if message["type"] == "hello":
            hello, answer = message, {"protocol": "falsify-av/1", "name": "fiss_plus"}
        else:
            answer = {"actions": [drive(world, memory, hello) for world in message["worlds"]]}
        print(json.dumps(answer), flush=True)


main()
