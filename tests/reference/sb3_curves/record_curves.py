"""Records learning curves of stable-baselines3's PPO on the reference world.

    python record_curves.py --world-dir DIR --end lost --obs raw --act raw --seeds 10 --out raw_lost.json

DIR holds `ped_env.py`, the reference world.  Every seed trains 70,000 steps with the paper's settings, one
thread, one environment.  The output holds, per seed,
  curve      mean reward of the episodes that end in each tenth of the training (7,000 steps)
  episodes   number of those episodes
  collision  share of 200 evaluation episodes with a collision: mean action, the episode's end as in the paper
  cpu_s      CPU seconds of the training
and once the 200 evaluation starts (r, phi, psi_p), so that another implementation can start in the same places.
The file is rewritten after every seed; seeds it already holds are kept.
"""
import argparse, importlib.metadata as meta, json, os, platform, sys, time

os.environ["OMP_NUM_THREADS"] = "1"
p = argparse.ArgumentParser()
p.add_argument("--world-dir", required=True)
p.add_argument("--reward", default="R2")
p.add_argument("--world", default="straight")
p.add_argument("--obs", default="raw")
p.add_argument("--act", default="raw")
p.add_argument("--end", default="lost")
p.add_argument("--seeds", type=int, default=10)
p.add_argument("--steps", type=int, default=70000)
p.add_argument("--out", required=True)
p.add_argument("--save-dir", default="", help="where to keep the policies as .zip")
a = p.parse_args()
sys.path.insert(0, a.world_dir)
sys.dont_write_bytecode = True

import torch

torch.set_num_threads(1)
from stable_baselines3 import PPO
from stable_baselines3.common.monitor import Monitor
from ped_env import PedEnv

BIN, EVAL, EVAL_SEED = 7000, 200, 100000
SETTINGS = dict(learning_rate=3e-4, n_steps=150, batch_size=64, n_epochs=10, gamma=0.98, gae_lambda=0.95,
                clip_range=0.2, vf_coef=0.5, ent_coef=0.01)


def eval_starts():
    """The starts that PedEnv draws for the evaluation seeds on the straight road, in the order of its draws."""
    import math
    import numpy as np
    starts = []
    for k in range(EVAL):
        rng = np.random.Generator(np.random.PCG64(EVAL_SEED + k))
        env = PedEnv(a.reward, a.world, a.obs, a.act)
        env.reset(seed=EVAL_SEED + k)
        r, phi, psi = rng.uniform(7.0, 30.0), rng.uniform(-math.pi / 3, math.pi / 3), rng.uniform(-math.pi, math.pi)
        assert abs(env.px - r * math.cos(phi)) < 1e-9 and env.psi == psi
        starts.append([r, phi, psi])
    return starts


def evaluate(model):
    env, hits, ret = PedEnv(a.reward, a.world, a.obs, a.act), 0, 0.0
    for k in range(EVAL):
        o, _ = env.reset(seed=EVAL_SEED + k)
        over = False
        while not over:
            act, _ = model.predict(o, deterministic=True)
            o, r, term, trunc, info = env.step(act)
            ret += r
            over = term or trunc
        hits += bool(info.get("collision"))
    return hits / EVAL, ret / EVAL


def train(seed):
    env = Monitor(PedEnv(a.reward, a.world, a.obs, a.act, a.end))
    model = PPO("MlpPolicy", env, seed=seed, device="cpu", verbose=0, **SETTINGS)
    c, w = time.process_time(), time.perf_counter()
    model.learn(a.steps)
    cpu, wall = time.process_time() - c, time.perf_counter() - w
    bins = a.steps // BIN
    total, count, t = [0.0] * bins, [0] * bins, 0
    for reward, length in zip(env.get_episode_rewards(), env.get_episode_lengths()):
        t += length
        b = min((t - 1) // BIN, bins - 1)
        total[b] += reward
        count[b] += 1
    if a.save_dir:
        os.makedirs(a.save_dir, exist_ok=True)
        model.save(os.path.join(a.save_dir, f"{a.obs}_{a.end}_{seed}.zip"))
    rate, ret = evaluate(model)
    return {"seed": seed, "curve": [round(x / max(n, 1), 6) for x, n in zip(total, count)], "episodes": count,
            "collision": rate, "eval_reward": round(ret, 6), "log_std": [round(float(x), 6) for x in model.policy.log_std.detach()],
            "updates": model.num_timesteps // SETTINGS["n_steps"], "cpu_s": round(cpu, 2), "wall_s": round(wall, 2)}


out = {"versions": {m: meta.version(m) for m in ("stable-baselines3", "torch", "gymnasium", "numpy")},
       "python": platform.python_version(), "world": a.world, "reward": a.reward, "obs": a.obs, "act": a.act,
       "end": a.end, "steps": a.steps, "bin": BIN, "settings": SETTINGS, "eval_starts": eval_starts(), "seeds": []}
if os.path.exists(a.out):
    out["seeds"] = json.load(open(a.out))["seeds"]
for seed in range(a.seeds):
    if any(s["seed"] == seed for s in out["seeds"]):
        continue
    out["seeds"].append(train(seed))
    text = json.dumps({k: v for k, v in out.items() if k not in ("seeds", "eval_starts")}, indent=1)[:-2]
    rows = lambda xs: ",\n".join("  " + json.dumps(x) for x in xs)
    text += f',\n "eval_starts": [\n{rows(out["eval_starts"])}\n ],\n "seeds": [\n{rows(out["seeds"])}\n ]\n}}\n'
    with open(a.out + ".part", "w") as f:
        f.write(text)
    os.replace(a.out + ".part", a.out)
    print({k: out["seeds"][-1][k] for k in ("seed", "collision", "cpu_s", "wall_s", "curve")}, flush=True)
