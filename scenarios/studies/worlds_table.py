"""The tables of `reports/worlds.md` from what `worlds.scn` makes:

    worlds_table.py FULL.json...                     how many faults remain faults, and how many near misses become faults
    worlds_table.py --causes FOLDER...               what makes those that differ end as at home; each folder has full.json, exact=speed.json, ...
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
    counts, seeds = defaultdict(Counter), []
    for file in files:
        found = json.loads(Path(file).read_text())["failures"]
        for row in found:
            for driver in (row["driver"], None):
                counts[driver].update({name: row[name] for name in ("failures", "old_faults", "still_faults", "turned_faults", "failed_encounters")})
        seeds.append(share(sum(row["still_faults"] for row in found), sum(row["old_faults"] for row in found)))
    print("| driver | faults that remain faults | near misses that become faults | errors |\n|---|--:|--:|--:|")
    for driver, own in sorted(counts.items(), key=lambda item: item[0] is None):
        others = own["failures"] - own["old_faults"]
        cells = [share(own["still_faults"], own["old_faults"]), share(own["turned_faults"], others), str(own["failed_encounters"])]
        print(f"| {f'`{driver}`' if driver else '**all**'} | {' | '.join(cells)} |")
    print("\nEach file alone: " + "; ".join(seeds))


def ends(file):
    """For each encounter that had or has a collision: the driver, and whether it is a fault at home and there."""
    found, recheck = {}, json.loads(Path(file).read_text())
    errors = sum(row["failed_encounters"] for row in recheck["failures"])
    if errors:
        sys.exit(f"{file}: {errors} encounters failed, and say nothing of a cause")
    for change in recheck["failure_changes"]:
        before, after = (change[side].get("collision") for side in ("before", "after"))
        found[change["before"]["name"]] = (change["where"].split(" in ")[0], bool(before and before["fault"]), bool(after and after["fault"]))
    return found


#: What was switched off, and in which words a table says so if the encounter ends as at home then.
SWITCHES = ("exact=speed", "exact=path", "exact=both", "substeps=20")
KINDS = ("speed", "path", "speed or path", "speed and path together", "steps of physics alone", "none found")


def kind(restored):
    match restored:
        case (True, True, *_):
            return "speed or path"
        case (True, False, *_):
            return "speed"
        case (False, True, *_):
            return "path"
        case (_, _, True, _):
            return "speed and path together"
        case (_, _, _, True):
            return "steps of physics alone"
    return "none found"


def causes(folders):
    counts, unexplained = defaultdict(Counter), []
    for folder in map(Path, folders):
        others = [ends(folder / f"{switch}.json") for switch in SWITCHES]
        for name, (driver, at_home, there) in ends(folder / "full.json").items():
            if at_home != there:
                found = kind([other.get(name, (driver, at_home, False))[2] == at_home for other in others])
                for row in ((at_home, driver), (at_home, "all")):
                    counts[row][found] += 1
                if found == KINDS[-1]:
                    unexplained.append(f"{folder.name}/{name} ({driver})")
    for at_home, title in ((True, "faults that are lost"), (False, "others that become faults")):
        print(f"| {title} | number | {' | '.join(KINDS)} |\n|---|{'--:|' * (len(KINDS) + 1)}")
        for driver in sorted({driver for side, driver in counts if side == at_home}, key=lambda name: (name == "all", name)):
            own = counts[at_home, driver]
            print(f"| `{driver}` | {own.total()} | {' | '.join(str(own[found]) for found in KINDS)} |")
    print("None found:", ", ".join(unexplained))


def native(folders):
    groups, worlds = defaultdict(list), []
    for row in (row for folder in folders for row in rows(folder)):
        groups[row["driver"], row["pedestrian"], row["world"]].append(row)
        worlds += [row["world"]] if row["world"] not in worlds else []
    print("| driver | pedestrian |" + "".join(f" faults in `{world}` | collisions | left out |" for world in worlds))
    print("|---|---|" + "--:|--:|--:|" * len(worlds))
    for policy, controller in dict.fromkeys(key[:2] for key in groups):
        cells = []
        for world in worlds:
            own = groups[policy, controller, world]
            fit = [row for row in own if not row["error"] and not row["left_out"]]
            faults, hits = (sum(row[name] == value for row in fit) for name, value in (("fault", "true"), ("outcome", "collision")))
            cells += [share(faults, len(fit)), share(hits, len(fit)), str(len(own) - len(fit))]
        print(f"| `{policy}` | `{controller}` | {' | '.join(cells)} |")
    for policy in dict.fromkeys(key[0] for key in groups):
        faults = [row for key, own in groups.items() if key[0] == policy for row in own if row["fault"] == "true" and not row["left_out"]]
        shortest = min(faults, key=lambda row: float(row["episode_length_s"]), default=None)
        said = f"{shortest['run_id']}:{shortest['episode']}, {float(shortest['episode_length_s']):.2f} s" if shortest else "none"
        print(f"shortest fault of {policy}: {said}")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--native", *folders]:
            native(folders)
        case ["--causes", *folders]:
            causes(folders)
        case files:
            agreement(files)
