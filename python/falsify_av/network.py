"""Networks in ONNX files: onnxruntime runs those that the program runs, and the others are refused in the same words."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .pedestrians import Pedestrian

_FLOATS: dict[str, type[np.floating[Any]]] = {"tensor(float)": np.float32, "tensor(double)": np.float64}


class Network:
    """A network with one output. Its inputs are 32-bit floats, which become 64-bit floats where the file wants those.

    Args:
        model: A file, or a session of onnxruntime.

    Raises:
        ValueError: It has other inputs than floats, or not exactly one output.
    """

    def __init__(self, model: Any) -> None:
        if not hasattr(model, "get_inputs"):
            import onnxruntime

            model = onnxruntime.InferenceSession(os.fspath(model), providers=["CPUExecutionProvider"])
        self.session = model
        inputs, outputs = model.get_inputs(), model.get_outputs()
        if not inputs or len(outputs) != 1:
            raise ValueError(f"the network needs at least one input and exactly one output, and has {len(inputs)} and {len(outputs)}")
        for each in inputs:
            if each.type not in _FLOATS:
                raise ValueError(f"the network's input `{each.name}` is a {each.type}; it must be 32-bit floats or 64-bit floats")
        #: The shape of each input, by its name; a free length is a text or `None`.
        self.shapes: dict[str, list[Any]] = {each.name: each.shape for each in inputs}
        self._types = {each.name: _FLOATS[each.type] for each in inputs}

    def answer(self, numbers: Mapping[str, NDArray[np.float32]]) -> NDArray[Any]:
        """Its output."""
        [found] = self.session.run(None, {name: given.astype(self._types[name]) for name, given in numbers.items()})
        return np.asarray(found)


def fits(shape: list[Any], *wanted: int | range) -> bool:
    """Whether a shape is one row, or any number of rows, of the lengths wanted."""
    one = len(shape) == len(wanted) + 1 and (shape[0] == 1 or not isinstance(shape[0], int))
    return one and all(
        isinstance(length, int) and (length in each if isinstance(each, range) else length == each) for length, each in zip(shape[1:], wanted)
    )


def onnx(path: str | os.PathLike[str]) -> Pedestrian:
    """A pedestrian of an ONNX file, such as those in ``pedestrians`` of a report: one input of states, and actions as its output.

    It needs ``pip install falsify-av[onnx]``. A scenario's ``controller mine = onnx(model: …)`` needs no onnxruntime. The two compute the same
    function with other last bits, so digests differ, outcomes seldom.

    Raises:
        ValueError: The file is no such network. A network that takes several states (``frame_stack``) walks only in a scenario, as a ``controller``.
    """
    network = Network(path)
    [(name, shape), *more] = network.shapes.items()
    if more or not fits(shape, range(1, 1 << 16)):
        raise ValueError("a pedestrian's network has one input, of the shape (1, n) or (batch, n)")
    width, one_by_one = shape[1], shape[0] == 1

    def choose(states: NDArray[np.float32]) -> NDArray[Any]:
        if states.shape[1] != width:
            raise ValueError(f"the network takes {width} numbers, and a state of this scenario has {states.shape[1]}")
        if one_by_one:
            return np.array([network.answer({name: state[None]}).ravel() for state in states])
        return network.answer({name: states})

    return choose
