"""A driver with two parameters: follows the route and brakes for actors that are in its way, or will be there soon."""
import argparse, json, math, sys

options = argparse.ArgumentParser()
options.add_argument("--gap", type=float, default=0.5, help="time gap that it keeps (s)")
options.add_argument("--width", type=float, default=1.0, help="what is in its way: half the width of its corridor (m)")
options = options.parse_args()

def drive(world):
    ego = world["ego"]
    sin, cos = math.sin(ego["yaw"]), math.cos(ego["yaw"])
    def turned(x, y):
        return cos * x + sin * y, cos * y - sin * x
    def local(x, y):  # metres ahead of the car's middle, and to its left
        return turned(x - ego["x"], y - ego["y"])
    ahead = [local(x, y) for x, y, _ in world["route"]]
    target = next((p for p in ahead if math.hypot(*p) > 3.5 + 0.6 * ego["speed"]), (10.0, 0.0))
    steer = 2 * math.atan2(target[1], target[0])
    places = (local(a["x"], a["y"]) for a in world["actors"])
    gaps = [x - 2.5 for x, y in places if x > 0 and abs(y) < options.width]
    if world["light"] and world["light"]["colour"] == "red":
        gaps.append(world["light"]["distance"])
    wanted = min([0.9 * world["speed_limit"]] + [max(0, gap - 2) / options.gap for gap in gaps])
    return {"id": world["id"], "acceleration": max(-8, min(2, 2 * (wanted - ego["speed"]))), "steer": steer}

for line in sys.stdin:
    message = json.loads(line)
    answer = {"protocol": "falsify-av/1"} if message["type"] == "hello" else {"actions": [drive(w) for w in message["worlds"]]}
    print(json.dumps(answer), flush=True)
