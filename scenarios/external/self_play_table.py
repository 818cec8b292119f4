"""The tables of reports/self_play.md: `python3 scenarios/external/self_play_table.py self_play/*/self_play`.

Each report is a seed. All drivers have the same starts. Intervals are Wilson's 95 % over starts, both towns and all seeds together.

- collisions: episodes in which the moving car touches the pedestrian
- only it, only blind: of the starts of `self_play_blind`, those from which this driver alone collides, and those from which that one alone does
"""

import csv
import sys
from pathlib import Path

Z = 1.959964


def wilson(count, of):
    centre, spread = count + Z * Z / 2, Z * (count * (of - count) / of + Z * Z / 4) ** 0.5
    return f"{count} of {of} ({(centre - spread) / (of + Z * Z):.3f}..{(centre + spread) / (of + Z * Z):.3f})"


def main(folders):
    episodes = {}
    for folder in folders:
        with open(Path(folder) / "episodes.csv", newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                if not row["error"] and not row["left_out"]:
                    key = row["pedestrian"], row["driver"]
                    episodes.setdefault(key, {})[folder, row["town"], row["episode"]] = row
    print("| pedestrian | driver | collisions | faults | only it | only blind |")
    print("|---|---|--:|--:|--:|--:|")
    for (pedestrian, driver), rows in episodes.items():
        blind = episodes[pedestrian, "self_play_blind"]
        hits = {start for start, row in rows.items() if row["outcome"] == "collision"}
        blind_hits = {start for start, row in blind.items() if row["outcome"] == "collision" and start in rows}
        faults = sum(row["fault"] == "true" for row in rows.values())
        only, only_blind = len(hits & blind.keys() - blind_hits), len(blind_hits - hits)
        print(
            f"| {pedestrian} | `{driver}` | {wilson(len(hits), len(rows))} | {wilson(faults, len(rows))} "
            f"| {only} | {only_blind} |"
        )


main(sys.argv[1:])
