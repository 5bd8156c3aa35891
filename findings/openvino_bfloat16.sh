#!/usr/bin/env bash
# OpenVINO 2026.4.1: a network in single precision is computed in bfloat16 where the CPU has it
# (AVX512_BF16, AMX), unless INFERENCE_PRECISION_HINT says f32. Nothing is printed. Seen with eight
# convolutions of 16 channels: outputs off by 3 % of their spread, by under 0.01 % with the hint; points
# decoded from such maps jump by cells. On a CPU without bfloat16 both are equal, which is told.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3.11 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet onnx==1.23.2 onnxruntime==1.32.0 openvino==2026.4.1
cd "$folder"
venv/bin/python - <<'PYTHON'
import numpy as np
import onnx
import onnxruntime
import openvino
from onnx import TensorProto, helper, numpy_helper

random = np.random.default_rng(0)
nodes, weights, last = [], [], "image"
for layer in range(8):
    weight = random.normal(0, 1 / 12, (16, 16, 3, 3)).astype(np.float32)
    weights.append(numpy_helper.from_array(weight, f"w{layer}"))
    nodes.append(helper.make_node("Conv", [last, f"w{layer}"], [f"y{layer}"], pads=[1, 1, 1, 1]))
    last = f"y{layer}"
sizes = [1, 16, 64, 64]
ends = [helper.make_tensor_value_info(name, TensorProto.FLOAT, sizes) for name in ("image", last)]
graph = helper.make_graph(nodes, "convolutions", ends[:1], ends[1:], weights)
model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)])
model.ir_version = 8
onnx.save(model, "net.onnx")

image = random.normal(0, 1, sizes).astype(np.float32)
session = onnxruntime.InferenceSession("net.onnx", providers=["CPUExecutionProvider"])
(true,) = session.run(None, {"image": image})


def off(**hints):
    """How far OpenVINO's output is off, a share of the output's spread."""
    compiled = openvino.Core().compile_model("net.onnx", "CPU", hints)
    found = compiled([image])[0]
    return float(np.abs(found - true).max() / true.std())


usual, single = off(), off(INFERENCE_PRECISION_HINT="f32")
able = "BF16" in openvino.Core().get_property("CPU", "OPTIMIZATION_CAPABILITIES")
print(f"OpenVINO {openvino.__version__}: {usual:.1e} as it is, {single:.1e} in f32")
assert single < 1e-4, single
if able:
    assert usual > 3e-3, usual
else:
    print("this CPU has no bfloat16: both are the same here")
    assert usual < 1e-4, usual
PYTHON
