"""Logs that `py123d` has converted, of nuScenes, nuPlan, Argoverse 2, the Waymo Open Dataset and others: the folder of a log, with `sync.arrow`."""

from __future__ import annotations

from pathlib import Path

from . import PEDESTRIAN, VEHICLE, Actor, Instant, Unreadable

try:
    from py123d.api.scene.arrow.arrow_scene_api import ArrowSceneAPI
    from py123d.datatypes.detections.box_detection_label import DefaultBoxDetectionLabel as Label
except ImportError:
    raise Unreadable("logs of py123d need it: pip install py123d") from None

KINDS = {Label.EGO: VEHICLE, Label.VEHICLE: VEHICLE, Label.PERSON: PEDESTRIAN}
HOST = 0


def read(log: Path) -> list[Instant]:
    """The instants of a log: of the car that recorded, and of all tracked boxes of cars and persons."""
    if not (log / "sync.arrow").is_file():
        raise Unreadable("there is no `sync.arrow` in it; give the folder of a log that py123d has converted")
    scene = ArrowSceneAPI(log)
    names: dict[str, int] = {}
    instants = []
    for step in range(scene.number_of_iterations):
        ego, boxes = scene.get_ego_state_se3_at_iteration(step), scene.get_box_detections_se3_at_iteration(step)
        seen = [(names.setdefault(each.attributes.track_token, len(names) + 1), each) for each in boxes or ()]
        actors = []
        for name, each in [*seen, *([] if ego is None else [(HOST, ego.box_detection_se3)])]:
            kind, box, velocity = KINDS.get(each.attributes.default_label), each.bounding_box_se2, each.velocity_2d
            if kind is not None:
                middle, moving = box.center_se2, None if velocity is None else (velocity.x, velocity.y)
                actors.append(Actor(name, kind, middle.x, middle.y, middle.yaw, box.length, box.width, moving))
        instants.append(Instant(scene.get_timestamp_at_iteration(step).time_us * 1e-6, actors, None if ego is None else HOST))
    return instants
