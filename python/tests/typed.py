"""What a type checker says of calls: `test_types.py` expects an error in exactly the lines that say so."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

import falsify_av


class Careful:
    def drive(self, world: dict[str, Any]) -> dict[str, float]:
        return {"brake": 1.0}


class Idle:
    def steer(self, world: dict[str, Any]) -> dict[str, float]:
        return {}


def homing(states: NDArray[np.float32]) -> NDArray[np.float32]:
    return states[:, :2]


env = falsify_av.make("my.scn", "mine", town="harbour", driver="behavior", reward="r2", own_driver=Careful, settings=["far=20 m"])
observation, info = env.reset(seed=7)
vector = falsify_av.make_vec(["my.scn", "more.scn"], 4, campaign="mine", maps={"harbour": "a.xodr"}, own_driver=lambda: Careful())
rows = falsify_av.evaluate(homing, "my.scn", "mine", episodes=20, own_driver=Careful)
found = falsify_av.judge([[0.0] * 4] * 2, [[0.0] * 2] * 2, 0.05, scenario="my.scn", town="harbour")
files = falsify_av.export("1a2b3c4d:17", "xosc-1.3", report="reports", ego="user")
again = falsify_av.replay("1a2b3c4d:17", report="reports")
version: str = falsify_av.__version__

falsify_av.make("my.scn", twon="harbour")  # error
falsify_av.make(42)  # error
falsify_av.make("my.scn", own_driver=Idle)  # error
falsify_av.make_vec(8)  # error
falsify_av.make_vec("my.scn", 4, sead=3)  # error
falsify_av.evaluate(homing, "my.scn", episodes=20, polcy="idm")  # error
falsify_av.evaluate(3, "my.scn", episodes=20)  # error
falsify_av.judge([[0.0]], [[0.0]], 0.05, own_driver=Careful)  # error
falsify_av.check("my.scn", setings=["far=20 m"])  # error
falsify_av.export("1a2b3c4d:17", "xosc-1.3", ego="mine")  # error
