"""What a bridge adds to a tick, in CPU time.

`python python/benches/worlds.py` times the Python side beside MetaDrive (`pip install './python[metadrive]'`), and `… worlds.py FALSIFY` what this program
adds with its messages and checks: episodes in `scenarios/external/my_world.py` beside the same at home, without the time of that bridge.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

# In place of this folder, whose `sumo.py` would be taken for the package.
sys.path[0] = str(Path(__file__).resolve().parents[1] / "tests")

EXTERNAL = Path(__file__).resolve().parents[2] / "scenarios" / "external"
TICKS = 2000
WALKER = {"x": 300.0, "y": -40.0, "yaw": 0.0, "vx": 0.0, "vy": 0.0}
CONTROL = {"throttle": 0.3, "brake": 0.0, "steer": 0.0, "acceleration": 0.0, "wheel_angle": 0.0}


def python_side() -> None:
    """Time answers to steps, and MetaDrive's part of them."""
    from test_bridges import MAP, START, TICK, VEHICLE

    from falsify_av.bridges import answer, metadrive

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


def serve(clock: str) -> None:
    """The bridge of ten lines, which writes down the CPU time that it took."""
    sys.path.insert(0, str(EXTERNAL))
    import my_world

    my_world.serve(my_world.MyWorld())
    with open(clock, "a") as file:
        file.write(f"{time.process_time()}\n")


def program_side(program: str) -> None:
    """Time episodes at home, and in a world of the same kinematics."""
    scenario = (EXTERNAL / "my_world.scn").read_text().replace("../lib", "std").replace("episodes: 20", "episodes: 400")
    with tempfile.TemporaryDirectory() as folder:
        clock, spent = Path(folder, "clock"), {}
        bridge = f'"{sys.executable} {Path(__file__).resolve()} serve {clock}")'
        scenario = scenario.replace('"python3 my_world.py", files: ["my_world.py"])', bridge)
        for world in ("here", "mine"):
            Path(folder, "run.scn").write_text(scenario.replace("worlds: [here, mine]", f"worlds: [{world}]"))
            command = [program, "run", "--allow-external", "--threads", "1", "--progress", "none", "--formats", "csv", "--out", world, "run.scn"]
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            spent[world] = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        theirs = sum(map(float, clock.read_text().split()))
        ticks = tomllib.loads(Path(folder, "mine", "two_worlds", "manifest.toml").read_text())["evaluation_ticks"]
    ours = 1e3 * (spent["mine"] - spent["here"] - theirs) / ticks
    print(f"messages and checks of the program {ours:.3f} ms a tick, the bridge of ten lines {1e3 * theirs / ticks:.3f} ms, over {ticks} ticks")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["serve", clock]:
            serve(clock)
        case [program]:
            program_side(program)
        case _:
            python_side()
