"""Ticks a CPU second of SUMO behind the protocol: `python python/benches/sumo.py WORLDS [MODEL]`.

Each world is a straight road at 50 km/h with one pedestrian who crosses, again and again. A tick is a message in the binary form that is read, decided
and answered in this process; the time of the simulator of falsify is not in it. The fastest of five repetitions is printed.
"""

import sys
import time

import numpy as np

from falsify_av.stacks.batch import Frame
from falsify_av.stacks.sumo import Sumo

ACTORS, POINTS, TICK, TICKS = 8, 40, 0.05, 240


def main(worlds: int, model: str) -> None:
    vehicle = {"length": 4.79, "width": 2.16, "wheelbase": 3.0, "greatest_wheel_angle": 0.86}
    sumo = Sumo({"vehicle": vehicle, "tick_s": TICK, "worlds": worlds}, model)
    numbers = np.zeros((worlds, 14 + 8 * ACTORS + 3 * POINTS))
    numbers[:, 0] = np.arange(worlds)
    fastest = 0.0
    for _ in range(5):
        x, speed, began = np.zeros(worlds), np.full(worlds, 10.0), time.process_time()
        start = np.linspace(-9.0, -3.0, worlds)
        for tick in range(TICKS):
            numbers[:, 1], numbers[:, 2] = tick, 7.0 if tick == 0 else -1.0
            numbers[:, 3], numbers[:, 6], numbers[:, 7] = x, speed, 13.9
            numbers[:, 12], numbers[:, 13] = 1, POINTS
            numbers[:, 14:22] = [1.0, 40.0, 0.0, 1.6, 0.0, 1.4, 0.5, 0.5]
            numbers[:, 16] = start + 1.4 * TICK * tick
            numbers[:, 78::3] = x[:, None] + 2.0 * np.arange(POINTS)
            frame = Frame(np.frombuffer(numbers.tobytes()).reshape(numbers.shape), ACTORS, POINTS)
            acceleration, steer = sumo.decide(frame)
            np.column_stack([frame.ids, acceleration, np.zeros(worlds), steer]).tobytes()
            speed = np.maximum(speed + TICK * acceleration, 0.0)
            x = x + TICK * speed
        fastest = max(fastest, worlds * TICKS / (time.process_time() - began))
    print(f"{model}, {worlds} worlds: {fastest:,.0f} ticks a CPU second")


main(int(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "EIDM")
