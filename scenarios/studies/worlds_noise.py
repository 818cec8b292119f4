"""A world of our car whose place is off by a random walk: how many faults any disturbance of this size loses.

    falsify recheck REPORT --sample 20 --world 'python3 scenarios/studies/worlds_noise.py 0.01'

The argument is the standard deviation of the steps in x, y (m), speed (m/s) and, a hundredth of it, yaw (rad) of a tick.
"""

import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "external"))
import my_world

STEP = float(sys.argv[1])


class Noisy(my_world.MyWorld):
    def begin(self, message):
        super().begin(message)
        self.random = random.Random(message["seed"])

    def step(self, message):
        super().step(message)
        self.x += self.random.gauss(0.0, STEP)
        self.y += self.random.gauss(0.0, STEP)
        self.yaw += self.random.gauss(0.0, STEP / 100)
        self.speed = max(self.speed + self.random.gauss(0.0, STEP), 0.0) if self.speed > 0.0 else 0.0


my_world.serve(Noisy())
