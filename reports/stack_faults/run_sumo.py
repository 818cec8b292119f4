"""A car of SUMO and a person on its lane: `python3 run_sumo.py FOLDER`, with nothing but libsumo (`pip install libsumo==1.28.0`).

FOLDER has road.net.xml, car.rou.xml and person.csv: where the person's middle is at each step of 0.05 s. Printed are the speed of the car, the gap from its
front to the person, how far the person is beside the middle of the lane, and the touch.
"""

import csv
import sys
from pathlib import Path

import libsumo

RADIUS = 0.188  # m: of the person
START = 100.0  # m: the front of the car


def main(folder: Path) -> None:
    with open(folder / "person.csv", newline="", encoding="utf-8") as file:
        steps = [tuple(map(float, row)) for row in list(csv.reader(file))[1:]]
    libsumo.start([
        "sumo", "-n", str(folder / "road.net.xml"), "-r", str(folder / "car.rou.xml"), "--step-length", "0.05", "--no-step-log", "true",
        "--collision.action", "warn", "--default.speeddev", "0",
    ])
    # SUMO lets a person walk, and be seen, from the step after.
    libsumo.person.add("person", "road", steps[0][1], typeID="adult")
    libsumo.person.appendWalkingStage("person", ["road"], 399.0)
    libsumo.person.setSpeed("person", 0.0)
    libsumo.simulationStep()  # Both come onto the road.
    speed = libsumo.vehicle.getSpeed("car")
    libsumo.vehicle.moveTo("car", "road_0", START)
    libsumo.vehicle.setPreviousSpeed("car", speed, 0.0)
    length, width = libsumo.vehicle.getLength("car"), libsumo.vehicle.getWidth("car")
    print("  time   speed     gap  beside")
    for time, along, left in steps:
        # SUMO's place of a person is the front end of its length.
        libsumo.person.moveToXY("person", "road", along + RADIUS, left, 90.0, 2)
        front, speed = libsumo.vehicle.getLanePosition("car"), libsumo.vehicle.getSpeed("car")
        aside, ahead = max(abs(left) - width / 2, 0.0), max(along - front, front - length - along, 0.0)
        print(f"{time:6.2f} {speed:7.3f} {along - RADIUS - front:7.2f} {left:7.2f}")
        if (aside**2 + ahead**2) ** 0.5 <= RADIUS:
            print(f"touch after {time:.2f} s: the car drives {speed:.2f} m/s")
            break
        libsumo.simulationStep()
    else:
        print("no touch")
    libsumo.close()


main(Path(sys.argv[1]))
