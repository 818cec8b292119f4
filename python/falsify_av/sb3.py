"""A ``VecEnv`` of stable-baselines3, whose worlds are stepped on all cores. It needs ``pip install falsify-av[sb3]``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnv

from .scenarios import Files
from .worlds import SIZE, Closable, action_space, checked_seed, episode_option, numbers_of, observation_space, started

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .worlds import Options


class PedestrianVecEnv(Closable, VecEnv):
    """Several worlds of one scenario. World *i* behaves as a :class:`falsify_av.PedestrianEnv` with the seed ``seed + i``.

    A world whose episode is over starts the next one in the same step. Its info then has ``terminal_observation``,
    ``TimeLimit.truncated``, the outcome, and ``episode`` with ``r`` (sum of rewards) and ``l`` (decisions) as ``VecMonitor`` writes them.
    """

    def __init__(
        self,
        scenario: Files | None = None,
        num_envs: int = 1,
        campaign: str | None = None,
        *,
        seed: int = 1,
        render_mode: str | None = None,
        **options: Unpack[Options],
    ) -> None:
        self._make(num_envs, scenario, campaign, seed, render_mode, options)
        self._actions: np.ndarray | None = None
        self._lengths = np.zeros(num_envs, np.int64)
        super().__init__(
            num_envs, observation_space(self.core), action_space(self.core)
        )

    def reset(self) -> np.ndarray:
        """Start an episode in every world: with the seeds of ``seed`` if it was called since the last reset."""
        core = self._open()
        seeds = np.array([-1 if seed is None else checked_seed(seed) for seed in self._seeds], np.int64)
        if seeds.max() >= 0:
            core.reseed(seeds)
        episodes = [episode_option(options) for options in self._options]
        self._reset_seeds()
        self._reset_options()
        self._lengths[:] = 0
        states = core.reset(np.ones(self.num_envs, np.bool_), np.array(episodes, np.int64))
        self.reset_infos = [started(core, world) for world in range(self.num_envs)]
        self._began()
        return states

    def step_async(self, actions: np.ndarray) -> None:
        """Take the actions of the next step."""
        self._open()
        self._actions = numbers_of(actions, (self.num_envs, *self.action_space.shape))

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Step all worlds."""
        core = self._open()
        if self._actions is None:
            raise RuntimeError("there are no actions; call step_async before step_wait")
        actions, self._actions = self._actions, None
        states, rewards, terminated, truncated, last = core.step(actions, "same_step")
        self._lengths += 1
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if last is None:
            return states, rewards.astype(np.float32), terminated, infos
        self._began()
        over = terminated | truncated
        for world in np.flatnonzero(over):
            info = core.end(int(world)) or {}
            info["episode"] = {"r": info["episode_reward"], "l": int(self._lengths[world]), "t": info["episode_length_s"]}
            info["terminal_observation"] = last[world].copy()
            info["TimeLimit.truncated"] = bool(truncated[world] and not terminated[world])
            infos[world] = info
        self._lengths[over] = 0
        return states, rewards.astype(np.float32), over, infos

    def close(self) -> None:
        """End the use of the environment."""
        self._closed = True

    def get_images(self) -> Sequence[np.ndarray | None]:
        """A view from above of each world."""
        core = self._open()
        return [core.picture(world, SIZE) for world in range(self.num_envs)]

    def _chosen(self, indices: None | int | Iterable[int]) -> list[int]:
        return list(self._get_indices(indices))

    def get_attr(self, attr_name: str, indices: None | int | Iterable[int] = None) -> list[Any]:
        """An attribute of this environment, once for each chosen world."""
        value = getattr(self, attr_name)
        return [value for _ in self._chosen(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: None | int | Iterable[int] = None) -> None:
        """Refused: worlds of one scenario have no attributes of their own."""
        raise AttributeError(f"worlds of one scenario have no attributes of their own, so `{attr_name}` cannot be set")

    def env_method(
        self, method_name: str, *args: Any, indices: None | int | Iterable[int] = None, **kwargs: Any
    ) -> list[Any]:
        """Call ``trace`` or ``suggested`` for the chosen worlds."""
        if method_name not in ("trace", "suggested"):
            raise AttributeError(f"worlds have no method `{method_name}`; there is trace, suggested")
        method = getattr(self._open(), method_name)
        return [method(world, *args, **kwargs) for world in self._chosen(indices)]

    def env_is_wrapped(self, wrapper_class: type, indices: None | int | Iterable[int] = None) -> list[bool]:
        """Worlds are never wrapped one by one."""
        return [False for _ in self._chosen(indices)]


def make_vec(
    scenario: Files | None = None,
    num_envs: int = 1,
    campaign: str | None = None,
    *,
    seed: int = 1,
    render_mode: str | None = None,
    **options: Unpack[Options],
) -> PedestrianVecEnv:
    """Make a ``VecEnv`` of a scenario; the arguments are those of :class:`PedestrianVecEnv`."""
    return PedestrianVecEnv(scenario, num_envs, campaign, seed=seed, render_mode=render_mode, **options)
