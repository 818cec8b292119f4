"""esmini as a world: its simple vehicle carries out the acceleration and the wheel angle of our drivers, and its drivers of UN Regulation 157 drive along their lane.

`scenarios/external/build_esmini.sh` builds the library from a checkout. Option: `library=PATH`, or the variable FALSIFY_ESMINI_LIBRARY. The C signatures of esmini
changed from 32-bit to 64-bit numbers: a place that is reported is read back, and a library of the other signatures is refused.
"""

from __future__ import annotations

import ctypes
import hashlib
import math
import os
import tempfile
from ctypes import CDLL, POINTER, Structure, byref, c_char_p, c_double, c_int, c_uint32, c_void_p
from pathlib import Path

from . import Message, chosen, state

DRIVERS = ("Regulation", "ReferenceDriver", "RSS", "FSM")
BEHIND = 0.35  # The point that esmini's simple vehicle moves is behind the middle of the wheelbase, by this share of it.
STRIDE = 25  # m: between waypoints of a route, whose points are 1 m apart.
NO_JUNCTION = 2**32 - 1
EXACT = 1e-6  # m: of a place that is read back.
BESIDE, CLOSE = 0.05, 0.02  # m: how far beside a place roads are looked for, unless the lane is this close.


#: The letters of the fields below.
LETTERS: dict[str, type[c_int] | type[c_uint32] | type[c_double]] = {"i": c_int, "u": c_uint32, "d": c_double}


def fields(text: str) -> list[tuple[str, type[c_int] | type[c_uint32] | type[c_double]]]:
    """The fields of a structure: a letter for the type, and names."""
    groups = (group.split() for group in text.split(","))
    return [(name, LETTERS[letter]) for letter, *names in groups for name in names]


class ObjectState(Structure):
    """`SE_ScenarioObjectState`."""

    _fields_ = fields(
        "i id model_id ctrl_type, d timestamp x y z h p r, u road junction, d t, i lane, d offset s speed center_x center_y center_z width length height,"
        "i type category, d wheel_angle wheel_rotation, i visibility"
    )


class SimpleState(Structure):
    """`SE_SimpleVehicleState`."""

    _fields_ = fields("d x y z h p speed wheel_rotation wheel_angle")


#: The functions: result, arguments.
FUNCTIONS = {
    "SE_SetLogFilePath": (None, (c_char_p,)),
    "SE_SetOptionPersistent": (c_int, (c_char_p,)),
    "SE_SetSeed": (None, (c_uint32,)),
    "SE_Init": (c_int, (c_char_p, c_int, c_int, c_int, c_int)),
    "SE_StepDT": (c_int, (c_double,)),
    "SE_Close": (None, ()),
    "SE_GetObjectState": (c_int, (c_int, POINTER(ObjectState))),
    "SE_ReportObjectPosXYH": (c_int, (c_int, c_double, c_double, c_double)),
    "SE_ReportObjectRoadPos": (c_int, (c_int, c_uint32, c_int, c_double, c_double)),
    "SE_ReportObjectVel": (c_int, (c_int, c_double, c_double, c_double)),
    "SE_SimpleVehicleCreate": (c_void_p, (c_double,) * 5),
    "SE_SimpleVehicleDelete": (None, (c_void_p,)),
    "SE_SimpleVehicleControlAccAndSteer": (None, (c_void_p, c_double, c_double, c_double)),
    "SE_SimpleVehicleSetSpeed": (None, (c_void_p, c_double)),
    "SE_SimpleVehicleGetState": (None, (c_void_p, POINTER(SimpleState))),
}


def world(words: list[str]) -> Esmini:
    """The world for `python3 -m falsify_av.bridges esmini WORDS`."""
    path = chosen("esmini", words, library="PATH").get("library", os.environ.get("FALSIFY_ESMINI_LIBRARY", ""))
    if not Path(path).is_file():
        raise SystemExit("esmini needs its library: scenarios/external/build_esmini.sh builds it; library=PATH or FALSIFY_ESMINI_LIBRARY names it")
    return Esmini(Path(path))


class Esmini:
    """A library of esmini. Its car is object 0, pedestrians follow."""

    def __init__(self, path: Path) -> None:
        self.esmini = CDLL(str(path))
        for name, (result, arguments) in FUNCTIONS.items():
            if not hasattr(self.esmini, name):
                raise SystemExit(f"this library of esmini has no function {name}: build a newer one, 3.6.0 or later")
            function = getattr(self.esmini, name)
            function.restype, function.argtypes = result, arguments
        self.vehicle: int | None = None
        self.folder = tempfile.TemporaryDirectory()
        self.about: Message = {
            "name": "esmini",
            "version": f"library {hashlib.sha256(path.read_bytes()).hexdigest()[:12]}",
            "drivers": list(DRIVERS), "friction": False, "lights": False, "seeds": True,
        }  # fmt: skip

    def load(self, message: Message) -> list[tuple[float, float]]:
        """Keep the map in a file, and ask where its lanes are."""
        self.tick, self.car, self.bodies = message["tick_s"], message["vehicle"], message["pedestrians"]
        self.map = Path(self.folder.name) / "town.xodr"
        self.map.write_text(message["map"], encoding="utf-8")
        self.esmini.SE_SetOptionPersistent(b"disable_stdout")
        self.esmini.SE_SetLogFilePath(str(Path(self.folder.name) / "log.txt").encode())
        x, y = message["lanes"][0]
        ego = {"x": x, "y": y, "yaw": 0.0, "speed": 0.0}
        self.start({"ego": ego, "driver": None, "route": [], "seed": 0, "pedestrians": [ego for _ in self.bodies]})
        self.report(0, x, y, 0.5)
        seen = self.state(0)
        if max(abs(seen.x - x), abs(seen.y - y), abs(seen.h - 0.5)) > EXACT:
            raise SystemExit("this library of esmini has other C signatures (32-bit numbers, or a time in SE_ReportObjectPosXYH): build a newer one, 3.6.0 or later")
        return [self.nearest(x, y) for x, y in message["lanes"]]

    def begin(self, message: Message) -> Message:
        """A new scenario with everybody at the start."""
        self.start(message)
        ego = message["ego"]
        if self.vehicle is not None:
            self.esmini.SE_SimpleVehicleDelete(self.vehicle)
            self.vehicle = None
        if not message["driver"]:
            back, base = BEHIND * self.car["wheelbase"], self.car["wheelbase"]
            x, y = ego["x"] - back * math.cos(ego["yaw"]), ego["y"] - back * math.sin(ego["yaw"])
            self.vehicle = self.esmini.SE_SimpleVehicleCreate(x, y, ego["yaw"], base, ego["speed"])
        self.place(message["pedestrians"])
        return self.now()

    def step(self, message: Message) -> Message:
        """One tick. esmini's drivers see the pedestrians as they were at its start."""
        if self.vehicle is not None:
            control = message["control"]
            self.esmini.SE_SimpleVehicleControlAccAndSteer(self.vehicle, self.tick, control["acceleration"], control["wheel_angle"])
            if self.simple().speed < 0.0:
                self.esmini.SE_SimpleVehicleSetSpeed(self.vehicle, 0.0)
        self.esmini.SE_StepDT(self.tick)
        self.place(message["pedestrians"])
        return self.now()

    def start(self, message: Message) -> None:
        """Start a scenario."""
        file = Path(self.folder.name) / "episode.xosc"
        file.write_text(self.scenario(message), encoding="utf-8")
        self.esmini.SE_Close()
        self.esmini.SE_SetSeed(message["seed"] % 2**32)
        if self.esmini.SE_Init(str(file).encode(), 0, 0, 0, 0) != 0:
            raise SystemExit("esmini cannot start the scenario")

    def place(self, pedestrians: list[Message]) -> None:
        """Put the pedestrians where they are at the end of the tick."""
        for number, told in enumerate(pedestrians, start=1):
            self.report(number, told["x"], told["y"], told["yaw"])
            self.esmini.SE_ReportObjectVel(number, told["vx"], told["vy"], 0.0)

    def now(self) -> Message:
        """The state of everybody."""
        places = [(seen.x, seen.y) for seen in map(self.state, range(1, len(self.bodies) + 1))]
        if self.vehicle is None:
            seen = self.state(0)
            return state(seen.x, seen.y, seen.h, seen.speed, places)
        simple, ahead = self.simple(), BEHIND * self.car["wheelbase"]
        return state(simple.x + ahead * math.cos(simple.h), simple.y + ahead * math.sin(simple.h), simple.h, simple.speed, places)

    def report(self, number: int, x: float, y: float, yaw: float) -> None:
        """Put an object somewhere."""
        self.esmini.SE_ReportObjectPosXYH(number, x, y, yaw)

    def state(self, number: int) -> ObjectState:
        """Where an object is."""
        seen = ObjectState()
        if self.esmini.SE_GetObjectState(number, byref(seen)) != 0:
            raise SystemExit(f"esmini has lost object {number}")
        return seen

    def simple(self) -> SimpleState:
        """Where the simple vehicle is."""
        seen = SimpleState()
        self.esmini.SE_SimpleVehicleGetState(self.vehicle, byref(seen))
        return seen

    def nearest(self, x: float, y: float) -> tuple[float, float]:
        """The nearest point on the middle of a lane. At the end of a road esmini may choose a lane of the junction, so roads a little beside are tried, too."""
        found: list[tuple[float, tuple[float, float]]] = []
        for east, north in ((0, 0), (BESIDE, 0), (-BESIDE, 0), (0, BESIDE), (0, -BESIDE)):
            self.report(0, x + east, y + north, 0.0)
            there = self.state(0)
            for along in (0.0, -BESIDE, BESIDE):
                self.esmini.SE_ReportObjectRoadPos(0, there.road, there.lane, 0.0, max(there.s + along, 0.0))
                seen = self.state(0)
                found.append((math.dist((x, y), (seen.x, seen.y)), (seen.x, seen.y)))
            if min(found)[0] < CLOSE:
                break
        return min(found)[1]

    def waypoints(self, route: list[list[float]]) -> list[list[float]]:
        """A point in 25 m, and the first after each junction: in a junction roads overlap, and esmini may take another one than that of the route."""
        points, since = [], STRIDE
        for point in route:
            self.report(0, *point)
            if self.state(0).junction != NO_JUNCTION:
                since = STRIDE
                continue
            if since >= STRIDE:
                points.append(point)
                since = 0
            since += 1
        return points

    def body(self, name: str) -> str:
        """A car. The reference point is the middle of its box."""
        half, axle = self.car["wheelbase"] / 2, 'maxSteering="0.7" wheelDiameter="0.7" trackWidth="1.6" positionZ="0.35"'
        return (
            f'<Vehicle name="{name}" vehicleCategory="car">{box(self.car["length"], self.car["width"], 1.5)}'
            '<Performance maxSpeed="70" maxAcceleration="10" maxDeceleration="10"/>'
            f'<Axles><FrontAxle {axle} positionX="{half}"/><RearAxle {axle} positionX="{-half}"/></Axles><Properties/></Vehicle>'
        )

    def scenario(self, message: Message) -> str:
        """An OpenSCENARIO file. At the end of a road esmini would hold a moving car: for its drivers another car stands at the end of the route."""
        ego, driver = message["ego"], message["driver"]
        route = message["route"] if driver else []
        last = "".join(f'<ScenarioObject name="last">{self.body("last")}</ScenarioObject>' for _ in route[-1:])
        controller = f'<Property name="esminiController" value="{"ALKS_R157SM_Controller" if driver else "ExternalController"}"/>'
        settings = f'<Property name="model" value="{driver}"/><Property name="logLevel" value="0"/>' if driver else ""
        control = f'<ObjectController><Controller name="driver"><Properties>{controller}{settings}</Properties></Controller></ObjectController>'
        people = "".join(
            f'<ScenarioObject name="person{number}"><Pedestrian name="person{number}" mass="70" model="" pedestrianCategory="pedestrian">'
            f'{box(2 * body["radius"], 2 * body["radius"], body["height"])}<Properties/></Pedestrian></ScenarioObject>'
            for number, body in enumerate(self.bodies)
        )
        waypoints = "".join(f'<Waypoint routeStrategy="shortest">{place(*point)}</Waypoint>' for point in self.waypoints(route))
        way = f'<RoutingAction><AssignRouteAction><Route name="way" closed="false">{waypoints}</Route></AssignRouteAction></RoutingAction>' if waypoints else ""
        actions = [
            f"<TeleportAction>{place(ego['x'], ego['y'], ego['yaw'])}</TeleportAction>",
            '<LongitudinalAction><SpeedAction><SpeedActionDynamics dynamicsShape="step" dynamicsDimension="time" value="0"/><SpeedActionTarget>'
            f'<AbsoluteTargetSpeed value="{ego["speed"]!r}"/></SpeedActionTarget></SpeedAction></LongitudinalAction>',
            way,
            f'<ControllerAction><ActivateControllerAction longitudinal="true" lateral="{"false" if driver else "true"}"/></ControllerAction>',
        ]
        places = {f"person{number}": (told["x"], told["y"], told["yaw"]) for number, told in enumerate(message["pedestrians"])}
        places |= {"last": point for point in route[-1:]}
        stand = "".join(
            f'<Private entityRef="{name}"><PrivateAction><TeleportAction>{place(*point)}</TeleportAction></PrivateAction></Private>' for name, point in places.items()
        )
        return (
            '<?xml version="1.0" encoding="UTF-8"?><OpenSCENARIO><FileHeader revMajor="1" revMinor="1" date="2026-01-01T00:00:00" description="" author=""/>'
            f'<ParameterDeclarations/><CatalogLocations/><RoadNetwork><LogicFile filepath="{self.map}"/></RoadNetwork><Entities><ScenarioObject name="ego">'
            f'{self.body("ego")}{control}</ScenarioObject>{people}{last}</Entities><Storyboard><Init><Actions><Private entityRef="ego">'
            f"{''.join(f'<PrivateAction>{action}</PrivateAction>' for action in actions if action)}</Private>{stand}</Actions></Init>"
            '<StopTrigger/></Storyboard></OpenSCENARIO>'
        )  # fmt: skip


def box(length: float, width: float, height: float) -> str:
    """A box around the reference point."""
    return f'<BoundingBox><Center x="0" y="0" z="{height / 2}"/><Dimensions length="{length}" width="{width}" height="{height}"/></BoundingBox>'


def place(x: float, y: float, yaw: float) -> str:
    """A place."""
    return f'<Position><WorldPosition x="{x!r}" y="{y!r}" h="{yaw!r}"/></Position>'
