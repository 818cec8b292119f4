"""CARLA as a world (client 0.9.16): its physics move the car, and walkers are put where they are told to be at each tick.

No server was there when this was written. The client package, which has CARLA's code for maps, and a session of our own making are what it was tried with
(`python/tests/test_carla.py`). Options: `host=NAME`, `port=N`. CARLA's frame is ours with y, yaw and steer of the other sign.
"""

from __future__ import annotations

import math
from importlib.metadata import version
from typing import Any

import carla

from . import Message, chosen, state

CAR, WALKER = "vehicle.tesla.model3", "walker.pedestrian.0001"
TIMEOUT = 60.0  # s: of a call of the client.
SETTLING = 40  # Ticks until a new car is at rest on its springs.
ABOVE = 0.5  # m: over the road, where actors are made.
#: The names of objects that only a server makes, which a test looks up in the client package.
USED = {
    "Client": ("set_timeout", "get_client_version", "get_server_version", "generate_opendrive_world"),
    "World": ("get_settings", "apply_settings", "get_blueprint_library", "spawn_actor", "tick", "get_snapshot"),
    "WorldSettings": ("synchronous_mode", "fixed_delta_seconds", "no_rendering_mode", "substepping", "max_substep_delta_time", "max_substeps"),
    "BlueprintLibrary": ("find",),
    "WorldSnapshot": ("find",),
    "ActorSnapshot": ("get_transform", "get_velocity"),
    "Vehicle": ("id", "bounding_box", "set_transform", "set_target_velocity", "set_target_angular_velocity", "apply_control"),
    "Walker": ("id", "bounding_box", "set_transform", "set_simulate_physics"),
}


def world(words: list[str]) -> Carla:
    """The world for `python3 -m falsify_av.bridges carla WORDS`."""
    options = chosen("carla", words, host="NAME", port=range(1, 65536))
    return Carla(carla.Client(options.get("host", "127.0.0.1"), options.get("port", 2000)))


class Carla:
    """A server of CARLA with a car and walkers."""

    def __init__(self, client: Any) -> None:
        self.client = client
        client.set_timeout(TIMEOUT)
        self.about: Message = {"name": "carla", "version": f"carla {version('carla')}", "drivers": [], "friction": False, "lights": False, "seeds": True}

    def load(self, message: Message) -> list[tuple[float, float]]:
        """Let the server make a world of the map, and make the actors."""
        if self.client.get_client_version() != self.client.get_server_version():
            raise SystemExit(f"the client is {self.client.get_client_version()}, and the server is {self.client.get_server_version()}")
        mesh = carla.OpendriveGenerationParameters(vertex_distance=0.5, wall_height=0.0)
        self.world = self.client.generate_opendrive_world(message["map"], mesh)
        settings = self.world.get_settings()
        settings.synchronous_mode, settings.no_rendering_mode, settings.fixed_delta_seconds = True, True, message["tick_s"]
        settings.substepping, settings.max_substep_delta_time, settings.max_substeps = True, 0.01, max(math.ceil(message["tick_s"] / 0.01), 1)
        self.world.apply_settings(settings)
        first = message["lanes"][0]
        kinds = self.world.get_blueprint_library()
        self.car = self.world.spawn_actor(kinds.find(CAR), pose(first[0], first[1], 0.0, ABOVE))
        self.middle = self.car.bounding_box.location.x
        away = [pose(first[0], first[1] + 20.0 * (number + 1), 0.0, ABOVE) for number, _ in enumerate(message["pedestrians"])]
        self.walkers = [self.world.spawn_actor(kinds.find(WALKER), place) for place in away]
        for walker in self.walkers:
            walker.set_simulate_physics(False)
        return nearest(carla.Map(message["town"], message["map"]), message["lanes"])

    def begin(self, message: Message) -> Message:
        """Let the car settle at its start, and give it its speed. The first tick carries that out, so the first state is what was told."""
        ego, yaw = message["ego"], message["ego"]["yaw"]
        x, y = ego["x"] - self.middle * math.cos(yaw), ego["y"] - self.middle * math.sin(yaw)
        self.car.apply_control(carla.VehicleControl(brake=1.0))
        self.car.set_transform(pose(x, y, yaw, ABOVE))
        for _ in range(SETTLING):
            self.world.tick()
        height = self.world.get_snapshot().find(self.car.id).get_transform().location.z
        self.car.set_transform(pose(x, y, yaw, height))
        self.car.set_target_angular_velocity(carla.Vector3D())
        self.car.set_target_velocity(carla.Vector3D(ego["speed"] * math.cos(yaw), -ego["speed"] * math.sin(yaw), 0.0))
        self.place(message["pedestrians"])
        return state(ego["x"], ego["y"], yaw, ego["speed"], [(told["x"], told["y"]) for told in message["pedestrians"]])

    def step(self, message: Message) -> Message:
        """One tick. Our drivers' pedals are CARLA's."""
        control = message["control"]
        self.car.apply_control(carla.VehicleControl(throttle=control["throttle"], brake=control["brake"], steer=-control["steer"]))
        self.place(message["pedestrians"])
        self.world.tick()
        seen = self.world.get_snapshot()
        car = seen.find(self.car.id)
        place, velocity = car.get_transform(), car.get_velocity()
        yaw = -math.radians(place.rotation.yaw)
        x, y = place.location.x + self.middle * math.cos(yaw), -place.location.y + self.middle * math.sin(yaw)
        speed = velocity.x * math.cos(yaw) - velocity.y * math.sin(yaw)
        places = [seen.find(walker.id).get_transform().location for walker in self.walkers]
        return state(x, y, yaw, speed, [(location.x, -location.y) for location in places])

    def place(self, pedestrians: list[Message]) -> None:
        """Put the walkers where they are at the end of the tick."""
        for walker, told in zip(self.walkers, pedestrians, strict=True):
            walker.set_transform(pose(told["x"], told["y"], told["yaw"], walker.bounding_box.extent.z))


def pose(x: float, y: float, yaw: float, height: float) -> Any:
    """A place of ours in CARLA's frame."""
    return carla.Transform(carla.Location(x=x, y=-y, z=height), carla.Rotation(yaw=-math.degrees(yaw)))


def nearest(town: Any, places: list[list[float]]) -> list[tuple[float, float]]:
    """For each place the nearest point on the middle of a lane of CARLA's map."""
    found = (town.get_waypoint(carla.Location(x=x, y=-y)).transform.location for x, y in places)
    return [(location.x, -location.y) for location in found]
