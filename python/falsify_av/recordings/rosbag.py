"""ROS 2 bags with Autoware's tracked objects, by the library ``rosbags``: ``TrackedObjects``, and ``nav_msgs/msg/Odometry`` for the car that recorded.

Poses of objects and of the car must be in one frame. The car's is that of its rear axle, and its box that of Autoware's sample vehicle.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from . import PEDESTRIAN, VEHICLE, Actor, Instant, Unreadable

try:
    from rosbags.highlevel import AnyReader, AnyReaderError
except ImportError:
    raise Unreadable("ROS 2 bags need the library rosbags: pip install rosbags") from None

KINDS = {1: VEHICLE, 2: VEHICLE, 3: VEHICLE, 4: VEHICLE, 5: VEHICLE, 7: PEDESTRIAN}
"""Labels of ``ObjectClassification``: car, truck, bus, trailer, motorcycle; pedestrian."""
HOST = 2**63 - 1
LENGTH, WIDTH, REAR_TO_MIDDLE = 4.77, 1.83, 1.375


def _yaw(turned: Any) -> float:
    return math.atan2(2 * (turned.w * turned.z + turned.x * turned.y), 1 - 2 * (turned.y**2 + turned.z**2))


def _moving(pose: Any, twist: Any, ahead: float) -> tuple[float, float, float, tuple[float, float]]:
    """The place that is `ahead` (m) of a pose, its heading, and its velocity, which messages have in the frame of the body."""
    yaw = _yaw(pose.orientation)
    sin, cos = math.sin(yaw), math.cos(yaw)
    along, aside = twist.linear.x, twist.linear.y
    velocity = (cos * along - sin * aside, sin * along + cos * aside)
    return pose.position.x + ahead * cos, pose.position.y + ahead * sin, yaw, velocity


def _object(each: Any) -> Actor | None:
    label = max(each.classification, key=lambda found: found.probability, default=None)
    kind = KINDS.get(label.label) if label is not None else None
    if kind is None:
        return None
    kinematics = each.kinematics
    x, y, yaw, velocity = _moving(kinematics.pose_with_covariance.pose, kinematics.twist_with_covariance.twist, 0.0)
    name = int.from_bytes(bytes(each.object_id.uuid)[:7], "little")
    return Actor(name, kind, x, y, yaw, each.shape.dimensions.x, each.shape.dimensions.y, velocity)


def read(bag: Path) -> list[Instant]:
    """The instants of the tracked objects; the car is where it was told to be last."""
    instants: list[Instant] = []
    host: tuple[str, Actor] | None = None
    try:
        with AnyReader([bag]) as reader:
            wanted = [each for each in reader.connections if each.msgtype.endswith(("/TrackedObjects", "/Odometry"))]
            for connection, _, raw in reader.messages(wanted):
                message: Any = reader.deserialize(raw, connection.msgtype)
                if connection.msgtype.endswith("/Odometry"):
                    x, y, yaw, velocity = _moving(message.pose.pose, message.twist.twist, REAR_TO_MIDDLE)
                    host = (message.header.frame_id, Actor(HOST, VEHICLE, x, y, yaw, LENGTH, WIDTH, velocity))
                    continue
                if host is not None and host[0] != message.header.frame_id:
                    raise Unreadable(f"objects are in the frame {message.header.frame_id!r} and the car in {host[0]!r}; give a bag with one frame for both")
                stamp = message.header.stamp
                actors = [actor for actor in map(_object, message.objects) if actor is not None]
                car = [] if host is None else [host[1]]
                instants.append(Instant(stamp.sec + stamp.nanosec * 1e-9, actors + car, HOST if car else None))
    except AnyReaderError as error:
        raise Unreadable(f"rosbags cannot read it: {error}") from None
    if not instants:
        raise Unreadable("there is no topic of `TrackedObjects` in it")
    return instants
