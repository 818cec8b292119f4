"""Recordings of others as traces of ASAM OSI, which ``falsify judge`` reads: ``python3 -m falsify_av.recordings FORMAT FILE OUT.osi``.

A reader gives the instants of a recording; what reads its files is the library of its format.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

VEHICLE, PEDESTRIAN = 2, 3
"""Kinds of moving objects, as numbers of OSI."""


class Unreadable(Exception):
    """Why a recording cannot be read: one sentence for the user."""


@dataclass(frozen=True)
class Actor:
    """A car or a pedestrian at an instant: the middle (m), heading (rad, from x to y), length and width (m, 0 if unknown), and velocity (m/s)."""

    name: int
    kind: int
    x: float
    y: float
    yaw: float
    length: float
    width: float
    velocity: tuple[float, float] | None


@dataclass(frozen=True)
class Instant:
    """All actors at a time (s), and the name of the car that recorded, if one did."""

    time: float
    actors: list[Actor]
    host: int | None = None


def _varint(number: int) -> bytes:
    parts = bytearray()
    while number > 127:
        parts.append(number & 127 | 128)
        number >>= 7
    return bytes([*parts, number])


def _whole(field: int, number: int) -> bytes:
    return _varint(field << 3) + _varint(number)


def _part(field: int, inner: bytes) -> bytes:
    return _varint(field << 3 | 2) + _varint(len(inner)) + inner


def _triple(field: int, *numbers: float) -> bytes:
    return _part(field, b"".join(_varint(place << 3 | 1) + struct.pack("<d", number) for place, number in enumerate(numbers, 1)))


def _message(instant: Instant) -> bytes:
    """A ``GroundTruth`` of OSI 3, with the fields that ``falsify judge`` reads."""
    seconds, nanos = divmod(round(instant.time * 1e9), 10**9)
    message = _part(2, _whole(1, seconds) + _whole(2, nanos))
    if instant.host is not None:
        message += _part(3, _whole(1, instant.host))
    for actor in instant.actors:
        base = _triple(1, actor.length, actor.width, 1.7) + _triple(2, actor.x, actor.y, 0.0) + _triple(3, 0.0, 0.0, actor.yaw)
        if actor.velocity is not None:
            base += _triple(4, *actor.velocity, 0.0)
        message += _part(5, _part(1, _whole(1, actor.name)) + _part(2, base) + _whole(3, actor.kind))
    return message


def write(path: Path, instants: Iterable[Instant]) -> int:
    """Write a trace in the binary form of OSI, messages with their lengths before them; the number of instants."""
    messages = [_message(instant) for instant in instants]
    if len(messages) < 2:
        raise Unreadable("it has fewer than two instants with cars or pedestrians")
    path.write_bytes(b"".join(struct.pack("<I", len(message)) + message for message in messages))
    return len(messages)
