"""A pedestrian that is a Python callable, as a program that campaigns name: ``controller mine = external(command: "python3 mine.py")``."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

_PROTOCOL = "falsify-pedestrian/1"


def serve(choose: Callable[[NDArray[np.float64]], Any]) -> None:
    """Answer the messages on the standard input until it ends. ``choose`` gets the states of some worlds, one a row, and returns an action for
    each, as the callables of :func:`falsify_av.evaluate` do.
    """
    for line in sys.stdin:
        request = json.loads(line)
        if request["type"] == "hello":
            answer: dict[str, Any] = {"protocol": _PROTOCOL, "name": "falsify_av"}
        else:
            worlds = request["worlds"]
            actions = np.asarray(choose(np.array([world["state"] for world in worlds])), np.float64)
            answer = {"actions": [{"id": world["id"], "action": action.tolist()} for world, action in zip(worlds, actions)]}
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()
