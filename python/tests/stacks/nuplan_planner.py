"""A planner of nuPlan: it keeps its lane, and stops for who is in it and at a red light."""

import math

from nuplan.common.actor_state.ego_state import EgoState
from nuplan.common.actor_state.state_representation import StateSE2, StateVector2D, TimePoint
from nuplan.common.maps.maps_datatypes import SemanticMapLayer, TrafficLightStatusType
from nuplan.planning.simulation.observation.observation_type import DetectionsTracks
from nuplan.planning.simulation.planner.abstract_planner import AbstractPlanner
from nuplan.planning.simulation.trajectory.interpolated_trajectory import InterpolatedTrajectory


class Keeper(AbstractPlanner):
    def __init__(self, room: float = 8.0, braking: float = 2.0, fails_within: float = 0.0):
        self.room, self.braking, self.fails_within = room, braking, fails_within

    def name(self):
        return "Keeper"

    def observation_type(self):
        return DetectionsTracks

    def initialize(self, initialization):
        layers, blocks = (SemanticMapLayer.ROADBLOCK, SemanticMapLayer.ROADBLOCK_CONNECTOR), initialization.route_roadblock_ids
        found = [initialization.map_api.get_map_object(block, layer) for block in blocks for layer in layers]
        self.lanes = [block.interior_edges[0] for block in found if block]

    def compute_planner_trajectory(self, current_input):
        ego, seen = current_input.history.current_state
        here = ego.rear_axle
        shut = [str(light.lane_connector_id) for light in current_input.traffic_light_data if light.status == TrafficLightStatusType.RED]
        path = [(math.dist((pose.x, pose.y), (here.x, here.y)), pose, lane) for lane in self.lanes for pose in lane.baseline_path.discrete_path]
        path = path[path.index(min(path, key=lambda each: each[0])) :]
        stops = [far for far, _, lane in path if lane.id in shut][:1]
        for person in seen.tracked_objects.tracked_objects:
            gap, far = min((math.dist((pose.x, pose.y), (person.center.x, person.center.y)), far) for far, pose, _ in path)
            stops += [far] if gap < 2.0 else []
            if gap < self.fails_within:
                raise RuntimeError("a person is near")
        speed = min(self.lanes[0].speed_limit_mps, math.sqrt(2 * self.braking * max(min(stops, default=1e3) - self.room, 0.0)))
        states = []
        for step in range(9):
            pose = next((pose for far, pose, _ in path if far >= 0.5 * step * speed), path[-1][1]) if step else here
            times, car = TimePoint(ego.time_us + 500_000 * step), ego.car_footprint.vehicle_parameters
            place = StateSE2(pose.x, pose.y, pose.heading)
            states.append(EgoState.build_from_rear_axle(place, StateVector2D(speed, 0.0), StateVector2D(0.0, 0.0), 0.0, times, car))
        return InterpolatedTrajectory(states)
