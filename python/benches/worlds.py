"""What a bridge adds to a tick of MetaDrive, in CPU time: `python python/benches/worlds.py`, with `pip install './python[metadrive]'`."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

# In place of this folder, whose `sumo.py` would be taken for the package.
sys.path[0] = str(Path(__file__).resolve().parents[1] / "tests")

from test_bridges import MAP, START, TICK, VEHICLE

from falsify_av.bridges import answer, metadrive

TICKS = 2000
WALKER = {"x": 300.0, "y": -40.0, "yaw": 0.0, "vx": 0.0, "vy": 0.0}
CONTROL = {"throttle": 0.3, "brake": 0.0, "steer": 0.0, "acceleration": 0.0, "wheel_angle": 0.0}


def main() -> None:
    """Time answers to steps, and MetaDrive's part of them."""
    world = metadrive.world([])
    body = {"radius": 0.2, "height": 1.8}
    ask = lambda message: answer(world, json.dumps(message).encode())  # noqa: E731
    ask({"type": "load", "town": "street", "map": MAP, "tick_s": TICK, "vehicle": VEHICLE, "pedestrians": [body], "lanes": [[200.0, -51.75]]})
    ask({"type": "begin", "seed": 1, "ego": {**START, "speed": 2.0}, "driver": None, "route": [], "pedestrians": [WALKER]})
    own, step = [0.0], world.env.step

    def timed(action: list[float]) -> None:
        began = time.process_time()
        step(action)
        own[0] += time.process_time() - began

    world.env.step = timed
    messages = [json.dumps({"type": "step", "tick": tick, "control": CONTROL, "pedestrians": [WALKER]}).encode() for tick in range(1, TICKS + 1)]
    began = time.process_time()
    for message in messages:
        answer(world, message)
    whole = time.process_time() - began
    print(f"MetaDrive {1e3 * own[0] / TICKS:.3f} ms a tick, the bridge {1e3 * (whole - own[0]) / TICKS:.3f} ms")


if __name__ == "__main__":
    main()
