"""The bridge to CARLA without a server: each name that it uses is in the client package, CARLA's own code reads the map, and a session of our own
making, a server whose car moves by kinematics, drives its loop."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

carla = pytest.importorskip("carla", reason="CARLA's client is not installed: `pip install carla==0.9.16`")

from falsify_av.bridges.carla import USED, Carla  # noqa: E402
from test_bridges import MAP, START, TICK, VEHICLE  # noqa: E402


class Recorded:
    """An object of the server that has the names that the bridge says it uses, and no others."""

    def __init__(self, kind: str, **names: Any) -> None:
        self.__dict__["kind"] = kind
        for name, value in names.items():
            setattr(self, name, value)

    def __setattr__(self, name: str, value: Any) -> None:
        assert name in USED[self.kind]
        self.__dict__[name] = value


def session() -> tuple[Any, list[str]]:
    """A client of a server with a car and walkers, and what was asked of it."""
    asked: list[str] = []
    actors: dict[int, Any] = {}
    box = SimpleNamespace(location=carla.Location(x=0.1), extent=carla.Vector3D(0.2, 0.2, 0.9))

    def spawn(kind: str, place: Any) -> Any:
        body = SimpleNamespace(place=place, velocity=carla.Vector3D(), control=carla.VehicleControl())
        number = len(actors) + 1
        actors[number] = body
        names: dict[str, Any] = {"id": number, "bounding_box": box, "set_transform": lambda place: setattr(body, "place", place)}
        if kind.startswith("vehicle"):
            names["set_target_velocity"] = lambda velocity: setattr(body, "velocity", velocity)
            names["set_target_angular_velocity"] = lambda _: None
            names["apply_control"] = lambda control: setattr(body, "control", control)
            return Recorded("Vehicle", **names)
        return Recorded("Walker", set_simulate_physics=lambda enabled: asked.append(f"physics {enabled}"), **names)

    def tick() -> None:
        car = actors[1]
        speed = math.hypot(car.velocity.x, car.velocity.y) + (3.0 * car.control.throttle - 7.0 * car.control.brake) * TICK
        yaw = car.place.rotation.yaw + 30.0 * car.control.steer * TICK
        heading = math.radians(yaw)
        car.velocity = carla.Vector3D(max(speed, 0.0) * math.cos(heading), max(speed, 0.0) * math.sin(heading), 0.0)
        at = car.place.location
        car.place = carla.Transform(carla.Location(at.x + car.velocity.x * TICK, at.y + car.velocity.y * TICK, at.z), carla.Rotation(yaw=yaw))

    def seen(number: int) -> Any:
        return Recorded("ActorSnapshot", get_transform=lambda: actors[number].place, get_velocity=lambda: actors[number].velocity)

    settings = Recorded("WorldSettings")
    world = Recorded(
        "World", get_settings=lambda: settings, apply_settings=lambda given: asked.append(f"tick {given.fixed_delta_seconds}"), spawn_actor=spawn, tick=tick,
        get_blueprint_library=lambda: Recorded("BlueprintLibrary", find=lambda kind: kind), get_snapshot=lambda: Recorded("WorldSnapshot", find=seen),
    )  # fmt: skip
    client = Recorded(
        "Client", set_timeout=lambda _: None, get_client_version=lambda: "0.9.16", get_server_version=lambda: "0.9.16",
        generate_opendrive_world=lambda text, mesh: asked.append(f"map {len(text)}") or world,
    )  # fmt: skip
    return client, asked


def test_the_client_has_each_name_that_the_bridge_uses() -> None:
    missing = [f"{kind}.{name}" for kind, names in USED.items() for name in names if not hasattr(getattr(carla, kind), name)]
    assert not missing
    assert isinstance(carla.OpendriveGenerationParameters(vertex_distance=0.5, wall_height=0.0), object)


def test_the_loop_is_in_our_frame() -> None:
    client, asked = session()
    bridge = Carla(client)
    lanes = bridge.load({
        "town": "street", "map": MAP, "tick_s": TICK, "vehicle": VEHICLE, "pedestrians": [{"radius": 0.2, "height": 1.8}],
        "lanes": [[200.0, -51.75], [300.0, -48.25]],
    })  # fmt: skip
    assert asked == [f"map {len(MAP)}", f"tick {TICK}", "physics False"]
    # CARLA's own reader of the map.
    assert math.dist(lanes[0], (200.0, -51.75)) < 0.01 and math.dist(lanes[1], (300.0, -48.25)) < 0.01
    walker = {"x": 180.0, "y": -45.0, "yaw": -1.5, "vx": 0.0, "vy": -1.0}
    ego = {**START, "yaw": 0.2}
    begun = bridge.begin({"ego": ego, "seed": 1, "driver": None, "pedestrians": [walker]})
    assert begun["ego"] == ego
    left = {"throttle": 0.0, "brake": 0.0, "steer": 0.5}
    for tick in range(20):
        walker["y"] -= 0.05
        after = bridge.step({"tick": tick + 1, "control": left, "pedestrians": [walker]})
        assert math.dist(after["pedestrians"][0], (walker["x"], walker["y"])) < 1e-4
    assert after["ego"]["yaw"] == pytest.approx(0.2 + math.radians(15.0), abs=1e-3), "it turns to the left"
    assert after["ego"]["speed"] == pytest.approx(8.0, abs=1e-3)
    assert after["ego"]["x"] == pytest.approx(150.0 + 8.0 * math.cos(0.34), abs=0.2)
    assert after["ego"]["y"] == pytest.approx(-51.75 + 8.0 * math.sin(0.34), abs=0.2)
    slower = bridge.step({"tick": 21, "control": {"throttle": 0.0, "brake": 1.0, "steer": 0.0}, "pedestrians": [walker]})
    assert slower["ego"]["speed"] == pytest.approx(8.0 - 0.35, abs=1e-3)


def test_another_version_of_the_server_is_refused() -> None:
    client, _ = session()
    client.get_server_version = lambda: "0.9.15"
    with pytest.raises(SystemExit, match="the client is 0.9.16, and the server is 0.9.15"):
        Carla(client).load({})
