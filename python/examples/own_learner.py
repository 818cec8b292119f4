"""Another learner in the place of the built-in one: PPO or SAC of stable-baselines3 on the environments of this package.

    python own_learner.py --algorithm ppo --decisions 20000 --runs 10 [--ours]

Every run trains with a seed of its own and is then evaluated in the same 200 episodes. ``--ours`` also trains the built-in learner
(`own_learner.scn`, with the program `falsify`) and prints the difference of the mean collision rates with Welch's 95 % interval.
It needs ``pip install falsify-av[sb3]``, and ``--ours`` also ``pip install falsify-av[tables] scipy`` and the program.
"""

import argparse
import json
import math
import os
import statistics
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import torch
from stable_baselines3 import PPO, SAC

import falsify_av
from falsify_av import sb3

EPISODES = 200
SCENARIO = Path(__file__).with_name("own_learner.scn")


def ppo(env, seed):
    """PPO with Table I of "Suicidal Pedestrian" (ITSC 2023): one environment, 150 decisions an update."""
    return PPO(
        "MlpPolicy", env, seed=seed, device="cpu", learning_rate=3e-4, n_steps=150, batch_size=64, n_epochs=10, gamma=0.98,
        gae_lambda=0.95, clip_range=0.2, vf_coef=0.5, ent_coef=0.01,
    )


def sac(env, seed):
    """SAC with the paper's discount, networks as wide as PPO's, and a gradient step for each decision."""
    return SAC(
        "MlpPolicy", env, seed=seed, device="cpu", gamma=0.98, learning_rate=1e-3, learning_starts=1000, batch_size=128,
        gradient_steps=-1, policy_kwargs={"net_arch": [64, 64]},
    )


#: The maker of each learner, its number of worlds, and its campaign.
LEARNERS = {"ppo": (ppo, 1, "own_learner"), "sac": (sac, 4, "scaled")}


def train_and_evaluate(algorithm, seed, decisions):
    """The collision rate of a training with this seed, and its CPU time (s)."""
    make, worlds, campaign = LEARNERS[algorithm]
    choice = {"campaign": campaign, "task": "train"}
    # Episodes of other seeds than the one that pedestrians are evaluated with.
    env = sb3.make_vec(SCENARIO, worlds, seed=1000 + worlds * seed, **choice)
    began = time.process_time()
    model = make(env, seed).learn(decisions)
    spent = time.process_time() - began

    def act(states):
        return model.predict(states, deterministic=True)[0]

    rows = falsify_av.evaluate(act, SCENARIO, episodes=EPISODES, seed=1, **choice)
    return statistics.fmean(row["is_success"] for row in rows), spent


def built_in(decisions, runs):
    """The collision rates of the built-in learner's runs."""
    with tempfile.TemporaryDirectory() as folder:
        report = falsify_av.program.run(SCENARIO, out=folder, settings={"decisions": decisions}, show=True)
        table = next(iter(report.values())).table("metrics").to_pylist()
    trained = next(row for row in table if row["metric"] == "collision_rate" and row["pedestrian"] == "trained")
    return [float(rate) for rate in trained["by_run"].split()][:runs]


def interval(one, other):
    """The difference of the means with Welch's 95 % interval."""
    from scipy import stats

    parts = [statistics.variance(side) / len(side) for side in (one, other)]
    freedom = sum(parts) ** 2 / sum(part**2 / (len(side) - 1) for part, side in zip(parts, (one, other)))
    half = float(stats.t.ppf(0.975, freedom)) * math.sqrt(sum(parts))
    difference = statistics.fmean(one) - statistics.fmean(other)
    return difference, difference - half, difference + half


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--algorithm", choices=LEARNERS, default="ppo")
    parser.add_argument("--decisions", type=int, default=20_000)
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--ours", action="store_true", help="also train the built-in learner")
    options = parser.parse_args()
    torch.set_num_threads(1)
    if options.runs < 2:
        parser.error("an interval needs at least two runs")
    if options.ours:
        missing = [name for name in ("pyarrow", "scipy") if find_spec(name) is None]
        if missing:
            parser.error(f"--ours needs {' and '.join(missing)}: pip install {' '.join(missing)}")
        falsify_av.program.find()
    rates = []
    for seed in range(options.runs):
        rate, spent = train_and_evaluate(options.algorithm, seed, options.decisions)
        rates.append(rate)
        print(json.dumps({"run": seed, "collision_rate": rate, "cpu_s": round(spent, 1)}), flush=True)
    print(f"{options.algorithm}: {statistics.fmean(rates):.3f} ± {statistics.stdev(rates):.3f} over {len(rates)} runs")
    if options.ours:
        ours = built_in(options.decisions, options.runs)
        print(f"built-in: {statistics.fmean(ours):.3f} ± {statistics.stdev(ours):.3f} over {len(ours)} runs {ours}")
        difference, low, high = interval(rates, ours)
        print(f"difference {difference:+.3f}, 95 % interval {low:+.3f} to {high:+.3f}")


if __name__ == "__main__":
    main()
