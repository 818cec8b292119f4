"""Stands in for what the adapter uses of nuPlan's devkit, which is not on PyPI: the same names, and of each what is needed here."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum, IntEnum
from pathlib import Path
from typing import Any

PLANNING = "nuplan.planning.simulation"
#: What a planner imports besides the names that the adapter uses.
MORE = {
    f"{PLANNING}.planner.abstract_planner": "AbstractPlanner PlannerInitialization PlannerInput",
    f"{PLANNING}.trajectory.interpolated_trajectory": "InterpolatedTrajectory",
}


def install(folder: Path, names: dict[str, str]) -> None:
    """Write a package `nuplan` of these names by module, and more, into a folder."""
    source = Path(__file__).read_text(encoding="utf-8")
    (folder / "stand_in_of_nuplan.py").write_text(source, encoding="utf-8")
    for module, of_it in {**names, **MORE}.items():
        file = folder.joinpath(*module.split(".")).with_suffix(".py")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"from stand_in_of_nuplan import {', '.join(of_it.split())}\n")


@dataclass(frozen=True)
class Point2D:
    x: float
    y: float


@dataclass(frozen=True)
class StateSE2:
    x: float
    y: float
    heading: float


StateVector2D = Point2D


@dataclass(frozen=True)
class TimePoint:
    time_us: int

    def __post_init__(self) -> None:
        assert self.time_us >= 0, "Time point has to be positive!"


@dataclass(frozen=True)
class VehicleParameters:
    width: float
    front_length: float
    rear_length: float
    rear_axle_to_center: float
    wheel_base: float
    vehicle_name: str
    vehicle_type: str
    height: float | None = None


@dataclass(frozen=True)
class EgoState:
    rear_axle: StateSE2
    velocity: Point2D
    acceleration: Point2D
    tire_steering_angle: float
    time_point: TimePoint
    vehicle_parameters: VehicleParameters
    angular_velocity: float

    @classmethod
    def build_from_rear_axle(cls, *values: Any, angular_vel: float = 0.0) -> EgoState:
        return cls(*values, angular_vel)

    @property
    def center(self) -> StateSE2:
        rear, ahead = self.rear_axle, self.vehicle_parameters.rear_axle_to_center
        return StateSE2(rear.x + ahead * math.cos(rear.heading), rear.y + ahead * math.sin(rear.heading), rear.heading)

    @property
    def time_us(self) -> int:
        return self.time_point.time_us

    @property
    def car_footprint(self) -> EgoState:
        return self


@dataclass(frozen=True)
class OrientedBox:
    center: StateSE2
    length: float
    width: float
    height: float


@dataclass(frozen=True)
class SceneObjectMetadata:
    timestamp_us: int
    token: str
    track_id: int
    track_token: str


class TrackedObjectType(Enum):
    VEHICLE = 0
    PEDESTRIAN = 1


@dataclass(frozen=True)
class Agent:
    tracked_object_type: TrackedObjectType
    box: OrientedBox
    velocity: Point2D
    metadata: SceneObjectMetadata

    @property
    def center(self) -> StateSE2:
        return self.box.center


@dataclass(frozen=True)
class TrackedObjects:
    tracked_objects: list[Agent]


@dataclass(frozen=True)
class DetectionsTracks:
    tracked_objects: TrackedObjects


SemanticMapLayer = IntEnum("SemanticMapLayer", "LANE INTERSECTION CROSSWALK LANE_CONNECTOR ROADBLOCK ROADBLOCK_CONNECTOR")
TrafficLightStatusType = IntEnum("TrafficLightStatusType", "GREEN YELLOW RED UNKNOWN")


@dataclass(frozen=True)
class TrafficLightStatusData:
    status: Any
    lane_connector_id: int
    timestamp: int


@dataclass(frozen=True)
class SimulationHistoryBuffer:
    ego_states: list[EgoState]
    observations: list[DetectionsTracks]
    sample_interval: float

    @classmethod
    def initialize_from_list(cls, size: int, states: list[Any], seen: list[Any], interval: float) -> SimulationHistoryBuffer:
        assert size == len(states) == len(seen)
        return cls(states, seen, interval)

    @property
    def current_state(self) -> tuple[EgoState, DetectionsTracks]:
        return self.ego_states[-1], self.observations[-1]


@dataclass(frozen=True)
class SimulationIteration:
    time_point: TimePoint
    index: int


@dataclass(frozen=True)
class PlannerInitialization:
    route_roadblock_ids: list[str]
    mission_goal: StateSE2
    map_api: Any


@dataclass(frozen=True)
class PlannerInput:
    iteration: SimulationIteration
    history: SimulationHistoryBuffer
    traffic_light_data: list[TrafficLightStatusData]


class AbstractPlanner:
    requires_scenario = False


class InterpolatedTrajectory:
    def __init__(self, trajectory: list[EgoState]) -> None:
        self.states = trajectory

    def get_sampled_trajectory(self) -> list[EgoState]:
        return self.states
