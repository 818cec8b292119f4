"""Gymnasium environments of scenarios.

An action is two numbers for each pedestrian: ``heading`` (rad, from the direction that the body's ``action_frame`` names, positive to
the left) and ``speed`` (m/s). It is kept for the ticks that the scenario's ``hold`` says. An observation is four numbers for each pedestrian:
``bearing`` of the car (rad, positive to the left), ``distance`` between the centres (m), ``relative_heading`` of the car (rad) and ``speed``
(m/s). A body with ``action_scaling: unit`` takes actions in [-1, 1], one with ``observation_scaling: unit`` gives states divided by
(pi, 30 m, pi, 8 m/s). A body with ``road: true`` adds eight numbers, ``rays`` and ``others`` more (``falsify explain state``).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from .scenarios import Files
from .worlds import SIZE, Closable, action_space, checked_seed, episode_option, numbers_of, observation_space, started

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .worlds import Options


class PedestrianEnv(Closable, gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """One scenario as a Gymnasium environment.

    ``reset(seed=s)`` starts episode 0 of the seed ``s``, and every further ``reset()`` the next one. Episode *k* of a seed has the start that
    episode *k* has in the evaluations of a campaign that is run with this seed. ``reset(options={"episode": k})`` starts episode *k*. An
    environment that is never given a seed uses ``seed``, so its results repeat.

    It can be pickled and copied, if ``own_driver`` can: a copy is made from the same arguments. It reads the files again, and begins as a new one does: the
    seed of a reset and an episode that is under way are not kept.

    Args:
        scenario: A scenario file, or several; without one the paper's scenario.
        campaign, town, driver, reward, task, block: Names that choose one scenario of the files (:func:`falsify_av.scenarios` lists them).
        seed: The seed until a reset gives another one; 1 is the default of the program, too.
        settings: Values of parameters and keys, as ``["far=20 m"]``.
        maps: OpenDRIVE files that replace the roads of towns.
        allow_external: Whether the scenario may start programs as drivers.
        own_driver: A class, or a function without arguments, that makes the driver under test; it takes the place of the scenario's driver
            (:mod:`falsify_av.drivers`). An exception of a driver is raised by the call in which it drove.
        render_mode: ``"rgb_array"`` for pictures from above (256 by 256 pixels, 60 m, north up), or none.

    Warns:
        RunUpWarning: The driver did not reach more than a twentieth of its starts; ``placed`` of the info is then true.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 1}

    def __init__(
        self,
        scenario: Files | None = None,
        campaign: str | None = None,
        *,
        seed: int = 1,
        render_mode: str | None = None,
        **options: Unpack[Options],
    ) -> None:
        self._make(1, scenario, campaign, seed, render_mode, options)
        self.observation_space = observation_space(self.core)
        self.action_space = action_space(self.core)
        tick, hold, _ = self.core.timing
        self.metadata = {**type(self).metadata, "render_fps": max(1, round(1 / (tick * hold)))}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Start an episode. See the class for the meaning of ``seed`` and ``options``."""
        core, episode = self._open(), episode_option(options)
        if seed is not None:
            seed = checked_seed(seed)
        super().reset(seed=seed)
        if seed is not None:
            core.reseed(np.array([seed], np.int64))
        states = core.reset(np.ones(1, np.bool_), np.array([episode], np.int64))
        self._began()
        return states[0], started(core, 0)

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Take one decision. At the end of an episode the info has its outcome and the verdict of the reference drivers."""
        core = self._open()
        numbers = numbers_of(action, self.action_space.shape)
        states, rewards, terminated, truncated, _ = core.step(numbers[None], "never")
        over = bool(terminated[0] or truncated[0])
        info = core.end(0) if over else {}
        return states[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), info or {}

    def render(self) -> NDArray[np.uint8] | None:
        """The view from above, if the environment was made with ``render_mode="rgb_array"``."""
        core = self._open()
        return core.picture(0, SIZE) if self.render_mode == "rgb_array" else None

    def suggested(self, pedestrian: str) -> NDArray[np.float64]:
        """The action that the built-in pedestrian ``"homing"`` or ``"intercept"`` would take now."""
        return self._open().suggested(0, pedestrian)

    def trace(self) -> dict[str, Any]:
        """The episode from tick to tick, as arrays (m, rad, s, m/s). Arrays of pedestrians have a column for each."""
        return self._open().trace(0)

    def close(self) -> None:
        """End the use of the environment; further calls raise ``RuntimeError``."""
        self._closed = True
        super().close()


class PedestrianVectorEnv(Closable, VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[Any]]):
    """Several worlds of one scenario, stepped on all cores. World *i* behaves as a :class:`PedestrianEnv` with the seed ``seed + i``.
    It is pickled and copied as one.

    Args:
        num_envs: The number of worlds.
        autoreset_mode: ``AutoresetMode.NEXT_STEP`` (the step after an end starts the next episode and ignores its action) or
            ``AutoresetMode.SAME_STEP`` (``info["final_obs"]`` and ``info["final_info"]`` have what the old episode ended with), or
            ``AutoresetMode.DISABLED`` (``reset(options={"reset_mask": mask})`` starts the next episodes).
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 1}

    def __init__(
        self,
        scenario: Files | None = None,
        campaign: str | None = None,
        *,
        num_envs: int = 1,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
        seed: int = 1,
        render_mode: str | None = None,
        **options: Unpack[Options],
    ) -> None:
        kinds = {AutoresetMode.NEXT_STEP: "next_step", AutoresetMode.SAME_STEP: "same_step", AutoresetMode.DISABLED: "never"}
        if autoreset_mode not in kinds:
            raise ValueError(f"there is no autoreset mode {autoreset_mode!r}; give a gymnasium.vector.AutoresetMode")
        self._autoreset = kinds[autoreset_mode]
        self._make(num_envs, scenario, campaign, seed, render_mode, options)
        self.num_envs = num_envs
        self.single_observation_space = observation_space(self.core)
        self.single_action_space = action_space(self.core)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.metadata = {**type(self).metadata, "autoreset_mode": autoreset_mode}
        self._over = np.zeros(num_envs, np.bool_)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Start an episode in every world, or in those of ``options["reset_mask"]``."""
        core, options = self._open(), dict(options or {})
        mask = options.pop("reset_mask", None)
        mask = np.ones(self.num_envs, np.bool_) if mask is None else np.asarray(mask)
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            raise ValueError(f"reset_mask needs {self.num_envs} booleans; it has the shape {mask.shape} and the type {mask.dtype}")
        if not mask.any():
            raise ValueError("reset_mask selects no world")
        episode = episode_option(options)
        if seed is None:
            seeds: list[int | None] = [None] * self.num_envs
        elif not isinstance(seed, Iterable) or isinstance(seed, str):
            seeds = [checked_seed(seed) + world for world in range(self.num_envs)]
        else:
            seeds = list(seed)
            if len(seeds) != self.num_envs:
                raise ValueError(f"there are {len(seeds)} seeds for {self.num_envs} worlds")
        given = [checked_seed(each) if each is not None and chosen else -1 for each, chosen in zip(seeds, mask)]
        if max(given) >= 0:
            core.reseed(np.array(given, np.int64))
        states = core.reset(mask, np.full(self.num_envs, episode, np.int64))
        self._over = self._over & ~mask
        self._began()
        infos: dict[str, Any] = {}
        for world in np.flatnonzero(mask):
            infos = self._add_info(infos, started(core, int(world)), int(world))
        return states, infos

    def step(
        self, actions: Any
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Take one decision in each world."""
        core = self._open()
        numbers = numbers_of(actions, self.action_space.shape)
        states, rewards, terminated, truncated, last = core.step(numbers, self._autoreset)
        over: NDArray[np.bool_] = terminated | truncated
        infos: dict[str, Any] = {}
        if last is not None or self._over.any():
            self._began()
        if last is None:
            begun = self._over if self._autoreset == "next_step" else np.zeros_like(over)
            for world in np.flatnonzero(over | begun):
                info = core.end(int(world)) if over[world] else started(core, int(world))
                infos = self._add_info(infos, info or {}, int(world))
        else:
            for world in np.flatnonzero(over):
                ended = {"final_obs": last[world].copy(), "final_info": core.end(int(world)) or {}}
                infos = self._add_info(infos, {**ended, **started(core, int(world))}, int(world))
        self._over = over
        return states, rewards, terminated, truncated, infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """A view from above of each world, if the environment was made with ``render_mode="rgb_array"``."""
        core = self._open()
        if self.render_mode != "rgb_array":
            return None
        return tuple(core.picture(world, SIZE) for world in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """End the use of the environment; further calls raise ``RuntimeError``."""
        self._closed = True

    def trace(self, world: int) -> dict[str, Any]:
        """The present episode of a world from tick to tick, as :meth:`PedestrianEnv.trace` has it."""
        return self._open().trace(world)


def make(
    scenario: Files | None = None,
    campaign: str | None = None,
    *,
    seed: int = 1,
    render_mode: str | None = None,
    **options: Unpack[Options],
) -> PedestrianEnv:
    """Make a Gymnasium environment of a scenario; the arguments are those of :class:`PedestrianEnv`."""
    return PedestrianEnv(scenario, campaign, seed=seed, render_mode=render_mode, **options)


def make_vec(
    scenario: Files | None = None,
    num_envs: int = 1,
    campaign: str | None = None,
    *,
    autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
    seed: int = 1,
    render_mode: str | None = None,
    **options: Unpack[Options],
) -> PedestrianVectorEnv:
    """Make a Gymnasium vector environment of a scenario; the arguments are those of :class:`PedestrianVectorEnv`."""
    return PedestrianVectorEnv(
        scenario, campaign, num_envs=num_envs, autoreset_mode=autoreset_mode, seed=seed, render_mode=render_mode, **options
    )
