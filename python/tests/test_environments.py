"""The contracts of Gymnasium and of PettingZoo, and the equality of vector and single environments."""

import copy
import pickle
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import falsify_av

CAST = Path(__file__).with_name("cast.scn")
CHOICES = [
    {"campaign": "short", "town": "harbour", "driver": "blind", "task": "train"},
    {"campaign": "steady"},
]


def equal(one, other):
    """Whether two infos are equal: dictionaries, arrays of any kind, not-a-numbers."""
    if isinstance(one, dict):
        return isinstance(other, dict) and one.keys() == other.keys() and all(equal(one[k], other[k]) for k in one)
    if isinstance(one, np.ndarray) and one.dtype == object:
        return one.shape == other.shape and all(equal(a, b) for a, b in zip(one, other))
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return one == other or (one != one and other != other)


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: choice["campaign"])
def test_gymnasium_finds_nothing_wrong(scenario, choice):
    check_env(falsify_av.make(scenario, render_mode="rgb_array", **choice))


def test_registered_names_make_single_and_vector_environments(scenario):
    env = gymnasium.make("falsify_av/Pedestrian-v0", scenario=scenario, **CHOICES[0])
    observation, _ = env.reset(seed=5)
    vector = gymnasium.make_vec(
        "falsify_av/Pedestrian-v0", 3, "vector_entry_point", scenario=scenario, **CHOICES[0]
    )
    observations, _ = vector.reset(seed=5)
    assert np.array_equal(observation, observations[0])
    assert not np.array_equal(observations[0], observations[1])


def test_the_paper_needs_no_file():
    env = falsify_av.make()
    assert env.core.names == ("pedestrian", "harbour", "behavior", "r2")


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: choice["campaign"])
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_a_vector_environment_equals_single_ones_bit_for_bit(scenario, mode, choice):
    worlds = 5
    single = SyncVectorEnv([lambda: falsify_av.make(scenario, **choice)] * worlds, autoreset_mode=mode)
    vector = falsify_av.make_vec(scenario, worlds, autoreset_mode=mode, **choice)
    assert single.single_action_space == vector.single_action_space
    assert single.observation_space == vector.observation_space
    first, second = single.reset(seed=11), vector.reset(seed=11)
    assert np.array_equal(first[0], second[0]) and equal(first[1], second[1])
    generator = np.random.default_rng(1)
    space, ends = vector.single_action_space, 0
    for _ in range(200):
        actions = generator.uniform(space.low, space.high, (worlds, 2)).astype(np.float32)
        first, second = single.step(actions), vector.step(actions)
        for one, other in zip(first[:4], second[:4]):
            assert one.dtype == other.dtype and np.array_equal(one, other)
        assert equal(first[4], second[4]), (first[4], second[4])
        ends += int((first[2] | first[3]).sum())
    assert ends > 2 * worlds


def test_arrays_of_two_steps_are_different_objects(scenario):
    env = falsify_av.make_vec(scenario, 2, **CHOICES[0])
    before, _ = env.reset(seed=1)
    kept = before.copy()
    after = env.step(env.action_space.sample())[0]
    assert not np.shares_memory(before, after) and np.array_equal(before, kept)


def test_an_episode_has_the_same_start_whatever_was_run_before(scenario):
    env = falsify_av.make(scenario, **CHOICES[0])
    env.reset(seed=4)
    env.step(env.action_space.sample())
    third, info = env.reset(options={"episode": 2})
    assert info == {"seed": 4, "episode_number": 2, "run_up_ticks": 0, "placed": False}
    assert env.reset()[1]["episode_number"] == 3
    again, _ = falsify_av.make(scenario, seed=4, **CHOICES[0]).reset(options={"episode": 2})
    assert np.array_equal(third, again)


def test_the_end_of_an_episode_has_a_verdict(scenario):
    env = falsify_av.make(scenario, campaign="short", town="harbour", driver="blind", task="train")
    labels = set()
    for episode in range(30):
        env.reset(seed=0, options={"episode": episode})
        over = False
        while not over:
            _, reward, terminated, truncated, info = env.step(env.suggested("intercept"))
            over = terminated or truncated
        assert info["is_success"] == (info["outcome"] == "collision")
        assert (info["outcome"] in ("collision", "bump")) == (info["verdict"] != "") == terminated
        assert info["ticks"] + 1 == len(env.trace()["time_s"])
        if info["is_success"]:
            assert reward > 0 and info["verdict"] in env.core.labels()
        labels.add(info["verdict"])
    assert "" in labels and len(labels) > 2, labels


def test_pictures_show_the_car_and_the_pedestrian(scenario):
    env = falsify_av.make(scenario, render_mode="rgb_array", **CHOICES[0])
    env.reset(seed=0)
    picture = env.render()
    assert picture.shape == (256, 256, 3) and picture.dtype == np.uint8
    colours = {tuple(colour) for colour in picture.reshape(-1, 3).tolist()}
    assert {(34, 86, 196), (214, 48, 48), (120, 124, 130)} <= colours


def test_pettingzoo_finds_nothing_wrong(scenario):
    pytest.importorskip("pettingzoo")
    from pettingzoo.test import parallel_api_test, parallel_seed_test

    from falsify_av.pettingzoo import parallel_env

    parallel_api_test(parallel_env(scenario, **CHOICES[0]), num_cycles=300)
    parallel_seed_test(lambda: parallel_env(scenario, **CHOICES[0]), num_cycles=30)


def test_the_pedestrians_of_a_cast_are_agents_with_the_names_of_their_roles():
    pytest.importorskip("pettingzoo")
    from pettingzoo.test import parallel_api_test, parallel_seed_test

    from falsify_av.pettingzoo import parallel_env

    env = parallel_env(CAST)
    assert env.possible_agents == ["child_0", "group_0", "group_1"]
    assert [env.observation_space(agent).shape for agent in env.possible_agents] == [(20,), (20,), (20,)]
    parallel_api_test(env, num_cycles=300)
    parallel_seed_test(lambda: parallel_env(CAST), num_cycles=30)
    observations, _ = env.reset(seed=3)
    # The friend, who walks alone, is half a metre away at most; 0.4 m are the two bodies.
    present, is_vehicle, ahead, left = observations["child_0"][12:16]
    assert (present, is_vehicle) == (1, 0) and np.hypot(ahead, left) < 1.3


def test_the_space_of_states_with_road_rays_and_others_holds_them():
    check_env(falsify_av.make(CAST), skip_render_check=True)


def test_statistics_of_others_keep_their_key(scenario):
    """Gymnasium owns `info["episode"]`: scripts of CleanRL and others read returns and lengths there."""
    import gymnasium as gym

    wrapped = gym.wrappers.RecordEpisodeStatistics(falsify_av.make(scenario, **CHOICES[0]))
    plain = falsify_av.make(scenario, **CHOICES[0])
    wrapped.reset(seed=1), plain.reset(seed=1)
    total, over = 0.0, False
    while not over:
        _, reward, terminated, truncated, info = wrapped.step(np.zeros(2, np.float32))
        total += reward
        *_, expected = plain.step(np.zeros(2, np.float32))
        over = terminated or truncated
    assert info.pop("episode")["r"] == pytest.approx(total) and equal(info, expected) and info["episode_number"] == 0


@pytest.mark.parametrize("mode", ["next_step", "same_step"])
def test_a_training_loop_of_others_reads_returns_of_a_vector(scenario, mode):
    import gymnasium as gym
    from gymnasium.vector import AutoresetMode, SyncVectorEnv
    from gymnasium.wrappers.vector import RecordEpisodeStatistics

    mode = AutoresetMode.NEXT_STEP if mode == "next_step" else AutoresetMode.SAME_STEP
    ours = RecordEpisodeStatistics(falsify_av.make_vec(scenario, 3, autoreset_mode=mode, **CHOICES[0]))
    theirs = SyncVectorEnv(
        [lambda: gym.wrappers.RecordEpisodeStatistics(falsify_av.make(scenario, **CHOICES[0]))] * 3, autoreset_mode=mode
    )
    for env in (ours, theirs):
        env.reset(seed=4)
        returns = []
        for _ in range(200):
            *_, infos = env.step(np.zeros((3, 2), np.float32))
            # The two forms in which scripts of CleanRL read them.
            final = infos.get("final_info", infos)
            if "episode" in infos:
                returns.extend(np.asarray(infos["episode"]["r"])[infos["_episode"]])
            elif "episode" in final:
                returns.extend(np.asarray(final["episode"]["r"])[final["_episode"]])
        assert len(returns) > 3 and np.isfinite(returns).all()


class Stop:
    """A driver that can be pickled."""

    def drive(self, world):
        return {"brake": 1.0}


def test_a_copy_of_an_environment_begins_as_it_did(scenario):
    options = {"render_mode": "rgb_array", "seed": 3, "own_driver": Stop, **CHOICES[0]}
    for env in (falsify_av.make(scenario, **options), falsify_av.make_vec(scenario, 3, autoreset_mode=AutoresetMode.SAME_STEP, **options)):
        first, info = env.reset()
        env.step(env.action_space.sample())
        for again in (pickle.loads(pickle.dumps(env)), copy.deepcopy(env), copy.copy(env)):
            assert type(again) is type(env) and again.core is not env.core and again.metadata == env.metadata
            assert again.render_mode == "rgb_array" and again.observation_space == env.observation_space
            states, other = again.reset()
            assert np.array_equal(first, states) and equal(info, other), "an episode under way is not kept"
        env.close()
        assert pickle.loads(pickle.dumps(env)).reset()[0].shape == first.shape, "a copy is open"


def test_a_copy_of_a_registered_environment_knows_its_name(scenario):
    env = gymnasium.make("falsify_av/Pedestrian-v0", scenario=scenario, **CHOICES[0])
    again = pickle.loads(pickle.dumps(env))
    assert again.spec.id == "falsify_av/Pedestrian-v0" and np.array_equal(env.reset()[0], again.reset()[0])


def test_environments_of_other_libraries_are_copied_as_well(scenario):
    pytest.importorskip("pettingzoo")
    from falsify_av.pettingzoo import parallel_env

    env = parallel_env(CAST, seed=2)
    again = pickle.loads(pickle.dumps(env))
    assert again.possible_agents == env.possible_agents
    one, other = env.reset()[0], again.reset()[0]
    assert all(np.array_equal(one[agent], other[agent]) for agent in env.possible_agents)


def test_a_driver_that_cannot_be_pickled_is_said(scenario):
    env = falsify_av.make(scenario, own_driver=lambda: Stop(), **CHOICES[0])
    with pytest.raises((pickle.PicklingError, AttributeError), match="lambda"):
        pickle.dumps(env)
