"""A ceiling for the places of road.scn that knows neither the sensors' errors nor the car's turns.

road_ceiling.py write EPISODES.csv   a scenario, for this folder: the first 12 starts of each place in the report of campaign `before`, each drawn six times
road_ceiling.py score CACHE REPORTS  of each start the share of draws with a fault of that walk of the grid which has most in the other draws
"""

import collections
import csv
import glob
import json
import math
import os
import re
import sys

STARTS, DRAWS, WALKS = 12, 6, 945


def rows(path):
    with open(path, encoding="utf-8") as table:
        return list(csv.DictReader(table))


def write(episodes):
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "road.scn"), encoding="utf-8") as study:
        head = study.read().partition("\n/// As `hunter` was trained")[0]
    print(head + f"\nmethod again = exhaustive(levels: 3, starts: {DRAWS})")
    blocks = collections.defaultdict(str)
    for row in rows(episodes):
        if row["pedestrian"] != "intercept" or int(row["episode"]) >= STARTS:
            continue
        x, y, px, py = (float(row[name]) for name in ("ego_x_m", "ego_y_m", "pedestrian_x_m", "pedestrian_y_m"))
        yaw = math.radians(float(row["ego_yaw_deg"]))
        bearing = math.degrees(math.remainder(math.atan2(py - y, px - x) - yaw, math.tau))
        name = f"start_{row['town']}_{row['driver']}_{row['episode']}"
        place = f"bearing: {bearing:.6f} deg  distance: {math.hypot(px - x, py - y):.6f} m  clearance: 0 m"
        print(f"spawn {name} {{ {place}  ego_poses: [({x:.4f} m, {y:.4f} m, {yaw:.6f} rad)] }}")
        what = f"towns: [{row['town']}]  drivers: [{row['driver']}]  methods: [again]  spawn: {name}"
        blocks[row["town"]] += f"  search {{ {what}  budget: 1_000_000_000_000  runs: 1  episodes: 0 }}\n"
    for town, searches in blocks.items():
        common = "vehicle: model3  body: sightless  spawn: ahead_of_a_moving_car  episode: until_passed"
        print(f"campaign redrawn_{town} {{\n  {common}\n{searches}}}")


def score(cache, reports):
    ids, faults, places = {}, collections.defaultdict(set), collections.defaultdict(list)
    for report in glob.glob(os.path.join(reports, "redrawn_*")):
        for row in rows(os.path.join(report, "searches.csv")):
            ids[row["first_start"], row["town"], row["driver"]] = row["run_id"]
        for row in rows(os.path.join(report, "failures.csv")):
            if row["fault"] == "true":
                faults[row["run_id"]].add(int(row["number"]))
    for path in glob.glob(os.path.join(cache, "tasks", "*", "*")):
        with open(path, "rb") as stored:
            _, head, body = stored.read().split(b"\n", 2)
        header = json.loads(head)
        searched = re.search(r"^search again in (\w+) against (\w+)", header["what"])
        if not searched:
            continue
        spent = json.loads(body[: header["length"]])["spent"]
        number, start = spent["first_start"]
        run = ids[f"{number}:{start:016x}", searched[1], searched[2]]
        found = [[False] * WALKS for _ in range(DRAWS)]
        for failure in (each for k, each in enumerate(spent["failures"]) if k in faults[run]):
            found[failure["start"]][(failure["simulations"] - 1) % WALKS] = True
        places[searched[1], searched[2]].append(sum(left_out(found, draw) for draw in range(DRAWS)) / DRAWS)
    means = {place: sum(found) / len(found) for place, found in sorted(places.items())}
    for (town, driver), mean in means.items():
        print(f"{town:12} {driver:16} {mean:.3f}")
    print(f"mean of {len(means)} places {sum(means.values()) / len(means):.3f}")


def left_out(found, draw):
    """The share of faults in a draw, among the walks with most faults in the others."""
    others = [sum(found[other][walk] for other in range(DRAWS) if other != draw) for walk in range(WALKS)]
    most = max(others)
    best = [walk for walk in range(WALKS) if others[walk] == most]
    return sum(found[draw][walk] for walk in best) / len(best)


if __name__ == "__main__":
    {"write": write, "score": score}[sys.argv[1]](*sys.argv[2:])
