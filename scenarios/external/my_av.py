"""A driver in twenty lines: follows the route, keeps a time gap of 2 s to the actor in its way, stops at red lights."""
import json, math, sys

def drive(world):
    ego = world["ego"]
    if not world["route"]:  # the road has ended
        return {"id": world["id"], "acceleration": -2, "steer": 0}
    sin, cos = math.sin(ego["yaw"]), math.cos(ego["yaw"])
    def local(x, y):  # metres ahead of the car's middle, and to its left
        dx, dy = x - ego["x"], y - ego["y"]
        return cos * dx + sin * dy, cos * dy - sin * dx
    ahead = [local(x, y) for x, y, _ in world["route"]]
    target = next((p for p in ahead if math.hypot(*p) > 3.5 + 0.6 * ego["speed"]), (10.0, 0.0))
    steer = max(-1, min(1, 2 * math.atan2(target[1], target[0])))
    gaps = [x - 2.5 for x, y in (local(a["x"], a["y"]) for a in world["actors"]) if x > 0 and abs(y) < 2]
    if world["light"] and world["light"]["colour"] == "red":
        gaps.append(world["light"]["distance"])
    wanted = min([0.9 * world["speed_limit"]] + [max(0, gap - 2) / 2 for gap in gaps])
    return {"id": world["id"], "acceleration": max(-8, min(2, 2 * (wanted - ego["speed"]))), "steer": steer}

for line in sys.stdin:
    message = json.loads(line)
    answer = {"protocol": "falsify-av/1"} if message["type"] == "hello" else {"actions": [drive(w) for w in message["worlds"]]}
    print(json.dumps(answer), flush=True)
