"""MetaDrive 0.4.3: IDMPolicy loses all obstacles while a pedestrian is near. `pip install metadrive-simulator==0.4.3`, then `python blind_idm.py`.

A car with IDMPolicy drives along a straight road. A pedestrian stands in its lane 55 m ahead, and another one 12 m beside it.
`FrontBackObjects.get_find_front_back_objs` reads `obj.lane` of every object near the car. Pedestrians have no `lane`, the exception is swallowed by the
bare `except` in `IDMPolicy.act`, and the car drives on as on an empty road. A pedestrian with the attribute shows the difference.
"""

import logging

from metadrive import MetaDriveEnv
from metadrive.component.traffic_participants.pedestrian import Pedestrian
from metadrive.manager.base_manager import BaseManager
from metadrive.policy.idm_policy import FrontBackObjects, IDMPolicy

AHEAD, BESIDE = 55.0, 12.0  # m


def lane_of(body):
    """The lane on which an object is, or the nearest one."""
    lanes = body.engine.current_map.road_network.get_all_lanes()
    return min(lanes, key=lambda lane: (not lane.point_on_lane(body.position), abs(lane.local_coordinates(body.position)[1])))


class Mended(Pedestrian):
    """A pedestrian that says on which lane it is."""

    lane = property(lane_of)


class Placed(BaseManager):
    """Puts objects ahead of the car."""

    def __init__(self, kinds):
        super().__init__()
        self.kinds = kinds

    def reset(self):
        lane = self.engine.current_map.road_network.get_lane((">", ">>", 0))
        heading, (x, y) = lane.heading_theta_at(0), lane.position(5.0, 0.0)
        for kind, ahead, beside in self.kinds:
            place = (x + ahead, y + beside)
            self.spawn_object(kind, position=place, heading_theta=heading, lane=lane, force_spawn=True)


class Env(MetaDriveEnv):
    kinds = ()

    def setup_engine(self):
        super().setup_engine()
        self.engine.register_manager("placed", Placed(self.kinds))


def drive(title, *kinds):
    """Drive up to the obstacle, and tell the speed there and what was swallowed."""
    swallowed = {}
    find = FrontBackObjects.get_find_front_back_objs.__func__

    def telling(cls, *arguments, **keys):
        try:
            return find(cls, *arguments, **keys)
        except Exception as error:
            swallowed[str(error)] = swallowed.get(str(error), 0) + 1
            raise

    FrontBackObjects.get_find_front_back_objs = classmethod(telling)
    settings = {"map_config": {"type": "block_sequence", "config": "SSS", "lane_num": 1, "lane_width": 3.5}, "traffic_density": 0.0, "agent_policy": IDMPolicy, "use_render": False, "log_level": logging.CRITICAL}
    env = type("Env", (Env,), {"kinds": kinds})({**settings, "num_scenarios": 1, "random_spawn_lane_index": False, "crash_vehicle_done": False})
    try:
        env.reset(seed=0)
        start, gap, speed = env.agent.position[0], float("inf"), 0.0
        for _ in range(200):
            env.step([0.0, 0.0])
            gap = AHEAD - (env.agent.position[0] - start) - env.agent.LENGTH / 2
            speed = float(env.agent.speed)
            if gap < 1.0:
                break
        reached = f"reaches it at {speed:.1f} m/s" if gap < 1.0 else f"is {gap:.1f} m before it after 20 s, at {speed:.1f} m/s"
        print(f"{title}: the car {reached}; swallowed: {swallowed or 'nothing'}")
    finally:
        env.close()
        FrontBackObjects.get_find_front_back_objs = classmethod(find)


if __name__ == "__main__":
    cases = {
        "a pedestrian in the lane": [(Pedestrian, AHEAD, 0.0)],
        "a mended pedestrian in the lane": [(Mended, AHEAD, 0.0)],
        "a mended pedestrian in the lane, and one beside the road": [(Mended, AHEAD, 0.0), (Pedestrian, AHEAD - 5.0, BESIDE)],
    }
    for title, kinds in cases.items():
        drive(title, *kinds)
