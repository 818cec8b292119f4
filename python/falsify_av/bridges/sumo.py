"""SUMO as a world (`libsumo` 1.28.0): its car-following models drive its car along the lanes, and persons are put where they are told to be at each step.

A car of SUMO cannot leave its lanes, so only SUMO's own drivers drive here. The town comes through SUMO's `netconvert`, without sidewalks: beside one, cars do not
brake for persons on the lane (eclipse-sumo/sumo#16092). Traffic lights are switched off.
"""

from __future__ import annotations

import math
import os
import tempfile
from importlib.metadata import version
from pathlib import Path

from . import Message, chosen, roads, state

# Its import prints two lines where another pyarrow is installed than the one that it is compiled against. Neither is used here.
os.environ.setdefault("LIBSUMO_AS_TRACI", "quiet")
import libsumo  # noqa: E402

MODELS = ("EIDM", "IDM", "Krauss")
OPTIONS = ["--no-step-log", "--no-warnings", "--collision.action", "none", "--time-to-teleport", "-1", "--pedestrian.model", "striping"]
EXACT = 2  # A place that is not moved to a lane.
STRIDE = 4  # m: between places of a route at which its edge is asked for.
EGO = "ego"


def world(words: list[str]) -> Sumo:
    """The world for `python3 -m falsify_av.bridges sumo`."""
    chosen("sumo", words)
    return Sumo()


class Sumo:
    """One simulation of SUMO, which begins anew for each episode."""

    def __init__(self) -> None:
        self.about: Message = {
            "name": "sumo",
            "version": f"libsumo {version('libsumo')}, eclipse-sumo {version('eclipse-sumo')}",
            "drivers": list(MODELS),
            "controls": False,
            # Persons have a place along a lane and beside it, which in bends is another one.
            "tolerance": 0.2,
            "friction": False,
            "lights": False,
            "seeds": True,
        }

    def load(self, message: Message) -> list[tuple[float, float]]:
        """Convert the map of a town, and allow persons on its lanes."""
        self.tick, self.car, self.bodies = message["tick_s"], message["vehicle"], message["pedestrians"]
        self.folder = tempfile.TemporaryDirectory()
        self.net = roads.convert(message["map"], Path(self.folder.name))
        text = self.net.read_text(encoding="utf-8")
        self.net.write_text(text.replace('disallow="pedestrian ', 'disallow="'), encoding="utf-8")
        return roads.nearest(roads.shapes(self.net), message["lanes"])

    def begin(self, message: Message) -> Message:
        """A new simulation with the car and the persons at their starts."""
        ego, model = message["ego"], message["driver"]
        types = Path(self.folder.name) / "types.add.xml"
        types.write_text(self.types(model), encoding="utf-8")
        seed = str(message["seed"] % 2**31)
        options = ["-n", str(self.net), "-a", str(types), "--step-length", str(self.tick), "--seed", seed, *OPTIONS]
        if libsumo.isLoaded():
            libsumo.load(options)
        else:
            libsumo.start(["sumo", *options])
        for light in libsumo.trafficlight.getIDList():
            libsumo.trafficlight.setProgram(light, "off")
        edges = self.edges(message["route"])
        libsumo.route.add("route", edges)
        _, _, lane = libsumo.simulation.convertRoad(ego["x"], ego["y"], False, "passenger")
        libsumo.vehicle.add(EGO, "route", typeID="car", departLane=str(lane), departPos="base", departSpeed="0")
        for number, _ in enumerate(self.bodies):
            libsumo.person.add(f"person{number}", edges[0], 0.0, typeID=f"person{number}")
            libsumo.person.appendWaitingStage(f"person{number}", 1e6)
        libsumo.simulationStep()
        x, y = ego["x"] + self.half * math.cos(ego["yaw"]), ego["y"] + self.half * math.sin(ego["yaw"])
        libsumo.vehicle.moveToXY(EGO, edges[0], lane, x, y, 90.0 - math.degrees(ego["yaw"]), EXACT)
        self.place(message["pedestrians"])
        libsumo.simulationStep()
        libsumo.vehicle.setPreviousSpeed(EGO, ego["speed"], 0.0)
        self.stop(edges[-1])
        return {**self.now(), "ego": {**self.now()["ego"], "speed": ego["speed"]}}

    def step(self, message: Message) -> Message:
        """One step. The driver sees the persons as they were at its start."""
        self.place(message["pedestrians"])
        libsumo.simulationStep()
        return self.now()

    def place(self, pedestrians: list[Message]) -> None:
        """Put the persons where they are at the end of the step."""
        for number, told in enumerate(pedestrians):
            libsumo.person.moveToXY(f"person{number}", "", told["x"], told["y"], 90.0 - math.degrees(told["yaw"]), EXACT)

    def now(self) -> Message:
        """The state of everybody. SUMO's place of a car is the middle of its front."""
        if EGO not in libsumo.vehicle.getIDList():
            return {"ego": {"x": 0.0, "y": 0.0, "yaw": 0.0, "speed": 0.0}, "pedestrians": [], "end": True}
        (x, y), yaw = libsumo.vehicle.getPosition(EGO), math.radians(90.0 - libsumo.vehicle.getAngle(EGO))
        x, y = x - self.half * math.cos(yaw), y - self.half * math.sin(yaw)
        places = [libsumo.person.getPosition(f"person{number}") for number, _ in enumerate(self.bodies)]
        return state(x, y, yaw, libsumo.vehicle.getSpeed(EGO), places)

    @property
    def half(self) -> float:
        """Half of the car's length (m)."""
        return float(self.car["length"]) / 2

    def stop(self, edge: str) -> None:
        """Let the car stand at the end of its route, where SUMO would take it away."""
        lane = f"{edge}_0"
        libsumo.vehicle.setStop(EGO, edge, libsumo.lane.getLength(lane) - 0.1, 0, 1e6)

    def edges(self, route: list[list[float]]) -> list[str]:
        """The edges along a route, without those inside junctions."""
        found: list[str] = []
        for x, y, _ in route[::STRIDE]:
            edge, *_ = libsumo.simulation.convertRoad(x, y, False, "passenger")
            if not edge.startswith(":") and (not found or found[-1] != edge):
                found.append(edge)
        return found

    def types(self, model: str) -> str:
        """SUMO's defaults, but for sizes."""
        persons = [
            f'<vType id="person{number}" vClass="pedestrian" length="{2 * body["radius"]}" width="{2 * body["radius"]}"/>'
            for number, body in enumerate(self.bodies)
        ]
        car = f'<vType id="car" carFollowModel="{model}" length="{self.car["length"]}" width="{self.car["width"]}"/>'
        return "\n".join(["<additional>", car, *persons, "</additional>"])
