"""A driver that brakes for whoever is in its way, or will be. With `late` it has a planted defect: in every third span of two seconds it answers 0.6 s late."""

import json
import math
import sys

LATE = "late" in sys.argv
SPAN, DELAY = 40, 12  # ticks
seeds = {}
wanted = {}


def in_way(ego, actor, reach):
    """Whether an actor is in the way, now or then, within a reach."""
    cos, sin = math.cos(ego["yaw"]), math.sin(ego["yaw"])
    x, y = actor["x"] - ego["x"], actor["y"] - ego["y"]
    ahead, left = cos * x + sin * y, cos * y - sin * x
    then = left + (cos * actor["vy"] - sin * actor["vx"]) * min(ahead / max(ego["speed"], 1), 3)
    beside = min(abs(left), abs(then)) if left * then > 0 else 0
    return 0 < ahead < reach and beside < 1.6


def drive(world):
    """The action of a tick."""
    ego, number, tick = world["ego"], world["id"], world["tick"]
    if tick == 0:
        seeds[number], wanted[number] = world["seed"], []
    angle = 0
    if world["route"]:
        x, y, _ = next((p for p in world["route"] if math.dist(p[:2], (ego["x"], ego["y"])) > 3.5 + 0.6 * ego["speed"]), world["route"][-1])
        angle = math.remainder(math.atan2(y - ego["y"], x - ego["x"]) - ego["yaw"], math.tau)
    reach = 6 + 0.3 * ego["speed"] + ego["speed"] ** 2 / 10
    brakes = any(in_way(ego, actor, reach) for actor in world["actors"])
    wanted[number].append(-8 if brakes else max(-4, min(2, 2 * (0.9 * world["speed_limit"] - ego["speed"]))))
    is_late = LATE and (seeds[number] + tick // SPAN) % 3 == 0
    then = max(len(wanted[number]) - 1 - DELAY, 0) if is_late else -1
    return {"id": number, "acceleration": wanted[number][then], "steer": max(-1, min(1, 2 * angle))}


for line in sys.stdin:
    message = json.loads(line)
    answer = {"protocol": "falsify-av/1"} if message["type"] == "hello" else {"actions": [drive(world) for world in message["worlds"]]}
    print(json.dumps(answer), flush=True)
