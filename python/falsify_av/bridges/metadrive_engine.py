"""The engine of MetaDrive behind the bridge: a flat town, one car, pedestrians that nothing but the bridge moves."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np
from metadrive.component.lane.point_lane import PointLane
from metadrive.component.navigation_module.node_network_navigation import NodeNetworkNavigation
from metadrive.component.traffic_participants.pedestrian import Pedestrian
from metadrive.engine.asset_loader import AssetLoader
from metadrive.envs import BaseEnv
from metadrive.examples.ppo_expert import numpy_expert
from metadrive.manager.base_manager import BaseManager
from metadrive.manager.sumo_map_manager import SumoMapManager
from metadrive.obs.observation_base import DummyObservation
from metadrive.obs.state_obs import LidarStateObservation
from metadrive.policy.env_input_policy import EnvInputPolicy
from metadrive.policy.expert_policy import ExpertPolicy
from metadrive.policy.idm_policy import IDMPolicy, TrajectoryIDMPolicy
from metadrive.version import VERSION

AWAY = (-5e3, -5e3)  # m: where pedestrians wait for an episode.
SETTLING = 60  # Ticks until the springs of a new car are at rest.
LANE = 3.5  # m: width of the lane along a route.
PIECE = 50.0  # m: of a route, whose ends are the checkpoints of `ExpertPolicy`; it sees them up to this distance.
DECISION = 0.1  # s: between decisions of `ExpertPolicy`, as it was trained.


def prepare_assets() -> None:
    """Stubs for the two files that MetaDrive looks for at its start, so that it does not fetch its models, which nothing here shows."""
    version, texture = (AssetLoader.asset_path / name for name in ("version.txt", "textures/grass1/GroundGrassGreen002_COL_1K.jpg"))
    for file, text in ((version, VERSION), (texture, "")):
        if not Path(file).exists():
            Path(file).parent.mkdir(parents=True, exist_ok=True)
            Path(file).write_text(text)


class Commanded(EnvInputPolicy):
    """Carries out an acceleration and an angle of the front wheels by forces at the wheels, which its tyres bound."""

    def __init__(self, car: Any, seed: int) -> None:
        super().__init__(car, seed)
        # In m/s^2, and in degrees, positive to the left.
        self.acceleration, self.angle = 0.0, 0.0

    def act(self, agent: str) -> None:
        """Set the forces of a tick; the car takes no pedals."""
        car = self.control_object
        force, step = car.MASS * self.acceleration / 4.0, self.engine.global_config["physics_world_step_size"]
        for wheel in range(4):
            car.system.applyEngineForce(max(force, 0.0), wheel)
            car.system.setBrake(max(-force, 0.0) * step, wheel)
        for wheel in (0, 1):
            car.system.setSteeringValue(self.angle, wheel)
        self.action_info["action"] = [0.0, 0.0]


class Expert(ExpertPolicy):
    """MetaDrive's trained driver, which sees what it was trained with: its lidar, and checkpoints of the route."""

    def __init__(self, car: Any, seed: int) -> None:
        super().__init__(car, seed)
        config = self.engine.global_config.copy()
        config["vehicle_config"].update({
            "navigation_module": NodeNetworkNavigation,
            "lidar": {"num_lasers": 240, "distance": 50, "num_others": 4, "gaussian_noise": 0.0, "dropout_prob": 0.0},
        })
        numpy_expert._expert_observation = LidarStateObservation(config)
        numpy_expert._expert_weights = np.load(numpy_expert.ckpt_path)
        # It draws its actions from numpy's own stream.
        np.random.seed(seed)
        tick = config["physics_world_step_size"] * config["decision_repeat"]
        self.ticks, self.every = 0, max(round(DECISION / tick), 1)

    def act(self, agent: str) -> Any:
        """A new action if it is time for one."""
        self.ticks += 1
        return super().act(agent) if (self.ticks - 1) % self.every == 0 else self.action_info["action"]


NATIVE = {"IDMPolicy": IDMPolicy, "TrajectoryIDMPolicy": TrajectoryIDMPolicy, "ExpertPolicy": Expert}


class Route:
    """What MetaDrive's drivers ask of a navigation: one lane, along the route."""

    MAX_LANE_WIDTH = 4.5  # m: of MetaDrive's maps, to scale observations.

    def __init__(self, lane: PointLane, car: Any) -> None:
        self.car = car
        lane.index = ("start", "end", 0)
        self.current_lane, self.current_ref_lanes, self.next_ref_lanes = lane, [lane], None
        self.map = self
        self.road_network = self

    def has_connection(self, *_: Any) -> bool:
        """There is no other lane."""
        return False

    def get_current_lane_width(self) -> float:
        return float(self.current_lane.width)

    def get_current_lateral_range(self, *_: Any) -> float:
        return float(self.current_lane.width)

    def get_navi_info(self) -> list[float]:
        """The next two checkpoints as the car sees them, each with the bend before it: none."""
        lane, car = self.current_lane, self.car
        along, _ = lane.local_coordinates(car.position)
        info: list[float] = []
        for number in (1, 2):
            way = lane.position(min((along // PIECE + number) * PIECE, lane.length), 0.0) - car.position
            way = way / max(np.hypot(*way) / PIECE, 1.0)
            info += [*((part / PIECE + 1) / 2 for part in car.convert_to_local_coordinates(way, 0.0)), 0.0, 0.5, 0.5]
        return info

    def __getattr__(self, name: str) -> Any:
        # The car attaches, detaches and destroys its navigation.
        if name in ("attach_to_world", "detach_from_world", "destroy", "reset"):
            return lambda *_: None
        raise AttributeError(name)


class Walkers(BaseManager):
    """Makes the pedestrians of each episode; outside of a manager the next reset fails."""

    def __init__(self, kinds: list[type[Pedestrian]]) -> None:
        super().__init__()
        self.kinds = kinds
        self.bodies: list[Pedestrian] = []

    def reset(self) -> None:
        """Put them far away."""
        away = [(AWAY[0] - 10.0 * number, AWAY[1]) for number in range(len(self.kinds))]
        self.bodies = [
            self.spawn_object(kind, position=place, heading_theta=0.0, force_spawn=True) for kind, place in zip(self.kinds, away, strict=True)
        ]


class Flat(BaseEnv):
    """A town of which only the lanes matter, without observations, rewards and ends."""

    def __init__(self, net: Path, step: float, substeps: int, bodies: list[dict[str, float]], mended: bool) -> None:
        prepare_assets()
        self.net = str(net)
        self.kinds = [kind(body, mended) for body in bodies]
        super().__init__({
            "use_render": False,
            "log_level": logging.CRITICAL,
            "agent_policy": Commanded,
            "physics_world_step_size": step,
            "decision_repeat": substeps,
            "horizon": None,
            "vehicle_config": {"navigation_module": None, "spawn_position_heading": [(0.0, 0.0), 0.0]},
            "show_terrain": False,
            "num_scenarios": 1,
        })

    def setup_engine(self) -> None:
        """The map, then the pedestrians."""
        super().setup_engine()
        maps = SumoMapManager(self.net)
        self.middle = middle(Path(self.net))
        self.engine.register_manager("map_manager", maps)
        self.walkers = Walkers(self.kinds)
        self.engine.register_manager("walkers", self.walkers)

    def reward_function(self, _: str) -> tuple[float, dict[str, Any]]:
        return 0.0, {}

    def cost_function(self, _: str) -> tuple[float, dict[str, Any]]:
        return 0.0, {}

    def done_function(self, _: str) -> tuple[bool, dict[str, Any]]:
        return False, {}

    def get_single_observation(self) -> DummyObservation:
        return DummyObservation()

    def settled(self) -> float:
        """The height of a car that stands still on its springs (m)."""
        for _ in range(SETTLING):
            self.step([0.0, 0.0])
        return float(self.agent.origin.getZ())

    def renew(self) -> None:
        """What a reset leaves of the last episode: how far the wheels have turned changes the last bits of their axles' directions."""
        car = self.agent
        car.set_pitch(0.0)
        car.set_roll(0.0)
        for number in range(4):
            wheel = car.system.getWheel(number)
            wheel.setRotation(0.0)
            wheel.setDeltaRotation(0.0)

    def hand_over(self, driver: str, points: list[tuple[float, float]], seed: int) -> None:
        """Let MetaDrive's own driver drive along a route."""
        lane = PointLane(np.array(points), LANE)
        car = self.agent
        car.navigation = Route(lane, car)
        # What a reset has measured along the last route.
        car.update_dist_to_left_right()
        car.last_heading_dir = car.heading
        for body in self.walkers.bodies:
            body.route = lane
        policy = NATIVE[driver]
        arguments = (lane,) if policy is TrajectoryIDMPolicy else ()
        self.engine.add_policy(car.id, policy, car, seed, *arguments)


def middle(net: Path) -> tuple[float, float]:
    """The middle of a net, to which `SumoMapManager` moves the origin."""
    import sumolib

    west, south, east, north = sumolib.net.readNet(str(net), withInternal=True).getBoundary()
    return (west + east) / 2, (south + north) / 2


def kind(body: dict[str, float], mended: bool) -> type[Pedestrian]:
    """A pedestrian of this size; a mended one says on which lane it is, without which `IDMPolicy` loses all that is near."""

    class Walker(Pedestrian):
        RADIUS, HEIGHT = body["radius"], body["height"]
        route: PointLane | None = None

    class Mended(Walker):
        @property
        def lane(self) -> PointLane:
            """The lane of the route if it is on it, and another one otherwise."""
            on_route = self.route is not None and self.route.point_on_lane(self.position)
            return self.route if on_route else ELSEWHERE

    return Mended if mended else Walker


ELSEWHERE = PointLane(np.array([[-4e3, 4e3], [-4e3 + 1.0, 4e3]]), 1.0)
