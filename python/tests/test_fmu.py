"""FMUs as drivers: two in C and one in Python are made here, others are those in the folder that `FALSIFY_FMU_DIR` names."""

from __future__ import annotations

import json
import math
import os
import shutil
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")

from falsify_av.stacks import fmu_file  # noqa: E402
from falsify_av.stacks.batch import Frame  # noqa: E402
from falsify_av.stacks.fmu import Fmu, main, seen  # noqa: E402
from falsify_av.stacks.fmu_file import File, opened  # noqa: E402
from falsify_av.stacks.fmu_links import COLUMNS, Link, linked  # noqa: E402

SOURCES = Path(__file__).with_name("stacks") / "fmu"
VEHICLE = {"length": 4.79, "width": 2.16, "wheelbase": 3.0, "greatest_wheel_angle": 0.86}
ACTORS, POINTS, TICK = 2, 20, 0.05
AEB = [
    "ego_speed=ego.speed", "object_distance=course.gap", "object_closing=course.closing", "object_lateral=course.left[m]",
    "object_class=course.kind[None,Pedestrian,Car]", "enabled=true", "brake=car.deceleration",
]
ACC = ["v=ego.speed", "v_set=road.limit", "gap=front.gap", "v_lead=front.speed", "lead=front.present", "a=car.acceleration"]
PYTHON = ["speed=ego.speed[m/s]", "gap=front.gap[m]", "pedal=car.brake"]


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with `aeb.fmu` and `acc.fmu`."""
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc")
    folder = tmp_path_factory.mktemp("fmu")
    for name in ("aeb", "acc"):
        subprocess.run([sys.executable, SOURCES / "build.py", name, folder / f"{name}.fmu"], check=True)
    return folder


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Nothing is unpacked anywhere else."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "falsify_av"


def driver(path: Path, words: list[str], worlds: int = 1, **parameters: float) -> Fmu:
    file = opened(path)
    return Fmu({"vehicle": VEHICLE, "tick_s": TICK, "worlds": worlds, "parameters": parameters}, file, linked(words, file.model))


def numbers(worlds: int, speed: float, users: list[list[float]], start: bool = False, revision: int = 1) -> Any:
    """Straight roads to the east, the middle of the car at 0; a user is kind, x, y, yaw, vx, vy, length, width."""
    found = np.zeros((worlds, 14 + 8 * ACTORS + 3 * POINTS + (ACTORS + 5 * POINTS if revision == 2 else 0)))
    found[:, 0], found[:, 2] = np.arange(worlds), 5.0 if start else -1.0
    found[:, 6], found[:, 7], found[:, 12], found[:, 13] = speed, 13.9, len(users), POINTS
    for place, user in enumerate(users):
        found[:, 14 + 8 * place : 22 + 8 * place] = user
    found[:, 14 + 8 * ACTORS : 14 + 8 * ACTORS + 3 * POINTS : 3] = 2.0 * np.arange(POINTS)
    if revision == 2:
        found[:, -1 : -1 - 5 * POINTS : -5] = 13.9
    return found


def frame(worlds: int, speed: float, users: list[list[float]], start: bool = False) -> Frame:
    return Frame(numbers(worlds, speed, users, start), ACTORS, POINTS)


def person(front: float, left: float = 0.0, across: float = 0.0) -> list[float]:
    """A pedestrian whose near side is so far ahead of the front of the car."""
    return [1.0, front + VEHICLE["length"] / 2 + 0.25, left, 0.0, 0.0, across, 0.5, 0.5]


@pytest.mark.parametrize(("name", "words", "step"), [("aeb", AEB, 0.01), ("acc", ACC, 0.02), ("PyAeb", PYTHON, TICK)])
def test_a_drive_is_that_of_fmpy(made: Path, tmp_path: Path, name: str, words: list[str], step: float) -> None:
    """The same inputs at the same steps, here and in `fmpy.simulate_fmu`."""
    path = python_unit(tmp_path) if name == "PyAeb" else made / f"{name}.fmu"
    fmu, told, answered = driver(path, words), [], []
    inner = fmu.worlds[0].fmu.step

    def step_of(values: list[float], until: float, starts: bool) -> list[float]:
        outputs = inner(values, until, starts)
        told.append((until - TICK, values))
        answered.append((fmu.worlds[0].fmu._steps * step, outputs))  # type: ignore[union-attr]
        return outputs

    fmu.worlds[0].fmu.step = step_of  # type: ignore[method-assign]
    x, speed = 0.0, 11.0
    # An episode before leaves nothing behind.
    for tick in [*range(40), *range(200)]:
        if tick == 0:
            x, speed = 0.0, 11.0
            told.clear()
            answered.clear()
        push = float(fmu.decide(frame(1, speed, [person(40.0 - x, 0.3 * math.sin(tick / 9))], start=tick == 0))[0][0])
        speed = max(speed + TICK * min(max(push, -8.0), 2.0), 0.0)
        x += TICK * speed
    assert max(abs(outputs[0]) for _, outputs in answered) > 0.5, "it has driven"
    links = fmu.links.inputs
    kinds = {"Boolean": np.bool_, "Enumeration": np.int32}
    types = [(link.variable.name, kinds.get(link.variable.type, np.float64)) for link in links]
    times = np.arange(round(200 * TICK / step)) * step
    held = [max((each for each in told if each[0] <= time + 1e-9), key=lambda each: each[0])[1] for time in times]
    signals = np.array([(time, *values) for time, values in zip(times, held)], [("time", np.float64), *types])
    names, end = [link.variable.name for link in fmu.links.outputs], 200 * TICK
    found = fmpy.simulate_fmu(str(path), stop_time=end, output_interval=step, input=signals, start_values=fmu.links.constants, output=names)
    for time, outputs in answered:
        row = found[int(np.argmin(np.abs(found["time"] - time)))]
        assert abs(row["time"] - time) < 1e-6
        assert [*row][1:] == pytest.approx(outputs, abs=1e-9), time


def python_unit(folder: Path) -> Path:
    pytest.importorskip("pythonfmu", reason="pythonfmu is not installed")
    done = subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", SOURCES / "slave.py", "-d", folder], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder / "PyAeb.fmu"


@pytest.mark.parametrize("name", ["aeb", "acc"])
def test_a_world_does_not_change_another(made: Path, name: str) -> None:
    """`acc` allows one instance in a process, and its state is global."""
    words = {"aeb": AEB, "acc": ACC}[name]
    many, alone = driver(made / f"{name}.fmu", words, worlds=3), driver(made / f"{name}.fmu", words)
    for tick in range(30):
        together = many.decide(frame(3, 9.0, [person(11.0 - 0.1 * tick)], start=tick == 0))[0]
        apart = alone.decide(frame(1, 9.0, [person(11.0 - 0.1 * tick)], start=tick == 0))[0]
        assert together.tolist() == [apart[0]] * 3
    assert apart[0] < -5.0


def test_the_state_of_an_episode_is_gone_in_the_next(made: Path) -> None:
    """The reset of `aeb` does nothing."""
    fmu, first = driver(made / "aeb.fmu", AEB), [person(6.0)]
    episodes = [[float(fmu.decide(frame(1, 8.0, first, start=tick == 0))[0][0]) for tick in range(6)] for _ in range(3)]
    assert episodes[0] == episodes[1] == episodes[2] and episodes[0][-1] < -7.0


def test_distances_are_from_the_front_and_an_object_has_a_rule() -> None:
    def users(speed: float, *rows: list[float]) -> dict[str, list[list[float]]]:
        return {user: found.get(0, []) for user, found in seen(frame(1, speed, [*rows]), VEHICLE).items()}

    ahead = users(10.0, person(12.0))
    assert ahead["front"] == ahead["course"] == ahead["person"] == [pytest.approx([12.0, 0.0, 0.0, 0.0, 10.0, 1.2, 1.0, 1.0])]
    assert ahead["vehicle"] == []
    beside = users(10.0, person(12.0, -3.0))
    assert beside["front"] == beside["course"] == [] and len(beside["person"]) == 1
    crossing = users(10.0, person(12.0, -3.0, 2.0))
    assert crossing["front"] == [] and crossing["course"][0][COLUMNS.index("lateral")] == 2.0
    assert users(10.0, person(12.0, -3.0, 9.0))["course"] == [], "it has crossed before the car comes"
    assert users(0.0, person(12.0, -3.0, 2.0))["course"] == [], "the car stands"
    assert users(10.0, person(-6.0), person(-0.6)) == dict.fromkeys(("front", "course", "person", "vehicle"), []), "the front has passed"
    van = [2.0, 20.0, 0.0, 0.0, 4.0, 0.0, 5.0, 2.0]
    both = users(10.0, van, person(5.0))
    assert [each[0] for each in both["front"]] == pytest.approx([5.0, 20.0 - 2.5 - VEHICLE["length"] / 2])
    assert both["vehicle"][0][COLUMNS.index("closing")] == 6.0


def test_numbers_are_converted(made: Path) -> None:
    model = opened(made / "aeb.fmu").model
    words = [*AEB[:1], "object_distance=front2.gap,99", "object_closing=vehicle.closing*-1", "object_lateral=person.left[cm]", *AEB[4:], "state=car.stop[Brakes]"]
    links = linked(words, model)
    own, near = {"ego.speed": 10.0}, {"front": [[5.0] + [0.0] * 7], "vehicle": [[0.0] * 4 + [3.0] + [0.0] * 3], "person": [[0.0, 1.5] + [0.0] * 6], "course": []}
    assert [each.told(own, near) for each in links.inputs] == pytest.approx([36.0, 99.0, -3.0, 150.0, 0.0]), "there is no second one"
    near["course"] = [[0.0] * 7 + [1.0]]
    assert links.inputs[4].told(own, near) == 2.0, "Pedestrian"
    assert [each.answered(1.0) for each in links.outputs] == [1.0, 1.0] and links.outputs[1].answered(0.0) == 0.0
    acc = linked([*ACC[:1], "v_set=60", *ACC[2:]], opened(made / "acc.fmu").model)
    assert acc.constants == {"v_set": 60.0}
    assert acc.inputs[2].told({"ego.speed": 7.0}, {"front": []}) == 7.0, "nobody is as fast as the car"


def test_a_scenario_sets_parameters(made: Path) -> None:
    early, late = driver(made / "aeb.fmu", AEB, tune_ttc=2.5), driver(made / "aeb.fmu", AEB)
    pushes = [[float(fmu.decide(frame(1, 8.0, [person(16.0)], start=tick == 0))[0][0]) for tick in range(10)][-1] for fmu in (early, late)]
    assert pushes[0] < -8.0 and pushes[1] > 0.0
    with pytest.raises(SystemExit, match="no parameter `tune_tc`: did you mean `tune_ttc`"):
        driver(made / "aeb.fmu", AEB, tune_tc=2.5)


def test_pedals_and_the_follower(tmp_path: Path) -> None:
    fmu = driver(python_unit(tmp_path), PYTHON)
    throttle, brake, steer = (float(each[0]) for each in fmu.decide(frame(1, 8.0, [], start=True)))
    assert throttle > 0.5 and (brake, steer) == (0.0, 0.0), "an FMU that only brakes is driven"
    throttle, brake, _ = (float(each[0]) for each in fmu.decide(frame(1, 8.0, [person(5.0)])))
    assert (throttle, brake) == (0.0, 0.5)


def test_the_angle_of_the_wheels_is_answered_as_such(made: Path) -> None:
    fmu = driver(made / "aeb.fmu", AEB)
    # A tenth of its braking stands for an angle; a brake of 9 m/s^2 builds up in 0.1 s.
    fmu.links.outputs = [Link(fmu.links.outputs[0].variable, "car.wheel", factor=0.1)]
    *_, wheel = fmu.decide(frame(1, 8.0, [person(5.0)], start=True))
    assert fmu.links.is_angle and wheel[0] == pytest.approx(0.9 * (1.0 - math.exp(-0.5)))
    fmu.links.outputs[0].factor = -4.0
    *_, wheel = fmu.decide(frame(1, 8.0, [person(5.0)]))
    assert wheel[0] == -VEHICLE["greatest_wheel_angle"], "more than the car has is cut"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("ego_spee=ego.speed", "the FMU has no variable `ego_spee`: did you mean `ego_speed`?"),
        ("ego_speed", "is no pair: write NAME=QUANTITY"),
        ("ego_speed=?", "is to be filled in: write ego_speed=ego.speed"),
        ("ego_speed=ego.sped", "names no quantity that fits: did you mean `ego.speed`?"),
        ("ego_speed=front.gap", "`ego_speed` is in km/h, and front.gap in m: take another quantity, or a unit of m km"),
        ("ego_speed=ego.speed[m/s]", "the description says that `ego_speed` is in km/h, not in m/s"),
        ("ego_speed=ego.speed[furlong]", "`ego_speed` is in furlong"),
        ("ego_speed=ego.speed*0", "`0` is no factor"),
        ("object_lateral=front.left", "states no unit of `object_lateral`: say which it is in, as object_lateral=front.left[m]"),
        ("object_class=front.kind", "which values of `object_class` stand for nobody, a pedestrian, a vehicle, in this order, as object_class=front.kind[None,Car,"),
        ("object_class=front.kind[None,Man,Car]", "`Man` is no value of `object_class`: there is None, Car, Pedestrian"),
        ("enabled=maybe", "`maybe` is no value of `enabled`"),
        ("brake=4", "`brake=4` names no quantity that fits: there is car.acceleration"),
        ("brake=car.brake", "`brake` is in m/s2, and car.brake in 1"),
        ("state=car.stop", "say which values of `state` brake, as state=car.stop[Brakes]"),
        ("state=car.deceleration[m/s2]", "the outputs stand for car.deceleration, car.deceleration"),
    ],
)
def test_a_wrong_link_is_named(made: Path, change: str, said: str) -> None:
    name = change.partition("=")[0]
    words = [each for each in AEB if each.partition("=")[0] != name]
    with pytest.raises(SystemExit) as found:
        linked([*words, change], opened(made / "aeb.fmu").model)
    assert said in str(found.value)


def test_what_has_no_value_is_asked_for(made: Path) -> None:
    model = opened(made / "aeb.fmu").model
    with pytest.raises(SystemExit, match="the input `enabled` has no value: write enabled=USER.present USER.kind, or a value, false, true; it starts with true"):
        linked([each for each in AEB if not each.startswith("enabled")], model)
    with pytest.raises(SystemExit, match="no output of the FMU drives the car"):
        linked(AEB[:-1], model)


def changed(made: Path, folder: Path, change: Callable[[str, bytes], tuple[str, bytes] | None]) -> Path:
    """A copy of `aeb.fmu` with other entries."""
    path = folder / "other.fmu"
    with zipfile.ZipFile(made / "aeb.fmu") as old, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as new:
        for entry in old.infolist():
            kept = change(entry.filename, old.read(entry))
            if kept is not None:
                new.writestr(*kept)
    return path


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda name, text: (name.replace(fmpy.platform, "win16"), text), "has no library for "),
        (lambda name, text: None if name.startswith("binaries") else (name, text), "only for nothing"),
        (lambda name, text: (name, text.replace(b'fmiVersion="2.0"', b'fmiVersion="1.0"')), "cannot be read as an FMU"),
        (lambda name, text: (name, text.replace(b"CoSimulation", b"ModelExchange")), "is for model exchange alone, without a solver of its own"),
        (lambda name, text: (name, text.replace(b"<ModelVariables>", b"<ModelVariables")), "cannot be read as an FMU"),
        (lambda name, text: (name.replace("modelDescription", "model"), text), "is no FMU, since it has no modelDescription.xml"),
        (lambda name, text: (name.replace("sources/", "../../sources/"), text), "its entry '../../sources/aeb.c' leads out of its folder"),
        (lambda name, text: (name.replace("sources/", "/tmp/"), text), "leads out of its folder"),
        (lambda name, text: (name.replace("sources/", "C:\\"), text), "leads out of its folder"),
    ],
)
def test_an_archive_that_cannot_be_used_is_refused(made: Path, tmp_path: Path, cache: Path, change: Any, said: str) -> None:
    with pytest.raises(SystemExit) as found:
        opened(changed(made, tmp_path, change))
    assert said in str(found.value)
    assert not cache.exists(), "nothing is unpacked"


def test_fmi_1_is_refused(tmp_path: Path) -> None:
    path, head = tmp_path / "old.fmu", '<fmiModelDescription fmiVersion="1.0" modelName="a" modelIdentifier="a" numberOfContinuousStates="0">'
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", f"{head}<Implementation/><ModelVariables/></fmiModelDescription>")
    with pytest.raises(SystemExit, match="is of FMI 1.0: export it as FMI 2.0 or 3.0 for co-simulation"):
        opened(path)


def test_bombs_links_and_other_files_are_refused(made: Path, tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    link = zipfile.ZipInfo("resources/link")
    link.external_attr = 0o120777 << 16
    with zipfile.ZipFile(made / "aeb.fmu") as old, zipfile.ZipFile(tmp_path / "link.fmu", "w") as new:
        new.writestr("modelDescription.xml", old.read("modelDescription.xml"))
        new.writestr(link, "/etc")
    with pytest.raises(SystemExit, match="leads out of its folder"):
        opened(tmp_path / "link.fmu")
    (tmp_path / "text.fmu").write_text("no archive")
    for name, said in (("text.fmu", "cannot be read as an FMU"), ("none.fmu", "there is no file")):
        with pytest.raises(SystemExit, match=said):
            opened(tmp_path / name)
    monkeypatch.setattr(fmu_file, "MOST_BYTES", 8 << 20)
    bomb = changed(made, tmp_path, lambda name, text: (name, text + b" " * (9 << 20) if name.endswith(".c") else text))
    assert bomb.stat().st_size < 1 << 20
    with pytest.raises(SystemExit, match="it has 9 MiB in 3 files, and at most 8 MiB in 10000 files are"):
        opened(bomb)
    assert not cache.exists()


def serving(path: Path, *words: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-m", "falsify_av.stacks", "fmu", path, *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def greeted(process: subprocess.Popen[bytes], worlds: int) -> dict[str, Any]:
    hello = {"type": "hello", "protocol": "falsify-av/1", "tick_s": TICK, "vehicle": VEHICLE, "worlds": worlds, "actors": ACTORS, "route_points": POINTS}
    assert process.stdin is not None and process.stdout is not None
    process.stdin.write(json.dumps(hello).encode() + b"\n")
    process.stdin.flush()
    return dict(json.loads(process.stdout.readline()))


def asked(process: subprocess.Popen[bytes], body: Any) -> Any:
    assert process.stdin is not None and process.stdout is not None
    process.stdin.write(struct.pack("<I", body.nbytes) + body.tobytes())
    process.stdin.flush()
    size = process.stdout.read(4)
    return np.frombuffer(process.stdout.read(struct.unpack("<I", size)[0]), "<f8").reshape(-1, 4) if size else None


def test_what_an_fmu_prints_is_no_answer_and_its_step_is_said_once(made: Path) -> None:
    process = serving(made / "aeb.fmu", *AEB)
    assert greeted(process, 2)["control"] == "acceleration"
    for tick in range(5):
        answer = asked(process, numbers(2, 8.0, [person(4.0)], start=tick == 0, revision=2))
    assert answer[:, 1] == pytest.approx([-8.26, -8.26], abs=0.01)
    _, said = process.communicate()
    assert process.returncode == 0
    assert said.count(b"steps by 0.01 s, and a tick is 0.05 s") == 1 and said.count(b"AEB: brakes at 4.0 m") == 2


@pytest.mark.parametrize(("fault", "said"), [(3, "its output `brake` is not finite, 0.15 s after the start"), (4, "fmi2DoStep failed with status 3")])
def test_an_fmu_that_fails_answers_no_number(made: Path, fault: int, said: str) -> None:
    process = serving(made / "aeb.fmu", *AEB, f"fault={fault}", "fault_time=0.12")
    greeted(process, 1)
    found = [asked(process, numbers(1, 8.0, [], start=tick == 0, revision=2)) for tick in range(3)]
    assert np.isfinite(found[1]).all() and np.isnan(found[2][0, 3])
    assert said in process.communicate()[1].decode()


@pytest.mark.parametrize(("fault", "said"), [(1, "with signal SIGABRT"), (2, "did not answer within 500 ms"), (3, "is not finite"), (4, "is not finite")])
def test_a_fault_costs_an_episode(made: Path, tmp_path: Path, program: str, fault: int, said: str) -> None:
    """Episodes that last less than 14 s with their run-up are over before."""
    words = " ".join([*AEB, f"fault={fault}", "fault_time=14"])
    (tmp_path / "aeb.fmu").write_bytes((made / "aeb.fmu").read_bytes())
    (tmp_path / "fault.scn").write_text(f"""edition 1
import "std/pedestrians.scn"
import "std/drivers.scn"
import "std/towns.scn"
driver mine = external(command: "{sys.executable} -m falsify_av.stacks fmu aeb.fmu {words}", worlds: 4, timeout: 0.5 s)
spawn near {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }}
episode short {{ ticks: 240  hold: 10  end_when: ahead < -6 m }}
campaign c {{ vehicle: model3  body: plausible  spawn: near  episode: short
  evaluate {{ towns: [harbour]  drivers: [mine]  pedestrians: [intercept]  episodes: 12 }} }}
""")
    done = subprocess.run([program, "run", "--allow-external", "fault.scn", "--out", "out"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 5, done.stderr
    errors = int(done.stderr.partition(" of 12 episodes are in error")[0].split()[-1])
    assert 0 < errors < 12 and said in done.stderr


def run(*words: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "falsify_av.stacks", "fmu", *words], capture_output=True, text=True)


def test_what_it_does_is_said_in_words(made: Path) -> None:
    fmu = made / "aeb.fmu"
    good = run(fmu, *AEB, "--try")
    assert good.returncode == 0 and "ok    drives 14.0 m/s" in good.stdout and "FAIL" not in good.stdout
    assert "from 14 m/s it stops 2.4 m before a person who stands in its way" in good.stdout
    off = run(fmu, *AEB[:-2], "enabled=false", AEB[-1], "--try")
    assert off.returncode == 5 and "its output `brake` is 0 in all manoeuvres" in off.stdout and "reacts to nothing at these speeds" in off.stdout
    stiff = run(fmu, *AEB[:1], "object_distance=1", "object_closing=10", *AEB[3:], "--try")
    assert "answers the same at all distances of a person at 3, 8, 14 m/s" in stiff.stdout
    stands = run(made / "acc.fmu", *ACC[:-1], "a=car.acceleration*0.01", "--try")
    assert "on an empty road: it stands, or nearly" in stands.stdout


@pytest.mark.parametrize(("fault", "said"), [("fault=1", "ends its process on an empty road, with SIGABRT"), ("fault=4", "fmi2DoStep failed with status 3")])
def test_an_fmu_that_fails_is_tried_to_its_end(made: Path, fault: str, said: str) -> None:
    found = run(made / "aeb.fmu", *AEB, fault, "--try")
    assert found.returncode == 5 and said in found.stdout


def test_a_scenario_to_fill_in_is_one_that_runs(made: Path, tmp_path: Path, program: str) -> None:
    scenario = tmp_path / "mine.scn"
    assert run(made / "aeb.fmu", "--new", scenario).stdout == f"{scenario} is written: fill in its command\n"
    again = run(made / "aeb.fmu", "--new", scenario)
    assert again.returncode == 1 and "exists and is not replaced" in again.stderr
    text = scenario.read_text(encoding="utf-8")
    assert "object_distance [m], from the front bumper: write object_distance=USER.gap" in text and "tune_ttc=1.4, tune.ttc [s]" in text
    for word in AEB:
        text = text.replace(f"{word.partition('=')[0]}=?", word)
    assert "budget: 20_000" in text
    scenario.write_text(text.replace("20_000", "3_000").replace(" state=?", "").replace("python3 -m falsify_av.stacks", f"{sys.executable} -m falsify_av.stacks"))
    done = subprocess.run([program, "run", "--smoke", "--allow-external", scenario, "--out", tmp_path / "out"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def foreign() -> list[Path]:
    folder = os.environ.get("FALSIFY_FMU_DIR")
    return sorted(Path(folder).glob("*.fmu")) if folder else []


@pytest.mark.parametrize("path", foreign() or [None], ids=lambda path: path.stem if path else "none")
def test_fmus_of_others_drive(path: Path | None, tmp_path: Path) -> None:
    """Every input at its start value: each steps as in `fmpy.simulate_fmu`, also in a second episode."""
    if path is None:
        pytest.skip("FALSIFY_FMU_DIR does not name a folder with FMUs of others")
    file = opened(path)
    assert run(path, "--new", tmp_path / "new.scn").returncode == 0
    variables = file.model.modelVariables
    outputs = [each for each in variables if each.causality == "output" and not each.shape and each.type not in ("String", "Binary", "Clock")]
    step = file.step(TICK)
    instance = fmu_file.Instance(file, [], outputs, {}, step)
    ours = [[instance.step([], (tick + 1) * step, tick == 0) for tick in range(100)] for _ in range(2)][1]
    theirs = fmpy.simulate_fmu(str(path), validate=False, stop_time=100 * step, output_interval=step, output=[each.name for each in outputs])
    for place, output in enumerate(outputs):
        assert [float(value) for value in theirs[output.name][1:]] == pytest.approx([row[place] for row in ours], abs=1e-9), output.name


def test_the_command_line_is_checked(made: Path) -> None:
    for words, said in ((["--step", "0"], "is no length of a step"), ([], "has no value")):
        with pytest.raises(SystemExit, match=said):
            main([str(made / "aeb.fmu"), *words])
    assert isinstance(opened(made / "aeb.fmu"), File)
