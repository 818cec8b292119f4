"""A pedestrian that is a Python callable, as a program that campaigns name: ``pedestrian mine = external(command: "python3 mine.py")``."""

from __future__ import annotations

import json
import sys
from copy import deepcopy
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .answers import answers

_PROTOCOL = "falsify-pedestrian/1"


#: Takes the states of some worlds, one a row, in 32-bit floats, and returns an action for each.
Pedestrian = Callable[[NDArray[np.float32]], ArrayLike]


def serve(choose: Pedestrian) -> None:
    """Answer the messages on the standard input until it ends. ``choose`` is called as :func:`falsify_av.evaluate` calls it.

    One with memory, which has a method ``begin``, is copied for each world, since worlds ask by turns.

    What anything prints on the standard output meanwhile goes to the standard error.
    """
    out = answers()
    walkers: dict[int, Any] = {}

    def remembered(world: dict[str, Any], state: NDArray[np.float32]) -> NDArray[Any]:
        if world["id"] not in walkers:
            walkers[world["id"]] = deepcopy(choose)
        walker = walkers[world["id"]]
        if world["tick"] == 0:
            walker.begin(np.ones(1, np.bool_))
        action: NDArray[Any] = np.asarray(walker(state[None]))[0]
        return action

    for line in sys.stdin:
        request = json.loads(line)
        if request["type"] == "hello":
            answer: dict[str, Any] = {"protocol": _PROTOCOL, "name": "falsify_av"}
        else:
            worlds = request["worlds"]
            states = np.array([world["state"] for world in worlds], np.float32)
            chosen = [remembered(*each) for each in zip(worlds, states)] if hasattr(choose, "begin") else choose(states)
            actions = np.asarray(chosen, np.float64)
            answer = {"actions": [{"id": world["id"], "action": action.tolist()} for world, action in zip(worlds, actions)]}
        out.write(json.dumps(answer).encode() + b"\n")
        out.flush()
