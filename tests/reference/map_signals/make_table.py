"""Where the lights, speed signs and limits of maps of other tools than CARLA's apply, read from their XML as ASAM OpenDRIVE says.

    python3 make_table.py FOLDER > signals.csv    # a folder with maps somewhere below it; maps.csv says where they come from

Rows: a light stops cars of a lane of a road at s (m), and has the id of its signal; a sign has its limit (km/h); a limit has the number
of driving lanes of lane sections in whose middle it holds. A map without any of them has a row `none`. Python's own XML parser, nothing of falsify.
"""
import collections
import pathlib
import sys
import xml.etree.ElementTree as ET

LIGHTS = {"1000001", "1000009", "1000010", "1000011"}
KMH = {"m/s": 3.6, "km/h": 1, "mph": 1.609344}


class Road:
    def __init__(self, node):
        self.node, self.id, self.length = node, node.get("id"), float(node.get("length"))
        self.right_hand, self.inside = node.get("rule") != "LHT", node.get("junction") != "-1"
        sections = node.findall("lanes/laneSection")
        starts = [float(section.get("s")) for section in sections]
        self.sections = list(zip(starts, [*starts[1:], self.length], sections))
        self.types = sorted((float(kind.get("s") or 0), limit(kind.find("speed"))) for kind in node.findall("type"))

    def lanes(self, number):
        """The lanes for cars of a section, by id. The centre lane has no width."""
        found = {int(lane.get("id")): lane for lane in self.sections[number][2].iter("lane") if lane.get("type") == "driving"}
        return {id: lane for id, lane in found.items() if id != 0}

    def along(self, lane):
        return (lane < 0) == self.right_hand


def before(roads, road, number, lane):
    """The lane outside junctions that leads to a lane; itself if it is outside."""
    while road.inside:
        way = "predecessor" if road.along(lane) else "successor"
        link, step = road.lanes(number)[lane].find(f"link/{way}"), -1 if road.along(lane) else 1
        to = road.node.find(f"link/{way}")
        if link is None:
            return None
        lane = int(link.get("id"))
        if 0 <= number + step < len(road.sections):
            number += step
        elif to is None or to.get("elementType") != "road":
            return None
        else:
            road = next((each for each in roads if each.id == to.get("elementId")), None)
            if road is None:
                return None
            number = 0 if to.get("contactPoint") == "start" else len(road.sections) - 1
    return road, number, lane


def limit(speed):
    """A `speed` in km/h; 0 stands for none, since no road has it."""
    if speed is None or speed.get("max") == "undefined":
        return 0
    number = 130 if speed.get("max") == "no limit" else float(speed.get("max")) * KMH[speed.get("unit") or "m/s"]
    return max(number, 0)


def last(places, s):
    return ([0] + [value for begin, value in places if begin <= s])[-1]


def applies(placed, road, lane):
    ranges = [sorted((int(v.get("fromLane")), int(v.get("toLane")))) for v in placed.findall("validity")]
    if ranges:
        return any(low <= lane <= high for low, high in ranges)
    return {"+": road.along(lane), "-": not road.along(lane)}.get(placed.get("orientation"), True)


def signals(roads):
    """Each signal at each place: what it is, its road, its place along it, and the number of the section and the lane."""
    definitions = {signal.get("id"): signal for road in roads for signal in road.node.findall("signals/signal")}
    for road in roads:
        own = [(signal, signal) for signal in road.node.findall("signals/signal")]
        others = [(definitions.get(each.get("id")), each) for each in road.node.findall("signals/signalReference")]
        for definition, placed in own + others:
            if definition is None:
                continue
            s = float(placed.get("s"))
            number = max((i for i, (start, _, _) in enumerate(road.sections) if start <= s), default=0)
            for lane in road.lanes(number):
                if applies(placed, road, lane):
                    yield definition, road, s, number, lane


def sign_limit(signal):
    """The limit of a sign (km/h), if it is one: its value, or without a value that of its subtype in the German catalogue."""
    if signal.get("type") != "274":
        return None
    if float(signal.get("value") or -1) > 0:
        return float(signal.get("value")) * KMH[signal.get("unit") or "km/h"]
    subtype = float(signal.get("subtype") or -1)
    return 10 * (subtype - 50) if 51 <= subtype <= 63 and subtype != 60 else subtype if subtype > 0 else None


def facts(root):
    roads = [Road(node) for node in root.findall("road")]
    by_type = [any(value for _, value in road.types) for road in roads]
    has_limits = any(by_type) or any(limit(speed) for road in roads for lane in road.node.iter("lane") for speed in lane.findall("speed"))
    signs, seen = collections.defaultdict(list), set()
    for signal, road, s, number, lane in signals(roads):
        is_light = signal.get("type") in LIGHTS and signal.get("dynamic") != "no"
        approach = before(roads, road, number, lane) if is_light else None
        # A lane that forks inside is reached several times.
        if approach and (signal.get("id"), *approach[1:], approach[0].id) not in seen:
            seen.add((signal.get("id"), *approach[1:], approach[0].id))
            on, part, held = approach
            start, end, _ = on.sections[part]
            ends, apart = (end, -3) if on.along(held) else (start, 3)
            place = s if on is road and abs(s - ends) >= 20 else min(max(ends + apart, start), end)
            yield "light", on.id, held, "%.1f" % place, signal.get("id")
        if sign_limit(signal):
            yield "sign", road.id, lane, "%.1f" % s, "%.1f" % sign_limit(signal)
            # It holds from there to the end of the road.
            signs[road.id].append((s, number, lane, sign_limit(signal)))
    limits = collections.Counter()
    for road in roads:
        for number, (start, end, _) in enumerate(road.sections):
            for lane, node in road.lanes(number).items():
                middle = (start + end) / 2
                own = sorted((start + float(speed.get("sOffset") or 0), limit(speed)) for speed in node.findall("speed"))
                value = last(own, middle) or last(road.types, middle)
                passed = [each for each in signs[road.id] if each[2] == lane and (each[0] <= middle if road.along(lane) else each[0] >= middle)]
                if passed and has_limits:
                    value = (max if road.along(lane) else min)(passed)[3]
                if value:
                    limits["%.1f" % value] += 1
    for value, count in sorted(limits.items()):
        yield "limit", "", "", count, value


def read(path):
    root = ET.parse(path).getroot()
    for node in root.iter():
        node.tag = node.tag.split("}")[-1]
    return root


def main(folder):
    print("map,kind,road,lane,s,value")
    for path in sorted(pathlib.Path(folder).rglob("*.xodr")):
        root = read(path)
        header = root.find("header")
        if header is not None and header.get("vendor") in ("VectorZero", "falsify"):
            continue
        for row in list(facts(root)) or [("none", "", "", "", "")]:
            print(path.stem, *row, sep=",")


main(sys.argv[1])
