"""SUMO's car-following models as a driver under test: EIDM, IDM or Krauss of Eclipse SUMO, asked once a tick by its library ``libsumo``.

Each world is a straight lane of one SUMO simulation, without sidewalks: with them SUMO's cars do not see a person on the lane (sumo#16092).
The car stands on the lane as ours stands on its route, and a pedestrian lies on it in the coordinates of the route. A tick is a step of SUMO, from
the speed that our car really has; our car then follows SUMO's speed, and steers along its route by pure pursuit, which is ours.

Install it with ``pip install libsumo==1.28.0``; ``docs/src/how-to/stacks/sumo.md`` says what it sees and what it was not made for.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from .batch import PEDESTRIAN, RED, YELLOW, Array, Frame, serve

# Its import prints two lines where another pyarrow is installed than the one that it is compiled against. Neither is used here.
os.environ.setdefault("LIBSUMO_AS_TRACI", "quiet")
import libsumo  # noqa: E402

MODELS = ("EIDM", "IDM", "Krauss")

LANE = 3.5  # m: width of the lane
LONG = 4000.0  # m: length of the lane
FIRST, LATEST = 200.0, LONG - 400.0  # m: where a car starts, and from where it is put back there
APART = 20.0  # m: between two worlds
DECELERATION = 4.5  # m/s^2: SUMO's usual braking, by which a car still stops at a yellow light
TURNING = 5.5  # m/s^2: the lateral acceleration for which SUMO's netconvert limits the speed of lanes that turn
STRONGEST, PULL = -9.0, 3.0  # m/s^2: SUMO's emergency braking, our car's pull
MIN_GAP = 2.5  # m: that SUMO's cars keep from what stands ahead
SIGHT = 150.0  # m: farther road users are not shown


class World:
    """One lane: its car, what is on it, and since when."""

    def __init__(self, place: int, tick: float) -> None:
        self.tick = tick
        self.edge, self.lane, self.route, self.y = f"e{place}", f"e{place}_0", f"r{place}", -APART * place
        self.place, self.episode = place, 0
        self.car = ""
        self.limit, self.speed = 0.0, 0.0
        self.persons: set[str] = set()
        self.leads = False

    def begin(self, speed: float) -> None:
        """A new car, which has no memory of an earlier episode."""
        if self.episode:
            self._remove(libsumo.vehicle, self.car)
            self.unlead()
            for person in sorted(self.persons):
                self._remove(libsumo.person, person)
            self.persons.clear()
        self.episode += 1
        self.car = f"car{self.place}.{self.episode}"
        libsumo.vehicle.add(self.car, self.route, typeID="car")
        libsumo.vehicle.moveTo(self.car, self.lane, FIRST)
        self.speed = speed

    @staticmethod
    def _remove(domain: Any, name: str) -> None:
        try:
            domain.remove(name)
        except libsumo.TraCIException:
            pass  # It has left the lane already.

    def impose(self, speed: float, limit: float) -> float:
        """Give SUMO's car the speed of ours, and the lane its limit; returns the place of the car's front on the lane (m)."""
        if limit != self.limit:
            libsumo.lane.setMaxSpeed(self.lane, max(limit, 0.1))
            self.limit = limit
        front = float(libsumo.vehicle.getLanePosition(self.car))
        if not FIRST / 2 < front < LATEST:
            front = FIRST
            libsumo.vehicle.moveTo(self.car, self.lane, front)
        # What it did in the last tick, not what SUMO wanted: the car may have been slower to follow.
        change, self.speed = (speed - self.speed) / self.tick, speed
        libsumo.vehicle.setPreviousSpeed(self.car, speed, change)
        return front

    def show(self, name: str, front: float, ahead: float, left: float, size: tuple[float, float]) -> None:
        """Put a person on the lane; `ahead` is from the front of the car to the person's near side (m)."""
        person = f"{name}.{self.place}.{self.episode}"
        # SUMO's place of a person is the end of its length.
        at = front + ahead + size[0]
        if not 0.5 < at < LONG - 1.0:
            return
        if person not in self.persons:
            # SUMO lets a person walk from the next step on.
            self.persons.add(person)
            libsumo.person.add(person, self.edge, at, typeID="person")
            libsumo.person.appendWalkingStage(person, [self.edge], LONG)
            libsumo.person.setLength(person, size[0])
            libsumo.person.setWidth(person, size[1])
            libsumo.person.setSpeed(person, 0.0)
        else:
            libsumo.person.moveToXY(person, self.edge, at, self.y + left, 90.0, 2)

    def hide(self, name: str, front: float) -> None:
        """Put a person, if it is there, behind the car."""
        if f"{name}.{self.place}.{self.episode}" in self.persons:
            libsumo.person.moveToXY(f"{name}.{self.place}.{self.episode}", self.edge, front - 50.0, self.y, 90.0, 2)

    def lead(self, front: float, gap: float, speed: float, length: float) -> None:
        """Put a vehicle ahead; `gap` is from the front of the car to its rear (m)."""
        name = f"lead{self.place}"
        if not self.leads:
            libsumo.vehicle.add(name, self.route, typeID="lead")
            self.leads = True
        libsumo.vehicle.setLength(name, length)
        libsumo.vehicle.moveTo(name, self.lane, front + max(gap, 0.1) + length)
        libsumo.vehicle.setPreviousSpeed(name, max(speed, 0.0), 0.0)

    def unlead(self) -> None:
        """Take the vehicle ahead away."""
        if self.leads:
            self._remove(libsumo.vehicle, f"lead{self.place}")
            self.leads = False


class Sumo:
    """All worlds in one simulation of SUMO."""

    def __init__(self, hello: dict[str, Any], model: str) -> None:
        self.vehicle, self.tick = hello["vehicle"], hello["tick_s"]
        self.worlds = [World(place, self.tick) for place in range(int(hello["worlds"]))]
        with tempfile.TemporaryDirectory() as folder:
            net, types = Path(folder) / "lanes.net.xml", Path(folder) / "types.add.xml"
            net.write_text(lanes(len(self.worlds)), encoding="utf-8")
            types.write_text(kinds(len(self.worlds), model, self.vehicle), encoding="utf-8")
            options = ["--no-step-log", "--no-warnings", "--collision.action", "none", "--time-to-teleport", "-1", "--default.speeddev", "0"]
            libsumo.start(["sumo", "-n", str(net), "-a", str(types), "--step-length", str(self.tick), *options])

    def decide(self, frame: Frame) -> tuple[Array, Array]:
        """One step of SUMO for all worlds; returns accelerations (m/s^2) and steers."""
        ahead, left, direction = frame.along(self.vehicle)
        kind, speed_along = frame.actors[:, 0], frame.actors[:, 4] * np.cos(direction) + frame.actors[:, 5] * np.sin(direction)
        turn = frame.actors[:, 3] - direction
        long_half, wide_half = frame.actors[:, 6] / 2, frame.actors[:, 7] / 2
        reach = np.abs(np.cos(turn)) * long_half + np.abs(np.sin(turn)) * wide_half
        side = np.abs(np.cos(turn)) * wide_half + np.abs(np.sin(turn)) * long_half
        gap = ahead - self.vehicle["length"] / 2 - reach
        walks = kind == PEDESTRIAN
        shown = walks & (np.abs(left) - wide_half < LANE / 2) & (np.abs(gap) < SIGHT)
        blocks = ~walks & (np.abs(left) - side < self.vehicle["width"] / 2) & (ahead > 0.0) & (gap < SIGHT)
        fronts = self._impose(frame, np.minimum(frame.limits(DECELERATION), frame.bends(TURNING, DECELERATION)))
        for row in np.flatnonzero(walks):
            front, world = fronts[frame.world_of[row]]
            name = f"person{frame.place_of[row]}"
            if shown[row]:
                reached = min(max(left[row], -LANE / 2), LANE / 2)
                world.show(name, front, float(gap[row]), reached, (2.0 * float(long_half[row]), 2.0 * float(wide_half[row])))
            else:
                world.hide(name, front)
        leaders: dict[int, int] = {}
        for row in np.flatnonzero(blocks):
            number = int(frame.world_of[row])
            if number not in leaders or gap[row] < gap[leaders[number]]:
                leaders[number] = int(row)
        self._lights_and_leaders(frame, fronts, leaders, gap, speed_along, long_half)
        libsumo.simulationStep()
        # EIDM subtracts absolute times, whose last bits depend on how long SUMO has run; an episode must not.
        wanted = np.round([libsumo.vehicle.getSpeed(world.car) for _, world in fronts], 6)
        acceleration = np.clip((wanted - frame.speed) / self.tick, STRONGEST, PULL)
        return np.where(frame.points > 0, acceleration, -PULL), frame.steer(self.vehicle)

    def _impose(self, frame: Frame, limits: Array) -> list[tuple[float, World]]:
        """The place of each car's front on its lane, and its world."""
        found = []
        for number, starts, speed, limit in zip(frame.ids.tolist(), frame.starts.tolist(), frame.speed.tolist(), limits.tolist()):
            world = self.worlds[number % len(self.worlds)]
            if starts or not world.episode:
                world.begin(speed)
            found.append((world.impose(max(speed, 0.0), limit), world))
        return found

    def _lights_and_leaders(
        self, frame: Frame, fronts: list[tuple[float, World]], leaders: dict[int, int], gap: Array, speed: Array, half: Array
    ) -> None:
        """A light at which the car must stop is a person as wide as the lane; a vehicle in the way is a vehicle ahead."""
        stops_in = frame.speed**2 / (2.0 * DECELERATION)
        stop = (frame.light == RED) | ((frame.light == YELLOW) & (stops_in < frame.light_distance))
        for number, (front, world) in enumerate(fronts):
            if stop[number]:
                world.show("line", front, float(frame.light_distance[number]) - self.vehicle["length"] / 2 + MIN_GAP, 0.0, (0.1, LANE))
            else:
                world.hide("line", front)
            row = leaders.get(number)
            if row is None:
                world.unlead()
            else:
                world.lead(front, float(gap[row]), float(speed[row]), 2.0 * float(half[row]))


def lanes(count: int) -> str:
    """A net of straight lanes without sidewalks, one for each world."""
    parts = ['<net version="1.20">', f'<location netOffset="0,0" convBoundary="0,{-APART * count},{LONG},0" origBoundary="0,0,0,0" projParameter="!"/>']
    ends = []
    for place in range(count):
        y = -APART * place
        shape = f"0,{y} {LONG},{y}"
        lane = f'<lane id="e{place}_0" index="0" speed="13.9" length="{LONG}" width="{LANE}" shape="{shape}"/>'
        parts.append(f'<edge id="e{place}" from="a{place}" to="b{place}" priority="-1">{lane}</edge>')
        for name, x, incoming in (("a", 0.0, ""), ("b", LONG, f"e{place}_0")):
            outline = f"{x},{y + LANE / 2} {x},{y - LANE / 2}"
            ends.append(f'<junction id="{name}{place}" type="dead_end" x="{x}" y="{y}" incLanes="{incoming}" intLanes="" shape="{outline}"/>')
    return "\n".join([*parts, *ends, "</net>"])


def kinds(count: int, model: str, vehicle: dict[str, float]) -> str:
    """SUMO's own defaults but for the size of the car, and without its random errors, which it draws for lanes and not for episodes."""
    exact = 'sigma="0" sigmaleader="0" sigmagap="0" sigmaerror="0" speedDev="0"'
    size = f'length="{vehicle["length"]}" width="{vehicle["width"]}" minGap="{MIN_GAP}"'
    return "\n".join([
        "<additional>",
        f'<vType id="car" carFollowModel="{model}" {size} {exact}/>',
        '<vType id="lead" carFollowModel="Krauss" sigma="0" speedDev="0"/>',
        '<vType id="person" vClass="pedestrian" minGap="0" speedDev="0"/>',
        *(f'<route id="r{place}" edges="e{place}"/>' for place in range(count)),
        "</additional>",
    ])


def main(words: list[str]) -> None:
    """Serve the model that is named: `EIDM` (default), `IDM` or `Krauss`."""
    model = words[0] if words else MODELS[0]
    if model not in MODELS:
        raise SystemExit(f"SUMO's model {model!r} is not known here; give one of {', '.join(MODELS)}")
    serve(f"sumo_{model.lower()}", lambda hello: Sumo(hello, model).decide)
