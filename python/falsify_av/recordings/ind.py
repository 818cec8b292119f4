"""inD and rounD: ``NN_tracks.csv`` with ``NN_tracksMeta.csv`` and ``NN_recordingMeta.csv`` beside it.

Their columns are those of the data sets' own page (https://levelxdata.com): headings in degrees from x to y, middles in metres, pedestrians without a size.
"""

from __future__ import annotations

import csv
import math
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from . import PEDESTRIAN, VEHICLE, Actor, Instant, Unreadable

CARS = {"car", "truck", "bus", "truck_bus", "van", "trailer", "motorcycle"}


def _rows(path: Path) -> Iterator[dict[str, str]]:
    if not path.is_file():
        raise Unreadable(f"there is no `{path.name}` beside it; the data set gives three files of each recording")
    with path.open(encoding="utf-8-sig", newline="") as file:
        yield from csv.DictReader(file)


def read(tracks: Path) -> list[Instant]:
    """The instants of a recording."""
    if not tracks.name.endswith("tracks.csv"):
        raise Unreadable("its name does not end with `tracks.csv`; give the tracks of a recording, such as 00_tracks.csv")
    beside = [tracks.with_name(tracks.name.replace("tracks.csv", f"{name}.csv")) for name in ("tracksMeta", "recordingMeta")]
    frames: dict[int, list[Actor]] = defaultdict(list)
    try:
        kinds = {int(row["trackId"]): row["class"].lower() for row in _rows(beside[0])}
        rate = float(next(_rows(beside[1]))["frameRate"])
        for row in _rows(tracks):
            name = int(row["trackId"])
            kind = VEHICLE if kinds[name] in CARS else PEDESTRIAN if kinds[name] == "pedestrian" else None
            if kind is not None:
                numbers = [float(row[key]) for key in ("xCenter", "yCenter", "heading", "length", "width", "xVelocity", "yVelocity")]
                x, y, heading, length, width, *velocity = numbers
                actor = Actor(name, kind, x, y, math.radians(heading), length, width, (velocity[0], velocity[1]))
                frames[int(row["frame"])].append(actor)
    except KeyError as error:
        raise Unreadable(f"there is no {error.args[0]!r} in its columns or tracks") from None
    except (StopIteration, ValueError, TypeError) as error:
        raise Unreadable(f"a field is empty or no number: {error}") from None
    # An instant without anybody is one, too.
    return [Instant(frame / rate, frames.get(frame, [])) for frame in range(min(frames, default=0), max(frames, default=-1) + 1)]
