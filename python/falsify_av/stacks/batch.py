"""Many worlds at a time: the binary form of the protocol of drivers as arrays, and the route as a coordinate.

A tick of all worlds is one :class:`Frame`. :func:`serve` reads frames and writes answers, so a driver costs a few array operations a world and
no text. ``scenarios/external/README.md`` describes the form.
"""

from __future__ import annotations

import json
import struct
import sys
from collections.abc import Callable
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..answers import answers

Array = NDArray[np.float64]

_HEAD, _ACTOR, _POINT, _LANE = 14, 8, 3, 5
PEDESTRIAN, VEHICLE = 1.0, 2.0
GREEN, YELLOW, RED = 1.0, 2.0, 3.0
STOP, YIELD = 1.0, 2.0

#: m and s: the place on the route that a driver steers to is this far ahead, plus this long at its speed.
AHEAD = 2.0, 0.4
#: m: between two points of the route.
APART = 2.0


class Frame:
    """All worlds that move in a tick. Units and frames are those of the protocol: m, s, m/s, rad."""

    def __init__(self, numbers: Array, actors: int, points: int) -> None:
        self.ids = numbers[:, 0].astype(np.int64)
        self.starts = numbers[:, 2] >= 0.0
        self.ego = numbers[:, 3:6]
        self.speed, self.limit = numbers[:, 6], numbers[:, 7]
        self.light, self.light_distance = numbers[:, 8], numbers[:, 9]
        self.sign, self.sign_distance = numbers[:, 10], numbers[:, 11]
        self.points = numbers[:, 13].astype(np.int64)
        first = _HEAD + _ACTOR * actors + _POINT * points
        self.route = numbers[:, _HEAD + _ACTOR * actors : first].reshape(-1, points, _POINT)
        # Revision 2 adds the ids of the road users, and of each point: width, lanes to the left and to the right, junction, speed limit.
        self.lanes = numbers[:, first + actors :].reshape(-1, points, _LANE) if numbers.shape[1] > first else None
        everybody = numbers[:, _HEAD : _HEAD + _ACTOR * actors].reshape(-1, actors, _ACTOR)
        # One row for each road user in sight: of which world it is, and the protocol's eight numbers.
        self.world_of, self.place_of = np.nonzero(everybody[:, :, 0])
        self.actors = everybody[self.world_of, self.place_of]
        self._segments = _Segments(self.route, self.points)

    def along(self, vehicle: dict[str, float]) -> tuple[Array, Array, Array]:
        """The road users in the coordinates of the route of their world, from the middle of the car.

        Returns how far ahead each is (m), how far to the left (m), and the direction of the route there (rad). How far to the left is measured from the
        route or from the place of the car beside it, whichever is nearer: a car that cuts a corner comes back to its route. In a bend a car sweeps more than
        its width, since its front swings out and its rear cuts the corner: who is beside the route there is that much nearer to its path.
        """
        everything = np.arange(len(self.ids))
        own, own_left, _, _ = self._segments.project(everything, self.ego[:, :2])
        ahead, left, direction, bend = self._segments.project(self.world_of, self.actors[:, 1:3])
        beside = left - own_left[self.world_of]
        left = np.where(np.abs(beside) < np.abs(left), beside, left)
        rear, front = vehicle["wheelbase"] / 2, (vehicle["length"] + vehicle["wheelbase"]) / 2
        # A circle of radius r departs from its tangent at the rear axle by x^2 / 2r, x ahead of the axle; the middle of the car is on the route.
        inside = np.sign(left) == np.sign(bend)
        swept = np.abs(bend) / 2 * np.where(inside, rear**2, front**2 - rear**2)
        return ahead - own[self.world_of], np.sign(left) * np.maximum(np.abs(left) - swept, 0.0), direction

    def bends(self, lateral: float, braking: float) -> Array:
        """The greatest speed from which braking (m/s^2) takes every bend of the route ahead with at most a lateral acceleration (m/s^2); m/s."""
        turns = np.abs(np.remainder(np.diff(self.route[:, :, 2], axis=1) + np.pi, 2 * np.pi) - np.pi)
        places = np.arange(turns.shape[1])
        turns[places[None, :] >= (self.points - 1)[:, None]] = 0.0
        squares = lateral * APART / np.maximum(turns, 1e-3) + 2.0 * braking * APART * places
        return np.asarray(np.sqrt(np.min(squares, axis=1, initial=1e4)))

    def limits(self, braking: float) -> Array:
        """The greatest speed from which braking (m/s^2) keeps the speed limit here and every one along the route ahead; m/s."""
        if self.lanes is None:
            return self.limit
        places = np.arange(self.lanes.shape[1])
        ahead = self.lanes[:, :, 4] ** 2 + 2.0 * braking * APART * places
        ahead[places[None, :] >= self.points[:, None]] = np.inf
        return np.asarray(np.minimum(self.limit, np.sqrt(np.min(ahead, axis=1))))

    def steer(self, vehicle: dict[str, float]) -> Array:
        """Steering along the route by pure pursuit, -1 to 1, positive to the left."""
        return self.wheel(vehicle) / vehicle["greatest_wheel_angle"]

    def wheel(self, vehicle: dict[str, float]) -> Array:
        """The same as an angle of the front wheels (rad)."""
        worlds = np.arange(len(self.ids))
        reach = AHEAD[0] + AHEAD[1] * self.speed
        index = np.minimum(np.ceil(reach / APART).astype(np.int64), np.maximum(self.points - 1, 0))
        target = self.route[worlds, index]
        # Where the route ends, it goes on straight.
        beyond = np.maximum(reach - APART * index, 0.0)
        x = target[:, 0] + beyond * np.cos(target[:, 2]) - self.ego[:, 0]
        y = target[:, 1] + beyond * np.sin(target[:, 2]) - self.ego[:, 1]
        angle = np.arctan2(y, x) - self.ego[:, 2]
        wheel = np.arctan2(2.0 * vehicle["wheelbase"] * np.sin(angle), np.hypot(x, y))
        most = vehicle["greatest_wheel_angle"]
        return np.where(self.points > 0, np.clip(wheel, -most, most), 0.0)


class _Segments:
    """The routes of all worlds as lines; the first and the last segment go on for ever."""

    def __init__(self, route: Array, points: NDArray[np.int64]) -> None:
        # A route of one point is a line in its direction.
        headings = np.stack([np.cos(route[:, :, 2]), np.sin(route[:, :, 2])], axis=2)
        self.starts = route[:, :-1, :2] if route.shape[1] > 1 else route[:, :, :2]
        steps = np.diff(route[:, :, :2], axis=1) if route.shape[1] > 1 else headings
        self.lasts = np.maximum(points - 2, 0)
        alone = points < 2
        steps[alone, 0] = headings[alone, 0]
        self.lengths = np.maximum(np.hypot(steps[:, :, 0], steps[:, :, 1]), 1e-9)
        self.units = steps / self.lengths[:, :, None]
        self.headings = np.arctan2(self.units[:, :, 1], self.units[:, :, 0])
        self.before = np.cumsum(self.lengths, axis=1) - self.lengths
        self.absent = np.arange(self.starts.shape[1])[None, :] > self.lasts[:, None]

    def project(self, world: NDArray[np.int64], points: Array) -> tuple[Array, Array, Array, Array]:
        """Length along the route (m), distance to its left (m), its direction (rad) and its bend (1/m, to the left), for points of some worlds."""
        if not len(world):
            return np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0)
        offset = points[:, None, :] - self.starts[world]
        units, lengths = self.units[world], self.lengths[world]
        along = offset[:, :, 0] * units[:, :, 0] + offset[:, :, 1] * units[:, :, 1]
        left = units[:, :, 0] * offset[:, :, 1] - units[:, :, 1] * offset[:, :, 0]
        on = np.clip(along, 0.0, lengths)
        rows = np.arange(len(world))
        on[:, 0] = np.minimum(along[:, 0], lengths[:, 0])
        last = self.lasts[world]
        on[rows, last] = np.where(last > 0, np.maximum(along[rows, last], 0.0), along[rows, last])
        apart = (along - on) ** 2 + left**2
        apart[self.absent[world]] = np.inf
        best = np.argmin(apart, axis=1)
        one, two = np.maximum(best - 1, 0), np.minimum(best + 1, last)
        turn = np.remainder(self.headings[world, two] - self.headings[world, one] + np.pi, 2 * np.pi) - np.pi
        bend = turn / np.maximum(self.before[world, two] - self.before[world, one], 0.1)
        return self.before[world, best] + on[rows, best], left[rows, best], self.headings[world, best], bend


def serve(
    name: str, start: Callable[[dict[str, Any]], Callable[[Frame], tuple[Array, ...]]], control: str = "acceleration", wheel_angle: bool = False
) -> None:
    """Answer the frames on the standard input until it ends.

    ``start`` gets the greeting of the program and returns a function from a frame to accelerations (m/s^2) and steers, one for each world; with the
    control ``pedals`` to throttles, brakes and steers; with ``wheel_angle`` to angles of the front wheels (rad) instead of steers.
    """
    source, out = sys.stdin.buffer, answers()
    hello = json.loads(source.readline())
    decide = start(hello)
    greeting = {"protocol": hello["protocol"], "name": name, "encoding": "binary", "control": control, "wheel_angle": wheel_angle, "revision": 2}
    out.write(json.dumps(greeting).encode() + b"\n")
    out.flush()
    actors, points = int(hello["actors"]), int(hello["route_points"])
    width = _HEAD + (_ACTOR + 1) * actors + (_POINT + _LANE) * points
    while (body := _frame(source)) is not None:
        frame = Frame(np.frombuffer(body, np.dtype("<f8")).reshape(-1, width), actors, points)
        *pushes, steer = decide(frame)
        answer = np.zeros((len(frame.ids), 4))
        answer[:, 0], answer[:, 1 : 1 + len(pushes)], answer[:, 3] = frame.ids, np.column_stack(pushes), steer
        out.write(struct.pack("<I", answer.nbytes) + answer.astype("<f8").tobytes())
        out.flush()


def _frame(source: BinaryIO) -> bytes | None:
    """The bytes of the next message; none at the end of the input."""
    length = source.read(4)
    if len(length) < 4:
        return None
    size = struct.unpack("<I", length)[0]
    body = source.read(size)
    return body if len(body) == size else None
