"""Episodes of a pedestrian of your own: a callable, such as a function, a trained policy or an ONNX session."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from .environments import PedestrianVectorEnv
from .progress import Progress, shown
from .worlds import checked_seed

#: Takes the states of some worlds, one a row, and returns an action for each.
Pedestrian = Callable[[NDArray[np.float32]], NDArray[np.floating[Any]]]


def evaluate(
    pedestrian: Pedestrian,
    scenario: Any = None,
    campaign: str | None = None,
    *,
    episodes: int,
    seed: int = 1,
    num_envs: int = 64,
    progress: bool | Progress = False,
    **options: Any,
) -> list[dict[str, Any]]:
    """Run episodes 0, 1, ... of a seed with a pedestrian, and return what each ended with, in their order.

    The episodes have the starts of the evaluations of a campaign that is run with this seed, so rows can be paired with those of its table
    ``episodes``. The names are those of its columns. The result does not depend on ``num_envs`` if each action depends on its own row only.

    Args:
        pedestrian: Gets states of the shape ``(worlds, numbers)`` and returns actions of the shape ``(worlds, 2 * pedestrians)``.
        scenario, campaign, options: As those of :func:`falsify_av.make`.
        episodes: The number of episodes.
        seed: The seed of the campaign.
        num_envs: The most episodes that run at once.
        progress: ``True`` for a bar in a terminal or a notebook, or a function that is called with the episodes done and all episodes.
    """
    if episodes < 1:
        raise ValueError(f"the number of episodes is {episodes}; give at least 1")
    worlds = min(num_envs, episodes)
    env = PedestrianVectorEnv(
        scenario, campaign, num_envs=worlds, autoreset_mode=AutoresetMode.DISABLED, seed=seed, **options
    )
    core, mask = env.core, np.ones(worlds, np.bool_)
    core.reseed(np.full(worlds, checked_seed(seed), np.int64))
    number = np.arange(worlds, dtype=np.int64)
    states = core.reset(mask, number)
    rows: dict[int, dict[str, Any]] = {}
    following = worlds
    left = episodes
    tell = shown(progress, "episodes")
    while left:
        actions = np.asarray(pedestrian(states))
        states, _, terminated, truncated, _ = env.step(actions)
        over = terminated | truncated
        for world in np.flatnonzero(over):
            row = core.end(int(world)) or {}
            rows[row["episode"]] = row
            left -= row["episode"] < episodes
            number[world] = following
            following += 1
        if over.any():
            tell(episodes - left, episodes)
            # A world without an episode of its own starts another one all the same; its row is not used.
            states = core.reset(over, number)
    return [rows[episode] for episode in range(episodes)]


def onnx(path: Any) -> Pedestrian:
    """A pedestrian of an ONNX file with one input of states and actions as its first output. It needs ``pip install onnxruntime``."""
    import onnxruntime

    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    name = session.get_inputs()[0].name
    return lambda states: session.run(None, {name: states})[0]
