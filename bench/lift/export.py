"""Write trained weights as the ONNX file that comes with the package, in half precision."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from bench.lift.network import Weights
from keypose.tracker.keypoints.lifting import INPUTS, NETWORKS, OUTPUTS

OPSET = 13
IR_VERSION = 8
THANKS = (
    "Trained on motion capture of the CMU Graphics Lab Motion Capture Database, mocap.cs.cmu.edu, "
    "created with funding from NSF EIA-0196217."
)


def export(nets: list[Weights], path: Path) -> str:
    """Write networks side by side; return the file's SHA-256."""
    nodes, tensors, outputs = [], [], []
    for name, net in zip(NETWORKS, nets, strict=True):
        blocks = sum(key.startswith("w") and key.endswith("a") for key in net)

        def stored(key: str, prefix: str = name, weights: Weights = net) -> str:
            values = np.asarray(weights[key])
            full = f"{prefix}_{key}"
            if values.ndim == 1:
                tensors.append(numpy_helper.from_array(values.astype(np.float32), full))
                return full
            # a layer is a convolution over a picture one pixel wide, with a row for each window:
            # OpenCV 4 and 5 both run it, however tall
            kernel = values.T[:, :, None, None].astype(np.float16)
            tensors.append(numpy_helper.from_array(kernel, f"{full}_half"))
            nodes.append(helper.make_node("Cast", [f"{full}_half"], [full], to=TensorProto.FLOAT))
            return full

        def layer(x: str, key: str, out: str, relu: bool = True, put: object = stored) -> str:
            w, b = (put(f"{kind}{key}") for kind in "wb")  # type: ignore[operator]
            end = f"{out}_sum" if relu else out
            nodes.append(helper.make_node("Conv", [x, w, b], [end], kernel_shape=[1, 1]))
            if relu:
                nodes.append(helper.make_node("Relu", [f"{out}_sum"], [out]))
            return out

        h = layer("input", "0", f"{name}_h")
        for n in range(blocks):
            inner = layer(h, f"{n}a", f"{name}_inner{n}")
            change = layer(inner, f"{n}b", f"{name}_change{n}")
            nodes.append(helper.make_node("Add", [h, change], [f"{name}_h{n}"]))
            h = f"{name}_h{n}"
        layer(h, "o", name, relu=False)
        outputs.append(
            helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, OUTPUTS, "rows", 1])
        )
    shape = helper.make_tensor_value_info("input", TensorProto.FLOAT, [1, INPUTS, "rows", 1])
    graph = helper.make_graph(nodes, "lifter", [shape], outputs, tensors)
    model = helper.make_model(
        graph,
        opset_imports=[helper.make_opsetid("", OPSET)],
        producer_name="keypose bench.lift",
        doc_string=THANKS,
    )
    model.ir_version = IR_VERSION
    onnx.checker.check_model(model)
    content = model.SerializeToString()
    path.write_bytes(content)
    return hashlib.sha256(content).hexdigest()
