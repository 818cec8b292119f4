"""Decisions a CPU second of whole trainings: ours and stable-baselines3's PPO, with the same worlds and settings, one thread each.

    python python/benches/learners.py FALSIFY [WIDTH ...] [--decisions N] [--repetitions N]

FALSIFY is the program. Both train ``pursuer`` against ``behavior`` in the harbour: 16 environments, 128 decisions each an update, minibatches of 256, 8
epochs, two hidden layers of WIDTH. stable-baselines3 steps the same worlds through ``falsify_av.sb3.make_vec``. The CPU time is what 5 N decisions take beyond
N (start, compilation and evaluation fall out). The repetitions take turns.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

SCENARIO = """edition 1
import "std/pedestrians.scn"
import "std/rewards.scn"
import "std/drivers.scn"
import "std/towns.scn"
spawn ahead_of_a_moving_car {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }}
episode until_passed {{ tick: 0.05 s  hold: 10  ticks: 240  end_when: ahead < -6 m }}
training t = ppo(
  steps: {steps}, environments: 16, steps_per_update: 128, batch_size: 256, epochs: 8, hidden: [{width}, {width}],
  learning_rate_schedule: linear, normalize_observations: true{more}
)
campaign c {{
  vehicle: model3  body: pursuer  spawn: ahead_of_a_moving_car  episode: until_passed
  training: t
  train {{ towns: [harbour]  drivers: [behavior]  rewards: [fault_led]  runs: 1 }}
  evaluate {{ towns: [harbour]  drivers: [behavior]  pedestrians: [trained]  episodes: 2 }}
}}
"""


def child(command, **options):
    """CPU time of a finished child (s)."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def ours(program, width, steps, folder, more=""):
    scenario = folder / "c.scn"
    scenario.write_text(SCENARIO.format(steps=steps, width=width, more=more))
    return child([program, "run", str(scenario), "--threads", "1", "--formats", "csv", "--out", str(folder / "out"), "--replace"])


def theirs(width, steps, folder):
    scenario = folder / "c.scn"
    scenario.write_text(SCENARIO.format(steps=steps, width=width, more=""))
    return child([sys.executable, __file__, "--learn", str(scenario), str(width), str(steps)])


def learn(scenario, width, steps):
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecNormalize

    from falsify_av import sb3

    torch.set_num_threads(1)
    env = VecNormalize(sb3.make_vec(scenario, num_envs=16), norm_reward=False)
    policy = {"net_arch": [width, width]}
    settings = {"n_steps": 128, "batch_size": 256, "n_epochs": 8, "gamma": 0.98, "ent_coef": 0.01, "device": "cpu"}
    PPO("MlpPolicy", env, policy_kwargs=policy, learning_rate=lambda left: 3e-4 * left, **settings).learn(steps)


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("program")
    arguments.add_argument("widths", nargs="*", type=int, default=[64, 128, 256])
    arguments.add_argument("--decisions", type=int, default=10_000)
    arguments.add_argument("--repetitions", type=int, default=3)
    options = arguments.parse_args()
    learners = {
        "falsify": lambda *given: ours(options.program, *given),
        "falsify, starts: 1_000": lambda *given: ours(options.program, *given, ", starts: 1_000"),
        "stable-baselines3": theirs,
    }
    print(f"{'width':>6} {'learner':>24} {'decisions / CPU s':>18}  of {options.repetitions} repetitions")
    for width in options.widths or [64, 128, 256]:
        rates = {name: [] for name in learners}
        for _ in range(options.repetitions):
            for name, train in learners.items():
                with tempfile.TemporaryDirectory() as folder:
                    few = train(width, options.decisions, Path(folder))
                    many = train(width, 5 * options.decisions, Path(folder))
                rates[name].append(4 * options.decisions / (many - few))
        for name, found in rates.items():
            print(f"{width:6} {name:>24} {statistics.median(found):18,.0f}  {min(found):,.0f} to {max(found):,.0f}", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--learn"]:
        learn(sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
    else:
        main()
