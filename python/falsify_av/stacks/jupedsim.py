"""A pedestrian of JuPedSim: its anticipation velocity model walks to a goal on the other side of the road and around the car.

At each decision a simulation of JuPedSim runs until the next one. Its floor is a square around the pedestrian, and the car is a hole in it, as long as the
way that the car drives in the next second. The goal lies straight across the line on which the car comes. The preferred speed is drawn once an episode.

Install it with ``pip install jupedsim==1.4.2``; ``docs/src/how-to/stacks/jupedsim.md`` compares it with recorded pedestrians.
"""

from __future__ import annotations

import json
import math
import random
import sys
from typing import Any

import jupedsim as jps
from shapely import Point, Polygon, box

from ..answers import answers

SPEED, SPREAD, SLOWEST = 1.34, 0.26, 0.5  # m/s: Weidmann 1993
RADIUS = 0.2  # m
FLOOR, BEYOND, REACHED = 80.0, 8.0, 0.5  # m: half of the floor, of the goal behind the car's line, of the goal
STEP = 0.01  # s
LOOK = 1.0  # s: so far ahead of the car no pedestrian steps
MARGINS = 0.3, 0.15, 0.0  # m: around the car, the first that leaves the pedestrian where it is


class Walk:
    """The pedestrian of one world in one episode."""

    def __init__(self, seed: int, tick: float, hold: int) -> None:
        drawn = random.Random(seed)
        self.speed = max(drawn.gauss(SPEED, SPREAD), SLOWEST)
        self.lasts = tick * hold
        self.goal: tuple[float, float] | None = None

    def choose(self, me: dict[str, float], ego: dict[str, float], car: dict[str, float]) -> tuple[float, float]:
        """Where it walks until the next decision: a direction in the world (rad) and a speed (m/s)."""
        if self.goal is None:
            self.goal = across(me, ego)
        x, y = self.goal
        if math.hypot(x - me["x"], y - me["y"]) < 2 * REACHED:
            return me["yaw"], 0.0
        around = box(me["x"] - FLOOR, me["y"] - FLOOR, me["x"] + FLOOR, me["y"] + FLOOR)
        floors = (around.difference(hole(ego, car, margin)) for margin in MARGINS)
        # A car that is where the pedestrian is, or where it wants to be, leaves no way; then it walks as if there were none.
        to = self._walk(next((floor for floor in floors if self._leaves_a_way(floor, me)), around), me)
        way = math.hypot(to[0] - me["x"], to[1] - me["y"])
        heading = math.atan2(to[1] - me["y"], to[0] - me["x"]) if way > 1e-6 else me["yaw"]
        return heading, way / self.lasts

    def _leaves_a_way(self, floor: Any, me: dict[str, float]) -> bool:
        """Whether the pedestrian and its goal are on a floor in one piece."""
        here, goal = Point(me["x"], me["y"]), Point(*(self.goal or (0.0, 0.0)))
        return bool(floor.geom_type == "Polygon" and floor.buffer(-RADIUS).contains(here) and floor.contains(goal.buffer(REACHED)))

    def _walk(self, floor: Polygon, me: dict[str, float]) -> tuple[float, float]:
        """Where JuPedSim's pedestrian is at the next decision (m)."""
        assert self.goal is not None
        simulation = jps.Simulation(model=jps.AnticipationVelocityModel(), geometry=floor, dt=STEP)
        stage = simulation.add_waypoint_stage(self.goal, REACHED)
        journey = simulation.add_journey(jps.JourneyDescription([stage]))
        parameters = jps.AnticipationVelocityModelAgentParameters(
            position=(me["x"], me["y"]), desired_speed=self.speed, radius=RADIUS, journey_id=journey, stage_id=stage
        )
        agent = simulation.add_agent(parameters)
        simulation.iterate(round(self.lasts / STEP))
        x, y = simulation.agent(agent).position
        return float(x), float(y)


def across(me: dict[str, float], ego: dict[str, float]) -> tuple[float, float]:
    """The goal: straight across the line on which the car comes."""
    sin, cos = math.sin(ego["yaw"]), math.cos(ego["yaw"])
    left = cos * (me["y"] - ego["y"]) - sin * (me["x"] - ego["x"])
    far = -left - math.copysign(BEYOND, left)
    return me["x"] - sin * far, me["y"] + cos * far


def hole(ego: dict[str, float], car: dict[str, float], margin: float) -> Polygon:
    """The car and the way that it drives in the next second."""
    sin, cos = math.sin(ego["yaw"]), math.cos(ego["yaw"])
    half = car["width"] / 2 + margin
    back, front = -car["length"] / 2 - margin, car["length"] / 2 + margin + LOOK * max(ego["speed"], 0.0)
    corners = ((back, -half), (front, -half), (front, half), (back, half))
    return Polygon([(ego["x"] + cos * x - sin * y, ego["y"] + sin * x + cos * y) for x, y in corners])


def main(_words: list[str]) -> None:
    """Answer the messages on the standard input until it ends. The body needs ``action_frame: world``."""
    walks: dict[int, Walk] = {}
    hello: dict[str, Any] = {}
    out = answers()
    for line in sys.stdin:
        message = json.loads(line)
        if message["type"] == "hello":
            if not message["protocol"].startswith("falsify-pedestrian/"):
                raise SystemExit("JuPedSim's pedestrian is no driver: name it as a pedestrian, `pedestrian jupedsim = external(command: …)`")
            hello, answer = message, {"protocol": message["protocol"], "name": "jupedsim"}
        else:
            answer = {"actions": [act(world, walks, hello) for world in message["worlds"]]}
        out.write(json.dumps(answer).encode() + b"\n")
        out.flush()


def act(world: dict[str, Any], walks: dict[int, Walk], hello: dict[str, Any]) -> dict[str, Any]:
    """The answer for one world."""
    number = world["id"]
    if "seed" in world or number not in walks:
        walks[number] = Walk(int(world.get("seed", 0)), hello["tick_s"], int(hello["hold"]))
    heading, speed = walks[number].choose(world["pedestrians"][0], world["ego"], hello["vehicle"])
    return {"id": number, "action": [heading, speed]}
