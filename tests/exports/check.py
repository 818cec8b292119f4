"""Checks exported files with the checkers of their formats. A file of one format after another:

    python tests/exports/check.py FOLDER

Packages: asam-qc-openscenarioxml, asam-qc-opendrive (with the schemas inside them), osi-python; for CommonRoad in a second environment
commonroad-io and commonroad-drivability-checker. What is not installed is named in a line that starts with SKIPPED.
"""

import importlib.util
import re
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
    import xmlschema

    folder = Path(importlib.util.find_spec(package).origin).parent / "schema"
    errors = list(xmlschema.XMLSchema(str(folder / place(version_of(path)))).iter_errors(str(path)))
    assert not errors, (path, str(errors[0]))
    return "schema"


def minor(path):
    return re.search(r'revMinor="(\d+)"', path.read_text()).group(1)


def openscenario(path):
    place = lambda minor: f"1.{minor}.0/OpenSCENARIO.xsd"
    return [schema("qc_openscenario", minor, place, path), qc("openscenario", path)]


def opendrive(path):
    place = lambda minor: f"1.{minor}.0/opendrive_1{minor}_core.xsd"
    return [schema("qc_opendrive", minor, place, path), qc("opendrive", path)]


def osi(path):
    """Reads all messages; the number of frames is in the name, and each has all actors."""
    from osi3.osi_groundtruth_pb2 import GroundTruth

    data, frames, place = path.read_bytes(), 0, 0
    while place < len(data):
        (length,) = struct.unpack_from("<I", data, place)
        message = GroundTruth.FromString(data[place + 4 : place + 4 + length])
        place += 4 + length
        time = message.timestamp.seconds + 1e-9 * message.timestamp.nanos
        assert abs(time - 0.05 * frames) < 1e-9, (path, time)
        assert {each.type for each in message.moving_object} == {2, 3}, path
        car = next(each for each in message.moving_object if each.id == message.host_vehicle_id)
        assert car.base.dimension.length > 4 and car.base.position.z > 0.5, path
        assert car.vehicle_attributes.bbcenter_to_rear.x < -1, path
        assert message.version.version_major == 3 and not message.FindInitializationErrors(), path
        frames += 1
    assert frames == int(path.name.split("_")[4]), path
    return [f"{frames} messages"]


def commonroad(path):
    """The schema, and the drivability checker: ego and pedestrian first collide at the last tick."""
    import commonroad
    import xmlschema
    from commonroad.common.file_reader import CommonRoadFileReader
    from commonroad.scenario.obstacle import ObstacleType
    from commonroad_dc.collision.collision_detection.pycrcc_collision_dispatch import create_collision_object

    xsd = next(Path(list(commonroad.__path__)[0]).rglob("XML_commonRoad_XSD.xsd"))
    errors = list(xmlschema.XMLSchema(str(xsd)).iter_errors(str(path)))
    assert not errors, (path, str(errors[0]))
    scenario, _ = CommonRoadFileReader(str(path)).open()
    by_type = lambda kind: [each for each in scenario.dynamic_obstacles if each.obstacle_type == kind]
    car, pedestrian = by_type(ObstacleType.CAR)[0], by_type(ObstacleType.PEDESTRIAN)[0]
    car_track, walk = create_collision_object(car), create_collision_object(pedestrian)
    last = pedestrian.prediction.final_time_step
    at = lambda track, step: track.obstacle_at_time(step)
    steps = [step for step in range(1, last + 1) if at(car_track, step).collide(at(walk, step))]
    assert steps and steps[0] == last, (path, steps[:3], last)
    return [f"collision at step {last}"]


CHECKS = [
    ("*.xosc", "qc_openscenario", openscenario),
    ("*.xodr", "qc_opendrive", opendrive),
    ("*.osi", "osi3", osi),
    ("*.commonroad.xml", "commonroad_dc", commonroad),
]


def main(folder):
    for pattern, package, check in CHECKS:
        files = sorted(Path(folder).rglob(pattern))
        if not installed(package):
            print(f"SKIPPED: {len(files)} files {pattern}, since {package} is not installed")
            continue
        said = [check(path) for path in files]
        assert said, f"no files {pattern}"
        print(f"{pattern}: {len(files)} files, the last one {', '.join(said[-1])}")


if __name__ == "__main__":
    main(sys.argv[1])
