"""A driver with two parameters: follows the route and brakes for actors that are in its way, or will be there soon."""
import json, math, sys

# The time gap that it keeps (s), and half the width of the corridor in which an actor is in its way (m).
parameters = {"gap": 0.5, "width": 1.0}

def drive(world):
    ego = world["ego"]
    if not world["route"]:  # the road has ended
        return {"id": world["id"], "acceleration": -2, "steer": 0}
    sin, cos = math.sin(ego["yaw"]), math.cos(ego["yaw"])
    def turned(x, y):
        return cos * x + sin * y, cos * y - sin * x
    def local(x, y):  # metres ahead of the car's middle, and to its left
        return turned(x - ego["x"], y - ego["y"])
    ahead = [local(x, y) for x, y, _ in world["route"]]
    target = next((p for p in ahead if math.hypot(*p) > 3.5 + 0.6 * ego["speed"]), (10.0, 0.0))
    steer = max(-1, min(1, 2 * math.atan2(target[1], target[0])))
    places = (local(a["x"], a["y"]) for a in world["actors"])
    gaps = [x - 2.5 for x, y in places if x > 0 and abs(y) < parameters["width"]]
    if world["light"] and world["light"]["colour"] == "red":
        gaps.append(world["light"]["distance"])
    wanted = min([0.9 * world["speed_limit"]] + [max(0, gap - 2) / parameters["gap"] for gap in gaps])
    return {"id": world["id"], "acceleration": max(-8, min(2, 2 * (wanted - ego["speed"]))), "steer": steer}

for line in sys.stdin:
    message = json.loads(line)
    if message["type"] == "hello":
        parameters.update(message.get("parameters", {}))
        answer = {"protocol": "falsify-av/1"}
    else:
        answer = {"actions": [drive(w) for w in message["worlds"]]}
    print(json.dumps(answer), flush=True)
