"""Other simulators as worlds: the bridges that ship, and what serves a bridge.

Each is a program that a scenario names, ``world metadrive = bridge(command: "metadrive")``, and that
``falsify check --world metadrive`` tries. ``docs/src/how-to/worlds.md`` says what each simulator is and can do, and
``docs/src/how-to/bridge.md`` describes the messages.
"""

from __future__ import annotations

import json
import sys
from typing import Any, Protocol

from ..answers import answers
from ..stacks import Stack

Message = dict[str, Any]

#: The bridges by their names: what each needs.
BRIDGES = {
    "metadrive": Stack(
        "metadrive", "MetaDrive", ("metadrive", "sumolib", "sumo"), "metadrive-simulator==0.4.3 eclipse-sumo==1.28.0 sumolib==1.28.0", (3, 11)
    ),
    "sumo": Stack("sumo", "SUMO", ("libsumo", "sumo"), "libsumo==1.28.0 eclipse-sumo==1.28.0"),
    "carla": Stack("carla", "CARLA's client", ("carla",), "carla==0.9.16"),
    # Its library is built by the user, and the bridge says how.
    "esmini": Stack("esmini", "esmini", (), ""),
}


class World(Protocol):
    """A simulator behind a bridge. The messages are those of the protocol; lengths are in m, times in s, angles in rad."""

    #: The greeting without the protocol: `name`, `version`, `drivers`, `pedal_delay`, `friction`, `lights`, `seeds`.
    about: Message

    def load(self, message: Message) -> list[tuple[float, float]] | None:
        """Load a town; the nearest place on the middle of a lane for each of `message["lanes"]`, or None if it has no lanes."""

    def begin(self, message: Message) -> Message:
        """Place the actors; the first state."""

    def step(self, message: Message) -> Message:
        """Move on one tick; the state after it."""


#: What an option of a bridge may be: a word without a value, a whole number, one of some words, or any text, which is named.
Kind = None | range | tuple[str, ...] | str


def chosen(bridge: str, words: list[str], **kinds: Kind) -> dict[str, Any]:
    """The values of the options that are given, `True` for one without a value; ends the program with a line for one that is wrong."""
    found: dict[str, Any] = {}
    for word in words:
        name, equals, value = word.partition("=")
        if name not in kinds:
            raise SystemExit(f"{bridge} has no option {name}; it has {', '.join(kinds) or 'none'}")
        kind = kinds[name]
        if kind is None:
            valid, form = not equals, f"{name} without a value"
        elif isinstance(kind, range):
            valid, form = value.isascii() and value.isdigit() and len(value) < 9 and int(value) in kind, f"{name}={kind[0]}..{kind[-1]}"
        elif isinstance(kind, tuple):
            valid, form = value in kind, f"{name}=WORD, one of {', '.join(kind)}"
        else:
            valid, form = value != "", f"{name}={kind}"
        if not valid or name in found:
            raise SystemExit(f"{bridge}: {word} is not valid: give {form}, once")
        found[name] = True if kind is None else int(value) if isinstance(kind, range) else value
    return found


#: A car that has stopped rocks on its springs: a speed backwards below this (m/s) is none.
ROCKING = 0.05


def state(x: float, y: float, yaw: float, speed: float, pedestrians: list[tuple[float, float]]) -> Message:
    """A state for an answer."""
    speed = 0.0 if -ROCKING < speed < 0.0 else speed
    return {"ego": {"x": x, "y": y, "yaw": yaw, "speed": speed}, "pedestrians": pedestrians}


def answer(world: World, line: bytes) -> bytes:
    """The answer to a message."""
    message = json.loads(line)
    kind = message["type"]
    if kind == "hello":
        said = {"protocol": message["protocol"], **world.about}
    elif kind == "load":
        said = {"lanes": world.load(message)}
    elif kind == "begin":
        said = {"tick": 0, **world.begin(message)}
    else:
        said = {"tick": message["tick"], **world.step(message)}
    return json.dumps(said).encode() + b"\n"


def serve(world: World) -> None:
    """Answer the messages on the standard input until it ends."""
    out = answers()
    for line in sys.stdin.buffer:
        out.write(answer(world, line))
        out.flush()
