"""Replays exported OpenSCENARIO files in esmini, and compares positions and touches with the files.

    python tests/exports/esmini.py ESMINI FILES.xosc

Both are compared tick by tick. The touch of the boxes is the one that the file's header states.
"""

import math
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections import Counter
from pathlib import Path

TICK = 0.05


def replay(esmini, path):
    root = ElementTree.parse(path).getroot()
    tracks, names = {}, [entity.get("name") for entity in root.iter("ScenarioObject")]
    for track in root.iter("Trajectory"):
        places = [vertex.find(".//WorldPosition") for vertex in track.iter("Vertex")]
        tracks[track.get("name").removeprefix("track_")] = [(float(p.get("x")), float(p.get("y"))) for p in places]
    header = root.find("FileHeader").get("description")
    struck = names.index(re.search(r"First overlap of ego and (\w+):", header).group(1))
    boxes = float(re.search(r"of the boxes at ([\d.]+) s", header).group(1))
    disc = float(re.search(r"with the disc at ([\d.]+) s", header).group(1))
    with tempfile.TemporaryDirectory() as folder:
        options = ["--headless", "--collision", "--disable_stdout", "--fixed_timestep", str(TICK)]
        options += ["--traj_filter", "0.0", "--pline_interpolation", "segment", "--csv_logger", "out.csv"]
        subprocess.run([esmini, "--osc", str(Path(path).resolve()), *options], cwd=folder, check=True, capture_output=True)
        lines = Path(folder, "out.csv").read_text().splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("Index"))
    head = [name.strip() for name in lines[start].split(",")]
    # What the ego, object 0, touches; others may touch one another, too.
    touched = head.index("#1 collision_ids")
    error, touch, compared = 0.0, None, 0
    for line in lines[start + 1 :]:
        values = [value.strip() for value in line.split(",")]
        tick = round(float(values[1]) / TICK)
        for number, name in enumerate(names, 1):
            if tick < len(tracks[name]):
                x, y = (float(values[head.index(f"#{number} World_Position_{axis} [m]")]) for axis in "XY")
                error = max(error, math.hypot(x - tracks[name][tick][0], y - tracks[name][tick][1]))
                compared += 1
        if touch is None and values[touched]:
            assert str(struck) in values[touched].split(), (path, names[struck], values[touched])
            touch = float(values[1])
    assert compared > 2, (path, "nothing was compared")
    assert touch is not None, (path, "no touch")
    return error, round((touch - boxes) / TICK), round((touch - disc) / TICK)


def main(esmini, files):
    results = [replay(esmini, path) for path in files]
    errors, boxes, discs = zip(*results)
    print(f"{len(files)} failures, greatest difference of a position {max(errors):.2e} m")
    print(f"ticks from the touch of the boxes to esmini's: {dict(Counter(boxes))}; from that of the disc: {dict(Counter(discs))}")
    assert max(errors) <= 1e-3, max(errors)
    assert all(abs(ticks) <= 1 for ticks in boxes + discs), (boxes, discs)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
