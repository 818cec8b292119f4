"""MetaDrive as a world (`metadrive-simulator` 0.4.3): its physics move the car, and pedestrians are put where they are told to be at each tick.

A driver of ours gives an acceleration and an angle of the front wheels, which forces at the wheels of MetaDrive's default car carry out, as far as its tyres
allow. MetaDrive's own drivers use its pedals. The town comes through SUMO's `netconvert`. Options: `mended` gives pedestrians the attribute
whose lack blinds `IDMPolicy`; `substeps=N` sets the physics steps of a tick; `exact=speed`, `exact=path` and `exact=both` give the car the speed, the path, or both of
our car after each tick, which shows what of MetaDrive's dynamics makes a difference.
"""

from __future__ import annotations

import math
import tempfile
from importlib.metadata import version
from pathlib import Path

from . import Message, chosen, roads, state

DRIVERS = ("IDMPolicy", "TrajectoryIDMPolicy", "ExpertPolicy")
EXACT = ("speed", "path", "both")
SUBSTEPS = 5  # Physics steps of a tick.


def world(words: list[str]) -> MetaDrive:
    """The world for `python3 -m falsify_av.bridges metadrive WORDS`."""
    options = chosen("metadrive", words, mended=None, substeps=range(1, 101), exact=EXACT)
    return MetaDrive("mended" in options, options.get("substeps", SUBSTEPS), options.get("exact"))


class MetaDrive:
    """One engine of MetaDrive with a car and pedestrians."""

    def __init__(self, mended: bool, substeps: int, exact: str | None) -> None:
        self.mended, self.substeps, self.exact = mended, substeps, exact
        versions = ", ".join(f"{name} {version(name)}" for name in ("metadrive-simulator", "eclipse-sumo"))
        options = (", mended pedestrians" if mended else "") + (f", exact {exact}" if exact else "")
        self.about: Message = {
            "name": "metadrive",
            "version": f"{versions}, {substeps} steps a tick{options}",
            "drivers": list(DRIVERS),
            "friction": False,
            "lights": False,
            "seeds": True,
        }

    def load(self, message: Message) -> list[tuple[float, float]]:
        """Start the engine with the map of a town."""
        # Its import takes seconds, and a greeting must not wait for it.
        from .metadrive_engine import Flat

        self.wheelbase, self.tick = message["vehicle"]["wheelbase"], message["tick_s"]
        with tempfile.TemporaryDirectory() as folder:
            net = roads.convert(message["map"], Path(folder))
            self.env = Flat(net, message["tick_s"] / self.substeps, self.substeps, message["pedestrians"], self.mended)
            self.env.reset(seed=0)
            self.middle, self.height = self.env.middle, self.env.settled()
            return roads.nearest(roads.shapes(net), message["lanes"])

    def begin(self, message: Message) -> Message:
        """A new car at its start, as deep in its springs as one at rest."""
        self.env.reset(seed=0)
        car, ego = self.env.agent, message["ego"]
        self.commanded = self.env.engine.get_policy(car.name)
        self.env.renew()
        car.set_position(self.theirs(ego["x"], ego["y"]), self.height)
        car.set_heading_theta(ego["yaw"])
        car.set_velocity((ego["speed"] * math.cos(ego["yaw"]), ego["speed"] * math.sin(ego["yaw"])))
        car.set_angular_velocity(0.0)
        if message["driver"] and self.exact:
            raise SystemExit("`exact` gives the car the motion of a driver of ours; MetaDrive's own drivers drive without it")
        if message["driver"]:
            points = [self.theirs(x, y) for x, y, _ in message["route"]]
            self.env.hand_over(message["driver"], points, message["seed"] % 2**31)
        self.place(message["pedestrians"])
        return self.now()

    def correct(self, before: Message, control: Message) -> None:
        """Give the car what our car has after a tick: its path, its speed, or both."""
        slip = math.atan(math.tan(control["wheel_angle"]) / 2)
        way, heading = before["speed"] * self.tick, before["yaw"] + slip
        car, after = self.env.agent, self.now()["ego"]
        yaw, speed = after["yaw"], after["speed"]
        if self.exact != "speed":
            yaw = before["yaw"] + way * math.sin(slip) * 2 / self.wheelbase
            car.set_position(self.theirs(before["x"] + way * math.cos(heading), before["y"] + way * math.sin(heading)))
            car.set_heading_theta(yaw)
        if self.exact != "path":
            speed = max(before["speed"] + control["acceleration"] * self.tick, 0.0)
        car.set_velocity((speed * math.cos(yaw), speed * math.sin(yaw)))

    def step(self, message: Message) -> Message:
        """One tick. MetaDrive's driver sees the pedestrians as they were at its start."""
        control = message["control"]
        before = self.now()["ego"] if self.exact else {}
        self.commanded.acceleration = control["acceleration"]
        # The same curvature with its own wheelbase.
        car = self.env.agent
        wheelbase = car.FRONT_WHEELBASE + car.REAR_WHEELBASE
        angle = math.atan(math.tan(control["wheel_angle"]) * wheelbase / self.wheelbase)
        self.commanded.angle = max(-car.max_steering, min(car.max_steering, math.degrees(angle)))
        self.env.step([0.0, 0.0])
        if self.exact:
            self.correct(before, control)
        self.place(message["pedestrians"])
        return self.now()

    def theirs(self, x: float, y: float) -> tuple[float, float]:
        """A place of ours in MetaDrive's frame, whose origin is the middle of the map."""
        return x - self.middle[0], y - self.middle[1]

    def place(self, pedestrians: list[Message]) -> None:
        """Put the pedestrians where they are at the end of the tick."""
        for body, told in zip(self.env.walkers.bodies, pedestrians, strict=True):
            body.set_position(self.theirs(told["x"], told["y"]), body.HEIGHT / 2)
            body.set_heading_theta(told["yaw"])
            body.set_velocity((told["vx"], told["vy"]))

    def now(self) -> Message:
        """The state of everybody."""
        car, (x, y) = self.env.agent, self.middle
        yaw, velocity = float(car.heading_theta), car.velocity
        speed = float(velocity[0]) * math.cos(yaw) + float(velocity[1]) * math.sin(yaw)
        places = [(float(body.position[0]) + x, float(body.position[1]) + y) for body in self.env.walkers.bodies]
        return state(float(car.position[0]) + x, float(car.position[1]) + y, yaw, speed, places)
