"""Recordings of others, converted and judged."""

import csv
import importlib.util
import json
import math
import subprocess
import sys

import numpy as np
import pytest

import falsify_av
from falsify_av import program
from falsify_av.recordings import PEDESTRIAN, VEHICLE, Actor, Instant, write
from falsify_av.recordings.__main__ import main

RATE = 25.0
TRACKS = "recordingId,trackId,frame,trackLifetime,xCenter,yCenter,heading,width,length,xVelocity,yVelocity,xAcceleration,yAcceleration".split(",")


def missing(name):
    return pytest.mark.skipif(importlib.util.find_spec(name) is None, reason=f"{name} is not installed")


def states(time):
    """A car that drives north-east at 8 m/s and a pedestrian who crosses its way after 6 s: middle, heading and velocity of both."""
    turned = math.radians(40)
    sin, cos = math.sin(turned), math.cos(turned)

    def seen(along, left, yaw, speed):
        yaw += turned
        return along * cos - left * sin + 100, along * sin + left * cos - 50, yaw, speed * math.cos(yaw), speed * math.sin(yaw)

    return seen(8 * (time - 6) - 2.4, 0.0, 0.0, 8.0), seen(0.2, 1.4 * (time - 6), math.pi / 2, 1.4)


def instants():
    times = np.arange(0, 7, 1 / RATE)
    for time in times:
        car, walker = (Actor(name, kind, *state[:3], *size, state[3:]) for name, kind, state, size in zip((1, 2), (VEHICLE, PEDESTRIAN), states(time), ((4.8, 2.0), (0.4, 0.4))))
        yield Instant(float(time), [car, walker])


def judged(trace):
    found = subprocess.run([program.find(), "judge", str(trace), "--json"], capture_output=True, text=True, check=True)
    return json.loads(found.stdout)["encounters"]


def test_a_trace_is_judged_as_its_arrays(tmp_path):
    assert write(tmp_path / "drive.osi", instants()) == 175
    (found,) = judged(tmp_path / "drive.osi")
    ego, walked = (np.array([[*state[:3], math.hypot(*state[3:])] for state in column]) for column in zip(*map(states, np.arange(0, 7, 1 / RATE))))
    wanted = falsify_av.judge(ego, walked, 1 / RATE, length=4.8, width=2.0, radius=0.2)
    assert found["verdict"] == wanted["verdict"] == "preventable" and found["touch_s"] == pytest.approx(wanted["touch_s"], abs=1e-6)
    assert [driver["avoids"] for driver in found["drivers"]] == [driver["avoids"] for driver in wanted["drivers"]]
    assert (found["variations"], found["avoided_in"]) == (wanted["variations"], wanted["avoided_in"])
    assert {driver["driver"] for driver in wanted["drivers"] if driver["votes"]} >= {"fsm", "r157_system", "r152_aeb"}


def ind(folder):
    """The three files of a recording of inD."""
    with (folder / "07_tracks.csv").open("w", newline="") as file:
        rows = csv.DictWriter(file, TRACKS, restval=0)
        rows.writeheader()
        for frame, instant in enumerate(instants()):
            for each in instant.actors:
                size = {"width": each.width, "length": each.length} if each.kind == VEHICLE else {}
                moving = {"xCenter": each.x, "yCenter": each.y, "heading": math.degrees(each.yaw) % 360, "xVelocity": each.velocity[0], "yVelocity": each.velocity[1]}
                rows.writerow({"recordingId": 7, "trackId": each.name, "frame": frame, **moving, **size})
    (folder / "07_tracksMeta.csv").write_text("recordingId,trackId,class\n7,1,car\n7,2,pedestrian\n")
    (folder / "07_recordingMeta.csv").write_text(f"recordingId,frameRate\n7,{RATE}\n")
    return folder / "07_tracks.csv"


def test_tracks_of_ind_are_judged(tmp_path, capsys):
    out = tmp_path / "ind.osi"
    assert main(["ind", str(ind(tmp_path)), str(out)]) == 0 and "175 instants" in capsys.readouterr().out
    (found,) = judged(out)
    assert found["verdict"] == "preventable" and found["touch_s"] == pytest.approx(6.0, abs=0.1)


@pytest.mark.parametrize(
    ("name", "change", "wanted"),
    [
        ("07_tracksMeta.csv", None, "no `07_tracksMeta.csv` beside it"),
        ("07_recordingMeta.csv", "recordingId,rate\n7,25\n", "'frameRate'"),
        ("07_recordingMeta.csv", "recordingId,frameRate\n", "a field is empty or no number"),
        ("07_tracks.csv", ",".join(TRACKS) + "\n", "fewer than two instants"),
        ("07_tracks.csv", ",".join(TRACKS) + "\n7,1,x\n", "a field is empty or no number"),
    ],
)
def test_what_is_no_recording_is_told_in_a_sentence(tmp_path, capsys, name, change, wanted):
    tracks = ind(tmp_path)
    (tmp_path / name).unlink() if change is None else (tmp_path / name).write_text(change)
    assert main(["ind", str(tracks), str(tmp_path / "out.osi")]) == 2
    said = capsys.readouterr().err
    assert wanted in said and said.count("\n") == 1 and not (tmp_path / "out.osi").exists()


def test_a_library_that_is_missing_is_named(tmp_path):
    code = "import sys; sys.modules['rosbags'] = None; from falsify_av.recordings.__main__ import main; sys.exit(main(sys.argv[1:]))"
    found = subprocess.run([sys.executable, "-c", code, "rosbag", str(tmp_path), str(tmp_path / "out.osi")], capture_output=True, text=True)
    assert found.returncode == 2 and found.stderr.count("\n") == 1 and "pip install rosbags" in found.stderr, found.stderr


MESSAGES = {
    "unique_identifier_msgs/msg/UUID": "uint8[16] uuid",
    "autoware_perception_msgs/msg/ObjectClassification": "uint8 label\nfloat32 probability",
    "autoware_perception_msgs/msg/TrackedObjectKinematics": "geometry_msgs/PoseWithCovariance pose_with_covariance\ngeometry_msgs/TwistWithCovariance twist_with_covariance",
    "autoware_perception_msgs/msg/Shape": "uint8 type\ngeometry_msgs/Vector3 dimensions",
    "autoware_perception_msgs/msg/TrackedObject": "unique_identifier_msgs/UUID object_id\nfloat32 existence_probability\n"
    "autoware_perception_msgs/ObjectClassification[] classification\nautoware_perception_msgs/TrackedObjectKinematics kinematics\nautoware_perception_msgs/Shape shape",
    "autoware_perception_msgs/msg/TrackedObjects": "std_msgs/Header header\nautoware_perception_msgs/TrackedObject[] objects",
}


@missing("rosbags")
def test_tracked_objects_of_a_bag_are_judged(tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore, get_types_from_msg

    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in MESSAGES.items():
        if name not in store.types:
            store.register(get_types_from_msg(text, name))

    def made(name, *values):
        return store.types[name](*values)

    def header(time):
        return made("std_msgs/msg/Header", made("builtin_interfaces/msg/Time", int(time), round(time % 1 * 1e9)), "map")

    def kinematics(x, y, yaw, speed):
        point = made("geometry_msgs/msg/Point", x, y, 0.0)
        turned = made("geometry_msgs/msg/Quaternion", 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
        vector, still = made("geometry_msgs/msg/Vector3", speed, 0.0, 0.0), made("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0)
        pose = made("geometry_msgs/msg/PoseWithCovariance", made("geometry_msgs/msg/Pose", point, turned), np.zeros(36))
        return pose, made("geometry_msgs/msg/TwistWithCovariance", made("geometry_msgs/msg/Twist", vector, still), np.zeros(36))

    bag = tmp_path / "bag"
    with Writer(bag, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        topics = {name: writer.add_connection(f"/{name}", kind, typestore=store) for name, kind in (("odometry", "nav_msgs/msg/Odometry"), ("objects", "autoware_perception_msgs/msg/TrackedObjects"))}
        for instant in instants():
            car, walker = instant.actors
            stamp, (rear_x, rear_y) = int(instant.time * 1e9), (car.x - 1.375 * math.cos(car.yaw), car.y - 1.375 * math.sin(car.yaw))
            odometry = made("nav_msgs/msg/Odometry", header(instant.time), "base_link", *kinematics(rear_x, rear_y, car.yaw, 8.0))
            writer.write(topics["odometry"], stamp, store.serialize_cdr(odometry, "nav_msgs/msg/Odometry"))
            pose, twist = kinematics(walker.x, walker.y, walker.yaw, 1.4)
            each = made(
                "autoware_perception_msgs/msg/TrackedObject",
                made("unique_identifier_msgs/msg/UUID", np.full(16, 5, np.uint8)),
                1.0,
                [made("autoware_perception_msgs/msg/ObjectClassification", 7, 0.9)],
                made("autoware_perception_msgs/msg/TrackedObjectKinematics", pose, twist),
                made("autoware_perception_msgs/msg/Shape", 1, made("geometry_msgs/msg/Vector3", 0.4, 0.4, 1.7)),
            )
            objects = made("autoware_perception_msgs/msg/TrackedObjects", header(instant.time), [each])
            writer.write(topics["objects"], stamp + 1, store.serialize_cdr(objects, "autoware_perception_msgs/msg/TrackedObjects"))
    out = tmp_path / "bag.osi"
    assert main(["rosbag", str(bag), str(out)]) == 0
    (found,) = judged(out)
    assert found["verdict"] == "preventable" and found["touch_s"] == pytest.approx(6.0, abs=0.1)


NET = {
    "a.nod.xml": '<nodes><node id="a" x="0" y="0"/><node id="b" x="100" y="0" type="priority"/><node id="c" x="200" y="0"/></nodes>',
    "a.edg.xml": "<edges>" + "".join(f'<edge id="{x}{y}" from="{x}" to="{y}" numLanes="1" speed="13.9" sidewalkWidth="2"/>' for x, y in ("ab", "bc", "ba", "cb")) + "</edges>",
    "a.con.xml": '<connections><crossing node="b" edges="ab ba" priority="1"/></connections>',
    "a.rou.xml": '<routes><vehicle id="v" depart="0"><route edges="ab bc"/></vehicle><person id="p" depart="0"><walk edges="ab ba"/></person></routes>',
}


@missing("sumo")
def test_floating_car_data_of_sumo_is_judged(tmp_path):
    import sumo

    for name, text in NET.items():
        (tmp_path / name).write_text(text)

    def run(program, *words):
        subprocess.run([f"{sumo.SUMO_HOME}/bin/{program}", *words], cwd=tmp_path, check=True, capture_output=True)

    run("netconvert", "-n", "a.nod.xml", "-e", "a.edg.xml", "-x", "a.con.xml", "-o", "a.net.xml")
    run("sumo", "-n", "a.net.xml", "-r", "a.rou.xml", "--step-length", "0.1", "--fcd-output", "fcd.xml", "--fcd-output.geo", "false")
    out = tmp_path / "sumo.osi"
    assert main(["sumo", str(tmp_path / "fcd.xml"), str(out)]) == 0
    found = subprocess.run([program.find(), "judge", str(out), "--json", "--near", "20"], capture_output=True, text=True, check=True)
    found = json.loads(found.stdout)
    assert found["encounters"] and not found["unjudged"] and all(each["touch_s"] is None for each in found["encounters"]), found


@missing("betterosi")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("name", ["drive.osi", "drive.mcap"])
def test_traces_of_betterosi_are_judged(tmp_path, name):
    import betterosi as osi

    with osi.Writer(tmp_path / name) as writer:
        for instant in instants():
            objects = [
                osi.MovingObject(
                    id=osi.Identifier(value=each.name),
                    type=osi.MovingObjectType(each.kind),
                    base=osi.BaseMoving(
                        dimension=osi.Dimension3D(length=each.length, width=each.width, height=1.7),
                        position=osi.Vector3D(x=each.x, y=each.y, z=0.0),
                        orientation=osi.Orientation3D(yaw=each.yaw),
                        velocity=osi.Vector3D(x=each.velocity[0], y=each.velocity[1], z=0.0),
                    ),
                )
                for each in instant.actors
            ]
            seconds, nanos = divmod(round(instant.time * 1e9), 10**9)
            stamp, version = osi.Timestamp(seconds=seconds, nanos=nanos), osi.InterfaceVersion(version_major=3, version_minor=8, version_patch=0)
            writer.add(osi.GroundTruth(version=version, timestamp=stamp, host_vehicle_id=osi.Identifier(value=1), moving_object=objects))
    (found,) = judged(tmp_path / name)
    assert found["verdict"] == "preventable" and found["touch_s"] == pytest.approx(6.0, abs=0.1)


@missing("omega_prime")
@pytest.mark.filterwarnings("ignore")
def test_recordings_of_omega_prime_are_judged(tmp_path):
    import omega_prime
    import polars

    rows = [
        {"total_nanos": round(instant.time * 1e9), "idx": each.name, "x": each.x, "y": each.y, "z": 0.0, "vel_x": each.velocity[0], "vel_y": each.velocity[1], "vel_z": 0.0}
        | {"acc_x": 0.0, "acc_y": 0.0, "acc_z": 0.0, "length": each.length, "width": each.width, "height": 1.7, "roll": 0.0, "pitch": 0.0}
        | {"yaw": math.remainder(each.yaw, math.tau), "type": each.kind, "role": 1 if each.kind == VEHICLE else 0, "subtype": 4 if each.kind == VEHICLE else 0}
        for instant in instants()
        for each in instant.actors
    ]
    omega_prime.Recording(polars.DataFrame(rows), host_vehicle_idx=1).to_mcap(tmp_path / "drive.mcap")
    (found,) = judged(tmp_path / "drive.mcap")
    assert found["verdict"] == "preventable" and found["touch_s"] == pytest.approx(6.0, abs=0.1)


@missing("py123d")
@pytest.mark.filterwarnings("ignore")
def test_logs_of_py123d_are_judged(tmp_path):
    from py123d.api.scene.arrow.arrow_log_writer import ArrowLogWriter
    from py123d.api.scene.arrow.utils.log_writer_config import LogWriterConfig
    from py123d.datatypes.detections.box_detection_label import DefaultBoxDetectionLabel
    from py123d.datatypes.detections.box_detections import BoxDetectionAttributes, BoxDetectionSE3, BoxDetectionsSE3
    from py123d.datatypes.detections.box_detections_metadata import BoxDetectionsSE3Metadata
    from py123d.datatypes.metadata.log_metadata import LogMetadata
    from py123d.datatypes.time.timestamp import Timestamp
    from py123d.datatypes.vehicle_state.dynamic_state import DynamicStateSE3
    from py123d.datatypes.vehicle_state.ego_state import EgoStateSE3
    from py123d.datatypes.vehicle_state.ego_state_metadata import EgoStateSE3Metadata
    from py123d.geometry import BoundingBoxSE3, PoseSE3, Vector3D
    from py123d.parser.base_dataset_parser import ModalitiesSync

    def turned(each):
        return PoseSE3(each.x, each.y, 0.0, math.cos(each.yaw / 2), 0.0, 0.0, math.sin(each.yaw / 2))

    here, labels = PoseSE3(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), BoxDetectionsSE3Metadata(DefaultBoxDetectionLabel)
    car = EgoStateSE3Metadata("car", 2.0, 4.8, 1.5, 2.9, here, here)
    writer = ArrowLogWriter(LogWriterConfig(), tmp_path / "logs", tmp_path / "sensors")
    writer.reset(LogMetadata("made", "made_train", "a", None))
    for instant in instants():
        ego, walker = instant.actors
        time = Timestamp.from_us(round(instant.time * 1e6))
        state = EgoStateSE3.from_center(turned(ego), car, time, DynamicStateSE3(Vector3D(8.0, 0.0, 0.0), Vector3D(0.0, 0.0, 0.0), Vector3D(0.0, 0.0, 0.0)))
        box, velocity = BoundingBoxSE3(turned(walker), 0.4, 0.4, 1.7), Vector3D(*walker.velocity, 0.0)
        boxes = [BoxDetectionSE3(BoxDetectionAttributes(DefaultBoxDetectionLabel.PERSON, "somebody"), box, velocity)]
        writer.write_sync(ModalitiesSync(time, [state, BoxDetectionsSE3(boxes, time, labels)]))
    writer.close()
    out = tmp_path / "drive.osi"
    assert main(["py123d", str(tmp_path / "logs/made_train/a"), str(out)]) == 0
    (found,) = judged(out)
    assert found["verdict"] == "preventable" and found["touch_s"] == pytest.approx(6.0, abs=0.1)
