"""Drivers and worlds that other packages bring, by the entry points of their metadata."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from falsify_av.bridges import BRIDGES
from falsify_av.stacks import STACKS

DRIVER = """
from falsify_av.drivers import serve

class Stop:
    def drive(self, world):
        return {"brake": 1.0}

def main(words):
    Stop.words = words
    serve(Stop)

def look():
    raise SystemExit("the car needs its key: put it in")
"""
WORLD = """
class Nothing:
    about = {"name": "nothing"}

def world(words):
    return Nothing()
"""
ENTRIES = """[falsify_av.drivers]
theirs = their_car:main
sumo = their_car:main
unmade = their_car:mian
needy = their_need:main
number = their_car:__file__

[falsify_av.worlds]
theirs = their_world:world
"""


@pytest.fixture
def theirs(tmp_path: Path) -> Path:
    """A folder with an installed package of others."""
    metadata = tmp_path / "their_package-2.1.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: their-package\nVersion: 2.1\n")
    (metadata / "entry_points.txt").write_text(ENTRIES)
    (tmp_path / "their_car.py").write_text(DRIVER)
    (tmp_path / "their_need.py").write_text("import no_such_package\n")
    (tmp_path / "their_world.py").write_text(WORLD)
    return tmp_path


def served(folder: Path, module: str, *words: str, said: str = "") -> subprocess.CompletedProcess[str]:
    paths = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", f"falsify_av.{module}", *words]
    return subprocess.run(command, input=said, env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True)


def test_a_package_brings_a_driver_and_a_world(theirs: Path) -> None:
    hello = json.dumps({"type": "hello", "protocol": "falsify-av/1"})
    step = json.dumps({"type": "step", "worlds": [{"id": 3, "tick": 0}]})
    found = served(theirs, "stacks", "theirs", "fast", said=f"{hello}\n{step}\n")
    assert [json.loads(line) for line in found.stdout.splitlines()][1] == {"actions": [{"id": 3, "brake": 1.0}]}, found.stderr
    hello = json.dumps({"type": "hello", "protocol": "falsify-world/1"})
    found = served(theirs, "bridges", "theirs", said=f"{hello}\n")
    assert json.loads(found.stdout) == {"protocol": "falsify-world/1", "name": "nothing"}, found.stderr
    assert served(theirs, "bridges", "--missing", "theirs").returncode == 0


def test_names_of_others_are_listed_and_ours_stay_ours(theirs: Path) -> None:
    found = served(theirs, "stacks", "nobody")
    assert found.returncode == 2 and found.stderr.endswith(f"names: {', '.join([*STACKS, 'needy', 'number', 'theirs', 'unmade'])}\n")
    code = "from falsify_av.entries import *; print(entries(DRIVERS, {'sumo': 'ours:main'})['sumo'].value)"
    paths = os.pathsep.join([str(theirs), os.environ.get("PYTHONPATH", "")])
    assert subprocess.check_output([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": paths}, text=True) == "ours:main\n"


@pytest.mark.parametrize(("name", "text"), [
    ("needy", "needy (their_need:main of their-package 2.1) needs the Python package no_such_package, which is not installed; install it for "),
    ("unmade", "unmade (their_car:mian of their-package 2.1) is not there: module 'their_car' has no attribute 'mian'; correct the entry point"),
    ("number", "number (their_car:__file__ of their-package 2.1) is str and no function; let the entry point name one"),
])  # fmt: skip
def test_what_is_wrong_with_an_entry_is_a_sentence(theirs: Path, name: str, text: str) -> None:
    for words in ([name], ["--missing", name]):
        found = served(theirs, "stacks", *words)
        assert found.returncode == 1 and found.stderr.startswith(text), found.stderr
    assert served(theirs, "stacks", "--missing", "theirs").stderr == "the car needs its key: put it in\n"


def test_ours_are_entries_of_the_same_kind() -> None:
    tomllib = pytest.importorskip("tomllib")
    project = tomllib.loads(Path(__file__).parents[1].joinpath("pyproject.toml").read_text(encoding="utf-8"))
    groups = project["project"]["entry-points"]
    assert groups["falsify_av.drivers"] == {name: f"falsify_av.stacks.{stack.module}:main" for name, stack in STACKS.items()}
    assert groups["falsify_av.worlds"] == {name: f"falsify_av.bridges.{bridge.module}:world" for name, bridge in BRIDGES.items()}
