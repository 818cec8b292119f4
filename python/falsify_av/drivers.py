"""Drivers under test that are Python objects: a class of your own, or a network in an ONNX file.

A driver has one method ``drive(world)``. It gets what a driver in a separate program gets (``scenarios/external/README.md``): ``ego``,
``speed_limit``, ``light``, ``sign``, ``actors`` and ``route``, in the world's frame, in m, s and rad. It returns ``throttle`` and ``brake`` (0 to 1) or
``acceleration`` (m/s^2), and ``steer`` (-1 to 1, positive to the left) or ``wheel_angle`` (rad). Steer along ``route``: it leads to the start of the episode, and a driver
that does not get there starts at rest. Where the road ends it is empty: brake there. A method ``reset(hello, seed)`` is called before each episode, if there is
one: ``hello`` describes the car and has the ``parameters`` of the scenario, and ``seed`` is the only source of random numbers. A class with ``revision = 2`` also gets ``lanes``, and the ids
of actors.

``falsify_av.make("my.scn", own_driver=MyDriver)`` puts it in the place of the scenario's driver, in this process. ``serve(MyDriver)`` makes a program of
it that campaigns name: ``driver mine = external(command: "python3 mine.py")``. The driver perceives and does the same in both. Each world has a
driver of its own.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .answers import answers
from .network import Network, fits
from .suggestion import suggested

_GREETING = {"protocol": "falsify-av/1", "name": "falsify_av"}
_LIGHTS = {"green": 1.0, "yellow": 2.0, "red": 3.0}
_PEDALS = ("throttle", "brake")
_CONTROLS = (*_PEDALS, "acceleration", "steer", "wheel_angle", "mode")
#: The lengths of each input of a network, besides its first, and its shape in words.
_INPUTS: dict[str, tuple[tuple[int | range, ...], str]] = {
    "ego": ((4,), "(1, 4)"),
    "actors": ((range(1, 65), 8), "(1, K, 8) with K from 1 to 64"),
    "route": ((range(1, 41), 3), "(1, R, 3) with R from 1 to 40"),
}
_OUTPUTS = {2: ("acceleration", "steer"), 3: ("throttle", "brake", "steer")}
_NOTHING: dict[str, Any] = {
    "ego": {"x": 0.0, "y": 0.0, "yaw": 0.0, "speed": 0.0}, "speed_limit": 0.0, "light": None, "actors": [], "route": []
}
_MODES = ("cruise", "turn", "follow", "yield", "emergency_stop", "red_light", "give_way", "arrived", "unknown")


class Driver(Protocol):
    """A driver under test. ``reset(hello, seed)`` may be there, too."""

    def drive(self, world: dict[str, Any]) -> Mapping[str, Any]:
        """Choose the control of the next tick."""
        ...


class _Answers:
    """The messages of a program, answered by drivers: one for each world."""

    def __init__(self, make: Callable[[], Driver]) -> None:
        self._make = make
        self._revision = {"revision": int(make.revision)} if hasattr(make, "revision") else {}
        self._hello: dict[str, Any] = {}
        self._drivers: dict[int, Driver] = {}

    def _made(self) -> Driver:
        driver = self._make()
        if not callable(getattr(driver, "drive", None)):
            raise TypeError(f"the driver is {type(driver).__name__}, which has no method `drive`")
        return driver

    def __call__(self, message: bytes) -> bytes:
        request = json.loads(message)
        if request["type"] == "hello":
            self._hello = request
            return json.dumps({**_GREETING, **self._revision}).encode()
        return json.dumps({"actions": [self._drive(world) for world in request["worlds"]]}).encode()

    def _drive(self, world: dict[str, Any]) -> dict[str, Any]:
        number = world["id"]
        if number not in self._drivers:
            self._drivers[number] = self._made()
        driver = self._drivers[number]
        reset = getattr(driver, "reset", None)
        if "seed" in world and reset is not None:
            reset(self._hello, world["seed"])
        return {"id": number, **_checked(driver.drive(world))}


def _checked(control: Mapping[str, Any]) -> dict[str, Any]:
    """The control of a tick with its numbers as floats.

    Raises:
        TypeError: It is no mapping, or a value has the wrong type.
        ValueError: A key is unknown, a number is not finite, or it says nothing of the speed.
    """
    if not isinstance(control, Mapping):
        raise TypeError(f"drive returned {type(control).__name__}; return a dict with throttle and brake or acceleration, and steer")
    checked: dict[str, Any] = {}
    for key, value in control.items():
        if key == "id":
            continue
        if key not in _CONTROLS:
            raise ValueError(f"the driver gave a wrong answer: an action has no key `{key}`; {suggested(key, _CONTROLS)}")
        if (key == "mode") != isinstance(value, str):
            wanted = "a text" if key == "mode" else "a number"
            raise TypeError(f"the driver gave a wrong answer: `{key}` is {value!r}, which is not {wanted}")
        if key == "mode" and value not in _MODES:
            raise ValueError(f"the driver gave a wrong answer: there is no mode `{value}`; {suggested(value, _MODES)}")
        if key != "mode":
            try:
                value = float(value)
            except (TypeError, ValueError):
                kind = type(value).__name__
                raise TypeError(f"the driver gave a wrong answer: `{key}` is of the type {kind}, which is not a number") from None
            if not math.isfinite(value):
                raise ValueError(f"the driver gave a wrong answer: `{key}` is {value}, which is not finite")
        checked[key] = value
    pedals = any(key in checked for key in _PEDALS)
    if pedals == ("acceleration" in checked):
        what = "both acceleration and pedals" if pedals else "neither throttle, brake nor acceleration"
        raise ValueError(f"the driver gave a wrong answer: an action with {what}")
    if "steer" in checked and "wheel_angle" in checked:
        raise ValueError("the driver gave a wrong answer: an action with both steer and wheel_angle")
    return checked


def answering(make: Callable[[], Driver]) -> Callable[[], Callable[[bytes], bytes]]:
    """A maker of functions from messages to answers."""
    if not callable(make):
        raise TypeError(f"driver is {type(make).__name__}; give a class, or a function without arguments that makes a driver")
    return lambda: _Answers(make)


def serve(make: Callable[[], Driver]) -> None:
    """Answer the messages on the standard input until it ends, as a program that a scenario names.

    What anything prints on the standard output meanwhile goes to the standard error.
    """
    answer, out = _Answers(make), answers()
    for line in sys.stdin.buffer:
        out.write(answer(line) + b"\n")
        out.flush()


class OnnxDriver:
    """A network with the inputs ``ego``, ``actors`` and ``route`` as `scenarios/external/README.md` describes them.

    A file that the program refuses raises a ``ValueError`` here, too. It runs in onnxruntime: ``own_driver=lambda: OnnxDriver("net.onnx")``, or with a session of your own. A scenario's ``driver p = onnx(model: …)``
    needs no onnxruntime. A pair of an input ``NAME_in`` and an output ``NAME_out`` is state, 0 at the start of an episode. The two compute the same function with other last bits, so episodes drift apart: digests differ, outcomes seldom.
    """

    def __init__(self, model: Any) -> None:
        self._network = Network(model, with_state=True)
        for name, shape in self._network.shapes.items():
            if name not in _INPUTS:
                known = ", ".join(f"`{each}`" for each in _INPUTS)
                raise ValueError(f"the network's input `{name}` is none of {known}, and no state: `NAME_in` with an output `NAME_out`")
            lengths, wanted = _INPUTS[name]
            if not fits(shape, *lengths):
                raise ValueError(f"the network's input `{name}` must have the shape {wanted}, and has {tuple(shape)}")
        self._state = self._network.zeros()
        count = self._answer(_NOTHING)[0].size
        if count not in _OUTPUTS:
            raise ValueError(f"the network's output has {count} numbers instead of two (acceleration, steer) or three (throttle, brake, steer)")

    def reset(self, hello: dict[str, Any], seed: int) -> None:
        """Forget the last episode."""
        self._state = self._network.zeros()

    def drive(self, world: dict[str, Any]) -> dict[str, float]:
        """Run the network."""
        numbers, self._state = self._answer(world)
        return {name: float(number) for name, number in zip(_OUTPUTS[numbers.size], numbers)}

    def _answer(self, world: dict[str, Any]) -> tuple[NDArray[Any], dict[str, NDArray[np.float32]]]:
        seen = {name: self._input(name, shape, world) for name, shape in self._network.shapes.items()}
        found, state = self._network.step({**seen, **self._state})
        return found.ravel(), state

    def _input(self, name: str, shape: list[Any], world: dict[str, Any]) -> NDArray[np.float32]:
        ego = world["ego"]
        sin, cos = math.sin(ego["yaw"]), math.cos(ego["yaw"])

        def turned(x: float, y: float) -> tuple[float, float]:
            return cos * x + sin * y, cos * y - sin * x

        def place(x: float, y: float, yaw: float) -> tuple[float, float, float]:
            return (*turned(x - ego["x"], y - ego["y"]), math.remainder(yaw - ego["yaw"], 2 * math.pi))

        if name == "ego":
            light = world["light"]
            seen = (_LIGHTS[light["colour"]], light["distance"]) if light else (0.0, 0.0)
            return np.array([[ego["speed"], world["speed_limit"], *seen]], np.float32)
        if name == "actors":
            rows = [
                [1.0, *place(each["x"], each["y"], each["yaw"]), *turned(each["vx"], each["vy"]), each["length"], each["width"]]
                for each in world["actors"]
            ]
            empty = [0.0] * 8
        else:
            rows = [list(place(*point)) for point in world["route"]]
            empty = rows[-1] if rows else [0.0] * 3
        count = shape[1]
        return np.array([(rows + [empty] * count)[:count]], np.float32)
