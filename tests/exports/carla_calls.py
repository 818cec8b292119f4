"""Runs exported CARLA scripts against a stand-in of the server, in which each call is checked against CARLA's client package.

    python tests/exports/carla_calls.py SCRIPTS.carla.py

Values (places, rotations, settings) are those of the package. Objects that need a server are stand-ins: a method must be in the package and in its
stubs, and the stub's signature must take the arguments. The folder `agents` is not in the package; its calls are checked against the signatures
of CARLA's public sources: `agents/navigation/behavior_agent.py` and `basic_agent.py` of 0.9.13, 0.9.14 and 0.9.15 take these calls alike.
"""

import ast
import contextlib
import inspect
import io
import json
import math
import re
import runpy
import sys
import types
from pathlib import Path

import carla

PACKAGE = {name: own for name, own in vars(carla).items() if inspect.isclass(own)}
STUB = ast.parse(Path(carla.__file__).with_name("libcarla.pyi").read_text())
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
calls = set()


def members(name):
    """Functions of a stub's class and of its bases, by name."""
    found = {}
    for base in CLASSES[name].bases:
        if isinstance(base, ast.Name) and base.id in CLASSES:
            found |= members(base.id)
    found |= {node.name: node for node in CLASSES[name].body if isinstance(node, ast.FunctionDef)}
    return found


def check(kind, name, arguments, keywords):
    """Checks a call by the package and by the stub."""
    assert hasattr(PACKAGE[kind], name), f"carla.{kind}.{name} is not in the package"
    stub = members(kind).get(name)
    assert stub is not None, f"carla.{kind}.{name} is not in the stubs"
    own = stub.args
    assert own.vararg is None and own.kwarg is None
    kinds, first = inspect.Parameter, len(own.args) - len(own.defaults)
    signature = inspect.Signature(
        [
            kinds(each.arg, kinds.POSITIONAL_OR_KEYWORD, default=None if place >= first else kinds.empty)
            for place, each in enumerate(own.args)
        ]
    )
    signature.bind(None, *arguments, **keywords)
    calls.add(f"{kind}.{name}")


class Server:
    """An object of the server of a kind; what it does is in METHODS."""

    def __init__(self, kind, **values):
        self.__dict__.update(kind=kind, values=values)

    def __getattr__(self, name):
        if name == "bounding_box":
            assert "bounding_box" in members(self.kind), (self.kind, name)
            # Off the origin, as that of some models of CARLA.
            return carla.BoundingBox(carla.Location(x=0.04, y=0.01, z=0.7), carla.Vector3D(2.4, 1.1, 0.7))
        if name == "transform":
            return self.values["transform"]

        def call(*arguments, **keywords):
            check(self.kind, name, arguments, keywords)
            return METHODS[name](self, *arguments, **keywords)

        return call


class Client(Server):
    def __init__(self, host, port):
        super().__init__("Client")
        self.values["world"] = Server("World", settings=carla.WorldSettings(), actors=[])


def spawn(world, blueprint, place):
    kind = "Walker" if blueprint.values["id"].startswith("walker") else "Vehicle"
    actor = Server(kind, transform=place, physics=True, alive=True)
    world.values["actors"].append(actor)
    return actor


def tick(world):
    assert world.values["settings"].synchronous_mode
    for actor in world.values["actors"]:
        # The agent's car drives on at 5 m/s.
        if actor.values["physics"] and "velocity" in actor.values:
            now = actor.values["transform"]
            yaw = math.radians(now.rotation.yaw)
            place = now.location + carla.Location(x=0.25 * math.cos(yaw), y=0.25 * math.sin(yaw))
            actor.values["transform"] = carla.Transform(place, now.rotation)
    return 1


def with_value(name):
    return lambda actor, value: actor.values.__setitem__(name, value)


METHODS = {
    "set_timeout": lambda client, second: None,
    "get_server_version": lambda client: "0.9.16",
    "load_world": lambda client, name: client.values["world"],
    "generate_opendrive_world": lambda client, road, parameters: None,
    "get_world": lambda client: client.values["world"],
    "get_settings": lambda world: world.values["settings"],
    "apply_settings": lambda world, settings: world.values.__setitem__("settings", settings),
    "get_blueprint_library": lambda world: Server("BlueprintLibrary"),
    "find": lambda library, id: Server("ActorBlueprint", id=id),
    "set_attribute": lambda blueprint, id, value: None,
    "spawn_actor": spawn,
    "tick": tick,
    "get_map": lambda world: Server("Map"),
    "get_waypoint": lambda own, location: Server("Waypoint", transform=carla.Transform(location)),
    "next": lambda waypoint, distance: [waypoint],
    "set_simulate_physics": with_value("physics"),
    "set_transform": with_value("transform"),
    "set_target_velocity": with_value("velocity"),
    "get_transform": lambda actor: actor.values["transform"],
    "apply_control": with_value("control"),
    "destroy": lambda actor: actor.values.__setitem__("alive", False),
}


class BehaviorAgent:
    def __init__(self, vehicle, behavior="normal", opt_dict={}, map_inst=None, grp_inst=None):
        assert vehicle.kind == "Vehicle" and vehicle.values["physics"]

    def set_destination(self, end_location, start_location=None):
        assert isinstance(end_location, carla.Location)

    def run_step(self, debug=False):
        return carla.VehicleControl()


def run(path):
    navigation = types.ModuleType("agents.navigation.behavior_agent")
    navigation.BehaviorAgent = BehaviorAgent
    sys.modules |= {"agents": types.ModuleType("agents"), "agents.navigation": types.ModuleType("agents.navigation")}
    sys.modules["agents.navigation.behavior_agent"] = navigation
    carla.Client, real = Client, carla.Client
    # The constructor's signature is that of the stub.
    assert {"host", "port"} <= {each.arg for each in members("Client")["__init__"].args.args}
    try:
        script = runpy.run_path(str(path))
        with contextlib.redirect_stdout(io.StringIO()):
            results = [script["main"](arguments) for arguments in ([], ["--map", "Town01"])]
    finally:
        carla.Client = real
    episode = script["EPISODE"]
    for error, touch in results:
        # Single precision at some hundreds of metres.
        assert error < 1e-3, (path, error)
        if episode["ego"] == "recorded" and not episode["release"]:
            assert abs(touch - float(re.match(r"[\d.]+", episode["touch"]).group())) < 1e-6, (path, touch, episode["touch"])
    return episode["ego"]


def main(paths):
    ran = [run(path) for path in paths]
    assert {"recorded", "agent"} <= set(ran), ran
    print(f"*.carla.py: {len(ran)} files in a stand-in of the server, {len(calls)} methods as in carla {json.dumps(version())}")


def version():
    from importlib.metadata import version

    return version("carla")


if __name__ == "__main__":
    main(sys.argv[1:])
