"""SUMO's floating car data (``--fcd-output``): cars at the middle of their front bumper, persons at their front, headings clockwise from north.

Sizes are those of SUMO's default types; ``--fcd-output.attributes all`` adds none.
"""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree

from . import PEDESTRIAN, VEHICLE, Actor, Instant, Unreadable

SIZES = {"vehicle": (VEHICLE, 5.0, 1.8), "person": (PEDESTRIAN, 0.215, 0.478)}


def read(path: Path) -> list[Instant]:
    """The instants of a file."""
    names: dict[str, int] = {}
    instants: list[Instant] = []
    try:
        for _, step in ElementTree.iterparse(path):
            if step.tag != "timestep":
                continue
            actors = []
            for each in step:
                if each.tag in SIZES:
                    kind, length, width = SIZES[each.tag]
                    yaw = math.radians(90 - float(each.attrib["angle"]))
                    sin, cos, speed = math.sin(yaw), math.cos(yaw), float(each.attrib["speed"])
                    x, y = float(each.attrib["x"]) - cos * length / 2, float(each.attrib["y"]) - sin * length / 2
                    name = names.setdefault(each.attrib["id"], len(names))
                    actors.append(Actor(name, kind, x, y, yaw, length, width, (cos * speed, sin * speed)))
            instants.append(Instant(float(step.attrib["time"]), actors))
            step.clear()
    except ElementTree.ParseError as error:
        raise Unreadable(f"it is no XML: {error}") from None
    except (KeyError, ValueError) as error:
        raise Unreadable(f"it is no floating car data of SUMO: {error!r}") from None
    return instants
