"""Ctrl-C ends whatever runs within a second, and progress is shown."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import falsify_av
from falsify_av.progress import Bar

SCENARIO = Path(__file__).with_name("short.scn")

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")

BEFORE = """
import sys
import numpy as np, falsify_av
choice = dict(campaign="short", town="harbour", driver="blind", task="train")
env = falsify_av.make_vec(sys.argv[1], 64, **choice)
def begun():
    print("begun", flush=True)
try:
"""
AFTER = """
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
CALLS = {
    "stepping": """
    env.reset(seed=1)
    begun()
    while True:
        env.step(np.zeros((64, 2), np.float32))
""",
    "evaluating": """
    begun()
    falsify_av.evaluate(lambda states: states[:, :2] * 0, sys.argv[1], episodes=10**7, **choice)
""",
}


def interrupted(name, *arguments):
    """Starts a call in another interpreter and interrupts it; the time until it ends (s)."""
    code = BEFORE + CALLS[name] + AFTER
    command = [sys.executable, "-c", code, str(SCENARIO), *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline().strip() == "begun", process.stderr.read()
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        clock = time.monotonic()
        assert process.stdout.readline().strip() == "interrupted", process.stderr.read()
        took = time.monotonic() - clock
        process.wait()
    return took


@pytest.mark.parametrize("name", ["stepping", "evaluating"])
def test_ctrl_c_ends_it_within_a_second(name):
    # Measured in CPU time nothing would be seen of a call that waits; other work on the machine may make it longer.
    assert interrupted(name) < 1.0 + os.getloadavg()[0]


def test_ctrl_c_ends_a_run_and_its_program(program, tmp_path):
    file = tmp_path / "long.scn"
    text = SCENARIO.read_text().replace("pedestrians: [random]  episodes: 4", "pedestrians: [random]  episodes: 1_000_000")
    file.write_text(text)
    code = f"""
import falsify_av
try:
    falsify_av.program.call("run", "--format", "json", "--out", {str(tmp_path / "out")!r}, {str(file)!r},
                            each_line=lambda line: print("begun", flush=True))
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline().strip() == "begun"
        process.send_signal(signal.SIGINT)
        said = process.stdout.read()
        process.wait()
    assert said.strip().splitlines()[-1] == "interrupted"


def test_progress_counts_to_the_end(scenario, capsys):
    choice = {"campaign": "short", "town": "harbour", "driver": "blind", "task": "train"}
    seen = []

    def walk(states):
        return states[:, :2] * 0

    falsify_av.evaluate(walk, scenario, episodes=20, num_envs=8, progress=lambda *counts: seen.append(counts), **choice)
    assert seen[-1] == (20, 20) and seen == sorted(seen)
    falsify_av.evaluate(walk, scenario, episodes=5, progress=True, **choice)
    assert "5 of 5 episodes" in capsys.readouterr().err


def test_a_bar_shows_the_share_and_ends_with_its_line(capsys):
    bar = Bar("tasks")
    for done in range(5):
        bar(done, 4)
    text = capsys.readouterr().err
    assert text.endswith("4 of 4 tasks\x1b[K\n") and "█" * 30 in text


def test_a_run_tells_its_tasks(program, scenario, tmp_path):
    seen = []
    falsify_av.run(
        scenario, out=tmp_path, arguments=["--smoke"], progress=lambda *counts: seen.append(counts)
    )
    assert seen and seen[-1][0] == seen[-1][1] == len(seen)
