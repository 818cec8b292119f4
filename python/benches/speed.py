"""Speed of the environments: decisions and ticks a second of CPU time, all ways of stepping in one run.

    python python/benches/speed.py [WORLDS] [SECONDS]

The bare library is a plain loop in Rust over the same scenario, seeds and actions (``tests/bench/worlds.rs``), built by cargo as the wheel is by
``maturin build --release``. CPU time is that of the process and, for ``SubprocVecEnv``, of its children.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np

import falsify_av
from falsify_av.scenarios import PAPER

REPOSITORY = Path(__file__).resolve().parents[2]


def cpu(who=resource.RUSAGE_SELF):
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime


def children():
    """CPU time of the living children (s)."""
    ticks = os.sysconf("SC_CLK_TCK")
    total = 0.0
    for entry in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{entry}/stat") as file:
                fields = file.read().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == os.getpid() or parent_of(fields[1]) == os.getpid():
            total += (int(fields[11]) + int(fields[12])) / ticks
    return total


def parent_of(process):
    """The parent of a process; workers are children of the fork server."""
    try:
        with open(f"/proc/{process}/stat") as file:
            return int(file.read().rsplit(")", 1)[1].split()[1])
    except OSError:
        return -1


def measure(name, worlds, hold, seconds, step, spent=cpu):
    step()
    decisions, began, clock = 0, spent(), time.perf_counter()
    while time.perf_counter() - clock < seconds:
        step()
        decisions += worlds
    used, wall = spent() - began, time.perf_counter() - clock
    rate = decisions / used
    print(f"{name:32} {worlds:5} worlds {rate:12,.0f} decisions {rate * hold:13,.0f} ticks a CPU second {decisions / wall * hold:13,.0f} ticks a second")
    return rate


def library(worlds, seconds, actions):
    """The rate of the library alone (decisions a CPU second)."""
    with tempfile.NamedTemporaryFile(suffix=".f32") as file:
        file.write(actions.astype("<f4").tobytes())
        file.flush()
        command = ["cargo", "bench", "-q", "--locked", "--no-default-features", "--bench", "worlds", "--"]
        command += [str(PAPER), str(worlds), str(seconds), file.name]
        ended = subprocess.run(command, cwd=REPOSITORY, check=True, stdout=subprocess.PIPE, text=True)
    found = json.loads(ended.stdout)
    return found["decisions"] / found["cpu_s"]


def main():
    worlds = int(sys.argv[1]) if len(sys.argv) > 1 else 256
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 10.0
    env = falsify_av.make_vec(num_envs=worlds)
    _, hold, _ = env.core.timing
    generator = np.random.default_rng(0)
    low, high = env.single_action_space.low, env.single_action_space.high
    actions = generator.uniform(low, high, (worlds, 2)).astype(np.float32)
    bare = library(worlds, seconds, actions)
    print(f"{'bare library':32} {worlds:5} worlds {bare:12,.0f} decisions {bare * hold:13,.0f} ticks a CPU second")

    def share(rate):
        print(f"{'':32} {rate / bare:.2f} of the bare library", flush=True)

    env.reset(seed=1)
    share(measure("falsify_av.make_vec", worlds, hold, seconds, lambda: env.step(actions)))
    try:
        from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv

        from falsify_av import sb3
    except ImportError:
        print("SKIPPED: stable-baselines3 is not installed")
        return
    ours = sb3.make_vec(num_envs=worlds)
    ours.reset()
    share(measure("falsify_av.sb3.make_vec", worlds, hold, seconds, lambda: ours.step(actions)))
    dummy = DummyVecEnv([partial(falsify_av.make, seed=1 + world) for world in range(worlds)])
    dummy.reset()
    share(measure("DummyVecEnv", worlds, hold, seconds, lambda: dummy.step(actions)))
    # A process for each world; a few are enough for its rate a CPU second.
    few = min(worlds, 8)
    processes = SubprocVecEnv([partial(falsify_av.make, seed=1 + world) for world in range(few)])
    processes.reset()
    share(measure("SubprocVecEnv", few, hold, seconds, lambda: processes.step(actions[:few]), lambda: cpu() + children()))
    processes.close()


if __name__ == "__main__":
    main()
