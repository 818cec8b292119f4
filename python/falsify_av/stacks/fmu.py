"""An FMU, a functional mock-up unit, as a driver under test: FMI 2.0 or 3.0 for co-simulation, by FMPy.

Each world has an instance, made anew at tick 0. In a tick it is told of the world and steps until the end of the tick; what it answers then drives the car.
A follower of ours steers, and drives if the FMU only brakes. It keeps to the speed that limits, bends and lights ahead allow, also for an FMU that drives.

Install it with ``pip install fmpy==0.3.32``; ``docs/src/how-to/stacks/fmu.md`` has the quantities, and which road user is which.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .batch import PEDESTRIAN, RED, YELLOW, Array, Frame, serve
from .fmu_file import Apart, File, Instance, opened
from .fmu_links import LATER, USER, USERS, Links, linked, parameters

COMFORT, LATERAL = 2.0, 2.0  # m/s^2: before a lower limit, a bend or a light, and in bends
HARD, PULL = 4.0, 2.0  # m/s^2: the hardest braking of the follower, its pull
FULL, BRAKE, THROTTLE = 20.0, 8.0, 3.0  # m/s^2: more than any brake; roughly what a pedal does that is pushed down
ROOM = 1.0  # m: from the front of the car to a stop line
ASIDE = 8.0  # m: farther beside the route nobody is a `person` or a `vehicle`
SOON = 4.0  # s: so far ahead the ways of the car and of a road user may cross


def seen(frame: Frame, vehicle: dict[str, float]) -> dict[str, dict[int, list[list[float]]]]:
    """The road users ahead, by what an FMU calls them and by the row of their world, the nearest first: the numbers of `USER` of each."""
    ahead, left, direction = frame.along(vehicle)
    rows, speed = frame.actors, frame.speed[frame.world_of]
    sin, cos, half = np.abs(np.sin(rows[:, 3] - direction)), np.abs(np.cos(rows[:, 3] - direction)), rows[:, 6:8] / 2
    reach, room = cos * half[:, 0] + sin * half[:, 1], cos * half[:, 1] + sin * half[:, 0] + vehicle["width"] / 2
    front = ahead - vehicle["length"] / 2 - reach
    gap = np.maximum(front, 0.0)
    along = rows[:, 4] * np.cos(direction) + rows[:, 5] * np.sin(direction)
    across = rows[:, 5] * np.cos(direction) - rows[:, 4] * np.sin(direction)
    closing = speed - along
    # At constant velocities: how far to the left it is when the car reaches it, and when the car has passed.
    reached, passed = ((gap + more) / np.maximum(closing, 1e-3) for more in (0.0, 2 * reach + vehicle["length"]))
    one, two = left + across * reached, left + across * np.minimum(passed, SOON)
    meets = (reached < SOON) & ((np.minimum(np.abs(one), np.abs(two)) < room) | (one * two < 0.0))
    walks, inside, near = rows[:, 0] == PEDESTRIAN, np.abs(left) < room, np.abs(left) < ASIDE
    numbers = {"gap": gap, "left": left, "speed": along, "lateral": across, "closing": closing, "ttc": np.where(closing > 1e-3, np.minimum(reached, LATER), LATER)}
    numbers |= {"present": np.ones(len(gap)), "kind": np.where(walks, 1.0, 2.0)}
    values = np.column_stack([numbers[name] for name in USER]).tolist()
    found: dict[str, dict[int, list[list[float]]]] = {user: {} for user in USERS}
    fits = {"front": inside, "course": inside | meets, "person": walks & near, "vehicle": ~walks & near}
    for row in np.argsort(front, kind="stable").tolist():
        # Whom the front of the car has passed is not ahead.
        for user in USERS if front[row] + 2 * reach[row] > 0.0 else ():
            if fits[user][row]:
                found[user].setdefault(int(frame.world_of[row]), []).append(values[row])
    return found


@dataclass
class World:
    """An instance in an episode, and the car a tick ago."""

    fmu: Instance | Apart
    ticks: int = 0
    speed: float = 0.0
    yaw: float = 0.0


class Fmu:
    """The FMU in all worlds."""

    def __init__(self, hello: dict[str, Any], file: File, links: Links, step: float | None = None) -> None:
        self.vehicle, self.tick, self.file, self.links = hello["vehicle"], float(hello["tick_s"]), file, links
        links.constants.update(parameters(hello.get("parameters") or {}, file.model))
        self.step = step or file.step(self.tick)
        if abs(self.step - self.tick) > 1e-9:
            print(f"{file.path} steps by {self.step:g} s, and a tick is {self.tick:g} s: each tick it steps until that is over", file=sys.stderr)
        self.is_apart = bool(file.model.coSimulation.canBeInstantiatedOnlyOncePerProcess) and int(hello["worlds"]) > 1
        self.worlds: dict[int, World] = {0: World(self._made())}
        #: Its last outputs, in its own units, and why it failed.
        self.last: dict[str, float] = {}
        self.failure = ""

    def _made(self) -> Instance | Apart:
        links = self.links

        def make() -> Instance:
            return Instance(self.file, [each.variable for each in links.inputs], [each.variable for each in links.outputs], links.constants, self.step)

        return Apart(make) if self.is_apart else make()

    def decide(self, frame: Frame) -> tuple[Array, ...]:
        """A tick of all worlds: accelerations (m/s^2), or throttles and brakes, and steers, or angles of the wheels (rad)."""
        allowed, users, is_angle = self._allowed(frame), seen(frame, self.vehicle), self.links.is_angle
        turn = frame.wheel(self.vehicle) if is_angle else frame.steer(self.vehicle)
        follower = np.where(frame.points > 0, np.clip(2.0 * (allowed - frame.speed), -HARD, PULL), -HARD)
        pushes = np.zeros((2, len(frame.ids)))
        for row, number in enumerate(frame.ids.tolist()):
            own = {"ego.speed": float(frame.speed[row]), "road.limit": float(frame.limit[row]), "road.speed": float(allowed[row])}
            near = {user: found.get(row, []) for user, found in users.items()}
            answers = self._ask(number, bool(frame.starts[row]), own, float(frame.ego[row, 2]), near)
            pushes[:, row] = self._push(answers, float(follower[row]), own["ego.speed"])
            most = self.vehicle["greatest_wheel_angle"] if is_angle else 1.0
            if "car.steer" in answers or "car.wheel" in answers:
                turn[row] = np.clip(answers.get("car.wheel" if is_angle else "car.steer", math.nan), -most, most)
        return (*pushes, turn) if self.links.is_pedals else (pushes[0], turn)

    def _allowed(self, frame: Frame) -> Array:
        """The speed that limits, bends and lights ahead allow (m/s)."""
        speed = np.minimum(frame.limits(COMFORT), frame.bends(LATERAL, COMFORT))
        room = frame.light_distance - self.vehicle["length"] / 2 - ROOM
        stop = (frame.light == RED) | ((frame.light == YELLOW) & (room > frame.speed**2 / (2 * HARD)))
        return np.where(stop, np.minimum(speed, np.sqrt(2 * COMFORT * np.maximum(room, 0.0))), speed)

    def _ask(self, number: int, starts: bool, own: dict[str, float], yaw: float, near: dict[str, list[list[float]]]) -> dict[str, float]:
        """What it answers in a world. If it fails that is not a number, which makes the episode an error."""
        if number not in self.worlds:
            self.worlds[number] = World(self._made())
        world = self.worlds[number]
        if starts or world.ticks == 0:
            world.ticks, world.speed, world.yaw = 0, own["ego.speed"], yaw
        own["ego.acceleration"] = (own["ego.speed"] - world.speed) / self.tick
        own["ego.yaw_rate"] = math.remainder(yaw - world.yaw, math.tau) / self.tick
        told = [each.told(own, near) for each in self.links.inputs]
        world.ticks, world.speed, world.yaw = world.ticks + 1, own["ego.speed"], yaw
        try:
            found = world.fmu.step(told, world.ticks * self.tick, world.ticks == 1)
            wrong = [each.variable.name for each, value in zip(self.links.outputs, found) if not math.isfinite(value)]
            if wrong:
                raise RuntimeError(f"its output `{wrong[0]}` is not finite")
        except Exception as error:
            self.failure = f"{error}, {world.ticks * self.tick:.2f} s after the start of an episode"
            print(f"{self.file.path} fails: {self.failure}", file=sys.stderr)
            return {"car.steer": math.nan}
        self.last = {each.variable.name: value for each, value in zip(self.links.outputs, found)}
        return {each.quantity: each.answered(value) for each, value in zip(self.links.outputs, found)}

    def _push(self, answers: dict[str, float], follower: float, speed: float) -> tuple[float, float]:
        """An acceleration (m/s^2) and 0, or a throttle and a brake. The follower bounds what the FMU wants."""
        stops = answers.get("car.stop", 0.0) > 0.0
        if self.links.is_pedals:
            brake = 1.0 if stops else max(answers.get("car.brake", 0.0), 0.0)
            throttle = min(answers.get("car.throttle", 1.0), max(follower, 0.0) / THROTTLE)
            return (0.0 if brake > 0.0 else throttle), max(brake, -follower / BRAKE)
        wanted = 2.0 * (answers["car.speed"] - speed) if "car.speed" in answers else answers.get("car.acceleration", follower)
        braking = answers.get("car.deceleration", 0.0)
        return min(follower, wanted, -braking if braking > 0.0 else wanted, -FULL if stops else wanted), 0.0


def main(words: list[str]) -> None:
    """Serve an FMU, write a scenario for it, or try it."""
    reader = argparse.ArgumentParser(prog="python3 -m falsify_av.stacks fmu", description="An FMU as a driver.")
    reader.add_argument("file", type=Path, metavar="FILE.fmu")
    reader.add_argument("links", nargs="*", metavar="NAME=QUANTITY", help="a variable and what it is: v_ego=ego.speed[m/s], or a value that stays, mode=2")
    reader.add_argument("--step", type=float, metavar="SECONDS", help="the length of its steps; otherwise that of its description, or a tick")
    reader.add_argument("--new", type=Path, metavar="FILE.scn", help="write a scenario with its variables to fill in")
    reader.add_argument("--try", action="store_true", dest="tries", help="say what it does in front of people and vehicles")
    given = reader.parse_intermixed_args(words)
    if given.step is not None and not 1e-5 <= given.step <= 10.0:
        raise SystemExit(f"--step {given.step:g} is no length of a step: give 0.00001 to 10, in seconds")
    file = opened(given.file)
    if given.new is not None:
        from .fmu_trial import write

        write(file, given.new)
        return
    links = linked(given.links, file.model)
    if given.tries:
        from .fmu_trial import tried

        raise SystemExit(tried(lambda hello: Fmu(hello, file, links, given.step)))
    serve(f"fmu_{file.model.modelName}", lambda hello: Fmu(hello, file, links, given.step).decide, "pedals" if links.is_pedals else "acceleration", links.is_angle)
