"""PDM-Closed, the winner of nuPlan's planning challenge of 2023, as a driver under test: a planner behind the adapter of :mod:`falsify_av.stacks.nuplan`.

It comes from clones of yours of ``tuplan_garage`` and ``nuplan-devkit``: neither is on PyPI. ``--clones DIR`` names the folder that holds both; without it
the environment variable ``FALSIFY_PDM`` does. Its map is simpler than that of other planners, and its wheels are taken for straight, as when its results were
recorded: the lane along the route is one part, or two if a light is ahead that is not green, and the second is closed. Its map is made again for each plan, so it searches
its centre line again each time.

``docs/src/how-to/stacks/pdm_closed.md`` says how to install it, what it sees and what it was not made for.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from ..drivers import serve
from . import nuplan
from .batch import Array
from .nuplan_map import BEHIND, Part, longer
from .nuplan_map import Map as Road
from .pursuit import limit

CLONES = {"tuplan_garage": "tuplan_garage/planning", "nuplan-devkit": "nuplan/planning"}
PLANNER = "tuplan_garage.planning.simulation.planner.pdm_planner"
#: What this adapter uses besides the names of all planners.
NAMES = {
    "nuplan.planning.simulation.trajectory.trajectory_sampling": "TrajectorySampling",
    f"{PLANNER}.pdm_closed_planner": "PDMClosedPlanner",
    f"{PLANNER}.proposal.batch_idm_policy": "BatchIDMPolicy",
}

# The settings of its authors (`pdm_closed_planner.yaml`): s and poses, shares of the limit, m/s, m, s, m/s^2, m.
INTERVAL, PLANNED, PROPOSED = 0.1, 80, 40
POLICIES = {
    "speed_limit_fraction": [0.2, 0.4, 0.6, 0.8, 1.0],
    "fallback_target_velocity": 15.0,
    "min_gap_to_lead_agent": 1.0,
    "headway_time": 1.5,
    "accel_max": 1.5,
    "decel_max": 3.0,
}
OFFSETS, RADIUS = [-1.0, 1.0], 50


def clones(folder: str | None) -> None:
    """Make both clones importable.

    Raises:
        SystemExit: A sentence that says what is missing.
    """
    if folder is None:
        raise SystemExit(
            "PDM-Closed comes from two clones, which are not on PyPI: clone autonomousvision/tuplan_garage and motional/nuplan-devkit into one folder "
            "and name it with `--clones DIR` or in FALSIFY_PDM"
        )
    for name, inside in CLONES.items():
        place = Path(folder) / name
        if not (place / inside).is_dir():
            raise SystemExit(f"there is no clone of {name} in {folder}: {place / inside} is not a folder")
        sys.path.insert(0, str(place))


class Nuplan(nuplan.Nuplan):
    """The names of both clones that this adapter uses."""

    def __init__(self) -> None:
        super().__init__({**nuplan.NAMES, **NAMES}, "PDM-Closed")

    def planner(self) -> Any:
        """PDM-Closed with the settings of its authors."""
        made: Any = self
        sampling = [made.TrajectorySampling(num_poses=poses, interval_length=INTERVAL) for poses in (PLANNED, PROPOSED)]
        return made.PDMClosedPlanner(*sampling, made.BatchIDMPolicy(**POLICIES), OFFSETS, RADIUS)


class Map(Road):
    """nuPlan's map of the lane along a line.

    The lane has two parts if a red light is ahead: the second begins at the light, and the planner takes it for closed.
    """

    def __init__(self, names: Any, line: Array, width: float, speed: float, light: float | None) -> None:
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])
        cut = len(line) if light is None else int(np.searchsorted(along, light + BEHIND))
        lines = [line[: cut + 1], line[cut:]] if 2 <= cut <= len(line) - 2 else [line]
        super().__init__(names, [Part(each, width, speed, number > 0) for number, each in enumerate(lines)])


class Driver(nuplan.Driver):
    """The planner of one world."""

    name = "PDM-Closed"

    def made(self) -> Any:
        """A planner for an episode."""
        return self.nuplan.planner()

    def road(self, world: dict[str, Any], route: Array) -> tuple[Road, list[Any]]:
        """The map, and its closed part if a light ahead is not green."""
        names, lanes, light = self.nuplan, world["lanes"], world["light"]
        width = lanes[0]["width"] + (nuplan.ROOM if any(each["junction"] for each in lanes) else 0.0)
        red = light["distance"] if light and light["colour"] != "green" else None
        road = Map(names, longer(route), width, limit(world, route), red)
        closed = names.TrafficLightStatusData(names.TrafficLightStatusType.RED, 2, self.time(world["tick"]))
        return road, [closed] if len(road.lanes) > 1 else []

    def turning(self, _world: dict[str, Any]) -> tuple[float, float]:
        """It is told of no turning."""
        return 0.0, 0.0


def look() -> None:
    """End with a sentence if the clones are not there."""
    clones(os.environ.get("FALSIFY_PDM") or None)


def main(words: list[str]) -> None:
    """Serve the planner; `--clones DIR` names the folder with both clones."""
    if words and (len(words) != 2 or words[0] != "--clones"):
        raise SystemExit(f"{' '.join(words)!r} is not an option of this driver; it has --clones DIR")
    clones(words[1] if words else os.environ.get("FALSIFY_PDM") or None)
    Driver.nuplan = Nuplan()
    serve(Driver)
