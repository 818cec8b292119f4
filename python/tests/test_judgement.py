"""Verdicts of recordings."""

import math

import numpy as np
import pytest

import falsify_av

DT = 0.05


def crossing(speed, distance, walking=1.4, dt=DT):
    """A car that drives east at a constant speed, and a pedestrian that crosses its axis this far ahead when the car's middle arrives."""
    arrives = distance / speed
    times = np.arange(0.0, arrives + 1.0, dt)
    still = 0 * times
    ego = np.stack([speed * times, still, still, still + speed], axis=1)
    return ego, np.stack([still + distance, (times - arrives) * walking], axis=1)


def episodes(scenario, count, **choice):
    """Tracks and infos of some episodes of a pedestrian that walks at random."""
    env = falsify_av.make(scenario, task="train", **choice)
    numbers = np.random.default_rng(4)
    for episode in range(count):
        env.reset(seed=2, options={"episode": episode})
        over = False
        while not over:
            to_car = env.suggested("homing") + numbers.normal(0, [0.6, 0.8])
            *_, terminated, truncated, info = env.step(to_car)
            over = terminated or truncated
        trace = env.trace()
        ego = np.stack([trace[f"ego_{name}"] for name in ("x_m", "y_m", "yaw_rad", "speed_mps")], axis=1)
        walked = np.stack([trace[f"pedestrian_{name}"][:, 0] for name in ("x_m", "y_m", "yaw_rad", "speed_mps")], axis=1)
        yield ego, walked, info


@pytest.mark.parametrize("driver", ["behavior", "blind"])
@pytest.mark.parametrize("town", ["harbour", "village"])
def test_an_episode_of_ours_has_its_own_verdict(scenario, town, driver):
    choice = {"campaign": "short", "town": town, "driver": driver}
    verdicts, same = set(), []
    for ego, walked, info in episodes(scenario, 30, **choice):
        if info["outcome"] not in ("collision", "bump", "timeout", "lost"):
            continue
        found = falsify_av.judge(ego, walked, DT, scenario=scenario, task="train", **choice)
        for name in ("verdict", "foreseeable", "fault"):
            assert found[name] == info[name], (name, found, info)
        assert math.isnan(found["touch_s"]) == (info["outcome"] not in ("collision", "bump"))
        if info["outcome"] in ("collision", "bump"):
            for name in ("warning_s", "impact_speed_mps"):
                assert found[name] == pytest.approx(info[name], abs=1e-9), name
            assert found["touch_s"] == pytest.approx(info["episode_length_s"], abs=1e-9)
        else:
            # Between two ticks they come nearer by half the way of both at most.
            between = DT / 2 * (ego[:, 3].max() + walked[:, 3].max())
            assert found["least_gap_m"] >= info["least_gap_m"] - between - 1e-9
        verdicts.add(info["verdict"])
        # Without its velocities the pedestrian does not stand at the start, which matters to few short encounters.
        positions = falsify_av.judge(ego, walked[:, :2], DT, scenario=scenario, task="train", **choice)
        same.append(positions["verdict"] == info["verdict"])
    assert len(verdicts) >= 3 and np.mean(same) >= 0.9, (verdicts, same)


def test_avoidable_and_unavoidable_crossings():
    visible = falsify_av.judge(*crossing(8.0, 40.0), DT)
    assert visible["verdict"] == "preventable" and visible["avoided_by"]["cc"] and visible["avoided_by"]["bound"]
    assert visible["foreseeable"] and visible["fault"]
    # The bumper is 2.395 m ahead of the middle.
    assert visible["impact_speed_mps"] == pytest.approx(8.0) and visible["touch_s"] == pytest.approx((40 - 2.395) / 8, abs=0.05)
    sudden = falsify_av.judge(*crossing(14.0, 8.0, walking=3.0), DT)
    assert sudden["verdict"] == "cannot_tell" and sudden["begins_late_s"] > 2.0, "it begins half a second before the touch"
    assert sudden["avoided_by"] == {} and sudden["counts_as"] == "" and visible["counts_as"] == "fault"


def test_boxes_hide_the_pedestrian():
    ego, pedestrian = crossing(8.0, 40.0, walking=2.0)
    wall = [(19.0, -2.0, 0.0, 40.0, 0.4)]
    free, hidden = falsify_av.judge(ego, pedestrian, DT), falsify_av.judge(ego, pedestrian, DT, boxes=wall)
    assert free["verdict"] == "preventable" and hidden["warning_s"] < free["warning_s"] - 0.2


@pytest.mark.parametrize("turn", [0.7, 2.0, -2.6])
def test_verdicts_do_not_depend_on_the_frame(turn):
    ego, pedestrian = crossing(9.0, 30.0)
    cos, sin = math.cos(turn), math.sin(turn)
    turned = np.array([[cos, sin], [-sin, cos]])
    other = np.concatenate([ego[:, :2] @ turned + [300.0, -20.0], ego[:, 2:] + [turn, 0.0]], axis=1)
    one, two = falsify_av.judge(ego, pedestrian, DT), falsify_av.judge(other, pedestrian @ turned + [300.0, -20.0], DT)
    assert one["verdict"] == two["verdict"] and one["touch_s"] == pytest.approx(two["touch_s"], abs=1e-6)


@pytest.mark.parametrize("dt", [0.01, 0.1, 0.2])
def test_recordings_of_other_rates_have_the_verdict(dt):
    for speed, distance, walking in [(8.0, 40.0, 1.4), (14.0, 8.0, 3.0), (12.0, 60.0, 1.0)]:
        usual = falsify_av.judge(*crossing(speed, distance, walking), DT)
        other = falsify_av.judge(*crossing(speed, distance, walking, dt), dt)
        assert other["verdict"] == usual["verdict"] and other["touch_s"] == pytest.approx(usual["touch_s"], abs=1e-6)


def test_without_a_touch_there_is_no_verdict():
    ego, pedestrian = crossing(8.0, 40.0)
    found = falsify_av.judge(ego, pedestrian + [0.0, 6.0], DT)
    assert found["verdict"] == "" and math.isnan(found["touch_s"]) and found["least_gap_m"] > 1.0 and found["avoided_by"] == {}
    assert found["pet_s"] > 0.0


def test_sizes_are_those_of_the_user():
    ego, pedestrian = crossing(8.0, 40.0, walking=0.0)
    pedestrian = pedestrian + [0.0, 1.1]
    assert falsify_av.judge(ego, pedestrian, DT)["verdict"] == "preventable"
    assert falsify_av.judge(ego, pedestrian, DT, width=1.6)["verdict"] == ""
    assert falsify_av.judge(ego, pedestrian, DT, width=1.6, radius=0.4)["verdict"] == "preventable"
    later = falsify_av.judge(ego, pedestrian, DT, length=3.0)["touch_s"] - falsify_av.judge(ego, pedestrian, DT, length=5.0)["touch_s"]
    assert later == pytest.approx(1.0 / 8.0, abs=1e-6)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"ego": [[0.0, 0.0, 0.0]] * 3}, "`ego` has 3 columns; give x, y, heading, speed"),
        ({"pedestrian": [[0.0, 0.0]] * 3}, "instants of the car and 3 of the pedestrian"),
        ({"ego": [[0.0] * 4], "pedestrian": [[0.0, 0.0]]}, "2 to 100000"),
        ({"ego": [[np.nan, 0.0, 0.0, 1.0]] * 120}, r"instant 0: the x of the car \(m\) is NaN"),
        ({"ego": [[0.0, 0.0, 0.0, -200.0]] * 120}, r"instant 0: the speed of the car \(m/s\) is -200"),
        ({"pedestrian": [[0.0, 0.0]] * 60 + [[1e5, 0.0]] * 60}, r"instant 60: the speed of the pedestrian"),
        ({"ego": "a text"}, "no array of numbers"),
        ({"ego": [1.0, 2.0]}, "1 dimensions"),
        ({"dt": 0.0}, "between two instants is 0 s"),
        ({"radius": -1.0}, "`radius` is -1"),
        ({"length": math.nan}, "`length` is NaN"),
        ({"boxes": [[1.0, 2.0]]}, "`boxes` has 2 columns"),
        ({"boxes": [[0.0, 0.0, 0.0, 0.0, 1.0]]}, "row 0 of `boxes`"),
        ({"town": "nowhere"}, "there is no town `nowhere`"),
    ],
)
def test_bad_recordings_are_errors(change, text):
    ego, pedestrian = crossing(8.0, 40.0)
    ego, pedestrian = ego[:120], pedestrian[:120]
    with pytest.raises(ValueError, match=text):
        falsify_av.judge(**{"ego": ego, "pedestrian": pedestrian, "dt": DT, **change})


@pytest.mark.parametrize("speed", [5.0, 10.0, 14.0])
def test_units_that_do_not_fit_are_errors_that_name_the_unit(speed):
    ego, pedestrian = crossing(speed, 40.0)
    assert falsify_av.judge(ego, pedestrian, DT)["verdict"]
    with pytest.raises(ValueError, match="the car moves 0.28 times as far .* the speeds look like km/h; give m/s"):
        falsify_av.judge(ego * [1, 1, 1, 3.6], pedestrian, DT)
    with pytest.raises(ValueError, match="the car moves 10.00 times as far .* an instant would be 0.05 s after the one before"):
        falsify_av.judge(ego, pedestrian, DT / 10)
    # A drive to the north: 90 degrees.
    north, walked = ego[:, [1, 0, 2, 3]] + [0.0, 0.0, 90.0, 0.0], pedestrian[:, [1, 0]]
    with pytest.raises(ValueError, match="the car moves at .* deg from its heading: the numbers look like degrees where radians are needed"):
        falsify_av.judge(north, walked, DT)
    with pytest.raises(ValueError, match="the pedestrian moves .* the speeds look like km/h"):
        velocity = np.full((len(ego), 2), [math.pi / 2, 1.4 * 3.6])
        falsify_av.judge(ego, np.concatenate([pedestrian, velocity], axis=1), DT)


def test_numbers_at_random_never_end_the_interpreter():
    numbers = np.random.default_rng(11)
    touched = refused = 0
    for _ in range(400):
        count = int(numbers.integers(1, 60))
        scale = float(10 ** numbers.uniform(-3, 6))
        ego = numbers.normal(0, scale, (count, 4))
        if numbers.random() < 0.7:
            # A drive whose steps are those of its speed: others are mostly refused.
            ego[:, :2] = np.cumsum(numbers.normal(0, 0.3, (count, 2)), axis=0)
        ego[:, 3] = 10 ** numbers.uniform(-9, 2.2, count)
        # Beside the car, or anywhere near it at each instant: the latter is mostly refused.
        rows = 1 if numbers.random() < 0.5 else count
        walked = ego + numbers.normal(0, 10 ** numbers.uniform(-3, 2), (rows, 4))
        walked[:, 3] = 10 ** numbers.uniform(-9, 2, count)
        dt = float(10 ** numbers.uniform(-3.1, -0.2))
        if numbers.random() < 0.5:
            # Velocities that fit the positions.
            for track in (ego, walked):
                step = np.gradient(track[:, :2], axis=0) if count > 1 else 0 * track[:, :2]
                track[:, 2:] = np.stack([np.arctan2(step[:, 1], step[:, 0]), np.hypot(*step.T) / dt], axis=1)
        boxes = numbers.normal(0, scale, (3, 5))
        boxes[:, 3:] = 10 ** numbers.uniform(-6, 4, (3, 2))
        try:
            found = falsify_av.judge(ego, walked, dt, width=float(10 ** numbers.uniform(-1.1, 2.1)), boxes=boxes)
            touched += found["verdict"] != ""
        except ValueError:
            refused += 1
    assert touched > 50 and 10 < refused < 300, (touched, refused)


REQUIRED = """edition 1
import "std/pedestrians.scn"
import "std/drivers.scn"
import "std/towns.scn"
import keeps_lane from "std/requirements.scn"
requirement slow_pass = always(gap < 1.5 m implies ego_speed < 3 m/s)
spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 30 m }
episode until_passed { ticks: 160  hold: 10  end_when: ahead < -6 m }
campaign mine {
  vehicle: model3  body: plausible  spawn: near  episode: until_passed  requirements: [slow_pass, keeps_lane]
  evaluate { towns: [harbour]  drivers: [blind]  pedestrians: [intercept]  episodes: 40 }
}
"""


def test_the_requirements_of_an_own_episode_have_its_robustness_and_verdict(tmp_path):
    file = tmp_path / "my.scn"
    file.write_text(REQUIRED, encoding="utf-8")
    env = falsify_av.make(file, "mine", seed=3)
    violations = faults = 0
    for episode in range(160):
        env.reset(options={"episode": episode})
        over = False
        while not over:
            _, _, terminated, truncated, info = env.step([0.0, 1.4])
            over = terminated or truncated
        trace = env.trace()
        ego = np.stack([trace[name] for name in ("ego_x_m", "ego_y_m", "ego_yaw_rad", "ego_speed_mps")], axis=1)
        names = ("pedestrian_x_m", "pedestrian_y_m", "pedestrian_yaw_rad", "pedestrian_speed_mps")
        pedestrian = np.stack([trace[name][:, 0] for name in names], axis=1)
        found = falsify_av.judge(ego, pedestrian, DT, scenario=file, campaign="mine")["requirements"]
        assert found["slow_pass"] == info["requirements"]["slow_pass"]
        assert found["keeps_lane"] is None, "a recording has no map"
        assert info["requirements"]["keeps_lane"]["preventable"] is None, "it says nothing of a pedestrian"
        violations += found["slow_pass"]["violated"]
        faults += found["slow_pass"]["fault"] is True
    assert violations > 5 and 0 < faults <= violations, (violations, faults)
