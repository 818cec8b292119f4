"""Times the paper's training here and with stable-baselines3, one after the other on the same machine.

    python measure.py --world-dir DIR [--repeat 2] [--ours "cargo bench --bench reference_world"] --out result.json

DIR holds `ped_env.py` and `train_sb3.py`, the reference world and its training with stable-baselines3 (one torch thread,
one environment: its fastest setting for a single environment).  Both learners train on the straight road with the paper's
settings, 150 decisions and 30 gradient steps an update; nobody evaluates anything.  Ours takes 70,000 decisions, the other
`--steps`; what is reported is CPU seconds for 70,000 decisions.  CPU seconds, not those on the clock, so that other work on the
machine disturbs less; imports do not count.  The ratio is that of the medians.
"""
import argparse, json, os, pathlib, platform, shlex, statistics, subprocess, sys

p = argparse.ArgumentParser()
p.add_argument("--world-dir", required=True)
p.add_argument("--repeat", type=int, default=2)
p.add_argument("--ours", default="cargo bench --bench reference_world")
p.add_argument("--steps", type=int, default=70000, help="decisions of the other learner")
p.add_argument("--out", default="")
a = p.parse_args()

WORLD = ["--obs", "raw", "--act", "raw", "--end", "lost", "--reward", "R2", "--world", "straight"]
PARTS = ["rollout_cpu_s", "update_cpu_s"]
package = pathlib.Path(__file__).resolve().parents[3]


def json_lines(command, **options):
    text = subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE, **options).stdout
    rows = [json.loads(line) for line in text.splitlines() if line.startswith("{")]
    return [{part: row[part] * 70000 / row["steps"] for part in PARTS} for row in rows]


def ours():
    return json_lines(shlex.split(a.ours), cwd=package)


def theirs(seed):
    command = [sys.executable, "-B", str(pathlib.Path(a.world_dir) / "train_sb3.py"), *WORLD]
    command += ["--threads", "1", "--eval", "0", "--seed", str(seed), "--steps", str(a.steps)]
    return json_lines(command, env=os.environ | {"OMP_NUM_THREADS": "1"})


runs = {"falsify": [], "stable_baselines3": []}
ours()  # What has to be built is built before anything is timed.
for seed in range(a.repeat):
    runs["falsify"] += ours()
    runs["stable_baselines3"] += theirs(seed)
runs["falsify"] += ours()

import stable_baselines3, torch

result = {"machine": platform.processor() or platform.machine(), "cpus": os.cpu_count(), "ours": a.ours, "their_steps": a.steps,
          "stable_baselines3": stable_baselines3.__version__, "torch": torch.__version__, "load": os.getloadavg()[0]}
try:
    cpuinfo = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    result["machine"] = next(line.split(":")[1].strip() for line in cpuinfo if line.startswith("model name"))
except (OSError, StopIteration):
    pass
median = {name: {part: statistics.median(run[part] for run in rows) for part in PARTS} for name, rows in runs.items()}
for rows in median.values():
    rows["total_cpu_s"] = sum(rows[part] for part in PARTS)
    rows.update({part: round(seconds, 3) for part, seconds in rows.items()})
result["median"] = median
result["ratio"] = {part: round(median["stable_baselines3"][part] / median["falsify"][part], 1) for part in median["falsify"]}
result["runs"] = {name: [{part: round(run[part], 3) for part in PARTS} for run in rows] for name, rows in runs.items()}
text = json.dumps(result, indent=1)
print(text)
if a.out:
    pathlib.Path(a.out).write_text(text + "\n")
