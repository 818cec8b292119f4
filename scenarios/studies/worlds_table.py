"""The tables of `reports/worlds.md` from reports of `worlds.scn`: `python3 scenarios/studies/worlds_table.py [--native] REPORT...`.

Each report is a seed. Episodes are paired by town, driver, pedestrian, run and number: they have one start. Left out are pairs of which one is in error or
left out, and pairs with other starts.

- faults: of the faults here, those that are faults there, with the interval (95 %, Clopper and Pearson)
- near misses: of the episodes here without a fault and with a gap below 1 m, those that are faults there
- why a fault is none there: no contact; a contact that no driver could have avoided; a contact with a car at rest
"""

import csv
import math
import sys
from collections import Counter, defaultdict
from pathlib import Path

HERE, NEAR = "here", 1.0  # The world of the program; m


def rows(folder):
    with open(Path(folder) / "episodes.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            yield (folder, row["town"], row["policy"], row["controller"], row["run"], row["episode"]), row


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


def is_fault(row):
    return row["fault"] == "true"


def counts(row):
    return not row["error"] and not row["left_out"]


def why(there):
    if there["collision"] != "true":
        return "a car at rest" if there["outcome"] == "bump" else "no contact"
    return f"a contact that is {there['counts_as'] or there['verdict']}"


def agreement(folders):
    worlds = defaultdict(dict)
    for folder in folders:
        for key, row in rows(folder):
            worlds[row["world"]][key] = row
    print("| world | driver | faults that remain faults | near misses that become faults | left out |\n|---|---|--:|--:|--:|")
    reasons = Counter()
    for world in sorted(set(worlds) - {HERE}):
        pairs = [(worlds[HERE][key], row) for key, row in worlds[world].items() if key in worlds[HERE]]
        drivers = list(dict.fromkeys(here["policy"] for here, _ in pairs))
        for driver in [*drivers, None]:
            own = [pair for pair in pairs if driver in (None, pair[0]["policy"])]
            fit = [(here, there) for here, there in own if counts(here) and counts(there) and here["start"] == there["start"]]
            faults = [pair for pair in fit if is_fault(pair[0])]
            near = [pair for pair in fit if not is_fault(pair[0]) and float(pair[0]["least_gap_m"] or "inf") < NEAR and pair[0]["outcome"] != "bump"]
            cells = [share(sum(is_fault(there) for _, there in some), len(some)) for some in (faults, near)]
            print(f"| {world} | {f'`{driver}`' if driver else '**all**'} | {' | '.join(cells)} | {len(own) - len(fit)} |")
            if driver is None:
                reasons.update((world, why(there)) for _, there in faults if not is_fault(there))
    print("\n| world | what a fault became | number |\n|---|---|--:|")
    for (world, reason), number in sorted(reasons.items(), key=lambda item: -item[1]):
        print(f"| {world} | {reason} | {number} |")


def native(folders):
    groups = defaultdict(list)
    for folder in folders:
        for (_, town, *_), row in rows(folder):
            groups[row["world"], row["policy"], row["controller"]].append(row)
    print("| world | driver | pedestrian | faults | collisions | fastest fault (m/s) | left out |\n|---|---|---|--:|--:|--:|--:|")
    for (world, policy, controller), own in groups.items():
        fit = [row for row in own if counts(row)]
        faults = [row for row in fit if is_fault(row)]
        fastest = max((float(row["impact_speed_mps"]) for row in faults), default=None)
        hits = sum(row["collision"] == "true" for row in fit)
        figures = [share(len(faults), len(fit)), share(hits, len(fit)), f"{fastest:.1f}" if fastest else "–", str(len(own) - len(fit))]
        print(f"| {world} | `{policy}` | `{controller}` | {' | '.join(figures)} |")


if __name__ == "__main__":
    given = sys.argv[1:]
    native(given[1:]) if given[:1] == ["--native"] else agreement(given)
