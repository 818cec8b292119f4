"""Drivers, and a pedestrian, that others wrote: adapters to packages on PyPI and to checkouts of yours.

Each is a program that a scenario names, ``policy eidm = external(command: "python3 -m falsify_av.stacks sumo")``, and that
``falsify check --driver sumo`` tries. :data:`STACKS` lists them; ``docs/src/how-to/stacks.md`` says what each is, what it sees, and what it was
not made for.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec


@dataclass(frozen=True)
class Stack:
    """A driver, or a pedestrian, of others."""

    #: The module of this package that adapts it.
    module: str
    #: What it is, in a few words.
    what: str
    #: Packages that it imports.
    imports: tuple[str, ...]
    #: What `pip install` takes.
    pip: str

    def missing(self) -> str | None:
        """A sentence that says what is not installed, and what installs it."""
        absent = [name for name in self.imports if find_spec(name) is None]
        if not absent:
            return None
        return f"{self.what} needs the Python package {' and '.join(absent)}: `pip install {self.pip}` installs it"


STACKS = {
    "sumo": Stack("sumo", "SUMO's car-following model", ("libsumo",), "libsumo==1.28.0"),
    "openpilot_like": Stack("openpilot", "openpilot's longitudinal planner", ("acados", "casadi"), "comma-deps-acados==0.2.2.post104"),
    "fiss": Stack("fiss", "FISS+", ("fiss_planner",), "fiss-planner==1.0.0"),
    "commonroad": Stack("commonroad", "CommonRoad's reactive planner", ("commonroad_rp",), "commonroad-reactive-planner==2025.1"),
    "pdm_closed": Stack("pdm", "PDM-Closed", ("shapely",), "shapely==2.1.2"),
    "jupedsim": Stack("jupedsim", "JuPedSim's pedestrian", ("jupedsim",), "jupedsim==1.4.2"),
}
