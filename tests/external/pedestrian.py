"""A pedestrian for the tests, which fails in the way that its first argument names, in about every third episode or at once.

`homing` walks straight at the car: its actions are measured from the line of sight. A second argument is a file to leave a mark in.
"""
import json, os, signal, sys

mode = sys.argv[1]
for name in sys.argv[2:]:
    open(name, "a").write("started\n")

marked = {}

def hang():
    while True:
        signal.pause()

def say(data):
    print(json.dumps(data), flush=True)

def action(world):
    if "seed" in world:
        marked[world["id"]] = world["seed"] % 3 == 0
    if marked[world["id"]] and world["tick"] > 0:
        if mode == "crash":
            os._exit(3)
        if mode == "garbage":
            print("now I walk left", flush=True)
            hang()
        if mode == "hang":
            hang()
    heading = "north" if mode == "wordy" else 0.0
    return {"id": world["id"], "action": [heading] if mode == "short" else [heading, 99.0]}

hello = json.loads(sys.stdin.readline())
assert hello["type"] == "hello" and hello["protocol"] == "falsify-pedestrian/1", hello
assert hello["pedestrians"] == 1 and hello["state"] == 4 and hello["action_bounds"][1] == [0.0, 3.5], hello
if mode == "gone":
    sys.exit()
say({"protocol": "falsify-pedestrian/9" if mode == "version" else "falsify-pedestrian/1", "name": "test", "novelty": 1})
for line in sys.stdin:
    [world] = json.loads(line)["worlds"]
    assert len(world["state"]) == 4 and len(world["pedestrians"]) == 1, world
    answer = json.dumps({"actions": [action(world)]}) + "\n"
    # Two answers in one write: the second is for a question that nobody has asked.
    sys.stdout.write(answer * 2 if mode == "eager" else answer)
    sys.stdout.flush()
