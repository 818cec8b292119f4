"""The bridge to esmini: with its library, if FALSIFY_ESMINI_LIBRARY names one, and that a library of other C signatures is refused."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from test_bridges import MAP, START, TICK, VEHICLE

from falsify_av.bridges.esmini import DRIVERS, FUNCTIONS, Esmini, world

LIBRARY = os.environ.get("FALSIFY_ESMINI_LIBRARY", "")
LOAD = {
    "town": "street", "map": MAP, "tick_s": TICK, "vehicle": VEHICLE, "pedestrians": [{"radius": 0.2, "height": 1.8}],
    "lanes": [[200.0, -51.75], [300.0, -48.25]],
}  # fmt: skip


@pytest.fixture(scope="module")
def esmini() -> Iterator[Esmini]:
    if not LIBRARY:
        pytest.skip("FALSIFY_ESMINI_LIBRARY names no library: scenarios/external/build_esmini.sh builds it")
    bridge = world([])
    bridge.load(LOAD)
    yield bridge
    bridge.folder.cleanup()


def episode(esmini: Esmini, ticks: int, at: tuple[float, float], control: dict[str, float], driver: str | None = None) -> list[dict[str, Any]]:
    """The states of an episode with a pedestrian that walks across the lane and stops there."""
    route = [[x, -51.75, 0.0] for x in range(150, 490)]

    def walker(tick: int) -> dict[str, float]:
        y = max(at[1] - 1.4 * TICK * tick, -51.75)
        return {"x": at[0], "y": y, "yaw": -math.pi / 2, "vx": 0.0, "vy": -1.4 if y > -51.75 else 0.0}

    states = [esmini.begin({"seed": 7, "ego": START, "driver": driver, "route": route, "pedestrians": [walker(0)]})]
    for tick in range(1, ticks + 1):
        states.append(esmini.step({"tick": tick, "control": control, "pedestrians": [walker(tick)]}))
        assert math.dist(states[-1]["pedestrians"][0], (walker(tick)["x"], walker(tick)["y"])) < 1e-6
    return states


def test_its_lanes_are_those_of_the_map(esmini: Esmini) -> None:
    places = esmini.load(LOAD)
    assert math.dist(places[0], (200.0, -51.75)) < 0.01 and math.dist(places[1], (300.0, -48.25)) < 0.01


def test_its_car_carries_out_what_our_drivers_command(esmini: Esmini) -> None:
    straight = episode(esmini, 20, (300.0, -40.0), {"acceleration": -3.0, "wheel_angle": 0.0})
    assert straight[0]["ego"] == pytest.approx(START, abs=1e-6) and straight[-1]["ego"]["speed"] == pytest.approx(5.0, abs=1e-6)
    left = episode(esmini, 20, (300.0, -40.0), {"acceleration": 0.0, "wheel_angle": 0.1})
    assert left[-1]["ego"]["yaw"] == pytest.approx(8.0 * math.tan(0.1) / VEHICLE["wheelbase"], rel=0.02) and left[-1]["ego"]["y"] > -51.75
    assert episode(esmini, 20, (300.0, -40.0), {"acceleration": -3.0, "wheel_angle": 0.0}) == straight, "episodes do not depend on earlier ones"


@pytest.mark.parametrize("driver", DRIVERS)
def test_its_drivers_keep_their_lane(esmini: Esmini, driver: str) -> None:
    alone = episode(esmini, 100, (300.0, -20.0), {"acceleration": 0.0, "wheel_angle": 0.0}, driver)
    assert alone[-1]["ego"]["x"] == pytest.approx(190.0, abs=1.0) and alone[-1]["ego"]["y"] == pytest.approx(-51.75, abs=0.05)
    met = episode(esmini, 100, (186.0, -47.5), {"acceleration": 0.0, "wheel_angle": 0.0}, driver)
    if driver == "ReferenceDriver":
        assert met[-1]["ego"]["speed"] < alone[-1]["ego"]["speed"] - 0.3, "it slows down for a person who steps into its lane"


#: What a library of esmini with 32-bit numbers does with a place.
OLD = """
#include <string.h>
static float place[4];
int SE_ReportObjectPosXYH(int id, float time, float x, float y, float h) { place[0] = x; place[1] = y; place[2] = h; return id < 0; }
int SE_GetObjectState(int id, char *state) { double seen[6] = {0, place[0], place[1], 0, place[2], 0}; memcpy(state + 16, seen, sizeof seen); return id < 0; }
"""


def test_a_library_of_other_signatures_is_refused(tmp_path: Path) -> None:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    rest = [name for name in FUNCTIONS if name not in ("SE_ReportObjectPosXYH", "SE_GetObjectState")]
    text = OLD + "".join(f"int {name}() {{ return 0; }}\n" for name in rest)
    source, library = tmp_path / "old.c", tmp_path / "libesminiLib.so"
    source.write_text(text)
    subprocess.run([compiler, "-shared", "-fPIC", "-w", "-o", library, source], check=True)
    bridge = world([f"library={library}"])
    with pytest.raises(SystemExit, match="other C signatures"):
        bridge.load(LOAD)
    bridge.folder.cleanup()
    source.write_text(OLD)
    subprocess.run([compiler, "-shared", "-fPIC", "-w", "-o", tmp_path / "older.so", source], check=True)
    with pytest.raises(SystemExit, match="has no function SE_"):
        world([f"library={tmp_path / 'older.so'}"])
