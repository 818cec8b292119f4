"""Checks exported files with the checkers of their formats. A file of one format after another:

    python tests/exports/check.py FOLDER

Packages: asam-qc-openscenarioxml, asam-qc-opendrive (with the schemas inside them), osi-python, mcap, jsonschema; for CommonRoad in a second
environment commonroad-io and commonroad-drivability-checker. FOXGLOVE_SCHEMAS is the folder of the npm package @foxglove/schemas, and needs node.
What is not installed is named in a line that starts with SKIPPED.
"""

import functools
import importlib.util
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path


def installed(package):
    return importlib.util.find_spec(package) is not None


def qc(kind, path):
    """Runs ASAM's checker; every checker that applies must complete, and none may find an issue."""
    with tempfile.TemporaryDirectory() as folder:
        config, result = Path(folder, "config.xml"), Path(folder, "result.xqar")
        bundle = {"openscenario": "xoscBundle", "opendrive": "xodrBundle"}[kind]
        config.write_text(
            f'<Config><Param name="InputFile" value="{path.resolve()}"/><CheckerBundle application="{bundle}">'
            f'<Param name="resultFile" value="{result}"/></CheckerBundle></Config>'
        )
        command = [str(Path(sys.executable).parent / f"qc_{kind}"), "-c", str(config)]
        subprocess.run(command, check=True, capture_output=True, cwd=folder)
        report = ElementTree.parse(result)
        completed = sum(checker.get("status") == "completed" for checker in report.iter("Checker"))
        issues = [issue.get("description") for issue in report.iter("Issue")]
    assert completed > 0 and not issues, (path, completed, issues[:3])
    return f"{completed} checkers"


def schema(package, version_of, place, path):
    """Validates a file by the schema inside ASAM's package."""
    folder = Path(importlib.util.find_spec(package).origin).parent / "schema"
    errors = list(loaded(folder / place(version_of(path))).iter_errors(str(path)))
    assert not errors, (path, str(errors[0]))
    return "schema"


@functools.cache
def loaded(path):
    import xmlschema

    return xmlschema.XMLSchema(str(path))


def minor(path):
    return re.search(r'revMinor="(\d+)"', path.read_text()).group(1)


def openscenario(path):
    place = lambda minor: f"1.{minor}.0/OpenSCENARIO.xsd"
    return [schema("qc_openscenario", minor, place, path), qc("openscenario", path)]


def opendrive(path):
    place = lambda minor: f"1.{minor}.0/opendrive_1{minor}_core.xsd"
    return [schema("qc_opendrive", minor, place, path), qc("opendrive", path)]


def ground_truth(path, data, number):
    """Reads a message, and checks the actors."""
    from osi3.osi_groundtruth_pb2 import GroundTruth

    message = GroundTruth.FromString(data)
    time = message.timestamp.seconds + 1e-9 * message.timestamp.nanos
    assert abs(time - 0.05 * number) < 1e-9, (path, time)
    assert {each.type for each in message.moving_object} == {2, 3}, path
    car = next(each for each in message.moving_object if each.id == message.host_vehicle_id)
    assert car.base.dimension.length > 4 and car.base.position.z > 0.5, path
    assert car.vehicle_attributes.bbcenter_to_rear.x < -1, path
    assert message.version.version_major == 3 and not message.FindInitializationErrors(), path
    return message


def frames_of(path):
    return int(path.name.split("_")[4])


def recording(path):
    """All messages of an MCAP file by topic, with its summary; checksums and indexes are checked."""
    from mcap.reader import make_reader

    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        records = [(record.name, record.metadata) for record in reader.iter_metadata()]
        topics = {}
        for schema, channel, message in reader.iter_messages():
            assert message.log_time == message.publish_time and message.sequence == len(topics.get(channel.topic, [])), path
            topics.setdefault(channel.topic, []).append((message.log_time, message.data))
    assert summary.statistics.message_count == sum(map(len, topics.values())), path
    assert summary.chunk_indexes and len(summary.metadata_indexes) == len(records), path
    return summary, records, topics


def osi_recording(path):
    """The trace in MCAP: the metadata of the standard, a descriptor that agrees with osi3, messages that both read alike."""
    import osi3.osi_groundtruth_pb2 as original
    from google.protobuf import descriptor_pb2, descriptor_pool, json_format, message_factory

    summary, records, topics = recording(path)
    ((name, metadata),) = records
    keys = {f"{end}_{of}_version" for end in ("min", "max") for of in ("osi", "protobuf")} | {"version"}
    assert name == "net.asam.osi.trace" and keys <= set(metadata), (path, records)
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", metadata[key]) for key in keys), (path, metadata)
    (channel,), (schema,) = summary.channels.values(), summary.schemas.values()
    assert {f"net.asam.osi.trace.channel.{of}_version" for of in ("osi", "protobuf")} == set(channel.metadata), path
    assert (schema.name, schema.encoding, channel.message_encoding) == ("osi3.GroundTruth", "protobuf", "protobuf"), path

    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
        pool.Add(file)
    own, fields = pool.FindMessageTypeByName(schema.name), 0
    open_types = [(own, original.GroundTruth.DESCRIPTOR)]
    while open_types:
        ours, theirs = open_types.pop()
        for field in ours.fields:
            same, fields = theirs.fields_by_name[field.name], fields + 1
            assert (field.number, field.type, field.is_repeated) == (same.number, same.type, same.is_repeated), field.full_name
            if field.message_type:
                assert field.message_type.full_name == same.message_type.full_name, field.full_name
                open_types.append((field.message_type, same.message_type))
            for value in field.enum_type.values if field.enum_type else []:
                assert field.enum_type.full_name == same.enum_type.full_name, field.full_name
                assert same.enum_type.values_by_name[value.name].number == value.number, value.name
    read = message_factory.GetMessageClass(own).FromString
    messages = topics[channel.topic]
    for number, (time, data) in enumerate(messages):
        message = ground_truth(path, data, number)
        assert time == message.timestamp.seconds * 10**9 + message.timestamp.nanos, path
        # Numbers of enumerations, since some have two names.
        plain = lambda each: json_format.MessageToDict(each, use_integers_for_enums=True)
        assert plain(read(data)) == plain(message), path
    assert len(messages) == frames_of(path), path
    return [f"{len(messages)} messages, descriptor with {fields} fields"]


def foxglove(path):
    """Every message is valid by the schema in the file and by Foxglove's own, and the actors move."""
    import jsonschema

    summary, _, topics = recording(path)
    said = []
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json"), path
        schemas = [json.loads(schema.data)]
        if schema.name.startswith("foxglove."):
            official = foxglove_schema(schema.name.removeprefix("foxglove."))
            schemas += [official] if official else []
        for of in schemas:
            jsonschema.Draft7Validator.check_schema(of)
            validator = jsonschema.Draft7Validator(of)
            for _, data in topics[channel.topic]:
                validator.validate(json.loads(data))
        said.append(f"{len(topics[channel.topic])} messages {channel.topic} by {len(schemas)} schemas")
    actors = [json.loads(data)["entities"] for _, data in topics["/actors"]]
    assert [each["id"] for each in actors[0]][0] == "ego" and actors[0] != actors[-1], path
    gaps = [json.loads(data)["gap_m"] for _, data in topics["/measures"]]
    assert min(gaps[:-1]) > 0 and gaps[-1] < 0.6, (path, gaps[-3:])
    return said


def foxglove_schema(name):
    """The schema of the npm package @foxglove/schemas; none without the package."""
    folder = os.environ.get("FOXGLOVE_SCHEMAS")
    if not folder or not shutil.which("node"):
        return None
    script = f"console.log(JSON.stringify(require({json.dumps(folder + '/jsonschema.js')}).{name}))"
    return json.loads(subprocess.run(["node", "-e", script], check=True, capture_output=True).stdout)


def commonroad(path):
    """The schema and the drivability checker. A planning problem starts in a free place and has a name of its own; in a recording, which has
    no problem, ego and pedestrian first collide at the last tick."""
    import commonroad
    from commonroad.common.file_reader import CommonRoadFileReader
    from commonroad.scenario.obstacle import ObstacleType
    from commonroad.scenario.scenario import ScenarioID
    from commonroad_dc import pycrcc
    from commonroad_dc.collision.collision_detection.pycrcc_collision_dispatch import (
        create_collision_checker,
        create_collision_object,
    )

    xsd = next(Path(list(commonroad.__path__)[0]).rglob("XML_commonRoad_XSD.xsd"))
    errors = list(loaded(xsd).iter_errors(str(path)))
    scenario, problems = CommonRoadFileReader(str(path)).open()
    name = str(scenario.scenario_id)
    assert ScenarioID.benchmark_id_pattern.fullmatch(name), (path, name)
    assert NAMES.setdefault(name, path) == path, (path, NAMES[name])
    lights = scenario.lanelet_network.traffic_lights
    at_lights = {light for lanelet in scenario.lanelet_network.lanelets for light in lanelet.traffic_lights}
    assert at_lights == {light.traffic_light_id for light in lights}, path
    for light in lights:
        assert {light.get_state_at_time_step(step).value for step in range(2000)} >= {"red", "green"}, path
    if problems.planning_problem_dict:
        assert not errors, (path, str(errors[0]))
        start = next(iter(problems.planning_problem_dict.values())).initial_state
        checker = create_collision_checker(scenario).time_slice(0)
        car = pycrcc.RectOBB(2.395, 1.082, start.orientation, *start.position)
        assert not checker.collide(car), (path, "the problem starts inside an obstacle")
        return [f"problem {name} with {len(lights)} lights"]
    assert len(errors) == 1 and "planningProblem" in str(errors[0]), (path, str(errors))
    by_type = lambda kind: [each for each in scenario.dynamic_obstacles if each.obstacle_type == kind]
    car, pedestrian = by_type(ObstacleType.CAR)[0], by_type(ObstacleType.PEDESTRIAN)[0]
    car_track, walk = create_collision_object(car), create_collision_object(pedestrian)
    last = pedestrian.prediction.final_time_step
    at = lambda track, step: track.obstacle_at_time(step)
    steps = [step for step in range(1, last + 1) if at(car_track, step).collide(at(walk, step))]
    assert steps and steps[0] == last, (path, steps[:3], last)
    return [f"recording {name}: collision at step {last}"]


def gif(path):
    """The frames follow each other without a gap until the end of the file, and all lie within the picture."""
    data = path.read_bytes()
    assert data[:6] == b"GIF89a" and data[-1:] == b";", path
    width, height, flags = struct.unpack_from("<HHB", data, 6)
    place, frames, delay = 13 + 3 * (2 << (flags & 7)), 0, 0

    def blocks(place):
        while data[place]:
            place += 1 + data[place]
        return place + 1

    while data[place] != 0x3B:
        if data[place] == 0x21:
            if data[place + 1] == 0xF9:
                delay += struct.unpack_from("<H", data, place + 4)[0]
            place = blocks(place + 2)
        else:
            assert data[place] == 0x2C, (path, place)
            left, top, wide, high = struct.unpack_from("<HHHH", data, place + 1)
            assert 0 < wide <= width - left and 0 < high <= height - top, path
            place, frames = blocks(place + 11), frames + 1
    assert place == len(data) - 1 and frames > 1, path
    return [f"{frames} frames in {delay / 100} s"]


# The names of scenarios of CommonRoad, each with its file.
NAMES = {}

CHECKS = [
    ("*.xosc", "qc_openscenario", openscenario),
    ("*.xodr", "qc_opendrive", opendrive),
    ("*_gt_*.mcap", "osi3", osi_recording),
    ("*.foxglove.mcap", "mcap", foxglove),
    ("*.gif", "struct", gif),
    ("*.commonroad.xml", "commonroad_dc", commonroad),
]


def main(folder):
    for pattern, package, check in CHECKS:
        # Exports of one town have the same map, and a checker takes seconds.
        files = sorted({path.read_bytes(): path for path in Path(folder).rglob(pattern)}.values())
        if not installed(package):
            print(f"SKIPPED: {len(files)} files {pattern}, since {package} is not installed")
            continue
        said = [check(path) for path in files]
        assert said, f"no files {pattern}"
        print(f"{pattern}: {len(files)} files, the last one {', '.join(said[-1])}")


    if not foxglove_schema("SceneUpdate"):
        print("SKIPPED: Foxglove's own schema, since FOXGLOVE_SCHEMAS does not name the package or node is missing")


if __name__ == "__main__":
    main(sys.argv[1])
