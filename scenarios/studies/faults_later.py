"""What is left of the avoidable injury of each driver if the careful humans react 0.25 s later, for `reports/faults.md`:

    faults_later.py REPORT...

A report is that of the campaign `later` in `faults.scn`, one for each seed. A fault is left if its `latest_reaction_s` is at least 1.40 s: the
careful human of UN R157 has 1.15 s. A gate that opens at 2 s, not in time to stop, opens up to v / 2a - 0.25 s later (not at all, if the pedestrian
comes on course after that), with v at the gate. The last column takes all of it and v at the touch: an estimate. Faults are *different* if their
digests are.
"""

import csv
import math
import sys
from collections import defaultdict
from pathlib import Path

CAREFUL = 1.15
#: The greatest deceleration of the Model 3's brake (m/s²).
BRAKE = 7.01


def rows(report, table):
    with open(Path(report) / f"{table}.csv", newline="", encoding="utf-8") as file:
        yield from csv.DictReader(file)


def risk(speed):
    """The risk of a severe injury at a speed in m/s, as in the verdicts."""
    return 1 / (1 + math.exp(4.68 - 0.0881 * 3.6 * speed))


def main(reports):
    found = defaultdict(list)
    for report in reports:
        episodes, faults = defaultdict(int), defaultdict(list)
        for row in rows(report, "searches"):
            episodes[row["driver"]] += int(row["episodes"])
        for row in rows(report, "failures"):
            if row["fault"] == "true":
                faults[row["driver"]].append(row)
        for driver, number in episodes.items():
            all_of_them = faults[driver]
            injury = [0.0, 0.0, 0.0]
            for row in all_of_them:
                speed, latest = float(row["impact_speed_mps"]), float(row["latest_reaction_s"] or 0)
                at_the_gate = max(0.0, CAREFUL + 0.6 + speed / (2 * BRAKE) - 2)
                for place, delay in enumerate((-CAREFUL, 0.25, at_the_gate)):
                    injury[place] += 1000 * risk(speed) / number if latest >= CAREFUL + delay else 0
            different = {(row["run_id"], row["start_number"], row["digest"]) for row in all_of_them}
            found[driver].append((len(all_of_them), len(different), *injury))
    for driver, seeds in found.items():
        total, different, now, *_ = map(sum, zip(*seeds))

        def less(place):
            sums = [[*map(sum, zip(*seeds))], *seeds]
            return [f"{100 * (each[place] / each[2] - 1):.0f}" if each[2] else "-" for each in sums]

        (later_all, *later), (gate, *_) = less(3), less(4)
        print(f"| `{driver}` | {total:,} | {different:,} | {now / len(seeds):.3f} | {later_all} ({', '.join(later)}) | {gate} |")


main(sys.argv[1:])
