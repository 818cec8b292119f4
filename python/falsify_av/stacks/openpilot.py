"""openpilot's longitudinal planner as a driver under test: its optimal control problem, solved by acados, chooses the acceleration.

`openpilot_like` is a statement of the published problem in this file: states, dynamics, costs, constraints and limits of June 2026.
``--openpilot DIR`` takes the problem from a checkout of yours instead (MIT license; it is not on PyPI). What surrounds the solver (which road user is a lead, the filter of the
speed, what becomes of the plan) is the adapter's in both cases. openpilot knows no pedestrians: a pedestrian in the path of the car is shown as a
lead, that is, as a vehicle ahead.

Install it with ``pip install comma-deps-acados==0.2.2.post104`` on Python 3.12, and a C compiler; ``docs/src/how-to/stacks/openpilot.md`` says what it sees
and what it was not made for.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from .acados import Solver, compiled
from .batch import RED, YELLOW, Array, Frame, serve

NODES = 12
TIMES = 10.0 * (np.arange(NODES + 1) / NODES) ** 2  # s: nodes of the plan
STEPS = np.diff(TIMES, prepend=0.0)
TICK = 0.05  # s: it plans at 20 Hz
LEAST, GREATEST = -3.5, 2.0  # m/s^2
CRUISE = -1.2, 1.6  # m/s^2: between them it approaches the set speed
FOLLOW, STOP, COMFORT = 1.45, 6.0, 2.5  # s, m, m/s^2: personality `standard`
DANGER = 0.75  # share of the comfortable distance below which a distance is punished
WEIGHTS = (3.0, 0.0, 0.0, 0.0, 200.0, 5.0)  # distance, x, v, a, change of a, jerk
LIMITS = (1e6, 1e6, 1e6, 100.0)  # of a broken constraint: speed, least and greatest acceleration, danger
FADING = 1.5  # 1/s^2: how fast a lead's acceleration is assumed to fade
DELAY = 0.15  # s: of the actuators, openpilot's default
PULL_AT, PULL = (0.0, 10.0, 25.0, 40.0), (1.6, 1.2, 0.8, 0.6)  # m/s, m/s^2: greatest acceleration at a speed
LATERAL, EASY = 3.0, 1.0  # m/s^2: ISO 11270's limit, which openpilot keeps when it steers; the braking for a bend or a lower limit, which it does by its set speed
STOPPING, HOLD = 0.5, -2.0  # m/s, m/s^2: below this speed the car is held

Lead = tuple[float, float, float]  # m to its rear, m/s, m/s^2


def braking(speed: Any) -> Any:
    """The way that comfortable braking takes (m)."""
    return speed**2 / (2.0 * COMFORT)


def comfortable(speed: Any, follow: Any) -> Any:
    """The distance to a standing obstacle that is kept at a speed (m)."""
    return braking(speed) + follow * speed + STOP


def problem() -> Any:
    """The optimal control problem: jerk moves the car so that it keeps its distance from an obstacle."""
    from acados.acados_template import AcadosModel, AcadosOcp
    from casadi import SX, vertcat

    place, speed, change, jerk = (SX.sym(name) for name in ("place", "speed", "change", "jerk"))
    rates = [SX.sym(name) for name in ("place_rate", "speed_rate", "change_rate")]
    least, greatest, obstacle, former, follow, danger = (SX.sym(name) for name in ("least", "greatest", "obstacle", "former", "follow", "danger"))
    model = AcadosModel()
    model.name = "falsify_long"
    model.x, model.u, model.xdot = vertcat(place, speed, change), vertcat(jerk), vertcat(*rates)
    model.p = vertcat(least, greatest, obstacle, former, follow, danger)
    model.f_expl_expr = vertcat(speed, change, jerk)
    model.f_impl_expr = model.xdot - model.f_expl_expr

    room, wanted = obstacle - place, comfortable(speed, follow)
    terms = [(room - wanted) / (speed + 10.0), place, speed, change, change - former, jerk]
    ocp = AcadosOcp()
    ocp.model, ocp.dims.N = model, NODES
    for end, count in (("", len(terms)), ("_e", len(terms) - 1)):
        setattr(ocp.cost, f"cost_type{end}", "NONLINEAR_LS")
        setattr(ocp.cost, f"W{end}", np.zeros((count, count)))
        setattr(ocp.cost, f"yref{end}", np.zeros(count))
        setattr(model, f"cost_y_expr{end}", vertcat(*terms[:count]))
    model.con_h_expr = vertcat(speed, change - least, greatest - change, (room - danger * wanted) / (speed + 10.0))
    bounds = len(LIMITS)
    ocp.constraints.x0 = np.zeros(3)
    ocp.constraints.lh, ocp.constraints.uh, ocp.constraints.idxsh = np.zeros(bounds), np.full(bounds, 1e4), np.arange(bounds)
    # The weights of broken constraints are set before it is solved.
    ocp.cost.zl = ocp.cost.Zl = ocp.cost.zu = ocp.cost.Zu = np.zeros(bounds)
    ocp.parameter_values = np.array([*CRUISE, 0.0, 0.0, FOLLOW, DANGER])
    options = ocp.solver_options
    options.qp_solver, options.qp_solver_cond_N, options.qp_solver_iter_max, options.qp_tol = "PARTIAL_CONDENSING_HPIPM", 1, 10, 1e-3
    options.nlp_solver_type, options.hessian_approx, options.integrator_type = "SQP_RTI", "GAUSS_NEWTON", "ERK"
    options.tf, options.shooting_nodes = float(TIMES[-1]), TIMES
    return ocp


class Plan:
    """The solver with its memory: it starts from its last plan, and a change of acceleration has a price."""

    def __init__(self, solver: Solver) -> None:
        self.solver = solver
        self.state, self.former = np.zeros(3), np.zeros(NODES + 1)
        self.speeds, self.accelerations = np.zeros(NODES + 1), np.zeros(NODES + 1)
        self.forget()

    def forget(self) -> None:
        """Start from nothing."""
        self.solver.reset()
        for node in range(NODES + 1):
            self.solver.set(node, "x", np.zeros(3))
            count = len(WEIGHTS) if node < NODES else len(WEIGHTS) - 1
            self.solver.cost_set(node, "yref", np.zeros(count))
        self.state[:] = 0.0
        # After a solver has failed, a plan is to stand.
        self.former, self.speeds, self.accelerations = np.zeros(NODES + 1), np.zeros(NODES + 1), np.zeros(NODES + 1)
        self.smooth: bool | None = None
        self.weigh(True)

    def weigh(self, smooth: bool) -> None:
        """Set the weights; ``smooth`` is whether a change of acceleration has a price, which fades between one and two seconds."""
        if smooth == self.smooth:
            return
        self.smooth = smooth
        for node in range(NODES):
            weights = np.array(WEIGHTS)
            weights[4] *= np.interp(TIMES[node], (1.0, 2.0), (1.0, 0.0)) if smooth else 0.0
            self.solver.cost_set(node, "W", np.asfortranarray(np.diag(weights)))
            self.solver.cost_set(node, "Zl", np.array(LIMITS))
        self.solver.cost_set(NODES, "W", np.copy(np.diag(weights)[:-1, :-1]))

    def from_state(self, speed: float, acceleration: float) -> None:
        """Set what the car does now (m/s, m/s^2)."""
        jumped = abs(speed - self.state[1]) > 2.0
        self.state[1:] = speed, acceleration
        if jumped:
            for node in range(NODES + 1):
                self.solver.set(node, "x", self.state)

    def solve(self, leads: list[Lead], limit: float) -> None:
        """Plan for the leads ahead and a set speed (m/s)."""
        speed = self.state[1]
        obstacle = np.min([forecast(lead, speed) for lead in leads] + [self._set_speed(limit)], axis=0)
        for node in range(NODES + 1):
            self.solver.set(node, "p", np.array([LEAST, GREATEST, obstacle[node], self.former[node], FOLLOW, DANGER]))
        self.solver.constraints_set(0, "lbx", self.state)
        self.solver.constraints_set(0, "ubx", self.state)
        failed = self.solver.solve() != 0
        plan = np.array([self.solver.get(node, "x") for node in range(NODES + 1)])
        self.speeds, self.accelerations = plan[:, 1], plan[:, 2]
        self.former = np.interp(TIMES + TICK, TIMES, self.accelerations)
        if failed:
            self.forget()

    def _set_speed(self, limit: float) -> Array:
        """An obstacle that keeps the car at the set speed."""
        least, greatest = (self.state[1] + 1.05 * each * TIMES for each in CRUISE)
        speeds = np.clip(limit, least, greatest)
        return np.asarray(np.cumsum(STEPS * speeds) + comfortable(speeds, FOLLOW))


def forecast(lead: Lead, speed: float) -> Array:
    """The standing obstacle that stands for a lead, at the nodes of the plan (m)."""
    distance, lead_speed, acceleration = lead
    # No plan exists if the car cannot stop any more; then the obstacle is where it still can.
    nearest = 0.5 * (speed + lead_speed) * (speed - lead_speed) / (-2.0 * LEAST)
    changes = np.clip(acceleration, -10.0, 5.0) * np.exp(-FADING * TIMES**2 / 2.0)
    speeds = np.maximum(max(lead_speed, 0.0) + np.cumsum(STEPS * changes), 0.0)
    return np.asarray(max(distance, nearest) + np.cumsum(STEPS * speeds) + braking(speeds))


def nobody(speed: float) -> Lead:
    """What openpilot assumes where no lead is: one that drives away."""
    return 50.0, speed + 10.0, 0.0


class Driver:
    """The planner of one world: the filter before the solver, and what becomes of its plan."""

    def __init__(self, plan: Any) -> None:
        self.plan, self.wanted, self.speed = plan, 0.0, 0.0
        self.ceiling, self.holding = GREATEST, 0.0

    def begin(self, speed: float) -> None:
        """Forget the last episode."""
        self.plan.forget()
        self.wanted, self.speed, self.ceiling, self.holding = 0.0, speed, GREATEST, 0.0

    def accelerate(self, speed: float, limit: float, leads: list[Lead]) -> float:
        """The acceleration of a tick (m/s^2)."""
        # A filter with a time constant of 2 s holds the plan's speed near the car's.
        share = TICK / (2.0 + TICK)
        self.speed = max(0.0, (1.0 - share) * self.speed + share * speed)
        self.plan.weigh(speed > 0.01)
        self.plan.from_state(self.speed, self.wanted)
        self.plan.solve((leads + [nobody(self.speed)] * 2)[:2], limit)
        speeds, accelerations = self.plan.speeds, self.plan.accelerations
        before, self.wanted = self.wanted, float(np.interp(TICK, TIMES, accelerations))
        self.speed += TICK * (self.wanted + before) / 2.0
        ahead = DELAY + TICK
        then = float(np.interp(ahead, TIMES, speeds))
        target = 2.0 * (then - float(speeds[0])) / ahead - float(accelerations[0])
        pull = float(np.interp(speed, PULL_AT, PULL))
        self.ceiling = min(max(pull, self.ceiling - 0.05), self.ceiling + 0.05)
        if float(speeds[0]) < STOPPING and target < 0.1:
            self.holding = max(HOLD, min(self.holding, target) - TICK)
            return self.holding
        self.holding = 0.0
        return min(max(target, LEAST), self.ceiling)


class Openpilot:
    """All worlds, each with a solver of its own."""

    def __init__(self, hello: dict[str, Any], make: Callable[[], Any]) -> None:
        self.vehicle, self.make = hello["vehicle"], make
        if abs(hello["tick_s"] - TICK) > 1e-9:
            raise SystemExit(f"openpilot plans every {TICK} s, and the tick of the episode is {hello['tick_s']} s; say `tick: {TICK} s`")
        # The first solver compiles the problem: that is part of the start, and not of the first answer.
        self.made = [make()]
        self.drivers: dict[int, Driver] = {}

    def decide(self, frame: Frame) -> tuple[Array, Array]:
        """Accelerations (m/s^2) and steers."""
        # Where the route ends, its set speed is none.
        limits = np.where(frame.points > 0, np.minimum(frame.limits(EASY), frame.bends(LATERAL, EASY)), 0.0)
        leads = self._leads(frame)
        accelerations = np.zeros(len(frame.ids))
        for row, number in enumerate(frame.ids.tolist()):
            starts = bool(frame.starts[row])
            if number not in self.drivers:
                self.drivers[number], starts = Driver(self.made.pop() if self.made else self.make()), True
            driver, speed = self.drivers[number], max(float(frame.speed[row]), 0.0)
            if starts:
                driver.begin(speed)
            accelerations[row] = driver.accelerate(speed, float(limits[row]), leads[row])
        return accelerations, frame.steer(self.vehicle)

    def _leads(self, frame: Frame) -> list[list[Lead]]:
        """The two nearest road users in the path of each car, and a light at which it must stop, as leads."""
        ahead, left, direction = frame.along(self.vehicle)
        turn = frame.actors[:, 3] - direction
        halves = frame.actors[:, 6:8] / 2.0
        reach = np.abs(np.cos(turn)) * halves[:, 0] + np.abs(np.sin(turn)) * halves[:, 1]
        side = np.abs(np.cos(turn)) * halves[:, 1] + np.abs(np.sin(turn)) * halves[:, 0]
        speeds = frame.actors[:, 4] * np.cos(direction) + frame.actors[:, 5] * np.sin(direction)
        gaps = ahead - self.vehicle["length"] / 2.0 - reach
        found: list[list[Lead]] = [[] for _ in frame.ids]
        for row in np.flatnonzero((np.abs(left) - side < self.vehicle["width"] / 2.0) & (ahead > 0.0)):
            found[frame.world_of[row]].append((float(gaps[row]), float(speeds[row]), 0.0))
        must = (frame.light == RED) | ((frame.light == YELLOW) & (braking(frame.speed) < frame.light_distance))
        for row in np.flatnonzero(must):
            # It keeps its distance from a lead, so a lead that far beyond the light makes it stop there.
            found[row].append((float(frame.light_distance[row]) - self.vehicle["length"] / 2.0 + STOP, 0.0, 0.0))
        return [sorted(each)[:2] for each in found]


def main(words: list[str]) -> None:
    """Serve the planner; `--openpilot DIR` takes the problem from a checkout."""
    if not words:
        serve("openpilot_like", lambda hello: Openpilot(hello, lambda: Plan(solver())).decide)
        return
    if len(words) != 2 or words[0] != "--openpilot":
        raise SystemExit(f"{' '.join(words)!r} is not an option of this driver; it has --openpilot DIR")
    from .openpilot_checkout import Checkout

    checkout = Checkout(Path(words[1]))
    serve("openpilot", lambda hello: Openpilot(hello, checkout.plan).decide)


def solver() -> Solver:
    """A solver of the problem of this file."""
    return compiled(problem, Path(__file__).read_bytes())
