"""Verdicts of encounters that were recorded elsewhere: in another simulator, or on a road."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .scenarios import Files, choose

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .scenarios import Selection


def _rows(name: str, numbers: ArrayLike) -> NDArray[np.float64]:
    try:
        rows = np.asarray(numbers, np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"`{name}` is no array of numbers: {error}") from error
    if rows.ndim != 2:
        raise ValueError(f"`{name}` has {rows.ndim} dimensions; give a row for each instant")
    return rows


def judge(
    ego: ArrayLike,
    pedestrian: ArrayLike,
    dt: float,
    *,
    length: float | None = None,
    width: float | None = None,
    radius: float | None = None,
    full_brake: float | None = None,
    boxes: ArrayLike | None = None,
    scenario: Files | None = None,
    campaign: str | None = None,
    **options: Unpack[Selection],
) -> dict[str, Any]:
    """Judge the first touch of a car and a pedestrian: would a careful driver have avoided it?

    The reference drivers brake on the path that the car took, and the pedestrian does what it did. What follows the touch is not used.
    Coordinates are those of any right-handed frame with x and y on the ground; angles count from x to y.

    Args:
        ego: A row for each instant: x and y of the middle of the car's box (m), its heading (rad), its speed along the heading (m/s, at most 150; negative when it reverses).
            CARLA and Unreal have y to the right: change the sign of y and of the heading.
        pedestrian: A row for each instant: x and y of its middle (m). With x, y, direction of motion (rad) and speed (m/s) the velocity is not
            taken from differences of positions.
        dt: Time between two instants (s), 0.001 to 0.5. The program's own episodes have 0.05 s.
        length, width: Size of the car (m).
        radius: Radius of the pedestrian (m).
        full_brake: Deceleration of the car at full brake (m/s²). Careful humans brake with it, at most with 7.59.
        boxes: Obstacles that hide the pedestrian and stop it: rows of x, y, heading, length, width (m, rad).
        scenario, campaign, options: A scenario, chosen as by :func:`falsify_av.make`. It gives the sizes and the obstacles that no other argument gives.
            The requirements of its campaign are evaluated, too.
            Without it the sizes are those of the paper (4.79 m by 2.16 m, 0.188 m), on an empty plane.

    Returns:
        ``verdict`` (empty without a touch; ``cannot_tell`` if the recording begins too late, by ``begins_late_s``), ``counts_as``, ``foreseeable``, ``fault``, ``warning_s`` and ``impact_speed_mps`` as the columns of the
        table of episodes; ``side``, the part of the car that was touched; ``findings``, what is damaged in the recording and where (an answer that rests on it is ``cannot_tell``); ``avoided_by``, which reference drivers avoid it; ``drivers``, the published drivers and ours, each with its ``source``, whether it ``votes``, its ``trigger`` and times, and how it ends; ``variations`` and ``avoided_in``, in how many of a thousand variations a careful human avoids it; ``touch_s``, the time of the touch from the first instant;
        ``least_gap_m``, ``min_ttc_s`` and ``pet_s``; ``requirements``, each by its name as in the info of an episode: ``violated``,
        ``robustness``, ``sample``, ``part``, ``preventable`` and ``fault``, or ``None`` for one about the lane, the lights or crosswalks, since a
        recording has no map. A number that does not apply is not a number.

    Raises:
        ValueError: The arrays have other shapes or lengths, a number that is not finite or out of its range, or units that do not fit each
            other: speeds explain how far an actor moves in ``dt``, and it moves where it heads. A car may reverse.
    """
    chosen = choose(scenario, {"campaign": campaign, **options})
    if boxes is None and scenario is None:
        boxes = np.zeros((0, 5))
    obstacles = None if boxes is None else np.zeros((0, 5)) if np.size(boxes) == 0 else _rows("boxes", boxes)
    sizes = [None if size is None else float(size) for size in (length, width, radius, full_brake)]
    return chosen.judged(_rows("ego", ego), _rows("pedestrian", pedestrian), float(dt), sizes, obstacles)
