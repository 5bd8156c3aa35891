#!/usr/bin/env bash
# OpenCV 5.0.0's dnn answers these operations of ONNX files otherwise than ONNX Runtime 1.32.0, and
# says nothing: Softmax, LogSoftmax and Hardmax of operator sets before 13 (which work along all axes
# from theirs on, OpenCV along one); auto_pad SAME_LOWER, and SAME_UPPER of a convolution with
# steps; ConvTranspose with auto_pad or output_shape; pools with ceil_mode and padding; Resize with
# antialias, and by a scale that does not divide the size; PRelu with slopes along the picture; GRU.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet opencv-python-headless==5.0.0.93 numpy==2.4.6 \
    onnx==1.23.2 onnxruntime==1.32.0
cd "$folder"
venv/bin/python - <<'PYTHON'
import cv2
import numpy as np
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

cv2.utils.logging.setLogLevel(0)
rng = np.random.default_rng(0)
x = rng.normal(size=(1, 4, 17, 13)).astype(np.float32)


def normal(*shape):
    return rng.normal(size=shape).astype(np.float32)


def scaled(*factors):
    return {"s": np.array([1, 1, *factors], np.float32)}


def apart(operation, inputs=("x",), version=13, weights=None, **attributes):
    """The shapes where they differ, else by how much the answers do."""
    node = helper.make_node(operation, list(inputs), ["y"], **attributes)
    held = [numpy_helper.from_array(value, name) for name, value in (weights or {}).items()]

    def network(shape):
        y = helper.make_tensor_value_info("y", TensorProto.FLOAT, shape)
        x_info = helper.make_tensor_value_info("x", TensorProto.FLOAT, x.shape)
        graph = helper.make_graph([node], "one", [x_info], [y], held)
        sets = [helper.make_opsetid("", version)]
        return helper.make_model(graph, opset_imports=sets, ir_version=8).SerializeToString()

    session = onnxruntime.InferenceSession(network(None), providers=["CPUExecutionProvider"])
    (expected,) = session.run(None, {"x": x})
    with open("one.onnx", "wb") as file:
        file.write(network(expected.shape))
    net = cv2.dnn.readNetFromONNX("one.onnx", cv2.dnn.ENGINE_AUTO)
    net.setInput(x)
    found = net.forward(["y"])[0]
    if found.shape != expected.shape:
        return f"{found.shape} for {expected.shape}"
    return float(np.abs(found - expected).max())


KERNEL = {"kernel_shape": [3, 3]}
OTHERWISE = {
    "Softmax 11": ("Softmax", ("x",), 11),
    "LogSoftmax 11": ("LogSoftmax", ("x",), 11),
    "Hardmax 11": ("Hardmax", ("x",), 11),
    "Conv SAME_LOWER": ("Conv", ("x", "w"), 13, {"w": normal(5, 4, 2, 2)}, {"auto_pad": "SAME_LOWER"}),
    "Conv SAME_UPPER by 3": (
        "Conv", ("x", "w"), 13, {"w": normal(5, 4, 5, 5)}, {"auto_pad": "SAME_UPPER", "strides": [3, 3]}
    ),
    "MaxPool SAME_LOWER": (
        "MaxPool", ("x",), 13, None, {"auto_pad": "SAME_LOWER", "kernel_shape": [2, 2], "strides": [2, 2]}
    ),
    "ConvTranspose SAME_UPPER": (
        "ConvTranspose", ("x", "w"), 13, {"w": normal(4, 5, 4, 4)}, {"auto_pad": "SAME_UPPER", "strides": [2, 2]}
    ),
    "ConvTranspose output_shape": (
        "ConvTranspose", ("x", "w"), 13, {"w": normal(4, 3, 3, 3)}, {"output_shape": [34, 26], "strides": [2, 2]}
    ),
    "MaxPool ceil_mode": (
        "MaxPool", ("x",), 13, None, {"ceil_mode": 1, "pads": [1] * 4, "kernel_shape": [2, 2], "strides": [2, 2]}
    ),
    "AveragePool ceil_mode": (
        "AveragePool", ("x",), 13, None,
        {"ceil_mode": 1, "pads": [0, 0, 1, 1], "count_include_pad": 1, "strides": [2, 2], **KERNEL},
    ),
    "Resize antialias": ("Resize", ("x", "", "s"), 18, scaled(0.5, 0.5), {"mode": "linear", "antialias": 1}),
    "Resize by half of 17": ("Resize", ("x", "", "s"), 13, scaled(0.5, 0.5), {"mode": "linear"}),
    "PRelu along the width": ("PRelu", ("x", "s"), 16, {"s": normal(13)}),
}
ALIKE = {
    "Softmax 13": ("Softmax", ("x",), 13, None, {"axis": 1}),
    "Conv SAME_UPPER by 1": ("Conv", ("x", "w"), 13, {"w": normal(5, 4, 3, 3)}, {"auto_pad": "SAME_UPPER"}),
    "Resize by two": ("Resize", ("x", "", "s"), 13, scaled(2, 2), {"mode": "linear"}),
    "PRelu of channels": ("PRelu", ("x", "s"), 16, {"s": normal(4, 1, 1)}),
}


def tried(case):
    operation, inputs, version, weights, attributes = (*case, *(None,) * (5 - len(case)))
    return apart(operation, inputs, version, weights, **(attributes or {}))


for name, case in OTHERWISE.items():
    found = tried(case)
    print(f"{name}: {found}")
    assert isinstance(found, str) or found > 0.05, name
for name, case in ALIKE.items():
    found = tried(case)
    assert isinstance(found, float) and found < 1e-4, (name, found)

x = normal(17, 1, 52)
gates = {"W": normal(1, 15, 52), "R": normal(1, 15, 5)}
found = apart("GRU", ("x", "W", "R"), 13, gates, hidden_size=5)
print(f"GRU: {found}")
assert found == "(1, 1, 5) for (17, 1, 1, 5)", found
PYTHON
