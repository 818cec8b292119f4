"""Runs exported policies in other programs and compares their actions with ours.

    python elsewhere.py FOLDER

FOLDER holds, for every policy NAME,
  NAME.safetensors, NAME.onnx   the policy, as a report holds it
  NAME.json                     states, our actions for them, the bounds of an action
Prints a JSON object: for every program the largest difference, or null where the program is not installed.  `load_policy` and
`run_onnx` are all it takes to use a trained pedestrian elsewhere.
"""
import importlib.util, json, os, pathlib, sys

os.environ["OMP_NUM_THREADS"] = "1"
import_ok = lambda *names: all(importlib.util.find_spec(name) for name in names)


def load_policy(path, low, high):
    """A stable-baselines3 policy, and what its observations are normalised with (None: they are not)."""
    import gymnasium, numpy as np
    from safetensors.torch import load_file
    from stable_baselines3.common.policies import ActorCriticPolicy
    tensors = load_file(path)
    moments = {name: tensors.pop(f"obs_rms.{name}", None) for name in ("mean", "var", "count")}
    hidden = [tensors[name].shape[0] for name in sorted(tensors) if "policy_net" in name and name.endswith("bias")]
    inputs = tensors["mlp_extractor.policy_net.0.weight"].shape[1]
    space = gymnasium.spaces.Box(np.float32(low), np.float32(high))
    seen = gymnasium.spaces.Box(-np.inf, np.inf, (inputs,))
    policy = ActorCriticPolicy(seen, space, lambda _: 0.0, net_arch=dict(pi=hidden, vf=hidden))
    policy.load_state_dict(tensors)
    return policy, moments if moments["mean"] is not None else None


def normalised(states, moments):
    """What the networks see: VecNormalize of stable-baselines3."""
    import numpy as np
    if moments is not None:
        deviation = np.sqrt(moments["var"].numpy() + 1e-8)
        states = np.clip((states - moments["mean"].numpy()) / deviation, -10, 10)
    return states.astype(np.float32)


def run_sb3(path, states, low, high):
    policy, moments = load_policy(path, low, high)
    return policy.predict(normalised(states, moments), deterministic=True)[0]


def run_torch(path, states, low, high):
    """Without stable-baselines3: the network by its tensors."""
    import numpy as np, torch
    from safetensors.torch import load_file
    tensors = load_file(path)
    moments = {name: tensors[f"obs_rms.{name}"] for name in ("mean", "var")} if "obs_rms.mean" in tensors else None
    x, layer = torch.from_numpy(normalised(states, moments)), 0
    while f"mlp_extractor.policy_net.{layer}.weight" in tensors:
        name = f"mlp_extractor.policy_net.{layer}"
        x, layer = torch.tanh(x @ tensors[f"{name}.weight"].T + tensors[f"{name}.bias"]), layer + 2
    action = x @ tensors["action_net.weight"].T + tensors["action_net.bias"]
    return np.clip(action.numpy(), np.float32(low), np.float32(high))


def run_onnx(path, states):
    import onnxruntime
    session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
    return session.run(["action"], {"state": states})[0]


def main(folder):
    import numpy as np
    worst = dict.fromkeys(["torch", "stable_baselines3", "onnxruntime", "onnx_checker"])

    def compare(program, expected, found):
        assert found.shape == expected.shape, (program, found.shape)
        worst[program] = max(worst[program] or 0.0, float(np.abs(found - expected).max()))

    for case in sorted(pathlib.Path(folder).glob("*.json")):
        recorded = json.loads(case.read_text())
        states, actions = np.array(recorded["states"]), np.array(recorded["actions"])
        tensors, graph = str(case.with_suffix(".safetensors")), str(case.with_suffix(".onnx"))
        bounds = recorded["low"], recorded["high"]
        if import_ok("torch", "safetensors"):
            compare("torch", actions, run_torch(tensors, states, *bounds))
        if import_ok("torch", "safetensors", "stable_baselines3", "gymnasium"):
            compare("stable_baselines3", actions, run_sb3(tensors, states, *bounds))
        if import_ok("onnxruntime"):
            compare("onnxruntime", actions, run_onnx(graph, states))
            compare("onnxruntime", actions[:1], run_onnx(graph, states[:1]))
        if import_ok("onnx"):
            import onnx
            onnx.checker.check_model(onnx.load(graph), full_check=True)
            worst["onnx_checker"] = 0.0
    print(json.dumps(worst))


if __name__ == "__main__":
    if not import_ok("numpy"):
        print(json.dumps(dict.fromkeys(["torch", "stable_baselines3", "onnxruntime", "onnx_checker"])))
    else:
        main(sys.argv[1])
