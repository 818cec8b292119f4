"""A pedestrian in twenty lines: walks to where it would meet the car, if the car kept its velocity."""
import json, math, sys

def choose(world):
    ego, me = world["ego"], world["pedestrians"][0]
    time = 0.0
    for _ in range(8):  # the longer the way, the farther the car is by then
        x = ego["x"] + time * ego["speed"] * math.cos(ego["yaw"])
        y = ego["y"] + time * ego["speed"] * math.sin(ego["yaw"])
        time = math.hypot(x - me["x"], y - me["y"]) / fastest
    line_of_sight = math.atan2(ego["y"] - me["y"], ego["x"] - me["x"])
    heading = math.atan2(y - me["y"], x - me["x"]) - line_of_sight
    return {"id": world["id"], "action": [math.remainder(heading, 2 * math.pi), fastest]}

for line in sys.stdin:
    message = json.loads(line)
    if message["type"] == "hello":
        fastest = message["action_bounds"][1][1]
        answer = {"protocol": "falsify-pedestrian/1"}
    else:
        answer = {"actions": [choose(world) for world in message["worlds"]]}
    print(json.dumps(answer), flush=True)
