"""The adapters of docs/src/how-to/adapters.md answer as the protocol says."""

import json
import math
import socket
import struct
import subprocess
import sys
import threading
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "scenarios/external"
UNITS = Path(__file__).parent / "stacks/fmu"
CAR = {"length": 4.8, "width": 2.0, "wheelbase": 3.0, "greatest_wheel_angle": 0.86}
HELLO = {"type": "hello", "protocol": "falsify-av/1", "tick_s": 0.05, "vehicle": CAR, "worlds": 2}
#: A person who stands 5 m before the front of the car.
PERSON = {"kind": "pedestrian", "x": 7.65, "y": 0.0, "yaw": 0.0, "vx": 0.0, "vy": 0.0, "length": 0.5, "width": 0.5}


def world(number, actors, **more):
    route = [[2.0 * place, 0.0, 0.0] for place in range(10)]
    ego = {"x": 0.0, "y": 0.0, "yaw": 0.0, "speed": 8.0}
    return {"id": number, "tick": 0, "seed": 7, "ego": ego, "speed_limit": 10.0, "light": None, "actors": actors, "route": route, **more}


def answers(script, *words, steps):
    """The actions of each step."""
    lines = [HELLO, *({"type": "step", "worlds": worlds} for worlds in steps)]
    text = "".join(json.dumps(line) + "\n" for line in lines)
    greeting, *said = subprocess.check_output([sys.executable, FOLDER / script, *words], input=text, text=True, timeout=60).splitlines()
    assert json.loads(greeting) == {"protocol": "falsify-av/1"}
    return [json.loads(line)["actions"] for line in said]


def test_an_fmu_brakes_in_its_own_world_alone(tmp_path):
    pytest.importorskip("fmpy")
    unit = tmp_path / "aeb.fmu"
    subprocess.run([sys.executable, UNITS / "build.py", "aeb", unit], check=True)
    free, near = world(0, []), world(1, [PERSON])
    first, second = answers("fmu_av.py", str(unit), steps=[[free, near], [world(0, [PERSON]), world(1, [])]])
    # 5 m at 8 m/s are 0.6 s, less than the 1.4 s of the unit, whose brake of 9 m/s^2 builds up in 0.1 s; a tick is five of its steps of 0.01 s.
    braking = pytest.approx(-9.0 * (1.0 - math.exp(-0.5)))
    assert [action["acceleration"] for action in first] == [2.0, braking]
    assert [action["acceleration"] for action in second] == [braking, 2.0], "a new episode forgets the last"
    assert [action["wheel_angle"] for action in first] == [0.0, 0.0]


def test_ros_messages_are_those_of_the_world():
    typesys = pytest.importorskip("rosbags.typesys")
    store, seen = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE), []
    server = socket.create_server(("localhost", 0))

    def node():
        with server, server.accept()[0] as link, link.makefile("rwb") as stream:
            for kind in ("nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseArray", "nav_msgs/msg/Path"):
                seen.append(store.deserialize_cdr(stream.read(struct.unpack("<I", stream.read(4))[0]), kind))
            vector = store.types["geometry_msgs/msg/Vector3"]
            cdr = bytes(store.serialize_cdr(store.types["geometry_msgs/msg/Twist"](vector(6.0, 0.0, 0.0), vector(0.0, 0.0, 0.8)), "geometry_msgs/msg/Twist"))
            stream.write(struct.pack("<I", len(cdr)) + cdr)

    thread = threading.Thread(target=node, daemon=True)
    thread.start()
    turned = {"x": 1.0, "y": 2.0, "yaw": math.pi / 2, "speed": 8.0}
    port = server.getsockname()[1]
    [[action]] = answers("ros2_av.py", f"localhost:{port}", steps=[[world(3, [PERSON], tick=30, ego=turned)]])
    thread.join(10)
    odometry, people, path = seen
    here = odometry.pose.pose
    assert (here.position.x, here.position.y, odometry.twist.twist.linear.x) == (1.0, 2.0, 8.0)
    assert here.orientation.z == pytest.approx(math.sqrt(0.5)) and here.orientation.w == pytest.approx(math.sqrt(0.5))
    assert (odometry.header.stamp.sec, odometry.header.stamp.nanosec) == (1, 500_000_000)
    assert [(each.position.x, each.position.y) for each in people.poses] == [(7.65, 0.0)]
    assert [each.pose.position.x for each in path.poses] == [2.0 * place for place in range(10)]
    # From 8 to 6 m/s; the yaw rate is v sin b / (wheelbase / 2) with b = atan(tan d / 2).
    assert action["acceleration"] == -4.0
    slip = math.atan(math.tan(action["wheel_angle"]) / 2)
    assert 8.0 * math.sin(slip) / 1.5 == pytest.approx(0.8)


def test_a_grpc_server_drives():
    pytest.importorskip("grpc")
    command = [sys.executable, str(FOLDER / "grpc_av.py"), "--serve", "localhost:0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            port = server.stdout.readline().split()[1]
            [actions] = answers("grpc_av.py", f"localhost:{port}", steps=[[world(0, []), world(1, [PERSON])]])
        finally:
            server.terminate()
    assert actions == [{"id": 0, "acceleration": 6.0, "steer": 0.0}, {"id": 1, "acceleration": -24.0, "steer": 0.0}]
