"""Pedestrians of one's own, and the program from Python."""

import numpy as np
import pytest

import falsify_av
from falsify_av import program as falsify

CHOICE = {"campaign": "short", "town": "harbour", "driver": "blind", "task": "train"}


def homing(states):
    """Walks towards the bearing of the car, at 3 m/s."""
    return np.stack([states[:, 0], np.full(len(states), 3.0, np.float32)], axis=1)


def test_a_callable_walks_the_same_in_any_number_of_worlds(scenario):
    rows = falsify_av.evaluate(homing, scenario, **CHOICE, episodes=20, seed=3, num_envs=20)
    assert [row["episode_number"] for row in rows] == list(range(20)) and {row["seed"] for row in rows} == {3}
    for worlds in (1, 7):
        again = falsify_av.evaluate(homing, scenario, **CHOICE, episodes=20, seed=3, num_envs=worlds)
        assert [row["digest"] for row in again] == [row["digest"] for row in rows]
    assert any(row["is_success"] for row in rows) and not all(row["is_success"] for row in rows)
    env = falsify_av.make(scenario, **CHOICE)
    state, _ = env.reset(seed=3, options={"episode": 4})
    over = False
    while not over:
        state, _, terminated, truncated, info = env.step(homing(state[None])[0])
        over = terminated or truncated
    assert info["digest"] == rows[4]["digest"]


def test_errors_of_a_callable_are_its_own(scenario):
    def broken(states):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        falsify_av.evaluate(broken, scenario, **CHOICE, episodes=2)
    with pytest.raises(ValueError, match="shape"):
        falsify_av.evaluate(lambda states: states, scenario, **CHOICE, episodes=2)
    with pytest.raises(ValueError, match="at least 1"):
        falsify_av.evaluate(homing, scenario, **CHOICE, episodes=0)


def test_the_program_runs_campaigns_and_repeats_episodes(program, scenario, tmp_path):
    walked = scenario.with_name("walked.scn")
    reports = falsify.run(walked, out=tmp_path / "out", seed=9)
    assert list(reports) == ["walked"] and {"episodes", "results"} <= set(reports["walked"].tables)
    assert reports["walked"].manifest["seed"] == 9
    parquet = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    rows = reports["walked"].table("episodes")
    assert isinstance(rows, parquet.Table) and rows.num_rows == 24
    name = f"{rows['run_id'][0]}:{rows['episode'][0]}"
    assert falsify.replay(name, report=tmp_path / "out")["digest"] == rows["digest"][0].as_py()
    with pytest.raises(KeyError, match="no table `nothing`; it has"):
        reports["walked"].table("nothing")


def test_errors_of_the_program_are_exceptions_with_its_text(program, tmp_path):
    wrong = tmp_path / "wrong.scn"
    wrong.write_text("edition 1\ncampaign c {\n  vehicel: model3\n}\n")
    with pytest.raises(falsify.ProgramError, match="vehicel") as raised:
        falsify.run(wrong, out=tmp_path / "out")
    assert raised.value.code == 3


def test_a_missing_program_is_an_error_that_names_the_remedy(monkeypatch, tmp_path):
    monkeypatch.delenv("FALSIFY_BIN", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("sysconfig.get_path", lambda name: str(tmp_path))
    with pytest.raises(FileNotFoundError, match="install the wheel falsify-av-program"):
        falsify.call("--version")


def test_a_network_walks_as_the_function_that_it_holds(scenario, tmp_path):
    pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")
    onnx = pytest.importorskip("onnx", reason="onnx is not installed")
    from onnx import TensorProto, helper

    weights = helper.make_tensor("weights", TensorProto.FLOAT, [4, 2], [1, 0, 0, 0, 0, 0, 0, 0])
    bias = helper.make_tensor("bias", TensorProto.FLOAT, [2], [0, 3])
    graph = helper.make_graph(
        [helper.make_node("Gemm", ["states", "weights", "bias"], ["actions"])],
        "homing",
        [helper.make_tensor_value_info("states", TensorProto.FLOAT, ["worlds", 4])],
        [helper.make_tensor_value_info("actions", TensorProto.FLOAT, ["worlds", 2])],
        [weights, bias],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    onnx.save(model, tmp_path / "homing.onnx")
    learnt = falsify_av.onnx(tmp_path / "homing.onnx")
    rows = falsify_av.evaluate(learnt, scenario, **CHOICE, episodes=6)
    assert [row["digest"] for row in rows] == [row["digest"] for row in falsify_av.evaluate(homing, scenario, **CHOICE, episodes=6)]
