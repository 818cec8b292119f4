"""The tables of `reports/worlds.md` from what `worlds.scn` makes:

    worlds_table.py FULL.json...                     how many faults remain faults, and how many near misses become faults
    worlds_table.py --causes FULL.json OTHER.json... how many of those that differ are as at home with one thing changed
    worlds_table.py --native REPORT...               the drivers of other simulators

A JSON file is the output of `falsify recheck --format json`, one for each seed. Intervals are those of Clopper and Pearson (95 %).
"""

import csv
import json
import math
import sys
from collections import Counter, defaultdict
from pathlib import Path


def rows(folder):
    with open(Path(folder) / "episodes.csv", newline="", encoding="utf-8") as file:
        yield from csv.DictReader(file)


def tail(successes, trials, share):
    """The probability of at least so many successes."""
    if successes == 0:
        return 1.0
    logs = [math.lgamma(trials + 1) - math.lgamma(k + 1) - math.lgamma(trials - k + 1) + k * math.log(share) + (trials - k) * math.log1p(-share)
            for k in range(successes, trials + 1)]  # fmt: skip
    return math.fsum(map(math.exp, logs))


def interval(successes, trials, alpha=0.05):
    """Clopper and Pearson, by bisection."""

    def root(is_below):
        low, high = 1e-12, 1.0 - 1e-12
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if is_below(middle) else (low, middle)
        return low

    low = root(lambda share: tail(successes, trials, share) < alpha / 2) if successes else 0.0
    high = root(lambda share: 1 - tail(successes + 1, trials, share) > alpha / 2) if successes < trials else 1.0
    return low, high


def share(successes, trials):
    if not trials:
        return "–"
    low, high = interval(successes, trials)
    return f"{successes} of {trials}: {100 * successes / trials:.1f} % ({100 * low:.1f} to {100 * high:.1f})"


def agreement(files):
    counts = defaultdict(Counter)
    for file in files:
        for row in json.loads(Path(file).read_text())["failures"]:
            for driver in (row["policy"], None):
                counts[driver].update({name: row[name] for name in ("failures", "old_faults", "still_faults", "turned_faults", "failed_encounters")})
    print("| driver | faults that remain faults | near misses that become faults | errors |\n|---|--:|--:|--:|")
    for driver, own in sorted(counts.items(), key=lambda item: item[0] is None):
        others = own["failures"] - own["old_faults"]
        cells = [share(own["still_faults"], own["old_faults"]), share(own["turned_faults"], others), str(own["failed_encounters"])]
        print(f"| {f'`{driver}`' if driver else '**all**'} | {' | '.join(cells)} |")


def ends(file):
    """For each encounter whether it is a fault at home and there, and what it is there."""
    found = {}
    for change in json.loads(Path(file).read_text())["failure_changes"]:
        before, after = (change[side].get("collision") for side in ("before", "after"))
        what = "no contact" if not after else "a fault" if after["fault"] else "a contact without fault"
        found[change["before"]["name"]] = (bool(before and before["fault"]), bool(after and after["fault"]), what)
    return found


def causes(full, others):
    differ = {name: end for name, end in ends(full).items() if end[0] != end[1]}
    print(Counter(("a fault" if end[0] else "no fault", end[2]) for end in differ.values()))
    print("| changed | faults that are faults again | others that are none again |\n|---|--:|--:|")
    for other in others:
        again = ends(other)
        lost = [again[name][1] for name, end in differ.items() if end[0]]
        turned = [not again.get(name, (False, False))[1] for name, end in differ.items() if not end[0]]
        print(f"| `{Path(other).stem}` | {sum(lost)} of {len(lost)} | {sum(turned)} of {len(turned)} |")


def native(folders):
    groups = defaultdict(list)
    for folder in folders:
        for row in rows(folder):
            groups[row["world"], row["policy"], row["controller"]].append(row)
    print("| world | driver | pedestrian | faults | collisions | fastest fault (m/s) | left out |\n|---|---|---|--:|--:|--:|--:|")
    for (world, policy, controller), own in groups.items():
        fit = [row for row in own if not row["error"] and not row["left_out"]]
        faults = [row for row in fit if row["fault"] == "true"]
        fastest = max((float(row["impact_speed_mps"]) for row in faults), default=None)
        hits = sum(row["collision"] == "true" for row in fit)
        figures = [share(len(faults), len(fit)), share(hits, len(fit)), f"{fastest:.1f}" if fastest else "–", str(len(own) - len(fit))]
        print(f"| {world} | `{policy}` | `{controller}` | {' | '.join(figures)} |")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--native", *folders]:
            native(folders)
        case ["--causes", full, *others]:
            causes(full, others)
        case files:
            agreement(files)
