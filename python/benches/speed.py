"""Speed of the environments: decisions and ticks a second of CPU time, all ways of stepping in one run.

    python python/benches/speed.py [WORLDS] [SECONDS] [REPETITIONS] [--loop PATH]

All step the worlds of one scenario with one array of actions. The bare library is a plain loop in Rust (``tests/bench/worlds.rs``), which cargo
builds as ``maturin build --release`` builds the wheel; PATH names it if it is built. Every other interface has a process of its own. The repetitions go
round the interfaces, so that all of them see the same load of the machine; the table has medians. CPU time is that of a process and its workers.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

import falsify_av
from falsify_av.scenarios import PAPER

REPOSITORY = Path(__file__).resolve().parents[2]
TICKS_A_SECOND = os.sysconf("SC_CLK_TCK")


def cpu_of(process):
    """The parent of a process, and its CPU time (s)."""
    with open(f"/proc/{process}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return int(fields[1]), (int(fields[11]) + int(fields[12])) / TICKS_A_SECOND


def cpu():
    """CPU time of this process and of its living workers (s)."""
    total = time.process_time()
    for process in filter(str.isdigit, os.listdir("/proc")):
        try:
            parent, spent = cpu_of(process)
        except OSError:
            continue
        if parent == os.getpid():
            total += spent
    return total


def actions(worlds):
    """The action of each world, the same in every decision."""
    space = falsify_av.make().action_space
    return np.random.default_rng(0).uniform(space.low, space.high, (worlds, *space.shape)).astype(np.float32)


def gymnasium_vector(worlds):
    env = falsify_av.make_vec(num_envs=worlds)
    env.reset(seed=1)
    return env


def sb3_vector(worlds):
    from falsify_av import sb3

    env = sb3.make_vec(num_envs=worlds)
    env.reset()
    return env


def singles(kind, worlds, **options):
    """Single environments in a vector of stable-baselines3; world *i* has the seed 1 + *i*, as in all other interfaces."""
    from stable_baselines3.common import vec_env

    env = getattr(vec_env, kind)([partial(falsify_av.make, seed=1 + world) for world in range(worlds)], **options)
    env.reset()
    return env


INTERFACES = {
    "falsify_av.make_vec": gymnasium_vector,
    "falsify_av.sb3.make_vec": sb3_vector,
    "DummyVecEnv": partial(singles, "DummyVecEnv"),
    # Forked workers share the memory of the imports: 256 of them fit.
    "SubprocVecEnv": partial(singles, "SubprocVecEnv", start_method="fork"),
}


def serve(interface, worlds):
    """Measures for each line of the input, which has the seconds of a repetition."""
    given = actions(worlds)
    env = INTERFACES[interface](worlds)
    env.step(given)
    print("{}", flush=True)
    for line in sys.stdin:
        decisions, began, clock = 0, cpu(), time.perf_counter()
        while time.perf_counter() - clock < float(line):
            env.step(given)
            decisions += worlds
        print(json.dumps({"decisions": decisions, "cpu_s": cpu() - began}), flush=True)
    env.close()


class Measured:
    """An interface in a process of its own."""

    def __init__(self, interface, worlds):
        command = [sys.executable, __file__, str(worlds), "--serve", interface]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.process.stdout.readline()

    def __call__(self, seconds):
        self.process.stdin.write(f"{seconds}\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def built_loop():
    """The program of the plain loop, which cargo builds."""
    command = ["cargo", "bench", "--no-run", "--locked", "--no-default-features", "--bench", "worlds", "--message-format=json"]
    built = subprocess.run(command, cwd=REPOSITORY, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    messages = [json.loads(line) for line in built]
    return next(each["executable"] for each in messages if each.get("target", {}).get("name") == "worlds" and each.get("executable"))


def measure(options):
    import importlib.util

    names = list(INTERFACES)
    if importlib.util.find_spec("stable_baselines3") is None:
        print("SKIPPED: stable-baselines3 is not installed")
        names = names[:1]
    program = options.loop or built_loop()
    hold = falsify_av.make().core.timing[1]
    with tempfile.NamedTemporaryFile(suffix=".f32") as file:
        file.write(actions(options.worlds).astype("<f4").tobytes())
        file.flush()

        def plain_loop(seconds):
            ended = subprocess.run([program, str(PAPER), str(options.worlds), str(seconds), file.name], check=True, stdout=subprocess.PIPE)
            return json.loads(ended.stdout)

        measured = {"plain loop in Rust": plain_loop, **{name: Measured(name, options.worlds) for name in names}}
        rates = {name: [] for name in measured}
        for _ in range(options.repetitions):
            for name, act in measured.items():
                found = act(options.seconds)
                rates[name].append(found["decisions"] / found["cpu_s"])
    for name in names:
        measured[name].close()
    bare, *_ = medians = [statistics.median(each) for each in rates.values()]
    print(f"| {options.worlds} worlds | decisions a CPU second | ticks a CPU second | share of the plain loop | least to greatest share |")
    print("|---|---|---|---|---|")
    for (name, each), median in zip(rates.items(), medians):
        shares = [rate / other for rate, other in zip(each, next(iter(rates.values())))]
        print(f"| {name} | {median:,.0f} | {median * hold:,.0f} | {median / bare:.2f} | {min(shares):.2f} to {max(shares):.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("worlds", type=int, nargs="?", default=256)
    parser.add_argument("seconds", type=float, nargs="?", default=5.0)
    parser.add_argument("repetitions", type=int, nargs="?", default=5)
    parser.add_argument("--loop", help="the plain loop, if it is built")
    parser.add_argument("--serve", choices=INTERFACES, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        serve(options.serve, options.worlds)
    else:
        measure(options)


if __name__ == "__main__":
    main()
