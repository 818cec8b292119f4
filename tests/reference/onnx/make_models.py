"""Writes the networks of this folder, and what onnxruntime answers them: `python make_models.py` (pip: onnx, onnxruntime, numpy).

`follow.onnx` drives: it steers for the third point of the route and slows down for whoever is near. Its weights are set by hand,
so that the file depends on nothing that is drawn.
"""
import json
import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

def constant(name, value, kind=np.float32):
    return numpy_helper.from_array(np.array(value, dtype=kind), name)

def save(name, nodes, inputs, outputs, constants):
    def value(key, shape):
        return helper.make_tensor_value_info(key, TensorProto.FLOAT, shape)
    graph = helper.make_graph(nodes, name, [value(*each) for each in inputs], [value(*each) for each in outputs], constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    onnx.checker.check_model(model)
    onnx.save(model, f"{name}.onnx")

# speed, limit, light, distance | 2 actors | 4 points
inputs = [("ego", ["n", 4]), ("actors", ["n", 2, 8]), ("route", ["n", 4, 3])]
flat = 4 + 16 + 12
first = np.zeros((flat, 6), dtype=np.float32)
first[0, 0] = -1.0            # limit - speed, both signs
first[1, 0] = 0.9
first[0, 1] = 1.0
first[1, 1] = -0.9
first[4 + 16 + 3 * 3 + 1, 2] = 0.25   # left of the route's last point, both signs
first[4 + 16 + 3 * 3 + 1, 3] = -0.25
first[4, 4] = 8.0             # someone in sight …
first[5, 4] = -0.5            # … and near
first[4 + 8, 5] = 8.0
first[5 + 8, 5] = -0.5
second = np.zeros((6, 2), dtype=np.float32)
second[0, 0], second[1, 0], second[4, 0], second[5, 0] = 1.0, -1.0, -1.0, -1.0
second[2, 1], second[3, 1] = 1.0, -1.0
nodes = [
    helper.make_node("Flatten", ["actors"], ["a"], axis=1),
    helper.make_node("Flatten", ["route"], ["r"], axis=1),
    helper.make_node("Concat", ["ego", "a", "r"], ["all"], axis=1),
    helper.make_node("Gemm", ["all", "w1", "b1"], ["h"]),
    helper.make_node("Relu", ["h"], ["hr"]),
    helper.make_node("Gemm", ["hr", "w2", "b2"], ["o"]),
    helper.make_node("Tanh", ["o"], ["t"]),
    helper.make_node("Mul", ["t", "scale"], ["control"]),
]
save("follow", nodes, inputs, [("control", ["n", 2])], [
    constant("w1", first), constant("b1", np.zeros(6)), constant("w2", second), constant("b2", np.zeros(2)),
    constant("scale", [4.0, 1.0]),
])
save("no_driver", [helper.make_node("Relu", ["image"], ["labels"])], [("image", [1, 3])], [("labels", [1, 3])], [])
save("five", [helper.make_node("Concat", ["ego", "one"], ["control"], axis=1)], [("ego", [1, 4])], [("control", [1, 5])],
     [constant("one", [[1.0]])])

import onnxruntime
session = onnxruntime.InferenceSession("follow.onnx")
draw = np.random.default_rng(1)
cases = []
for _ in range(20):
    fed = {"ego": draw.normal(size=(1, 4)) * 4, "actors": draw.normal(size=(1, 2, 8)) * 4, "route": draw.normal(size=(1, 4, 3)) * 4}
    fed = {key: np.round(value, 3).astype(np.float32) for key, value in fed.items()}
    answer = session.run(["control"], fed)[0]
    cases.append({**{key: value.ravel().tolist() for key, value in fed.items()}, "control": answer.ravel().tolist()})
with open("follow.json", "w") as file:
    json.dump({"onnxruntime": onnxruntime.__version__, "cases": cases}, file)
    file.write("\n")
