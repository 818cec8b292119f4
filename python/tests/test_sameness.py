"""An episode that is stepped from Python is that of the program: the same start, the same states, the same digest."""

import csv
import json
import subprocess
from pathlib import Path

import falsify_av

WALKED = Path(__file__).with_name("walked.scn")


def test_digests_are_those_of_the_program(program, tmp_path):
    out = tmp_path / "reports"
    subprocess.run([program, "run", str(WALKED), "--seed", "9", "--out", str(out)], check=True, capture_output=True)
    tables = list(out.rglob("episodes.csv"))
    assert len(tables) == 1
    with tables[0].open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 24
    with (tables[0].parent / "failures.csv").open() as file:
        failures = {(row["run_id"], row["number"]): row for row in csv.DictReader(file)}
    env = falsify_av.make(WALKED)
    for row in rows:
        env.reset(seed=9, options={"episode": int(row["episode"])})
        over = False
        while not over:
            _, _, terminated, truncated, info = env.step(env.suggested(row["pedestrian"]))
            over = terminated or truncated
        for column in ("start", "digest", "outcome"):
            assert info[column] == row[column], column
        if failure := failures.get((row["run_id"], row["episode"])):
            assert (info["verdict"], info["driving_mode"]) == (failure["verdict"], failure["driving_mode"])
        assert repr(info["least_gap_m"]) == repr(float(row["least_gap_m"]))
    names = {row["outcome"] for row in rows}
    assert "collision" in names and len(names) > 1


def test_a_replay_has_the_digest(program, tmp_path):
    out = tmp_path / "reports"
    subprocess.run([program, "run", str(WALKED), "--out", str(out)], check=True, capture_output=True)
    with next(out.rglob("episodes.csv")).open() as file:
        row = next(row for row in csv.DictReader(file) if row["pedestrian"] == "homing" and row["outcome"] == "collision")
    name = f"{row['run_id']}:{row['episode']}"
    replayed = subprocess.run([program, "replay", name, "--report", str(out), "--json"], check=True, capture_output=True).stdout
    env = falsify_av.make(WALKED)
    env.reset(options={"episode": int(row["episode"])})
    over = False
    while not over:
        _, _, terminated, truncated, info = env.step(env.suggested("homing"))
        over = terminated or truncated
    assert info["digest"] == json.loads(replayed)["digest"]
