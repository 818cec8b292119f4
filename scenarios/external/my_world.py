"""A world of your own: a bridge to another simulator, here one of ten lines. Copy it and put your simulator in the three places.

It answers the messages of `docs/src/how-to/bridge.md` on its standard output and uses nothing but the standard library.

    falsify check --world 'python3 scenarios/external/my_world.py'
    falsify run --allow-external scenarios/external/my_world.scn
"""

import json
import math
import sys


class MyWorld:
    """A car that turns about the middle of its wheelbase, and pedestrians that stand where they are put."""

    # What the simulator is and can do. Leave out what it cannot.
    ABOUT = {"name": "my_world", "version": "1", "drivers": [], "friction": False, "lights": False, "seeds": True}

    def load(self, message):
        """Load the map (OpenDRIVE), once for each start of this program; returns the nearest places on the middle of its lanes, None without lanes."""
        # 1: load message["map"], and make a car like message["vehicle"] and message["pedestrians"].
        self.tick, self.wheelbase = message["tick_s"], message["vehicle"]["wheelbase"]
        return None

    def begin(self, message):
        """Place everybody: the first state of an episode."""
        # 2: put the car and the pedestrians where they start, and forget the last episode.
        ego = message["ego"]
        self.x, self.y, self.yaw, self.speed = ego["x"], ego["y"], ego["yaw"], ego["speed"]
        self.walkers = message["pedestrians"]

    def step(self, message):
        """Move on one tick."""
        # 3: drive the car, and put each pedestrian where it is at the end of the tick.
        control = message["control"]
        slip = math.atan(math.tan(control["wheel_angle"]) / 2)
        before, self.speed = self.speed, max(self.speed + control["acceleration"] * self.tick, 0.0)
        way = (before + self.speed) / 2 * self.tick
        self.x += way * math.cos(self.yaw + slip)
        self.y += way * math.sin(self.yaw + slip)
        self.yaw += way * math.sin(slip) / (self.wheelbase / 2)
        self.walkers = message["pedestrians"]

    def state(self, tick):
        """Where everybody is now, as the simulator says it."""
        ego = {"x": self.x, "y": self.y, "yaw": self.yaw, "speed": self.speed}
        return {"tick": tick, "ego": ego, "pedestrians": [[walker["x"], walker["y"]] for walker in self.walkers]}


def serve(world):
    """Answer each line of the standard input with a line, until it ends."""
    for line in sys.stdin:
        message = json.loads(line)
        kind = message["type"]
        if kind == "hello":
            answer = {"protocol": message["protocol"], **world.ABOUT}
        elif kind == "load":
            answer = {"lanes": world.load(message)}
        elif kind == "begin":
            world.begin(message)
            answer = world.state(0)
        elif kind == "step":
            world.step(message)
            answer = world.state(message["tick"])
        else:
            sys.exit(f"a message of another kind: {kind}")
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    serve(MyWorld())
