"""Networks in ONNX files: onnxruntime runs those that the program runs, and the others are refused in the same words."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import shipped_network

_FLOATS: dict[str, type[np.floating[Any]]] = {"tensor(float)": np.float32, "tensor(double)": np.float64}


class Network:
    """A network with one output. Its inputs are 32-bit floats, which become 64-bit floats where the file wants those.

    It is pickled as its file's name, or as the file's bytes. One of a session of yours cannot be pickled.

    Args:
        model: A file, its bytes, or a session of onnxruntime.
        with_state: Whether a pair of an input ``NAME_in`` and an output ``NAME_out`` is state, and no input and no output.

    Raises:
        ValueError: It has other inputs than floats, or not exactly one output.
    """

    def __init__(self, model: Any, with_state: bool = False) -> None:
        self._with_state = with_state
        self._file: str | bytes | None = None
        if not hasattr(model, "get_inputs"):
            import onnxruntime

            self._file = model if isinstance(model, bytes) else os.path.abspath(model)
            model = onnxruntime.InferenceSession(self._file, providers=["CPUExecutionProvider"])
        self.session = model
        inputs, outputs = model.get_inputs(), model.get_outputs()
        names = [each.name for each in outputs] if with_state else []
        pairs = {each.name: f"{each.name[:-3]}_out" for each in inputs if each.name.endswith("_in") and f"{each.name[:-3]}_out" in names}
        #: The shape of each state, by the name of its input; a free length is a number of worlds, 1 here.
        self._states = {each.name: tuple(length if isinstance(length, int) else 1 for length in each.shape) for each in inputs if each.name in pairs}
        self._types = {each.name: _FLOATS.get(each.type, np.float32) for each in inputs}
        inputs, outputs = [each for each in inputs if each.name not in pairs], [each for each in outputs if each.name not in pairs.values()]
        self._wanted = [*(each.name for each in outputs), *pairs.values()]
        if not inputs or len(outputs) != 1:
            raise ValueError(f"the network needs at least one input and exactly one output, and has {len(inputs)} and {len(outputs)}")
        for each in inputs:
            if each.type not in _FLOATS:
                raise ValueError(f"the network's input `{each.name}` is a {each.type}; it must be 32-bit floats or 64-bit floats")
        #: The shape of each input, by its name; a free length is a text or `None`.
        self.shapes: dict[str, list[Any]] = {each.name: each.shape for each in inputs}
        #: What its file says of itself, such as the frames of its training.
        self.properties: dict[str, str] = dict(model.get_modelmeta().custom_metadata_map)
        #: The numbers of a row of its output; `None` if the file leaves it open.
        last = outputs[0].shape[-1] if outputs[0].shape else None
        self.width: int | None = last if isinstance(last, int) else None

    def __deepcopy__(self, _: dict[int, Any]) -> Network:
        # It remembers nothing, and a session has no copy.
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        if self._file is None:
            raise TypeError("a network of a session of onnxruntime cannot be pickled, since a session cannot; make it of the file")
        return type(self), (self._file, self._with_state)

    def zeros(self) -> dict[str, NDArray[np.float32]]:
        """Its states at the start of an episode."""
        return {name: np.zeros(shape, np.float32) for name, shape in self._states.items()}

    def step(self, numbers: Mapping[str, NDArray[np.float32]]) -> tuple[NDArray[Any], dict[str, NDArray[np.float32]]]:
        """Its output, and its states after it.

        Raises:
            ValueError: A state has another shape than before.
        """
        found, *states = self.session.run(self._wanted, {name: given.astype(self._types[name]) for name, given in numbers.items()})
        after = dict(zip(self._states, states))
        for name, shape in self._states.items():
            if after[name].shape != shape:
                raise ValueError(f"the network's state `{name}` has the shape {shape}, and its output {after[name].shape}")
        return np.asarray(found), after

    def answer(self, numbers: Mapping[str, NDArray[np.float32]]) -> NDArray[Any]:
        """Its output."""
        return self.step(numbers)[0]


def fits(shape: list[Any], *wanted: int | range) -> bool:
    """Whether a shape is one row, or any number of rows, of the lengths wanted."""
    one = len(shape) == len(wanted) + 1 and (shape[0] == 1 or not isinstance(shape[0], int))
    return one and all(
        isinstance(length, int) and (length in each if isinstance(each, range) else length == each) for length, each in zip(shape[1:], wanted)
    )


class Walker:
    """A pedestrian's network. One that takes several states gets the last ones of an episode, the oldest first, with zeros before its start.
    :func:`falsify_av.evaluate` calls :meth:`check`. It is pickled with what it has seen.

    Raises:
        ValueError: The network has other inputs than one of states.
    """

    def __init__(self, network: Network) -> None:
        [(name, shape), *more] = network.shapes.items()
        if more or not fits(shape, range(1, 1 << 16)):
            raise ValueError("a pedestrian's network has one input, of the shape (1, n) or (batch, n)")
        self._network, self._name = network, name
        self._width, self._one_by_one = shape[1], shape[0] == 1
        #: The pedestrians that it moves, each by itself.
        self._agents = 1
        self._past: NDArray[np.float32] | None = None

    def check(self, env: Any) -> None:
        """Compare its training, as far as its file says, with an environment of :func:`falsify_av.make` or ``make_vec``.

        A network of one pedestrian, as trainings with ``policies`` write, then moves each pedestrian of a cast by itself.

        Raises:
            ValueError: Its states or actions have other frames or units than those of the environment, as in a campaign with another ``body``.

        Warns:
            UserWarning: It was trained with another body, or another time of a decision.
        """
        core = getattr(env, "unwrapped", env).core
        shared = core.pedestrians > 1 and self._network.width == 2
        reason, difference = core.unfit(self._network.properties, self._width, shared)
        if reason:
            raise ValueError(f"the network cannot walk in this scenario: {reason}; give its campaign the `body` of its training: `pursuer` for `hunter`, `child_pursuer` for `hunter_child` of std/pedestrians.scn")
        if difference:
            warnings.warn(f"the network was trained otherwise: {difference}", stacklevel=3)
        self._agents = core.pedestrians if shared else 1

    def begin(self, worlds: NDArray[np.bool_]) -> None:
        """Forget what was seen in the worlds of a mask, whose episodes begin."""
        worlds = np.repeat(worlds, self._agents)
        if self._past is None or len(self._past) != len(worlds):
            self._past = np.zeros((len(worlds), self._width), np.float32)
        self._past[worlds] = 0

    def __call__(self, states: NDArray[np.float32]) -> NDArray[Any]:
        worlds = len(states)
        states = states.reshape(worlds * self._agents, -1)
        numbers = states.shape[1]
        if self._width % numbers:
            raise ValueError(
                f"the network takes {self._width} numbers, and a state of this scenario has {numbers}: if it moves one pedestrian of several, call `check(env)` first"
            )
        if self._width > numbers:
            if self._past is None:
                raise ValueError("the network takes several states: call `begin` where episodes begin, as `falsify_av.evaluate` does")
            self._past = np.concatenate([self._past[:, numbers:], states], axis=1)
            states = self._past
        if self._one_by_one:
            actions = np.array([self._network.answer({self._name: state[None]}).ravel() for state in states])
        else:
            actions = self._network.answer({self._name: states})
        return actions.reshape(worlds, -1)


def onnx(path: str | os.PathLike[str]) -> Walker:
    """A pedestrian of an ONNX file, such as those in ``pedestrians`` of a report: one input of states, and actions as its output.

    It needs ``pip install falsify-av[onnx]``. A scenario's ``pedestrian mine = onnx(model: …)`` needs no onnxruntime. The two compute the same
    function with other last bits, so digests differ, outcomes seldom. ``check(env)`` of it refuses an environment with other states or actions.

    Raises:
        ValueError: The file is no such network.
    """
    return Walker(Network(path))


def hunter(body: str = "adult") -> Walker:
    """The trained pedestrian that comes with the program: ``hunter``, or ``hunter_child`` for the body ``"child"``.

    It walks in scenarios with the body ``pursuer`` (``child_pursuer``) and needs ``pip install falsify-av[onnx]``. ``hunter`` sees the road: it
    takes three states of twelve numbers, ``hunter_child`` three of four.

    Raises:
        ValueError: There is none with this body.
    """
    names = {"adult": "hunter.onnx", "child": "hunter_child.onnx"}
    if body not in names:
        raise ValueError(f"no trained pedestrian has the body {body!r}; there are {', '.join(map(repr, names))}")
    return Walker(Network(shipped_network(names[body])))
