"""Drivers, and a pedestrian, that others wrote: adapters to packages on PyPI and to checkouts of yours.

Each is a program that a scenario names, ``driver eidm = external(command: "python3 -m falsify_av.stacks sumo")``, and that
``falsify check --driver sumo`` tries. :data:`STACKS` lists them; ``docs/src/how-to/stacks.md`` says what each is, what it sees, and what it was
not made for.
"""

from __future__ import annotations

import shutil
import sys
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
    #: The only version of Python that its package is built for.
    python: tuple[int, int] | None = None
    #: Programs that it starts.
    programs: tuple[str, ...] = ()

    def missing(self) -> str | None:
        """A sentence that says what is not installed, and what installs it."""
        if self.python is not None and sys.version_info[:2] != self.python:
            built, this = (".".join(map(str, version[:2])) for version in (self.python, sys.version_info))
            return f"{self.what} needs Python {built}, for which its package is built, and `python3` is {this}: start it with another `python3` on the PATH"
        absent = [name for name in self.imports if find_spec(name) is None]
        if absent:
            plural = "s" if len(absent) > 1 else ""
            return f"{self.what} needs the Python package{plural} {', '.join(absent)}: `pip install {self.pip}`"
        without = [name for name in self.programs if shutil.which(name) is None]
        if without:
            return f"{self.what} needs the program{'s' if len(without) > 1 else ''} {', '.join(without)} on the PATH, which compile its problem"
        return None


STACKS = {
    "sumo": Stack("sumo", "SUMO's car-following model", ("libsumo",), "libsumo==1.28.0"),
    "openpilot_like": Stack(
        "openpilot", "openpilot's longitudinal planner", ("acados", "casadi"), "comma-deps-acados==0.2.2.post104", (3, 12), ("cc", "make")
    ),
    "pdm_closed": Stack(
        "pdm",
        "PDM-Closed",
        ("scipy", "shapely", "pandas", "geopandas", "aioboto3", "aiofiles", "retry", "cv2", "pyquaternion", "matplotlib", "PIL", "pytest"),
        "'numpy<2' scipy==1.13.1 shapely==2.0.6 pandas==2.3.3 geopandas aioboto3 aiofiles retry opencv-python-headless pyquaternion matplotlib pillow pytest",
    ),
    "nuplan": Stack("nuplan", "a planner of nuPlan", (), ""),
    "fiss": Stack("fiss", "FISS+", ("fiss_planner",), "fiss-planner==1.0.0"),
    "commonroad": Stack("commonroad", "CommonRoad's reactive planner", ("commonroad_rp",), "commonroad-reactive-planner==2025.1"),
    "fmu": Stack("fmu", "an FMU", ("fmpy",), "fmpy==0.3.32"),
    "jupedsim": Stack("jupedsim", "JuPedSim's pedestrian", ("jupedsim",), "jupedsim==1.4.2"),
}
