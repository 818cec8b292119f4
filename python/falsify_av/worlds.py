"""The worlds that every environment of this package steps: how they are made, what their numbers mean, and when they are closed."""

from __future__ import annotations

import operator
import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from . import _core
from .drivers import Driver, answering
from .scenarios import Files, Selection, choose

if TYPE_CHECKING:
    from typing_extensions import Self

#: The numbers of an observation of one pedestrian, in order.
OBSERVATION = ("bearing", "distance", "relative_heading", "speed")
#: The numbers of an action of one pedestrian, in order.
ACTION = ("heading", "speed")

# Bounds that no episode reaches: a car of 1,000 km/h drives 28 km in 100 s.
_FARTHEST, _FASTEST = 1e5, 1e3
#: Pixels of a picture from side to side.
SIZE = 256
#: The share of run-ups that a driver may fail without a warning: that of reports.
_FAILED = 0.05


class Options(Selection, total=False):
    """The options of environments besides the scenario, its campaign and the seed."""

    #: A class, or a function without arguments, that makes the driver under test; it takes the place of the scenario's driver.
    own_driver: Callable[[], Driver] | None


class RunUpWarning(UserWarning):
    """The driver often does not reach the starts of its episodes, as one that does not follow ``route``. It starts there at rest."""


def failed_run_ups(failed: int, all_of_them: int) -> str:
    """The text of the warning; empty if no more than a twentieth of the run-ups failed."""
    if failed <= _FAILED * all_of_them:
        return ""
    return (
        f"the driver did not reach its start in {failed} of {all_of_them} run-ups, and was placed there at rest: see whether it steers along "
        "`route`; `placed` is true in the infos and the rows of these episodes"
    )


def observation_space(worlds: _core.Worlds, agent: int | None = None) -> spaces.Space[NDArray[np.float32]]:
    """The states of one of the controlled pedestrians, or of all, one after another."""
    low: list[float] = []
    high: list[float] = []
    for number, (_, scaled, further) in enumerate(worlds.agents()):
        if agent in (None, number):
            most = np.array([np.pi, _FARTHEST, np.pi, _FASTEST], np.float32)
            if scaled:
                most = (most / np.array([np.pi, 30.0, np.pi, 8.0])).astype(np.float32)
            low += [*(most * np.array([-1, 0, -1, 0], np.float32)), *(bounds[0] for bounds in further)]
            high += [*most, *(bounds[1] for bounds in further)]
    box = spaces.Box(np.array(low, np.float32), np.array(high, np.float32), dtype=np.float32)
    return cast("spaces.Space[NDArray[np.float32]]", box)


def action_space(worlds: _core.Worlds, agent: int | None = None) -> spaces.Space[NDArray[np.float32]]:
    """The actions of one of the controlled pedestrians, or of all, one after another."""
    bounds = np.array(worlds.action_bounds(), np.float32)
    bounds = bounds if agent is None else bounds[2 * agent : 2 * agent + 2]
    return cast("spaces.Space[NDArray[np.float32]]", spaces.Box(bounds[:, 0], bounds[:, 1], dtype=np.float32))


def make_worlds(count: int, scenario: Files | None, seed: int, options: Mapping[str, Any]) -> _core.Worlds:
    """Worlds of one scenario of the files; ``options`` are those of :func:`make`."""
    options = dict(options)
    driver = options.pop("own_driver", None)
    made = None if driver is None else answering(driver)
    return choose(scenario, options).worlds(count, checked_seed(seed), made)


def whole(what: str, number: Any) -> int:
    """A whole number, as it was given."""
    try:
        if isinstance(number, (bool, np.bool_)):
            raise TypeError
        return operator.index(number)
    except TypeError:
        raise TypeError(f"{what} is {number!r}, which is no whole number") from None


def checked_seed(seed: Any) -> int:
    """A seed from 0 to 2^63 - 1."""
    number = whole("the seed", seed)
    if not 0 <= number < 2**63:
        raise ValueError(f"the seed is {number}; give one from 0 to 2^63 - 1")
    return number


def episode_option(options: Mapping[str, Any] | None) -> int:
    """The number of the episode in the options of a reset; -1 for the next one."""
    if not options:
        return -1
    unknown = set(options) - {"episode"}
    if unknown:
        raise ValueError(f"reset has no option {', '.join(sorted(map(str, unknown)))}; there is `episode`")
    episode = whole("the number of the episode", options["episode"])
    if episode < 0:
        raise ValueError(f"the number of the episode is {episode}; episodes count from 0")
    return episode


def numbers_of(action: Any, shape: tuple[int, ...] | None) -> NDArray[Any]:
    """An action as an array of 32 or 64 bits a number."""
    try:
        numbers = np.asarray(action)
    except ValueError as error:
        raise ValueError(f"the action is no array of numbers: {error}") from error
    if numbers.dtype not in (np.float32, np.float64):
        if numbers.dtype.kind not in "iuf":
            raise TypeError(f"the action has elements of type {numbers.dtype}; this needs float32 or float64")
        numbers = numbers.astype(np.float64)
    if numbers.shape != shape:
        raise ValueError(f"the action has the shape {numbers.shape}; this needs {shape}")
    return numbers


def started(core: _core.Worlds, world: int) -> dict[str, Any]:
    """The info of an episode that has just started."""
    place = core.place(world)
    if place is None:
        return {}
    ticks, placed = core.run_up(world)
    return {"seed": place[0], "episode_number": place[1], "run_up_ticks": ticks, "placed": placed}


def _again(kind: type[Any], words: tuple[Any, ...], options: dict[str, Any]) -> Any:
    """An environment from the arguments of another one."""
    return kind(*words, **options)


class Closable:
    """The compiled worlds of an environment, until it is closed.

    It is pickled and copied as its arguments: the files are read again, and the copy is open and begins as a new one does, without an episode that is under way.
    """

    core: _core.Worlds
    render_mode: str | None
    _closed = False
    _warned = False
    _arguments: tuple[tuple[Any, ...], dict[str, Any]]

    def __new__(cls, *words: Any, **options: Any) -> Self:
        """Remember the arguments."""
        made = super().__new__(cls)
        made._arguments = words, options
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        """Its arguments, and what Gymnasium's registry says of it."""
        return _again, (type(self), *self._arguments), {name: value for name, value in vars(self).items() if name == "spec"}

    def _make(
        self, count: int, scenario: Files | None, campaign: str | None, seed: int, render_mode: str | None, options: Mapping[str, Any]
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            human = ", which gymnasium.wrappers.HumanRendering shows in a window (it needs pygame)" if render_mode == "human" else ""
            raise ValueError(f"there is no render mode {render_mode!r}; there is 'rgb_array'{human}")
        self.core = make_worlds(count, scenario, seed, {"campaign": campaign, **options})
        self.render_mode = render_mode

    def _open(self) -> _core.Worlds:
        if self._closed:
            raise RuntimeError("the environment is closed")
        return self.core

    def _began(self) -> None:
        """Warn once, when more than a twentieth of the run-ups up to now has failed."""
        text = "" if self._warned else failed_run_ups(*self.core.run_ups())
        if text:
            self._warned = True
            warnings.warn(text, RunUpWarning, stacklevel=3)
