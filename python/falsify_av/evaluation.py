"""Episodes of a pedestrian of your own: a callable, such as a function, a trained policy or a network."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium.vector import AutoresetMode

from .environments import PedestrianVectorEnv
from .network import Walker
from .pedestrians import Pedestrian
from .progress import Progress, shown
from .scenarios import Files
from .worlds import RunUpWarning, checked_seed, failed_run_ups, numbers_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .worlds import Options


def evaluate(
    pedestrian: Pedestrian,
    scenario: Files | None = None,
    campaign: str | None = None,
    *,
    episodes: int,
    seed: int = 1,
    num_envs: int = 64,
    progress: bool | Progress = False,
    **options: Unpack[Options],
) -> list[dict[str, Any]]:
    """Run episodes 0, 1, ... of a seed with a pedestrian, and return what each ended with, in their order.

    The episodes have the starts of the evaluations of a campaign that is run with this seed, so rows can be paired with those of its table
    ``episodes``. The names are those of its columns. The result does not depend on ``num_envs`` if each action depends on its own row only.

    Args:
        pedestrian: Gets states of the shape ``(worlds, numbers)`` and returns actions of the shape ``(worlds, 2 * pedestrians)``. One with memory has
            a method ``begin``, which gets the mask of the worlds whose episodes begin.
        scenario, campaign, options: As those of :func:`falsify_av.make`.
        episodes: The number of episodes.
        seed: The seed of the campaign.
        num_envs: The most episodes that run at once.
        progress: ``True`` for a bar in a terminal or a notebook, or a function that is called with the episodes done and all episodes.

    Raises:
        ValueError: A network of :func:`falsify_av.onnx` or :func:`falsify_av.hunter` was trained with other states or actions.

    Warns:
        RunUpWarning: The driver did not reach more than a twentieth of its starts; ``placed`` of a row is then true.
    """
    if episodes < 1:
        raise ValueError(f"the number of episodes is {episodes}; give at least 1")
    worlds = min(num_envs, episodes)
    env = PedestrianVectorEnv(
        scenario, campaign, num_envs=worlds, autoreset_mode=AutoresetMode.DISABLED, seed=seed, **options
    )
    if isinstance(pedestrian, Walker):
        pedestrian.check(env)
    core, mask = env.core, np.ones(worlds, np.bool_)
    core.reseed(np.full(worlds, checked_seed(seed), np.int64))
    number = np.arange(worlds, dtype=np.int64)
    states = core.reset(mask, number)
    begin = getattr(pedestrian, "begin", lambda _: None)
    begin(mask)
    rows: dict[int, dict[str, Any]] = {}
    following = worlds
    tell = shown(progress, "episodes")
    running = mask
    while running.any():
        # A world without a further episode rests. Its last state stays among the rows, and its action is ignored.
        actions = numbers_of(pedestrian(states), env.action_space.shape)
        states, _, terminated, truncated, _ = core.step(actions, "rest")
        over = running & (terminated | truncated)
        if not over.any():
            continue
        for world in np.flatnonzero(over):
            row = core.end(int(world)) or {}
            rows[row["episode_number"]] = row
            number[world] = following
            following += 1
        tell(len(rows), episodes)
        again = over & (number < episodes)
        running = running & ~over | again
        if again.any():
            states = core.reset(again, number)
            begin(again)
    ends = [rows[episode] for episode in range(episodes)]
    text = failed_run_ups(sum(row["placed"] for row in ends), sum(row["run_up_ticks"] > 0 for row in ends))
    if text:
        warnings.warn(text, RunUpWarning, stacklevel=2)
    return ends
