"""nuPlan's map of what a driver is told of its road: the lane along the route, one part after another, and nothing beside it.

It answers what planners most ask. What it cannot answer raises an error that names the method: no lanes beside the own one, no intersections, crosswalks or
stop lines, and no pictures of the map.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .batch import Array

BEHIND, BEYOND = 24.0, 60.0  # m: so far the lane goes on straight, behind the car and beyond the route


def longer(route: Array) -> Array:
    """The route with poses a metre apart that goes on straight behind the car and beyond its end."""

    def beyond(pose: Array, distances: Array) -> Array:
        return np.column_stack([pose[0] + distances * math.cos(pose[2]), pose[1] + distances * math.sin(pose[2]), np.full(len(distances), pose[2])])

    line = np.vstack([beyond(route[0], np.arange(-BEHIND, 0.0, 1.0)), route, beyond(route[-1], np.arange(1.0, BEYOND, 1.0))])
    line[:, 2] = np.unwrap(line[:, 2])
    return line


@dataclass(frozen=True)
class Part:
    """A part of the lane along the route: at least two poses, the width (m), the speed limit (m/s), and whether it is a lane connector of nuPlan."""

    line: Array
    width: float
    speed: float
    connects: bool = False


class Incomplete:
    """A thing of the map; what it does not have is an error that says so."""

    #: What it is, in nuPlan's words.
    what = "thing"

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"the {self.what} that this adapter gives to planners has no `{name}`: the simulator does not tell a driver that")


class Polyline(Incomplete):
    """nuPlan's polyline through poses."""

    what = "polyline"

    def __init__(self, nuplan: Any, number: str, line: Array) -> None:
        self.id = number
        self.discrete_path = [nuplan.StateSE2(*pose) for pose in line]
        self._line = line
        self._along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])

    @property
    def length(self) -> float:
        """Its length (m)."""
        return float(self._along[-1])

    @cached_property
    def linestring(self) -> Any:
        """The line of shapely."""
        from shapely.geometry import LineString

        return LineString(self._line[:, :2])

    def get_nearest_arc_length_from_position(self, point: Any) -> float:
        """How far along it (m) it is nearest to a point."""
        from shapely.geometry import Point

        return float(self.linestring.project(Point(point.x, point.y)))

    def get_nearest_pose_from_position(self, point: Any) -> Any:
        """Its pose that is nearest to a point."""
        place = self.get_nearest_arc_length_from_position(point)
        x, y, heading = (float(np.interp(place, self._along, column)) for column in self._line.T)
        return type(self.discrete_path[0])(x, y, heading)


class _Area(Incomplete):
    """What has an outline."""

    id: str
    incoming_edges: list[Any]
    outgoing_edges: list[Any]
    polygon: Any

    @property
    def parallel_edges(self) -> list[Any]:
        """Those beside it with itself, which is alone."""
        return [self]

    def contains_point(self, point: Any) -> bool:
        """Whether a point is in it."""
        from shapely.geometry import Point

        return bool(self.polygon.contains(Point(point.x, point.y)))


class Lane(_Area):
    """nuPlan's lane, or lane connector, of a part."""

    what = "lane"
    adjacent_edges = None, None

    def __init__(self, nuplan: Any, number: str, part: Part) -> None:
        self.id, self.speed_limit_mps, self.connects = number, part.speed, part.connects
        self.incoming_edges, self.outgoing_edges = [], []
        aside = np.column_stack([-np.sin(part.line[:, 2]), np.cos(part.line[:, 2]), np.zeros(len(part.line))]) * part.width / 2
        self.baseline_path = Polyline(nuplan, f"{number}.middle", part.line)
        self.left_boundary = Polyline(nuplan, f"{number}.left", part.line + aside)
        self.right_boundary = Polyline(nuplan, f"{number}.right", part.line - aside)
        self._sides = part.line[:, :2] + aside[:, :2], (part.line - aside)[::-1, :2]
        self.block = Block(self)

    @cached_property
    def polygon(self) -> Any:
        """Its outline."""
        from shapely.geometry import Polygon

        return Polygon(np.vstack(self._sides)).buffer(0)

    def get_roadblock_id(self) -> str:
        """The id of its block."""
        return self.block.id

    def parent(self) -> Any:
        """Its block."""
        return self.block

    def is_same_roadblock(self, other: Any) -> bool:
        """Whether another lane is in its block."""
        return bool(other.get_roadblock_id() == self.block.id)


class Block(_Area):
    """nuPlan's road block of one lane."""

    what = "road block"

    def __init__(self, inside: Lane) -> None:
        self.id, self.interior_edges = f"block{inside.id}", [inside]
        self.incoming_edges, self.outgoing_edges = [], []

    @property
    def polygon(self) -> Any:
        """The outline of its lane."""
        return self.interior_edges[0].polygon


class Map(Incomplete):
    """nuPlan's map of the parts of the lane, one after another. Lanes and lane connectors are its layers, with their blocks; all other layers are empty."""

    what = "map"

    def __init__(self, nuplan: Any, parts: Iterable[Part], name: str = "") -> None:
        self.layers, self.map_name = nuplan.SemanticMapLayer, name
        self.lanes = [Lane(nuplan, str(number), part) for number, part in enumerate(parts, 1)]
        self.blocks = [each.block for each in self.lanes]
        for one, two in zip(self.lanes, self.lanes[1:]):
            one.outgoing_edges, two.incoming_edges = [two], [one]
            one.block.outgoing_edges, two.block.incoming_edges = [two.block], [one.block]

    @property
    def route(self) -> list[str]:
        """The ids of the blocks along the route."""
        return [each.id for each in self.blocks]

    def _of(self, layer: Any) -> list[Any]:
        """What a layer holds."""
        names = self.layers
        if layer in (names.ROADBLOCK, names.ROADBLOCK_CONNECTOR):
            return [each.block for each in self.lanes if each.connects == (layer == names.ROADBLOCK_CONNECTOR)]
        if layer in (names.LANE, names.LANE_CONNECTOR):
            return [each for each in self.lanes if each.connects == (layer == names.LANE_CONNECTOR)]
        return []

    def get_available_map_objects(self) -> list[Any]:
        """The layers that are not empty."""
        names = self.layers
        return [layer for layer in (names.LANE, names.LANE_CONNECTOR, names.ROADBLOCK, names.ROADBLOCK_CONNECTOR) if self._of(layer)]

    def get_map_object(self, number: str, layer: Any) -> Any:
        """A thing of a layer by its id, or none."""
        return next((each for each in self._of(layer) if each.id == number), None)

    def get_all_map_objects(self, point: Any, layer: Any) -> list[Any]:
        """What there is of a layer at a point."""
        return [each for each in self._of(layer) if each.contains_point(point)]

    def get_one_map_object(self, point: Any, layer: Any) -> Any:
        """The first thing of a layer at a point, or none."""
        return next(iter(self.get_all_map_objects(point, layer)), None)

    def get_proximal_map_objects(self, point: Any, radius: float, layers: list[Any]) -> dict[Any, list[Any]]:
        """What there is near a point (m), by layer."""
        from shapely.geometry import Point

        near = Point(point.x, point.y).buffer(radius)
        return {layer: [each for each in self._of(layer) if each.polygon.intersects(near)] for layer in layers}

    def is_in_layer(self, point: Any, layer: Any) -> bool:
        """Whether a point is in a layer."""
        return any(each.contains_point(point) for each in self._of(layer))

    def get_distance_to_nearest_map_object(self, point: Any, layer: Any) -> tuple[str | None, float]:
        """What is nearest of a layer, and its distance (m)."""
        from shapely.geometry import Point

        here = Point(point.x, point.y)
        found = min(((each.polygon.distance(here), each.id) for each in self._of(layer)), default=(math.inf, None))
        return found[1], found[0]

    def initialize_all_layers(self) -> None:
        """Nothing is left to load."""
