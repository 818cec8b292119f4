"""Maps in OpenDRIVE as nets of SUMO, in the same frame."""

from __future__ import annotations

import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

Array = np.ndarray


def convert(opendrive: str, folder: Path) -> Path:
    """The net of SUMO that `netconvert` makes of a map, unshifted: a file in a folder."""
    import sumo

    source, net = folder / "town.xodr", folder / "town.net.xml"
    source.write_text(opendrive, encoding="utf-8")
    program = Path(sumo.SUMO_HOME) / "bin" / "netconvert"
    options = [
        "--offset.disable-normalization=true",  # The net keeps the frame of the map.
        "--opendrive.curve-resolution=0.5",
        "--opendrive.internal-shapes=true",
        "--opendrive.advance-stopline=0",
        "--geometry.min-dist=-1",
        "--no-turnarounds=true",
        "--flatten=true",
        "--precision=4",
    ]
    done = subprocess.run([program, "--opendrive-files", source, "-o", net, *options], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"netconvert cannot convert the map: {done.stderr.strip()}")
    shift = ElementTree.parse(net).getroot().find("location")
    if shift is None or [float(part) for part in shift.get("netOffset", "").split(",")] != [0.0, 0.0]:
        raise SystemExit("netconvert has shifted the map")
    return net


def shapes(net: Path) -> list[Array]:
    """The middles of the lanes of a net for cars, those inside junctions, too: points (n, 2)."""
    found = []
    for lane in ElementTree.parse(net).getroot().iter("lane"):
        allowed, forbidden = lane.get("allow"), lane.get("disallow", "")
        if (allowed is None or "passenger" in allowed.split()) and not {"passenger", "all"} & set(forbidden.split()):
            found.append(np.array([[float(part) for part in point.split(",")[:2]] for point in lane.get("shape", "").split()]))
    return [shape for shape in found if len(shape) > 1]


def nearest(lanes: list[Array], places: list[list[float]]) -> list[tuple[float, float]]:
    """For each place the nearest point on the lanes."""
    starts = np.concatenate([lane[:-1] for lane in lanes])
    ways = np.concatenate([np.diff(lane, axis=0) for lane in lanes])
    lengths = np.maximum((ways**2).sum(axis=1), 1e-12)
    found = []
    for place in np.array(places, dtype=float):
        along = np.clip(((place - starts) * ways).sum(axis=1) / lengths, 0.0, 1.0)
        points = starts + along[:, None] * ways
        x, y = points[((place - points) ** 2).sum(axis=1).argmin()]
        found.append((float(x), float(y)))
    return found
