"""The table of a stack's page from reports of its scenario: `python3 scenarios/external/stack_table.py REPORT...`.

Each report is a seed. A row is a driver; counts are sums over the seeds.

- faults, hits: episodes with `natural` or `intercept`, each with a start of its own, that end in a fault, or in a collision with the moving car
- braked needlessly: of the episodes with `natural` in which the driver that sees nobody passes with 2 m or more to spare, those in which this
  driver needs a second longer
- search: starts with a fault, of those that the search has tried
- fastest: the highest speed of the car in a fault (m/s)
"""

import csv
import sys
from pathlib import Path

SPARE, LATER = 2.0, 1.0  # m, s


def read(folder, table):
    with open(Path(folder) / f"{table}.csv", newline="", encoding="utf-8") as file:
        yield from csv.DictReader(file)


def share(count, of):
    return f"{count} of {of}" if of else "–"


def main(folders):
    episodes, searches, fastest = {}, {}, {}
    for folder in folders:
        for row in read(folder, "episodes"):
            episodes.setdefault(row["driver"], {})[folder, row["pedestrian"], row["episode"]] = row
        for row in read(folder, "searches"):
            searches.setdefault(row["driver"], []).append(row)
        for row in read(folder, "failures"):
            if row["fault"] == "true" and row["impact_speed_mps"]:
                fastest[row["driver"]] = max(fastest.get(row["driver"], 0.0), float(row["impact_speed_mps"]))
    print("| driver | `natural`: faults | hits | `intercept`: faults | hits | braked needlessly | search: starts with a fault | fastest (m/s) |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for policy, rows in episodes.items():
        cells = []
        for controller in ("natural", "intercept"):
            those = [row for (_, name, _), row in rows.items() if name == controller and not row["error"]]
            faults = [row for row in those if row["fault"] == "true"]
            cells += [share(len(faults), len(those)), str(sum(row["outcome"] == "collision" for row in those))]
        free = [(row, rows[key]) for key, row in episodes["blind"].items() if key[1] == "natural" and key in rows]
        free = [pair for pair in free if pair[0]["outcome"] != "collision" and float(pair[0]["least_gap_m"] or "inf") >= SPARE]
        later = sum(float(own["episode_length_s"]) >= float(blind["episode_length_s"]) + LATER for blind, own in free)
        tried = searches.get(policy, [])
        found = share(sum(int(row["fault_starts"]) for row in tried), sum(int(row["starts"]) for row in tried))
        fast = f"{fastest[policy]:.1f}" if policy in fastest else "–"
        print(f"| `{policy}` | {' | '.join(cells)} | {share(later, len(free))} | {found} | {fast} |")


main(sys.argv[1:])
