"""The world of scenarios/external/my_world.py with a fault: `world.py FAULT`. It comes in the third tick of an episode, or in the message that the fault is about."""

import math
import random
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scenarios" / "external"))
import my_world

FAULT = sys.argv[1]
#: Whether the mark in the working folder shows that it was started before.
STARTED = FAULT == "another" and Path("started").exists()
if FAULT == "another":
    Path("started").touch()
#: Factors of the wheel angle and of the deceleration.
STEER = {"mirrored": -1.0, "straight": 0.0, "weak_steer": 0.1, "strong_steer": 2.0}.get(FAULT, 1.0)
BRAKE = {"no_brake": 0.0, "weak_brake": 0.1, "tenth": 0.1, "mild_brake": 0.7}.get(FAULT, 1.0)
#: How late the car does what it is told (ticks).
LATE = {"soon": 2, "late_control": 3, "late_pedals": 6, "declared": 6}.get(FAULT, 0)
#: Where the wheel is not late.
PEDALS = ("late_pedals", "declared")


class World(my_world.MyWorld):
    NAMES = {"here": "here", "nameless": " ", "two_lines": "a\nb", "long_name": "x" * 61, "turned": "a\u202eb"}
    VERSIONS = {"long_version": "1" * 900_000, "turned_version": "1\u2066", "another": "2" if STARTED else "1"}
    DRIVERS = {"stranger": [], "twins": ["theirs", "theirs"], "no_word": ["theirs", ""]}
    ABOUT = {**my_world.MyWorld.ABOUT, "name": NAMES.get(FAULT, "my_world"), "version": VERSIONS.get(FAULT, my_world.MyWorld.ABOUT["version"]), "drivers": DRIVERS.get(FAULT, ["theirs", "blind"]), "controls": FAULT != "rails", "tolerance": {"tolerant": 0.03, "lax": 9.0, "late": 0.5, "later": 0.5}.get(FAULT, 0.0), "seeds": FAULT != "unseeded", "pedal_delay": {"declared": 0.3, "tardy": 0.6}.get(FAULT, 0.0)}

    def load(self, message):
        super().load(message)
        self.size, self.radius = message["vehicle"], message["pedestrians"][0]["radius"]
        self.tick *= {"half_tick": 0.5, "double_tick": 2.0}.get(FAULT, 1.0)
        if FAULT == "no_lanes":
            return None
        shift = 0.3 if FAULT == "shifted" else 0.05
        lanes = [[x + shift, y] for x, y in message["lanes"]]
        return lanes[1:] if FAULT == "few_lanes" else lanes

    def begin(self, message):
        if FAULT in ("rare", "often") and message["seed"] % {"rare": 130, "often": 13}[FAULT] == 7:
            sys.exit(3)
        if FAULT == "late_start":
            time.sleep(3600)
        super().begin(message)
        self.native = message["driver"]
        self.first_yaw = self.yaw
        self.wanted = [{"acceleration": 0.0} if FAULT in PEDALS else {"acceleration": 0.0, "wheel_angle": 0.0}] * LATE
        self.told = []
        if FAULT == "misplaced":
            self.y += 0.5

    def step(self, message):
        control = message["control"]
        is_right, is_fast = control["wheel_angle"] < 0.0, message["tick"] > 150 and self.speed > 12.0
        control["wheel_angle"] *= -1.0 if (FAULT == "no_right" and is_right) or (FAULT == "mirrored_fast" and is_fast) else STEER
        control["acceleration"] *= BRAKE if control["acceleration"] < 0.0 or FAULT == "tenth" else 1.0
        self.wanted.append({"acceleration": control["acceleration"]} if FAULT in PEDALS else dict(control))
        control.update(self.wanted.pop(0))
        if self.native:
            message["control"].update(acceleration=-5.0 if self.native == "theirs" else 0.0, wheel_angle=0.0)
        super().step(message)
        if FAULT == "bumps":
            (there,), (sin, cos) = message["pedestrians"], (math.sin(self.yaw), math.cos(self.yaw))
            x, y = there["x"] - self.x, there["y"] - self.y
            beyond = max(abs(cos * x + sin * y) - self.size["length"] / 2, 0.0), max(abs(cos * y - sin * x) - self.size["width"] / 2, 0.0)
            self.speed *= 0.7 if math.hypot(*beyond) <= self.radius else 1.0
        if FAULT == "drifts":
            self.y += 0.02
        if FAULT in ("unseeded", "draws"):
            self.x += random.uniform(0.0, 1e-4)

    def state(self, tick):
        state = super().state(tick)
        ego = state["ego"]
        if tick > 0:
            ego["speed"] *= 3.6 if FAULT == "kmh" else 1.0
            ego["x"] += {"off": 0.45, "aside": 0.15, "creeps": 0.02 * min(tick, 20)}.get(FAULT, 0.0)
            ego["yaw"] *= 180 / math.pi if FAULT == "degrees" else 1.0
        if tick < 3:
            return state
        self.told.append(state["pedestrians"])
        state["pedestrians"] = self.told[-1 - min({"late": 1, "later": 3}.get(FAULT, 0), len(self.told) - 1)]
        if FAULT == "hang":
            time.sleep(3600)
        if FAULT == "crash" or (FAULT == "bad_driver" and self.native == "blind"):
            sys.exit(3)
        if FAULT == "fast":
            ego["speed"] += 1e6
        if FAULT == "lasting":
            ego["y"] += 0.4
        if FAULT == "nan":
            ego["x"] = float("nan")
        if FAULT == "null":
            ego["speed"] = None
        if FAULT == "infinite":
            ego["x"] = 1e999
        if FAULT in ("elsewhere", "tolerant"):
            state["pedestrians"][0][0] += 0.02
        if FAULT == "ends":
            state["end"] = True
        if FAULT == "stuck_yaw":
            ego["yaw"] = self.first_yaw
        if FAULT == "ends_near":
            state["end"] = math.dist((self.x, self.y), state["pedestrians"][0]) < 4.0
        if FAULT == "behind":
            state["tick"] -= 1
        if FAULT == "jumps":
            ego["x"] += 3.0
        if FAULT == "nobody":
            state["pedestrians"] = []
        if FAULT == "half":
            del state["pedestrians"]
        return state


my_world.serve(World())
