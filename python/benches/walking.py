"""JuPedSim's pedestrian in the table of recorded walking figures: `python python/benches/walking.py [PEDESTRIANS]`.

As in the test of the built-in natural pedestrian, a car drives past at 10 m/s, the body reaches every command at once, and speeds and headings are
compared second by second while it walks. `reports/natural_walking.md` has the recorded figures.
"""

import math
import random
import sys

import numpy as np

from falsify_av.stacks.jupedsim import Walk

TICK, HOLD, SECONDS = 0.05, 10, 20
CAR = {"length": 4.79, "width": 2.16}


def track(seed: int) -> np.ndarray:
    """Velocities (m/s), one a second, of one pedestrian while it walks."""
    drawn = random.Random(seed)
    bearing, distance = math.radians(drawn.uniform(10, 45)), drawn.uniform(20, 40)
    me = {"x": distance * math.cos(bearing), "y": -distance * math.sin(bearing), "yaw": math.pi / 2}
    walk, velocities = Walk(seed, TICK, HOLD), []
    for decision in range(SECONDS * 2):
        ego = {"x": 10.0 * decision * TICK * HOLD, "y": 0.0, "yaw": 0.0, "speed": 10.0}
        heading, speed = walk.choose(me, ego, CAR)
        me = {"x": me["x"] + speed * math.cos(heading) * TICK * HOLD, "y": me["y"] + speed * math.sin(heading) * TICK * HOLD, "yaw": heading}
        if decision % 2 and speed > 0.05:
            velocities.append((speed * math.cos(heading), speed * math.sin(heading)))
    # In the last second it arrives.
    return np.array(velocities[:-1]).reshape(-1, 2)


def main(count: int) -> None:
    tracks = [each for each in map(track, range(count)) if len(each) > 1]
    speeds = np.hypot(*np.concatenate(tracks).T)
    changes = np.concatenate([np.diff(np.hypot(*each.T)) for each in tracks])
    turns = np.concatenate([np.diff(np.unwrap(np.arctan2(each[:, 1], each[:, 0]))) for each in tracks])
    print(f"{len(tracks)} pedestrians, {len(speeds)} seconds")
    print(f"speed: mean {speeds.mean():.3f}, sd {speeds.std():.3f}, 99th and 99.9th percentile {np.quantile(speeds, 0.99):.2f}, {np.quantile(speeds, 0.999):.2f} m/s")
    for name, values, unit in (("speed", changes, "m/s"), ("heading", turns, "rad")):
        deviation, far = math.sqrt(np.mean(values**2)), np.quantile(np.abs(values), 0.999)
        print(f"change of {name} in 1 s: sd {deviation:.3f}, 99.9th percentile {far:.2f} {unit}")


main(int(sys.argv[1]) if len(sys.argv) > 1 else 600)
