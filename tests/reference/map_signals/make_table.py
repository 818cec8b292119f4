"""Where the lights, speed signs and limits of maps of other tools than CARLA's apply, read from their XML as ASAM OpenDRIVE says.

    python3 make_table.py FOLDER > signals.csv    # a folder with maps somewhere below it

Rows: a light stops cars of a lane of a road at s (m), and has the id of its signal; a sign has its limit (km/h); a limit has the number
of lanes with a `speed` of it. A map without any of them has a row `none`. Python's own XML parser, nothing of falsify.
"""
import collections
import pathlib
import sys
import xml.etree.ElementTree as ET

LIGHTS = {"1000001", "1000009", "1000010", "1000011"}
KMH = {"m/s": 3.6, "km/h": 1, "mph": 1.609344}


def is_driven(lane):
    return lane.get("type") == "driving" and lane.get("id") != "0"  # the centre lane has no width


def facts(root):
    limits = collections.Counter()
    for road in root.findall("road"):
        sections = road.findall("lanes/laneSection")
        starts = [float(section.get("s")) for section in sections]
        right_hand = road.get("rule") != "LHT"
        for lane in road.iter("lane"):
            if is_driven(lane):
                for speed in lane.findall("speed"):
                    limits["%.1f" % (float(speed.get("max")) * KMH[speed.get("unit") or "m/s"])] += 1
        for signal in road.findall("signals/signal"):
            s, orientation = float(signal.get("s")), signal.get("orientation")
            number = max(i for i, start in enumerate(starts) if start <= s)
            lanes = [int(lane.get("id")) for lane in sections[number].iter("lane") if is_driven(lane)]
            ranges = [sorted((int(v.get("fromLane")), int(v.get("toLane")))) for v in signal.findall("validity")]
            for lane in lanes:
                along = (lane < 0) == right_hand
                if ranges:
                    applies = any(low <= lane <= high for low, high in ranges)
                else:
                    applies = {"+": along, "-": not along}.get(orientation, True)
                if not applies:
                    continue
                ends = [*starts[1:], float(road.get("length"))]
                end, before = (ends[number], -3) if along else (starts[number], 3)
                if signal.get("type") in LIGHTS and signal.get("dynamic") != "no":
                    assert road.get("junction") == "-1", "lights in junctions hold cars before them"
                    place = s if abs(s - end) >= 20 else end + before
                    yield "light", road.get("id"), lane, "%.1f" % place, signal.get("id")
                if signal.get("type") == "274":
                    limit = float(signal.get("value")) * KMH[signal.get("unit") or "km/h"]
                    yield "sign", road.get("id"), lane, "%.1f" % s, "%.1f" % limit
    for limit, count in sorted(limits.items()):
        yield "limit", "", "", count, limit


print("map,kind,road,lane,s,value")
for path in sorted(pathlib.Path(sys.argv[1]).rglob("*.xodr")):
    root = ET.parse(path).getroot()
    if root.find("header").get("vendor") in ("VectorZero", "falsify"):
        continue
    for row in list(facts(root)) or [("none", "", "", "", "")]:
        print(path.stem, *row, sep=",")
