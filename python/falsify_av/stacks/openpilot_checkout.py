"""The problem of openpilot's planner from a checkout of yours, in the place of the statement in :mod:`falsify_av.stacks.openpilot`.

``long_mpc.py`` of the checkout runs as it is, with its costs, constraints and forecasts. What it imports of the rest of openpilot (messages, logs, clocks)
is replaced by stand-ins of a few lines, so nothing is built but the solver.

``python3 -m falsify_av.stacks.openpilot_checkout DIR FILE`` solves 200 drawn situations with a checkout and writes the plans, which
``python/tests/test_stacks.py`` compares with ``openpilot_like``; ``--compare DIR`` compares at once and prints the greatest difference.
"""

from __future__ import annotations

import importlib.util
import inspect
import json
import random
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from . import openpilot
from .acados import compiled
from .batch import Array
from .openpilot import FADING, GREATEST, LEAST, NODES, TICK, Lead, Plan, nobody

FOLDER = "selfdrive/controls/lib/longitudinal_mpc_lib"
TRIED = "openpilot 0.11.2 (June 2026)"

SITUATIONS, TICKS = 200, 4


class Checkout:
    """A checkout, and the problem in it."""

    def __init__(self, folder: Path) -> None:
        roots = [root for root in (folder / "openpilot", folder) if (root / FOLDER / "long_mpc.py").is_file()]
        if not roots:
            raise SystemExit(f"there is no {FOLDER}/long_mpc.py in {folder}; give the folder of a checkout of openpilot (tried: {TRIED})")
        self.root, self.file = roots[0], roots[0] / FOLDER / "long_mpc.py"
        for name, module in stand_ins().items():
            sys.modules[name] = module
        for name in ("selfdrive.modeld.constants", f"{FOLDER.replace('/', '.')}.following_distance"):
            path = self.root / f"{name.replace('.', '/')}.py"
            if path.is_file():
                sys.modules[f"openpilot.{name}"] = load(f"openpilot.{name}", path)
        self.module = load("openpilot_long_mpc", self.file)
        from acados.acados_template import AcadosModel, AcadosOcp

        # The file imports these where it generates code, and not where it drives.
        vars(self.module).update(AcadosModel=AcadosModel, AcadosOcp=AcadosOcp)
        found = inspect.signature(self.module.LongitudinalMpc.update).parameters
        if not hasattr(self.module, "gen_long_ocp") or list(found)[1:3] != ["radarstate", "v_cruise"]:
            raise SystemExit(f"{self.file} is of a version that this adapter does not know: {', '.join(found)}; tried: {TRIED}")

    def plan(self) -> CheckoutPlan:
        """The planner of one world."""
        solver = compiled(self.module.gen_long_ocp, self.file.read_bytes())
        vars(self.module)["AcadosOcpSolverCython"] = lambda *_: solver
        return CheckoutPlan(self.module.LongitudinalMpc())


class CheckoutPlan:
    """The planner of the checkout with the interface of :class:`falsify_av.stacks.openpilot.Plan`."""

    def __init__(self, planner: Any) -> None:
        self.planner = planner

    def forget(self) -> None:
        """Start from nothing."""
        self.planner.reset()

    def weigh(self, smooth: bool) -> None:
        """Set the weights."""
        self.planner.set_weights(smooth)

    def from_state(self, speed: float, acceleration: float) -> None:
        """Set what the car does now (m/s, m/s^2)."""
        self.planner.set_cur_state(speed, acceleration)

    def solve(self, leads: list[Lead], limit: float) -> None:
        """Plan for two leads and a set speed (m/s)."""
        one, two = (radar(lead) for lead in leads)
        self.planner.update(SimpleNamespace(leadOne=one, leadTwo=two), limit)

    @property
    def speeds(self) -> Array:
        """Speeds at the nodes (m/s)."""
        return np.array(self.planner.v_solution)

    @property
    def accelerations(self) -> Array:
        """Accelerations at the nodes (m/s^2)."""
        return np.array(self.planner.a_solution)


def radar(lead: Lead) -> Any:
    """A lead as openpilot's radar reports it."""
    return SimpleNamespace(status=True, present=True, modelProb=1.0, dRel=lead[0], vLead=lead[1], aLeadK=lead[2], aLeadTau=FADING)


def stand_ins() -> dict[str, ModuleType]:
    """What ``long_mpc.py`` imports of the rest of openpilot."""
    personality = SimpleNamespace(relaxed=0, standard=1, aggressive=2)
    source = SimpleNamespace(cruise=0, lead0=1, lead1=2, lead2=3, e2e=4)
    log = SimpleNamespace(LongitudinalPersonality=personality, LongitudinalPlan=SimpleNamespace(LongitudinalPlanSource=source))
    names: dict[str, dict[str, Any]] = {
        "cereal": {"log": log},
        "openpilot.cereal": {"log": log},
        "opendbc.car.interfaces": {"ACCEL_MIN": LEAST, "ACCEL_MAX": GREATEST},
        "openpilot.common.realtime": {"DT_MDL": TICK},
        "openpilot.common.swaglog": {"cloudlog": SimpleNamespace(warning=lambda _: None)},
        "openpilot.selfdrive.controls.radard": {"_LEAD_ACCEL_TAU": FADING},
        f"openpilot.{FOLDER.replace('/', '.')}.c_generated_code.acados_ocp_solver_pyx": {"AcadosOcpSolverCython": None},
    }
    made = {}
    for name, members in names.items():
        made[name] = ModuleType(name)
        vars(made[name]).update(members)
    return made


def load(name: str, path: Path) -> ModuleType:
    """Run a file as a module."""
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def situations() -> list[dict[str, Any]]:
    """Drawn situations: what the car does, two leads, a set speed, and whether a change of acceleration has a price."""
    drawn, found = random.Random(39), []
    for _ in range(SITUATIONS):
        speed = drawn.uniform(0.0, 25.0)
        leads = [[drawn.uniform(2.0, 90.0), drawn.uniform(-1.0, 20.0), drawn.uniform(-3.0, 1.5)] for _ in range(drawn.randrange(3))]
        found.append({
            "speed": speed,
            "acceleration": drawn.uniform(-3.0, 1.5),
            "leads": leads,
            "limit": drawn.uniform(3.0, 30.0),
            "smooth": drawn.random() < 0.8,
        })
    return found


def last_plan(plan: Any, situation: dict[str, Any]) -> list[list[float]]:
    """The speeds (m/s) and the accelerations (m/s^2) of the last of some plans in a row: the solver starts each from the one before."""
    plan.forget()
    plan.weigh(situation["smooth"])
    plan.from_state(situation["speed"], situation["acceleration"])
    leads = [tuple(lead) for lead in situation["leads"]]
    for _ in range(TICKS):
        plan.solve((leads + [nobody(situation["speed"])] * 2)[:2], situation["limit"])
    return [[round(float(number), 9) for number in numbers] for numbers in (plan.speeds, plan.accelerations)]


def differences(plan: Any, recorded: list[dict[str, Any]]) -> list[float]:
    """The greatest difference of a speed (m/s) or an acceleration (m/s^2) in each situation, sorted."""
    return sorted(float(np.max(np.abs(np.subtract(last_plan(plan, each), each["plan"])))) for each in recorded)


def main(words: list[str]) -> None:
    """Write the plans of a checkout, or compare them."""
    if len(words) != 2:
        raise SystemExit("usage: python3 -m falsify_av.stacks.openpilot_checkout DIR FILE | --compare DIR")
    compares = words[0] == "--compare"
    checkout = Checkout(Path(words[1] if compares else words[0])).plan()
    recorded = [{**situation, "plan": last_plan(checkout, situation)} for situation in situations()]
    if compares:
        apart = differences(Plan(openpilot.solver()), recorded)
        print(f"{len(apart)} situations, plans of {NODES + 1} nodes: median difference {apart[len(apart) // 2]:.1e}, greatest {apart[-1]:.1e}")
        return
    rows = [json.dumps(each) for each in recorded]
    Path(words[1]).write_text("[\n" + ",\n".join(rows) + "\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
