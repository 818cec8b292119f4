"""The contracts of stable-baselines3. They need torch, which is large; without it the tests are reported as skipped."""

import numpy as np
import pytest

import falsify_av

pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed")

from stable_baselines3 import PPO  # noqa: E402
from stable_baselines3.common.env_checker import check_env  # noqa: E402
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor  # noqa: E402

from falsify_av import sb3  # noqa: E402

CHOICE = {"campaign": "short", "town": "harbour", "driver": "blind", "task": "train"}


@pytest.mark.parametrize("choice", [CHOICE, {"campaign": "steady"}], ids=["natural", "scaled"])
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_stable_baselines3_finds_nothing_wrong(scenario, choice):
    check_env(falsify_av.make(scenario, **choice))


def test_the_vec_env_equals_single_ones_bit_for_bit(scenario):
    worlds = 4
    single = DummyVecEnv([lambda: falsify_av.make(scenario, **CHOICE)] * worlds)
    vector = sb3.make_vec(scenario, worlds, **CHOICE)
    single.seed(3)
    vector.seed(3)
    assert np.array_equal(single.reset(), vector.reset())
    assert single.reset_infos == vector.reset_infos
    generator, ends = np.random.default_rng(0), 0
    for _ in range(150):
        actions = generator.uniform(vector.action_space.low, vector.action_space.high, (worlds, 2)).astype(np.float32)
        one, other = single.step(actions), vector.step(actions)
        for a, b in zip(one[:3], other[:3]):
            assert a.dtype == b.dtype and np.array_equal(a, b)
        for a, b in zip(one[3], other[3]):
            if not b:
                # DummyVecEnv writes this key at every step.
                assert a == {"TimeLimit.truncated": False}
                continue
            ends += 1
            assert np.array_equal(a["terminal_observation"], b["terminal_observation"])
            for key in ("TimeLimit.truncated", "digest", "outcome", "verdict", "is_success"):
                assert a[key] == b[key]
            assert b["episode"]["r"] == a["episode_reward"] and a["episode_number"] == b["episode_number"]
    assert ends > 10


def test_ppo_trains_on_it_and_monitors_take_it(scenario):
    env = VecMonitor(sb3.make_vec(scenario, 8, **CHOICE))
    model = PPO("MlpPolicy", env, n_steps=32, batch_size=64, n_epochs=2, seed=1, device="cpu").learn(512)
    assert len(model.ep_info_buffer) > 0
    assert all(np.isfinite(each["r"]) for each in model.ep_info_buffer)


def test_a_closed_vec_env_says_so(scenario):
    env = sb3.make_vec(scenario, 2, **CHOICE)
    with pytest.raises(RuntimeError, match="step_async"):
        env.step_wait()
    with pytest.raises(AttributeError, match="no attributes of their own"):
        env.set_attr("x", 1)
    env.reset()
    assert len(env.env_method("trace", indices=[1])) == 1
    env.close()
    with pytest.raises(RuntimeError, match="closed"):
        env.reset()


def test_ppo_trains_on_worlds_without_a_monitor(scenario):
    env = DummyVecEnv([lambda: falsify_av.make(scenario, **CHOICE)] * 2)
    PPO("MlpPolicy", env, n_steps=64, batch_size=64, n_epochs=1, seed=1, device="cpu").learn(256)
