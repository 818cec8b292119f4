"""A driver for the tests that follows its route and brakes for people who are in its way, or will be when it is there."""
import json, math, sys

def in_way(ego, actor, reach):
    """Whether a pedestrian is in the way, now or then, within a reach."""
    if actor["kind"] != "pedestrian":
        return False
    cos, sin = math.cos(ego["yaw"]), math.sin(ego["yaw"])
    x, y = actor["x"] - ego["x"], actor["y"] - ego["y"]
    ahead, left = cos * x + sin * y, cos * y - sin * x
    faster = cos * actor["vy"] - sin * actor["vx"]
    then = left + faster * min(ahead / max(ego["speed"], 1), 3)
    beside = min(abs(left), abs(then)) if left * then > 0 else 0
    return 0 < ahead < reach and beside < 1.6

def drive(world):
    ego = world["ego"]
    if not world["route"]:
        return {"id": world["id"], "acceleration": -2, "steer": 0}
    x, y, _ = next((p for p in world["route"] if math.dist(p[:2], (ego["x"], ego["y"])) > 3.5 + 0.6 * ego["speed"]), world["route"][-1])
    angle = math.remainder(math.atan2(y - ego["y"], x - ego["x"]) - ego["yaw"], math.tau)
    reach = 6 + 0.3 * ego["speed"] + ego["speed"] ** 2 / 10
    brakes = any(in_way(ego, actor, reach) for actor in world["actors"])
    acceleration = -8 if brakes else max(-4, min(2, 2 * (0.9 * world["speed_limit"] - ego["speed"])))
    return {"id": world["id"], "acceleration": acceleration, "steer": max(-1, min(1, 2 * angle))}

for line in sys.stdin:
    message = json.loads(line)
    answer = {"protocol": "falsify-av/1"} if message["type"] == "hello" else {"actions": [drive(w) for w in message["worlds"]]}
    print(json.dumps(answer), flush=True)
