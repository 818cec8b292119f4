"""Repeats an episode of falsify in CARLA, tick by tick.

    python EPISODE.carla.py --map Town01       on a map of the server
    python EPISODE.carla.py                    on the OpenDRIVE file beside this script

Needs the package carla of the server's version (0.9.13 or later). With EPISODE["ego"] == "agent" it needs CARLA's folder
PythonAPI/carla on PYTHONPATH, too, for the module agents.

Places are the middles of boxes in the frame of OpenDRIVE (metres, radians, y to the left); CARLA's y points to the right.
"""

import argparse
import json
import math
from pathlib import Path

import carla

EPISODE = json.loads("{}")
# After the recorded end an episode goes on for this time (s).
AFTERWARDS = 10.0
# How far the agent's route leads beyond the recorded end (m).
BEYOND = 60.0


def transform(actor, state, model=None):
    """The transform of an actor whose box has its middle at a state; the model's own box may be off its origin."""
    x, y, z, yaw = state
    rotation = carla.Rotation(yaw=-math.degrees(yaw))
    # The origin of a walker is its middle, that of a vehicle is on the ground.
    up = actor["size"][2] / 2 if actor["kind"] == "pedestrian" else 0.0
    place = carla.Location(x=x, y=-y, z=z + up)
    if model is not None and actor["kind"] == "vehicle":
        offset = model.bounding_box.location
        off = carla.Transform(carla.Location(), rotation).transform(carla.Location(x=offset.x, y=offset.y))
        place = carla.Location(x=place.x - off.x, y=place.y - off.y, z=place.z)
    return carla.Transform(place, rotation)


def middle(model, actor):
    """Place and yaw of the middle of an actor's box, in the frame of OpenDRIVE."""
    now = model.get_transform()
    place = now.location
    if actor["kind"] == "vehicle":
        offset = model.bounding_box.location
        turned = carla.Transform(carla.Location(), carla.Rotation(yaw=now.rotation.yaw)).transform(
            carla.Location(x=offset.x, y=offset.y)
        )
        place = carla.Location(x=place.x + turned.x, y=place.y + turned.y, z=place.z)
    return place.x, -place.y, -math.radians(now.rotation.yaw)


def gap(ego, pedestrian, shapes):
    """Distance from the ego's box to the pedestrian's disc (m). For a box at most the distance; it is zero when they touch."""
    car, body = shapes
    if body["shape"] == "disc":
        ahead, left = seen_from(ego, pedestrian)
        outside = math.hypot(max(abs(ahead) - car["size"][0] / 2, 0.0), max(abs(left) - car["size"][1] / 2, 0.0))
        return max(outside - body["size"][0] / 2, 0.0)
    # The widest gap along an axis of one of the boxes.
    turn = pedestrian[2] - ego[2]
    cos, sin = abs(math.cos(turn)), abs(math.sin(turn))
    gaps = [0.0]
    for here, there, one, other in ((ego, pedestrian, car, body), (pedestrian, ego, body, car)):
        ahead, left = seen_from(here, there)
        length, width = other["size"][0] / 2, other["size"][1] / 2
        gaps.append(abs(ahead) - one["size"][0] / 2 - length * cos - width * sin)
        gaps.append(abs(left) - one["size"][1] / 2 - length * sin - width * cos)
    return max(gaps)


def seen_from(here, there):
    """A place in the frame of a pose: ahead and left (m)."""
    x, y, yaw = there[0] - here[0], there[1] - here[1], here[2]
    return x * math.cos(yaw) + y * math.sin(yaw), y * math.cos(yaw) - x * math.sin(yaw)


def spawn(world, actor):
    """Spawns an actor at its first state, 2 m above it, since a place on the ground may count as occupied."""
    blueprint = world.get_blueprint_library().find(actor["blueprint"])
    blueprint.set_attribute("role_name", "hero" if actor["name"] == "ego" else actor["name"])
    start = transform(actor, actor["track"][0])
    start.location.z += 2.0
    model = world.spawn_actor(blueprint, start)
    model.set_simulate_physics(False)
    model.set_transform(transform(actor, actor["track"][0], model))
    return model


def agent_of(world, model, actor):
    """CARLA's agent as the ego's driver, with a route along the recorded way and on."""
    from agents.navigation.behavior_agent import BehaviorAgent

    x, y, z, _ = actor["track"][-1]
    end = world.get_map().get_waypoint(carla.Location(x=x, y=-y, z=z))
    ahead = end.next(BEYOND)
    agent = BehaviorAgent(model, behavior="normal")
    agent.set_destination((ahead[0] if ahead else end).transform.location)
    return agent


def play(world, models):
    """Steps through the episode; returns the greatest error of a replayed place (m) and the time of the touch (s)."""
    actors, dt = EPISODE["actors"], EPISODE["dt"]
    by_agent, release = EPISODE["ego"] == "agent", EPISODE["release"]
    shapes = [actors[0], actors[EPISODE["pedestrian"]]]
    agent = None
    if by_agent:
        models[0].set_simulate_physics(True)
        vx, vy = EPISODE["ego_velocity"]
        models[0].set_target_velocity(carla.Vector3D(x=vx, y=-vy, z=0.0))
        world.tick()
        agent = agent_of(world, models[0], actors[0])
    last = len(actors[0]["track"]) - 1
    ticks = last + (round(AFTERWARDS / dt) if by_agent else 0)
    walking = 0 if not release else None
    error, touch = 0.0, None
    for tick in range(1, ticks + 1):
        here = [middle(model, actor) for model, actor in zip(models, actors)]
        if walking is None:
            ego, pedestrian = here[0], here[EPISODE["pedestrian"]]
            if math.hypot(ego[0] - pedestrian[0], ego[1] - pedestrian[1]) <= release[1]:
                walking = tick - 1
        if agent is not None:
            models[0].apply_control(agent.run_step())
        for number, (model, actor) in enumerate(zip(models, actors)):
            if number == 0 and by_agent:
                continue
            step = tick
            if actor["kind"] == "pedestrian" and release:
                step = release[0] if walking is None else release[0] + tick - walking
            model.set_transform(transform(actor, actor["track"][min(step, last)], model))
        world.tick()
        for number, (model, actor) in enumerate(zip(models, actors)):
            if not release and not (number == 0 and by_agent):
                x, y, _ = middle(model, actor)
                wanted = actor["track"][min(tick, last)]
                error = max(error, math.hypot(x - wanted[0], y - wanted[1]))
        ego, pedestrian = middle(models[0], actors[0]), middle(models[EPISODE["pedestrian"]], actors[EPISODE["pedestrian"]])
        if touch is None and gap(ego, pedestrian, shapes) <= 0.001:
            touch = tick * dt
            if by_agent:
                break
    return error, touch


def main(arguments=None):
    parser = argparse.ArgumentParser(description=EPISODE["summary"])
    parser.add_argument("--host", default="localhost")
    parser.add_argument("--port", type=int, default=2000)
    parser.add_argument("--map", help="a map of the server; without it the OpenDRIVE file beside this script is loaded")
    options = parser.parse_args(arguments)
    client = carla.Client(options.host, options.port)
    client.set_timeout(5.0)
    try:
        client.get_server_version()
    except RuntimeError as error:
        raise SystemExit(f"no CARLA server answers at {options.host}:{options.port}: {error}") from None
    client.set_timeout(60.0)
    if options.map:
        client.load_world(options.map)
    else:
        road = Path(__file__).with_name(EPISODE["map"]).read_text(encoding="utf-8")
        client.generate_opendrive_world(road, carla.OpendriveGenerationParameters(wall_height=0.0))
    world = client.get_world()
    before = world.get_settings()
    settings = world.get_settings()
    settings.synchronous_mode = True
    settings.fixed_delta_seconds = EPISODE["dt"]
    world.apply_settings(settings)
    models = []
    try:
        for actor in EPISODE["actors"]:
            models.append(spawn(world, actor))
        world.tick()
        error, touch = play(world, models)
    finally:
        for model in models:
            model.destroy()
        world.apply_settings(before)
    print(EPISODE["summary"])
    print(f"greatest error of a replayed place: {error:.4f} m")
    print("no touch" if touch is None else f"touch at {touch:.2f} s; recorded: {EPISODE['touch']}")
    return error, touch


if __name__ == "__main__":
    main()
