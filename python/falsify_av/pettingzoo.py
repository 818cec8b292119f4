"""A parallel environment of PettingZoo. It needs ``pip install falsify-av[pettingzoo]``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pettingzoo import ParallelEnv

from .scenarios import Files
from .worlds import SIZE, Closable, action_space, checked_seed, episode_option, numbers_of, observation_space, started

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .worlds import Options


class PedestriansEnv(Closable, ParallelEnv):
    """One scenario in which each controlled pedestrian is an agent. Its name is that of its role in the cast and its number within it, as ``child_0``;
    without a cast it is ``pedestrian_0``. All agents get the reward of the episode.

    An episode ends for all agents at once. Seeds and options are those of :class:`falsify_av.PedestrianEnv`.
    """

    metadata: ClassVar[dict[str, Any]] = {
        "name": "falsify_pedestrians_v0",
        "render_modes": ["rgb_array"],
        "is_parallelizable": True,
    }

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
        self.possible_agents = [name for name, _, _ in self.core.agents()]
        self.agents: list[str] = []
        # One object for each agent: spaces have generators of their own.
        self.observation_spaces = {agent: observation_space(self.core, number) for number, agent in enumerate(self.possible_agents)}
        self.action_spaces = {agent: action_space(self.core, number) for number, agent in enumerate(self.possible_agents)}
        self._ends = np.cumsum([space.shape[0] for space in self.observation_spaces.values() if space.shape])

    def observation_space(self, agent: str) -> Any:
        """The observations of an agent."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Any:
        """The actions of an agent."""
        return self.action_spaces[agent]

    def _observations(self, state: np.ndarray) -> dict[str, np.ndarray]:
        parts = np.split(state, self._ends[:-1])
        return {agent: part.copy() for agent, part in zip(self.possible_agents, parts)}

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, dict[str, Any]]]:
        """Start an episode. Of the options only ``episode`` has a meaning; PettingZoo's own test passes others."""
        core, episode = self._open(), episode_option({name: value for name, value in (options or {}).items() if name == "episode"})
        if seed is not None:
            core.reseed(np.array([checked_seed(seed)], np.int64))
        states = core.reset(np.ones(1, np.bool_), np.array([episode], np.int64))
        self.agents = self.possible_agents[:]
        self._began()
        return self._observations(states[0]), {agent: started(core, 0) for agent in self.agents}

    def step(
        self, actions: dict[str, np.ndarray]
    ) -> tuple[dict[str, np.ndarray], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Take one decision for each agent."""
        core = self._open()
        if not self.agents:
            raise RuntimeError("no agent is left; call reset before step")
        missing = [agent for agent in self.agents if agent not in actions]
        if missing:
            raise ValueError(f"there is no action for {', '.join(missing)}")
        joint = np.concatenate([numbers_of(actions[agent], self.action_spaces[agent].shape) for agent in self.agents])
        states, rewards, terminated, truncated, _ = core.step(joint[None], "never")
        over = bool(terminated[0] or truncated[0])
        agents, self.agents = self.agents, [] if over else self.agents
        return (
            self._observations(states[0]),
            {agent: float(rewards[0]) for agent in agents},
            {agent: bool(terminated[0]) for agent in agents},
            {agent: bool(truncated[0]) for agent in agents},
            {agent: (core.end(0) or {}) if over else {} for agent in agents},
        )

    def render(self) -> np.ndarray | None:
        """The view from above, if the environment was made with ``render_mode="rgb_array"``."""
        core = self._open()
        return core.picture(0, SIZE) if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """End the use of the environment."""
        self._closed = True


def parallel_env(
    scenario: Files | None = None,
    campaign: str | None = None,
    *,
    seed: int = 1,
    render_mode: str | None = None,
    **options: Unpack[Options],
) -> PedestriansEnv:
    """Make a parallel environment of a scenario; the arguments are those of :class:`PedestriansEnv`."""
    return PedestriansEnv(scenario, campaign, seed=seed, render_mode=render_mode, **options)
