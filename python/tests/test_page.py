"""The examples of the page about Python."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import falsify_av

PAGES = Path(__file__).resolve().parents[2] / "docs/src/how-to"


def block(page, language, part):
    """The first block of a language on a page that has this part."""
    blocks = re.findall(rf"^```{language}\n(.*?)^```$", (PAGES / page).read_text(), re.DOTALL | re.MULTILINE)
    return next(each for each in blocks if part in each)


def test_the_driver_of_the_page_reaches_its_starts(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("my.scn").write_text(block("scenario.md", "scn", "campaign mine"))
    names = {"falsify_av": falsify_av}
    exec(block("python.md", "python", "class Careful"), names)
    asked = 0

    class Counted(names["Careful"]):
        def drive(self, world):
            nonlocal asked
            asked += 1
            return super().drive(world)

    def homing(states):
        return np.tile([0.0, 3.0], (len(states), 1))

    choice = {"campaign": "mine", "town": "harbour", "driver": "behavior", "reward": "r2", "own_driver": Counted}
    rows = falsify_av.evaluate(homing, "my.scn", episodes=40, **choice)
    assert [row["episode_number"] for row in rows if row["placed"]] == []
    assert all(row["run_up_ticks"] > 0 and row["error"] == "" for row in rows)
    # Each tick of a run-up and of an episode is asked for once: no world starts an episode that has no row.
    ticks = sum(row["run_up_ticks"] + row["ticks"] for row in rows)
    assert asked == ticks, (asked, ticks)


def test_a_driver_that_does_not_steer_is_told(tmp_path):
    scenario = tmp_path / "my.scn"
    scenario.write_text(block("scenario.md", "scn", "campaign mine"))

    class Straight:
        def drive(self, world):
            return {"throttle": 0.4}

    choice = {"campaign": "mine", "town": "harbour", "driver": "behavior", "reward": "r2", "own_driver": Straight}
    with pytest.warns(falsify_av.RunUpWarning, match=r"did not reach its start in \d+ of 8 run-ups.*`route`"):
        rows = falsify_av.evaluate(lambda states: np.zeros((len(states), 2)), scenario, episodes=8, **choice)
    placed = next(row["episode_number"] for row in rows if row["placed"])
    env = falsify_av.make(scenario, **choice)
    with pytest.warns(falsify_av.RunUpWarning, match="1 of 1 run-ups"):
        _, info = env.reset(seed=1, options={"episode": placed})
    assert info["placed"] and info["run_up_ticks"] > 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env.reset(seed=1, options={"episode": placed})  # It is told once.
