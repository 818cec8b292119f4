"""The numbers of reports/stacks.md: `python3 scenarios/studies/stacks_table.py CSV stacks/1/* stacks/2/* stacks/3/*`.

Each report is a campaign of scenarios/studies/stacks.scn with one seed. The CSV has a row for each driver, pedestrian, town and seed; the tables are printed, with
counts summed over towns and seeds.

- starts: episodes of a pedestrian, each from a start of its own, or the starts that a search has tried
- faults: starts with a fault
- fastest: the highest speed of the car in a fault (m/s)
- shortest: the least time from the start of an episode to a fault (s)
- spares: of the collisions of a driver that sees no pedestrian, the starts from which this one hits nobody
- first: the same of the first 20 starts of each town and seed, which all drivers but CommonRoad's have had

Intervals are Wilson's, 95 %, over starts: for these towns, pedestrians and searches.
"""

import csv
import sys
from pathlib import Path

FIRST = 20  # starts of each town and seed
SPARE, LATER = 2.0, 1.0  # m, s: needless braking, as in scenarios/external/stack_table.py
COLUMNS = "campaign driver pedestrian town seed starts faults collisions fastest_fault_mps shortest_fault_s first_starts first_faults first_collisions".split()


def read(folder, table):
    with open(Path(folder) / f"{table}.csv", newline="", encoding="utf-8") as file:
        yield from csv.DictReader(file)


def wilson(count, of):
    if not of:
        return 0.0, 1.0
    z, share = 1.959964, count / of
    middle, half = share + z * z / (2 * of), z * (share * (1 - share) / of + z * z / (4 * of * of)) ** 0.5
    return max(0.0, (middle - half) / (1 + z * z / of)), min(1.0, (middle + half) / (1 + z * z / of))


def share(count, of):
    if not of:
        return "–"
    low, high = wilson(count, of)
    return f"{count} of {of} ({low:.3f}..{high:.3f})"


def share_of(count, of):
    return f"{count} of {of}" if of else "–"


def least(values, better):
    found = [value for value in values if value != ""]
    return better(found) if found else ""


def episodes(folder, seed):
    """Rows of the pedestrians of a report."""
    groups = {}
    speeds = {(row["run_id"], row["number"]): row["impact_speed_mps"] for row in read(folder, "failures") if not row["requirement"]}
    for row in read(folder, "episodes"):
        if not row["error"] and row["left_out"] in ("", "false"):
            row["impact_speed_mps"] = speeds.get((row["run_id"], row["episode"]))
            groups.setdefault((row["driver"], row["pedestrian"], row["town"]), []).append(row)
    for (policy, controller, town), rows in groups.items():
        yield summary(policy, controller, town, seed, rows)


def summary(policy, controller, town, seed, rows):
    faults = [row for row in rows if row["fault"] == "true"]
    early = [row for row in rows if int(row["episode"]) < FIRST]
    hits = [row for row in rows if row["outcome"] == "collision"]
    return {
        "driver": policy,
        "pedestrian": controller,
        "town": town,
        "seed": seed,
        "starts": len(rows),
        "faults": len(faults),
        "collisions": len(hits),
        "fastest_fault_mps": least([round(float(row["impact_speed_mps"]), 2) for row in faults], max),
        "shortest_fault_s": least([round(float(row["episode_length_s"]), 2) for row in faults], min),
        "first_starts": len(early),
        "first_faults": sum(row["fault"] == "true" for row in early),
        "first_collisions": sum(row in hits for row in early),
    }


def searches(folder, seed):
    """Rows of the searches of a report."""
    faults = {}
    if not (Path(folder) / "searches.csv").exists():
        return
    for row in read(folder, "failures"):
        if row["fault"] == "true":
            faults.setdefault(row["run_id"], []).append(row)
    for row in read(folder, "searches"):
        those = faults.get(row["run_id"], [])
        yield {
            "driver": row["driver"],
            "pedestrian": "search",
            "town": row["town"],
            "seed": seed,
            "starts": int(row["starts"]),
            "faults": int(row["fault_starts"]),
            "collisions": int(row["failures"]),
            "fastest_fault_mps": least([round(float(each["impact_speed_mps"]), 2) for each in those], max),
            "shortest_fault_s": least([round(float(each["episode_length_s"]), 2) for each in those], min),
            "first_starts": "",
            "first_faults": "",
            "first_collisions": "",
        }


def needless(folders):
    """Of each driver: episodes with `natural` that it needs a second longer for than one that sees no pedestrian and passes with 2 m to spare, and of how many."""
    found = {}
    for folder in folders:
        rows = {}
        for row in read(folder, "episodes"):
            if row["pedestrian"] == "natural" and not row["error"]:
                rows.setdefault(row["driver"], {})[row["town"], row["episode"]] = row
        for policy, those in rows.items():
            counts = found.setdefault(policy, [0, 0])
            for key, own in those.items():
                free = rows.get("blind", {}).get(key)
                if free and free["outcome"] != "collision" and float(free["least_gap_m"] or "inf") >= SPARE:
                    counts[0] += float(own["episode_length_s"]) >= float(free["episode_length_s"]) + LATER
                    counts[1] += 1
    return found


def spared(folders):
    """Of each driver: the starts from which it hits nobody of those from which one that sees no pedestrian does, and how many these are."""
    found = {}
    for folder in folders:
        hits = {}
        for row in read(folder, "episodes"):
            if not row["error"] and row["left_out"] in ("", "false"):
                hits.setdefault(row["driver"], {})[row["pedestrian"], row["town"], row["episode"]] = row["outcome"] == "collision"
        for policy, those in hits.items():
            counts = found.setdefault(policy, [0, 0])
            struck = [key for key, hit in hits["blind"].items() if hit and key in those]
            counts[0] += sum(not those[key] for key in struck)
            counts[1] += len(struck)
    return found


def table(rows, braked, passed):
    """The table of shares, a row for each driver."""
    names = ["natural", "intercept", "trained", "search"]
    print(f"| driver | {' | '.join(names)} | fastest fault (m/s) | shortest (s) | spares of `blind`'s | brakes needlessly |\n|---|{'--:|' * (len(names) + 4)}")
    for driver in dict.fromkeys(row["driver"] for row in rows):
        own = [row for row in rows if row["driver"] == driver]
        cells = []
        for name in names:
            those = [row for row in own if row["pedestrian"] == name]
            cells.append(share(sum(row["faults"] for row in those), sum(row["starts"] for row in those)))
        fastest, shortest = least([row["fastest_fault_mps"] for row in own], max), least([row["shortest_fault_s"] for row in own], min)
        late, of = braked.get(driver, (0, 0))
        tail = [str(fastest or "–"), str(shortest or "–"), share_of(*passed.get(driver, (0, 0))), share_of(late, of)]
        print(f"| `{driver}` | {' | '.join([*cells, *tail])} |")


def collisions(rows):
    """The table of collisions, and of the first starts."""
    print("\n| driver | collisions: natural | intercept | trained | first 20, faults: natural | intercept | trained |\n|---|--:|--:|--:|--:|--:|--:|")
    for driver in dict.fromkeys(row["driver"] for row in rows):
        cells = []
        for prefix, counted in (("", "collisions"), ("first_", "faults")):
            for name in ("natural", "intercept", "trained"):
                those = [row for row in rows if row["driver"] == driver and row["pedestrian"] == name]
                of = sum(row[f"{prefix}starts"] for row in those)
                cells.append(f"{sum(row[f'{prefix}{counted}'] for row in those)} of {of}" if of else "–")
        print(f"| `{driver}` | {' | '.join(cells)} |")


def guarded(folders):
    """The table of the emergency brake in front of drivers: the same starts with and without it, of all reports of a seed, the last of which counts."""
    found = {}
    for folder in folders:
        for row in read(folder, "episodes"):
            if not row["error"] and row["left_out"] in ("", "false"):
                key = Path(folder).parent.name, row["pedestrian"], row["town"], row["episode"]
                found.setdefault(row["driver"], {})[key] = row
    names = [name for name in found if "_aeb_" in name]
    if not names:
        return
    print("\nwith an emergency brake in front, at the same starts\n")
    print("| driver | faults: alone | with the brake | collisions: alone | with the brake | brakes needlessly: alone | with the brake |")
    print(f"|---|{'--:|' * 6}")
    for name in names:
        pairs = [(found[name.replace("_aeb", "")].get(key), row, key) for key, row in found[name].items()]
        pairs = [pair for pair in pairs if pair[0] is not None]
        cells = []
        for hit in (lambda row: row["fault"] == "true", lambda row: row["outcome"] == "collision"):
            cells += [f"{sum(hit(pair[side]) for pair in pairs)} of {len(pairs)}" for side in (0, 1)]
        free = []
        for alone, with_it, key in pairs:
            blind = found["blind"].get(key)
            if key[1] == "natural" and blind and blind["outcome"] != "collision" and float(blind["least_gap_m"] or "inf") >= SPARE:
                free.append([float(row["episode_length_s"]) >= float(blind["episode_length_s"]) + LATER for row in (alone, with_it)])
        cells += [f"{sum(pair[side] for pair in free)} of {len(free)}" for side in (0, 1)]
        print(f"| `{name.replace('_aeb', '')}` | {' | '.join(cells)} |")


def by_seed(rows):
    """The table of seeds and towns: faults of starts, all pedestrians together."""
    seeds, towns = (sorted({row[key] for row in rows}) for key in ("seed", "town"))
    head = [f"seed {seed}" for seed in seeds] + towns
    print(f"\n| driver | {' | '.join(head)} |\n|---|{'--:|' * len(head)}")
    for driver in dict.fromkeys(row["driver"] for row in rows):
        cells = []
        for key, values in (("seed", seeds), ("town", towns)):
            for value in values:
                those = [row for row in rows if row["driver"] == driver and row[key] == value]
                cells.append(f"{sum(row['faults'] for row in those)} of {sum(row['starts'] for row in those)}")
        print(f"| `{driver}` | {' | '.join(cells)} |")


def main(out, folders):
    rows = []
    for folder in folders:
        seed = Path(folder).parent.name
        rows += [{"campaign": Path(folder).name, **row} for row in [*episodes(folder, seed), *searches(folder, seed)]]
    with open(out, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    for campaign in dict.fromkeys(Path(folder).name for folder in folders):
        those = [folder for folder in folders if Path(folder).name == campaign]
        part = [row for folder in those for row in [*episodes(folder, Path(folder).parent.name), *searches(folder, Path(folder).parent.name)]]
        print(f"\n{campaign}\n")
        table(part, needless(those), spared(those))
        collisions(part)
        by_seed(part)
    guarded(folders)


main(sys.argv[1], sys.argv[2:])
