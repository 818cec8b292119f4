"""FISS+ as a driver under test: a sampling-based planner in Frenet coordinates that its authors publish as `fiss-planner`.

It plans every second tick (10 Hz) and follows the plan in between, its path as well as its speed. A plan that fails means full braking. Other
road users are forecast at constant velocity and enlarged by 0.4 m. Their numbers, the lanes ahead and the speed limits ahead are those of
revision 2 of the protocol: it may use a second lane of its direction, and it slows down before a lower limit.

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
COMFORT, LATERAL = 2.0, 2.0  # m/s^2: before a lower limit, in bends
ROOM = 1.5  # m: beside the lane in junctions
MARGIN, APART = 0.4, 2.0  # m: around others, between two points of the route
AHEAD = 3.0, 0.6  # m and s: the place on its path that it steers to


class World:
    """The planner's memory of one world."""

    def __init__(self, vehicle):
        params = fiss_planner.VehicleParams()
        for key in ("length", "width", "wheelbase"):
            if hasattr(params, key):
                setattr(params, key, vehicle[key])
        params.max_steer = vehicle["greatest_wheel_angle"]
        self.planner = fiss_planner.make_planner(fiss_planner.make_config("fiss_plus"), params)
        self.acceleration, self.plan, self.age = 0.0, None, 0

    def replan(self, world, route):
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

    def accelerate(self, speed, tick):
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

    def target(self, ego, route):
        """The place that it steers to: on its path if that is long enough, or on the route."""
        reach = AHEAD[0] + AHEAD[1] * ego["speed"]
        path = route[:, :2] if self.plan is None else np.column_stack(self.plan[3:])
        for points in (path, route[:, :2]):
            far = np.flatnonzero(np.hypot(points[:, 0] - ego["x"], points[:, 1] - ego["y"]) >= reach)
            if len(far):
                return points[far[0]]
        return route[-1, :2]


def limit(world, route):
    """The greatest speed from which comfortable braking keeps every limit and takes every bend ahead."""
    turns = [math.remainder(after - before, math.tau) for before, after in zip(route[:-1, 2], route[1:, 2])]
    bends = [math.sqrt(LATERAL * APART / max(abs(turn), 1e-3)) for turn in turns] + [math.inf]
    allowed = (min(lane["speed_limit"], bend) for lane, bend in zip(world["lanes"], bends))
    return min(math.sqrt(speed**2 + 2 * COMFORT * APART * place) for place, speed in enumerate(allowed))


def obstacle(actor):
    """A forecast at constant velocity."""
    speed = math.hypot(actor["vx"], actor["vy"])
    heading = math.atan2(actor["vy"], actor["vx"]) if speed > 0.05 else actor["yaw"]
    size = actor["length"] + MARGIN, actor["width"] + MARGIN
    return fiss_planner.predict_constant_velocity(
        actor["id"] + 1, actor["x"], actor["y"], heading, speed, *size, HORIZON, STEP
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
    x, y = state.target(ego, route) - (ego["x"], ego["y"])  # pure pursuit
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
            hello, answer = message, {"protocol": "falsify-av/1", "name": "fiss_plus", "revision": 2}
        else:
            answer = {"actions": [drive(world, memory, hello) for world in message["worlds"]]}
        print(json.dumps(answer), flush=True)


main()
