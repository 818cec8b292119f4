"""Compares the searches of scenarios/studies/requirements.scn with psy-taliro 3.2.0: `python3 requirements_rival.py REPORT SEED…`, with the folders of reports.

    for seed in 1 2 3; do falsify run scenarios/studies/requirements.scn --seed $seed --out requirements/$seed; done
    pip install ./python psy-taliro==3.2.0
    python3 scenarios/studies/requirements_rival.py requirements/1/requirements requirements/2/requirements requirements/3/requirements

Both sides search from starts 0, 1, 2, … of the search of a seed, in the same environment; the hash of start 0 is compared. psy-taliro has, for each requirement, driver
and seed, as many simulations as `archive` had. From a start it may use CAP of them and leaves it at its first violation, with its own stopping rule. A sample is a
walk: heading and speed of the pedestrian, each with four values that are kept for 3 s. The cost is the robustness, from the monitor of the environment.

Printed are the starts from which each method found a violation, and of ARCH-COMP's count the share of falsified runs with the mean and the median of the simulations to
the first violation over these.
"""

import csv
import logging
import math
import statistics
import sys
import tomllib
from pathlib import Path

import falsify_av
from staliro import SignalInput, TestOptions, costfunc, staliro
from staliro.cost_func import Result
from staliro.optimizers import DualAnnealing, UniformRandom
from staliro.signals import piecewise_constant

SCENARIO = Path(__file__).with_name("requirements.scn")
GOALS = ["no_collision", "slow_pass", "safe_passing", "no_imminent_risk", "comfort"]
METHODS = {"kinds": "archive", "plans": "cem", "meet": "intercept"}  # of requirements.scn
LEGS, SECONDS = 4, 12.0
RIVALS = {
    "psy-taliro annealing, 25": (DualAnnealing, 25),
    "psy-taliro annealing, 4": (DualAnnealing, 4),
    "psy-taliro uniform, 25": (UniformRandom, 25),
    "psy-taliro uniform, 4": (UniformRandom, 4),
}


class Spent(Exception):
    """All simulations are used."""


def searches(report):
    with open(Path(report) / "searches.csv", newline="", encoding="utf-8") as file:
        yield from csv.DictReader(file)


def simulate(env, start, walk):
    """The robustness of the goal if the pedestrian walks so from a start, and the end of the episode."""
    _, info = env.reset(options={"episode": start})
    decision, over = 0, False
    while not over:
        time = decision * 0.5
        _, _, terminated, truncated, info = env.step(walk(time))
        over = terminated or truncated
        decision += 1
    return info


def rival(env, goal, optimizer, cap, budget, seed):
    """The failed starts, and the number of simulations to the first violation, of a budget of simulations."""
    used, first, failed, start = 0, None, set(), 0
    speeds = (0.0, float(env.action_space.high[1]))
    turn = [(-math.pi, math.pi)] * LEGS

    def cost_of(inputs):
        nonlocal used, first
        if used >= budget:
            raise Spent
        heading, speed = inputs.signals["heading"], inputs.signals["speed"]
        last = SECONDS - 1e-6
        info = simulate(env, start, lambda time: [heading.at_time(min(time, last)), speed.at_time(min(time, last))])
        used += 1
        found = info["requirements"][goal]
        if found["violated"]:
            failed.add(start)
            first = first or used
        # The sign decides; -0 is a violation, and infinity is no number for an optimiser.
        return Result(min(max(found["robustness"], -1e3), 1e3) if not found["violated"] else min(max(found["robustness"], -1e3), -1e-9), None)

    try:
        while used < budget:
            options = TestOptions(
                tspan=(0.0, SECONDS),
                signals={
                    "heading": SignalInput(control_points=turn, factory=piecewise_constant),
                    "speed": SignalInput(control_points=[speeds] * LEGS, factory=piecewise_constant),
                },
                runs=1,
                iterations=cap,
                seed=seed * 1_000_003 + start + 1,
            )
            staliro(costfunc(cost_of), optimizer(min_cost=0.0), options)
            start += 1
    except Spent:
        pass
    return len(failed), start, first


def main(reports):
    logging.disable(logging.CRITICAL)
    rows = []
    for report in reports:
        seed = tomllib.loads((Path(report) / "manifest.toml").read_text(encoding="utf-8"))["seed"]
        runs = list(searches(report))
        for row in runs:
            simulations = int(row["episodes"]) + int(row["left_out_episodes"])
            first = row["first_failure_simulations"]
            rows.append((METHODS[row["method"]], GOALS[int(row["block"])], row["driver"], seed, int(row["failed_starts"]), int(row["starts"]), simulations, int(first) if first else None))
        for row in (row for row in runs if row["method"] == "kinds"):
            goal, policy = GOALS[int(row["block"])], row["driver"]
            budget = int(row["episodes"]) + int(row["left_out_episodes"])
            env = falsify_av.make(str(SCENARIO), "requirements", task="search", block=int(row["block"]), town="harbour", policy=policy, reward="fault", seed=seed)
            info = simulate(env, 0, lambda time: [0.0, 0.0])
            assert row["first_start"] == f"0:{info['start']}", (row["first_start"], info["start"])
            for name, (optimizer, cap) in RIVALS.items():
                failed, starts, first = rival(env, goal, optimizer, cap, budget, seed)
                rows.append((name, goal, policy, seed, failed, starts, budget, first))
            env.close()
            print(report, goal, policy, budget, *[row[4] for row in rows[-4:]], file=sys.stderr, flush=True)
    tell(rows)


def tell(rows):
    methods = list(dict.fromkeys(row[0] for row in rows))
    policies = list(dict.fromkeys(row[2] for row in rows))
    print("| requirement | driver | simulations |", *[f"{method} |" for method in methods])
    print("|---|---|---|" + "---|" * len(methods))
    for goal in GOALS:
        for policy in policies:
            of = [row for row in rows if row[1] == goal and row[2] == policy]
            budget = sum(row[6] for row in of if row[0] == "archive")
            counts = [sum(row[4] for row in of if row[0] == method) for method in methods]
            print(f"| `{goal}` | `{policy}` | {budget:,} |", *[f"{count} |" for count in counts])
    totals = [sum(row[4] for row in rows if row[0] == method) for method in methods]
    print("| all | | |", *[f"{total} |" for total in totals])
    print("\n| method | simulations | starts | failed starts | falsified runs | mean simulations to the first | median |\n|---|---|---|---|---|---|---|")
    for method, total in zip(methods, totals):
        of = [row for row in rows if row[0] == method]
        firsts = [row[7] for row in of if row[7]]
        mean, median = (f"{statistics.mean(firsts):.0f}", f"{statistics.median(firsts):.0f}") if firsts else ("–", "–")
        print(f"| {method} | {sum(row[6] for row in of):,} | {sum(row[5] for row in of):,} | {total} | {len(firsts)} of {len(of)} | {mean} | {median} |")


if __name__ == "__main__":
    main(sys.argv[1:])
