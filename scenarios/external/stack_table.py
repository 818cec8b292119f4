"""The table of a stack's page from reports of its scenario: `python3 scenarios/external/stack_table.py REPORT...`.

Each report is a seed. A row is a driver; counts are sums over the seeds.

- faults, hits: episodes with `natural` or `intercept`, each with a start of its own, that end in a fault, or in a collision with the moving car
- braked needlessly: of the natural encounters whom the car passes with 2 m or more to spare as it drives without anybody, those that delay it by a
  second (table `prices`)
- search: starts with a fault, of those that the search has tried
- fastest: the highest speed of the car in a fault (m/s)
"""

import csv
import sys
from pathlib import Path


def read(folder, table):
    path = Path(folder) / f"{table}.csv"
    if path.exists():
        with open(path, newline="", encoding="utf-8") as file:
            yield from csv.DictReader(file)


def share(count, of):
    return f"{count} of {of}" if of else "–"


def main(folders):
    episodes, searches, fastest, prices = {}, {}, {}, {}
    for folder in folders:
        for row in read(folder, "episodes"):
            episodes.setdefault(row["driver"], {})[folder, row["pedestrian"], row["episode"]] = row
        for row in read(folder, "searches"):
            searches.setdefault(row["driver"], []).append(row)
        for row in read(folder, "prices"):
            delayed, spared = prices.get(row["driver"], (0, 0))
            own = int(row["spared_encounters"])
            prices[row["driver"]] = delayed + round(float(row["needless_braking"] or 0) * own), spared + own
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
        tried = searches.get(policy, [])
        found = share(sum(int(row["fault_starts"]) for row in tried), sum(int(row["starts"]) for row in tried))
        fast = f"{fastest[policy]:.1f}" if policy in fastest else "–"
        print(f"| `{policy}` | {' | '.join(cells)} | {share(*prices.get(policy, (0, 0)))} | {found} | {fast} |")


main(sys.argv[1:])
