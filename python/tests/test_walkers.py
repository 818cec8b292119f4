"""Who walks in another simulator: a pedestrian that was trained here, a shipped one, `intercept`, `natural`, a program, and a search's finds."""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from falsify_av.bridges import BRIDGES

SCENARIOS = Path(__file__).resolve().parents[2] / "scenarios"


@pytest.mark.parametrize("world", ["metadrive", "sumo"])
def test_each_kind_of_pedestrian_walks_in_another_simulator(world: str, program: str, tmp_path: Path) -> None:
    missing = BRIDGES[world].missing()
    if missing is not None:
        pytest.skip(missing)
    text = Path(__file__).with_name("walkers.scn").read_text().replace("../../scenarios", SCENARIOS.as_posix())
    if world == "sumo":
        text = text.replace("metadrive", world).replace("there = cruise()", 'there = native(name: "EIDM")')
    (tmp_path / "walkers.scn").write_text(text)
    shutil.copy(SCENARIOS / "external" / "my_pedestrian.py", tmp_path)
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])

    def falsify(*words: str) -> str:
        command = [str(Path(program).resolve()), *words, "--allow-external", "--progress", "none"]
        return subprocess.run(command, cwd=tmp_path, env={**os.environ, "PATH": path}, capture_output=True, text=True, check=True).stdout

    falsify("run", "--out", "out", "walkers.scn")
    tables = [(tmp_path / "out" / report / "episodes.csv").read_text() for report in ("walkers", "program")]
    rows = [row for table in tables for row in csv.DictReader(table.splitlines())]
    walked = {(row["pedestrian"], row["world"]) for row in rows if not row["error"] and not row["left_out"]}
    assert walked == {(name, world) for name in ("trained", "hunter", "intercept", "natural", "program")}
    assert all(row["error"] == "" for row in rows)
    if world == "metadrive":
        again = json.loads(falsify("recheck", "out/walkers", "--world", world, "--format", "json"))
        found = [row for row in again["failures"] if row["found_in"] == "search"]
        assert found and all(row["still_collisions"] and not row["failed_encounters"] for row in found)
