"""A fault as files for the maintainers of a stack: `python3 scenarios/studies/stacks_fault.py TICKS STACK FOLDER`.

TICKS is the table of `falsify replay RUN:EPISODE --ticks ticks.csv`; STACK is `EIDM`, `IDM`, `Krauss`, `openpilot` or `fiss`. The folder gets `person.csv`, where the person is at
each tick in the coordinates of the way that the car drove. A model of SUMO also gets a net of one lane and a route file with the car, openpilot a maneuver of its own
tests. The scripts `run_….py` of reports/stacks need nothing but the stack.
"""

import csv
import math
import sys
from pathlib import Path

FRONT, LENGTH, WIDTH, LANE = 100.0, 4.79, 2.16, 3.5  # m: the car's front at the start; the car; the lane
LONG = 400.0  # m: the lane
RADIUS, TICK = 0.188, 0.05  # m, s: the person, a tick
AFTER = 20  # ticks: how long the person goes on after the touch

NET = """<net version="1.20">
  <location netOffset="0,0" convBoundary="0,0,{long},0" origBoundary="0,0,0,0" projParameter="!"/>
  <edge id="road" from="a" to="b" priority="-1"><lane id="road_0" index="0" speed="{speed}" length="{long}" width="{lane}" shape="0,0 {long},0"/></edge>
  <junction id="a" type="dead_end" x="0" y="0" incLanes="" intLanes="" shape="0,{half} 0,-{half}"/>
  <junction id="b" type="dead_end" x="{long}" y="0" incLanes="road_0" intLanes="" shape="{long},{half} {long},-{half}"/>
</net>
"""

ROUTES = """<routes>
  <vType id="car" carFollowModel="{model}" length="{length}" width="{width}" minGap="2.5" speedFactor="1" speedDev="0" sigma="0" {exact}/>
  <vType id="adult" vClass="pedestrian" minGap="0" length="0.376" width="0.376"/>
  <vehicle id="car" type="car" depart="0" departLane="0" departPos="{front}" departSpeed="{speed}"><route edges="road"/></vehicle>
</routes>
"""


def project(path, x, y):
    """Where a point is beside a path: how far along it and how far to the left of it (m); the first and the last piece go on straight."""
    best, before = None, 0.0
    for place, ((ax, ay), (bx, by)) in enumerate(zip(path, path[1:])):
        length = math.hypot(bx - ax, by - ay)
        ux, uy = (bx - ax) / length, (by - ay) / length
        along, left = (x - ax) * ux + (y - ay) * uy, ux * (y - ay) - uy * (x - ax)
        on = min(max(along, -math.inf if place == 0 else 0.0), math.inf if place == len(path) - 2 else length)
        apart = math.hypot(along - on, left)
        if best is None or apart < best[0]:
            best = apart, before + on, left
        before += length
    return best[1:]


MANEUVER = '''# A maneuver for openpilot's own tests, selfdrive/test/longitudinal_maneuvers: a lead that is there from
# the tick on in which the person is in the path of the car.
from openpilot.selfdrive.test.longitudinal_maneuvers.maneuver import Maneuver

MANEUVER = Maneuver(
  'a person steps into the path of the car',
  duration={duration},
  initial_speed={speed},
  lead_relevancy=True,
  initial_distance_lead={distance},
  speed_lead_values=[{rate}, {rate}, {rate}, {rate}],
  prob_lead_values=[0.0, 0.0, 1.0, 1.0],
  cruise_values=[{cruise}, {cruise}, {cruise}, {cruise}],
  breakpoints=[0.0, {before}, {time}, {end}],
  personality=1,
)
'''


def sumo(folder, model, speeds):
    """A net and a route file."""
    exact = 'sigmaleader="0" sigmagap="0" sigmaerror="0"' if model == "EIDM" else ""
    (folder / "road.net.xml").write_text(NET.format(long=LONG, speed=round(max(speeds), 3), lane=LANE, half=LANE / 2), encoding="utf-8")
    routes = ROUTES.format(model=model, length=LENGTH, width=WIDTH, front=FRONT, speed=round(speeds[0], 3), exact=exact)
    (folder / "car.rou.xml").write_text(routes.replace(" />", "/>"), encoding="utf-8")


def openpilot(folder, person, speeds):
    """The person as a lead that keeps its mean speed from the tick on in which it overlaps the width of the car for good."""
    gaps = [along - RADIUS - FRONT for _, along, _ in person]
    outside = [place for place, (_, _, left) in enumerate(person[:-AFTER]) if abs(left) - RADIUS >= WIDTH / 2]
    first = min(outside[-1] + 1 if outside else 0, len(person) - 2 - AFTER)
    touch = len(person) - 1 - AFTER
    time, end = person[first][0], person[touch][0]
    rate = (gaps[touch] - gaps[first]) / (end - time)
    text = MANEUVER.format(
        duration=round(end + 1.0, 2),
        speed=round(speeds[0], 2),
        cruise=round(max(speeds), 2),
        distance=round(gaps[first] - rate * time, 2),
        rate=round(rate, 2),
        before=round(time - TICK / 2, 3),
        time=round(time, 2),
        end=round(end + 1.0, 2),
    )
    (folder / "maneuver.py").write_text(text, encoding="utf-8")


def main(ticks, stack, folder):
    with open(ticks, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    path = []
    for row in rows:
        place = float(row["ego_x_m"]), float(row["ego_y_m"])
        if not path or math.dist(place, path[-1]) > 0.3:
            path.append(place)
    speeds = [float(row["ego_speed_mps"]) for row in rows]
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    person = []
    for row in rows:
        along, left = project(path, float(row["pedestrian_x_m"]), float(row["pedestrian_y_m"]))
        person.append((float(row["time_s"]), FRONT - LENGTH / 2 + along, left))
    # After the touch the person goes on as in the last tick, so a car that comes a moment later meets it, too.
    (before, last) = person[-2:]
    for step in range(1, AFTER + 1):
        person.append(tuple(end + step * (end - start) for start, end in zip(before, last)))
    with open(folder / "person.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["time_s", "along_m", "left_m"])
        writer.writerows([f"{time:.2f}", f"{along:.3f}", f"{left:.3f}"] for time, along, left in person)
    if stack == "openpilot":
        openpilot(folder, person, speeds)
    elif stack != "fiss":
        sumo(folder, stack, speeds)
    print(f"{folder}: from {speeds[0]:.2f} m/s, at most {max(speeds):.2f} m/s, contact at {rows[-1]['time_s']} s")


main(*sys.argv[1:])
