"""ROS 2 messages as a driver: `python3 ros2_av.py HOST:PORT`. Each tick it sends an Odometry, a PoseArray (people) and a Path in CDR, each after its length as 32 bits,
low byte first, and reads a Twist: the wanted speed and yaw rate. Needs rosbags, and no ROS."""
import json, math, socket, struct, sys
import numpy as np
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS2_HUMBLE)
made = lambda name, *values: store.types[name](*values)
vector = lambda x, y: made("geometry_msgs/msg/Vector3", x, y, 0.0)
zeros = np.zeros(36)

def pose(x, y, yaw):
    turn = made("geometry_msgs/msg/Quaternion", 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    return made("geometry_msgs/msg/Pose", made("geometry_msgs/msg/Point", x, y, 0.0), turn)

def messages(world, tick):
    ego, time = world["ego"], world["tick"] * tick
    header = made("std_msgs/msg/Header", made("builtin_interfaces/msg/Time", int(time), round(time % 1 * 1e9)), "map")
    here = made("geometry_msgs/msg/PoseWithCovariance", pose(ego["x"], ego["y"], ego["yaw"]), zeros)
    motion = made("geometry_msgs/msg/TwistWithCovariance", made("geometry_msgs/msg/Twist", vector(ego["speed"], 0.0), vector(0.0, 0.0)), zeros)
    yield made("nav_msgs/msg/Odometry", header, "base_link", here, motion)
    yield made("geometry_msgs/msg/PoseArray", header, [pose(a["x"], a["y"], a["yaw"]) for a in world["actors"]])
    yield made("nav_msgs/msg/Path", header, [made("geometry_msgs/msg/PoseStamped", header, pose(*point)) for point in world["route"]])

def drive(world, hello):
    for message in messages(world, hello["tick_s"]):
        cdr = bytes(store.serialize_cdr(message, message.__msgtype__))
        node.write(struct.pack("<I", len(cdr)) + cdr)
    node.flush()
    twist = store.deserialize_cdr(node.read(struct.unpack("<I", node.read(4))[0]), "geometry_msgs/msg/Twist")
    speed, base = world["ego"]["speed"], hello["vehicle"]["wheelbase"]
    slip = math.asin(max(-0.7, min(0.7, twist.angular.z * base / 2 / max(speed, 1.0))))
    return {"id": world["id"], "acceleration": 2 * (twist.linear.x - speed), "wheel_angle": math.atan(2 * math.tan(slip))}

host, port = sys.argv[1].rsplit(":", 1)
node = socket.create_connection((host, int(port))).makefile("rwb")
for message in map(json.loads, sys.stdin):
    hello = message if message["type"] == "hello" else hello
    actions = None if message is hello else [drive(world, hello) for world in message["worlds"]]
    print(json.dumps({"protocol": "falsify-av/1"} if actions is None else {"actions": actions}), flush=True)
