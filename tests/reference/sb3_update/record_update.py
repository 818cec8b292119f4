"""Records one update of stable-baselines3's PPO: weights before, rollout, minibatch order, weights after.

    python record_update.py --world-dir DIR --out FOLDER

DIR holds `ped_env.py`, the reference world.  A policy is trained for --warm-up updates, so that its weights,
values and deviations are not the initial ones.  Then Adam begins anew (zero moments), rollouts are collected until
one has at least two hits and two episodes that were cut off, and `PPO.train` runs once, unchanged.

FOLDER receives
  before.safetensors, after.safetensors   the policy's state dictionary, F32
  rollout.json    settings, versions, and the rollout buffer as `train` saw it: observations, actions (before
                  clipping), rewards (with gamma times the value of the final observation added where an episode
                  was cut off), episode starts, values, log-probabilities, advantages, returns; the observation
                  after the last step and whether it begins an episode; `order`, the sample numbers in the order
                  of every epoch; what `train` logged; `noise`, how far the weights after the same update in
                  double precision lie from `after`.
"""
import argparse, importlib.metadata as meta, json, os, struct, sys

os.environ["OMP_NUM_THREADS"] = "1"
p = argparse.ArgumentParser()
p.add_argument("--world-dir", required=True)
p.add_argument("--warm-up", type=int, default=60)
p.add_argument("--seed", type=int, default=0)
p.add_argument("--out", required=True)
a = p.parse_args()
sys.path.insert(0, a.world_dir)
sys.dont_write_bytecode = True

import numpy as np
import torch

torch.set_num_threads(1)
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from ped_env import PedEnv

SETTINGS = dict(learning_rate=3e-4, n_steps=150, batch_size=64, n_epochs=10, gamma=0.98, gae_lambda=0.95,
                clip_range=0.2, vf_coef=0.5, ent_coef=0.01)


def save_tensors(path, state):
    header, data = {}, b""
    for name, tensor in state.items():
        raw = tensor.detach().numpy().astype("<f4").tobytes()
        header[name] = {"dtype": "F32", "shape": list(tensor.shape), "data_offsets": [len(data), len(data) + len(raw)]}
        data += raw
    head = json.dumps(header, separators=(",", ":")).encode()
    head += b" " * (-len(head) % 8)
    with open(path, "wb") as f:
        f.write(struct.pack("<Q", len(head)) + head + data)


def copy_state(policy):
    return {name: tensor.detach().clone() for name, tensor in policy.state_dict().items()}


def numbers(array):
    """The shortest decimals that give the same single-precision numbers."""
    array = np.asarray(array, np.float32)
    return [float(str(x)) for x in array.ravel()]


class Nothing(BaseCallback):
    def _on_step(self):
        return True


def in_double(before, buffer, order):
    """The same update, written out, in double precision."""
    w = {name: tensor.double().requires_grad_(True) for name, tensor in before.items()}
    adam = torch.optim.Adam(list(w.values()), lr=SETTINGS["learning_rate"], eps=1e-5)
    column = lambda x: torch.tensor(np.asarray(x, np.float64))
    obs, act = column(buffer.observations[:, 0]), column(buffer.actions[:, 0])
    old, adv, ret = (column(x[:, 0]) for x in (buffer.log_probs, buffer.advantages, buffer.returns))

    def net(trunk, head, x):
        for layer in (0, 2):
            name = f"mlp_extractor.{trunk}.{layer}"
            x = torch.tanh(x @ w[name + ".weight"].T + w[name + ".bias"])
        return x @ w[head + ".weight"].T + w[head + ".bias"]

    for epoch in order:
        for i in range(0, len(epoch), SETTINGS["batch_size"]):
            b = torch.tensor(epoch[i:i + SETTINGS["batch_size"]])
            normal = torch.distributions.Normal(net("policy_net", "action_net", obs[b]), w["log_std"].exp())
            ratio = (normal.log_prob(act[b]).sum(1) - old[b]).exp()
            advantage = (adv[b] - adv[b].mean()) / (adv[b].std() + 1e-8)
            eps = SETTINGS["clip_range"]
            policy_loss = -torch.min(advantage * ratio, advantage * ratio.clamp(1 - eps, 1 + eps)).mean()
            value_loss = ((net("value_net", "value_net", obs[b])[:, 0] - ret[b]) ** 2).mean()
            loss = policy_loss - SETTINGS["ent_coef"] * normal.entropy().sum(1).mean() + SETTINGS["vf_coef"] * value_loss
            adam.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(list(w.values()), 0.5)
            adam.step()
    return w


model = PPO("MlpPolicy", PedEnv("R2", "straight", "raw", "raw", "paper"), seed=a.seed, device="cpu", **SETTINGS)
model.learn(a.warm_up * SETTINGS["n_steps"])
policy = model.policy
policy.optimizer = policy.optimizer_class(policy.parameters(), lr=SETTINGS["learning_rate"], **policy.optimizer_kwargs)

callback = Nothing()
callback.init_callback(model)
hits = cut_off = 0
while hits < 2 or cut_off < 2:
    assert model.collect_rollouts(model.env, callback, model.rollout_buffer, SETTINGS["n_steps"])
    rewards = model.rollout_buffer.rewards
    hits, cut_off = int((rewards >= 1.0).sum()), int(((rewards != 0.0) & (rewards < 1.0)).sum())
buffer, before, order = model.rollout_buffer, copy_state(policy), []
columns = {name: getattr(buffer, name).copy() for name in (
    "observations", "actions", "rewards", "episode_starts", "values", "log_probs", "advantages", "returns")}
assert all(c.shape[:2] == (SETTINGS["n_steps"], 1) for c in columns.values())

permutation = np.random.permutation


def recorded(n):
    order.append(permutation(n).tolist())
    return np.array(order[-1])


np.random.permutation = recorded
model.set_logger(Logger(folder=None, output_formats=[]))
model.train()
np.random.permutation = permutation
assert len(order) == SETTINGS["n_epochs"]
after = copy_state(policy)


class View:
    pass


view = View()
for name, column in columns.items():
    setattr(view, name, column)
double = in_double(before, view, order)
noise = max(float((double[name] - after[name].double()).abs().max()) for name in after)

os.makedirs(a.out, exist_ok=True)
save_tensors(os.path.join(a.out, "before.safetensors"), before)
save_tensors(os.path.join(a.out, "after.safetensors"), after)
out = {"versions": {m: meta.version(m) for m in ("stable-baselines3", "torch", "gymnasium", "numpy")},
       "settings": SETTINGS | {"max_grad_norm": model.max_grad_norm, "adam_eps": policy.optimizer.defaults["eps"]},
       "warm_up": a.warm_up, "seed": a.seed, "obs_dim": 4, "action_dim": 2}
out |= {name: numbers(column) for name, column in columns.items() if name != "episode_starts"}
out["episode_starts"] = [bool(x) for x in columns["episode_starts"].ravel()]
out["last_obs"] = numbers(model._last_obs)
out["last_done"] = bool(model._last_episode_starts[0])
out["order"] = order
out["logged"] = {k.removeprefix("train/"): float(v) for k, v in model.logger.name_to_value.items()}
out["noise"] = noise
out["movement"] = max(float((after[name] - before[name]).abs().max()) for name in after)
with open(os.path.join(a.out, "rollout.json"), "w") as f:
    f.write("{\n" + ",\n".join(f" {json.dumps(k)}: {json.dumps(v, separators=(',', ':'))}" for k, v in out.items()) + "\n}\n")
print({k: out[k] for k in ("logged", "noise", "movement", "last_done")}, f"{hits} hits, {cut_off} cut off")
