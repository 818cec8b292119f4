"""FISS+ on a straight road with a person: `python3 run_fiss.py FOLDER SPEED LIMIT [exact]`, with nothing but fiss-planner (`pip install fiss-planner==1.0.0`).

FOLDER has person.csv, where the person's middle is at each step of 0.05 s, and seen.csv, the place and the velocity that the sensors give the planner, in the steps in which they see the
person. SPEED and LIMIT are in m/s. The planner is the `LocalPlanner` of the package with its default settings, its MPC and its bicycle as the car. A forecast is at constant velocity, and
it plans every second step. With `exact` as a last word it sees the person as it is. Printed are the speed of the car, the gap from its front to the person, how far the person is
beside the middle of the lane, what the planner did, and the touch.
"""

import csv
import math
import sys
from pathlib import Path

import fiss_planner
import numpy as np

RADIUS = 0.188  # m: of the person
LENGTH, WIDTH, WHEELBASE, LANE = 4.79, 2.16, 3.0, 3.5  # m
START = 100.0 - LENGTH / 2  # m: the middle of the car
TICK, EVERY, STEP = 0.05, 2, 0.1  # s, steps, s


def pipeline(params: fiss_planner.VehicleParams) -> tuple[fiss_planner.LocalPlanner, float]:
    """The planner on one lane without neighbours, and how far it looks ahead (s)."""
    settings = fiss_planner.LocalPlannerConfig()
    settings.planner.type = fiss_planner.PlannerType.FISS_PLUS
    settings.stitching.latency = TICK
    settings.path.lane_width, settings.path.num_left_lanes, settings.path.num_right_lanes = LANE, 0, 0
    planner = fiss_planner.LocalPlanner(settings, params)
    xs = np.arange(0.0, 400.0, 2.0)
    planner.set_reference_path(xs, np.zeros_like(xs))
    return planner, settings.planner.sampling.max_t + 0.5


def read(file: Path) -> list[tuple[float, ...]]:
    with open(file, newline="", encoding="utf-8") as rows:
        return [tuple(map(float, row)) for row in list(csv.reader(rows))[1:]]


def main(folder: Path, speed: float, limit: float, exact: bool) -> None:
    steps = read(folder / "person.csv")
    seen = {} if exact else {round(time / TICK): [row] for time, *row in read(folder / "seen.csv")}
    params = fiss_planner.VehicleParams()
    params.length, params.width, params.wheelbase, params.rear_axle_to_center = LENGTH, WIDTH, WHEELBASE, WHEELBASE / 2
    planner, horizon = pipeline(params)
    controller = fiss_planner.make_controller("mpc", params)
    car = fiss_planner.KinematicBicycle(params, fiss_planner.EgoState(START, 0.0, 0.0, speed))
    plan, since, did = None, 0.0, ""
    print("  time   speed     gap  beside")
    for tick, (time, along, left) in enumerate(steps):
        ego = car.state
        aside, ahead = max(abs(left - ego.y) - WIDTH / 2, 0.0), max(abs(along - ego.x) - LENGTH / 2, 0.0)
        print(f"{time:6.2f} {ego.v:7.3f} {along - RADIUS - ego.x - LENGTH / 2:7.2f} {left:7.2f}  {did}")
        if math.hypot(aside, ahead) <= RADIUS:
            print(f"touch after {time:.2f} s: the car drives {ego.v:.2f} m/s")
            return
        if tick % EVERY == 0:
            before = steps[max(tick - 1, 0)]
            known = [(along, left, (along - before[1]) / TICK, (left - before[2]) / TICK)] if exact else seen.get(tick, [])
            persons = [
                fiss_planner.predict_constant_velocity(1, x, y, math.atan2(vy, vx), math.hypot(vx, vy), 2 * RADIUS, 2 * RADIUS, horizon, STEP)
                for x, y, vx, vy in known
            ]
            found = planner.step(time, ego, persons, limit)
            did = "emergency" if found.emergency else "last plan" if found.fallback else "looks less far" if found.degraded else "plan"
            if len(found.trajectory) >= 2:
                plan, since = found.trajectory, time
        command = controller.compute(ego, plan, time - since)
        car.step(command, TICK)
    print("no touch")


main(Path(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3]), sys.argv[4:] == ["exact"])
