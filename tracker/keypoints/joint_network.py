"""A person's joints in one region of one picture, by a network that sees joints alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.joint_kinds import KINDS, prepared
from keypose.tracker.keypoints.layouts import NETWORK_LAYOUTS
from keypose.tracker.keypoints.model_files import JointHeads, Model, note_damaged, verified
from keypose.tracker.keypoints.region import Region
from keypose.tracker.keypoints.runtimes import (
    ONNX,
    Runtime,
    Tensor,
    cannot_run,
    fast_is_here,
    open_runtime,
)

OF_AN_ANIMAL: Final = 1.15
"""What the input shows of the region around an animal, which ends at its keypoints: networks of
animals were trained on boxes around the whole of it × 1.25."""


@dataclass(frozen=True, eq=False)
class SeenJoints:
    """What a network of joints sees: uv (K, 2) pixels of the whole picture, in the order of its
    names, NaN where it sees none; confidence (K,) from 0 to 1."""

    uv: Array
    confidence: Array


class JointNetwork:
    """A network that has been read. One thread at a time; the same input gives the same output."""

    def __init__(self, model: Model, heads: JointHeads, runtime: Runtime) -> None:
        self.names = NETWORK_LAYOUTS[heads.layout]
        self.fingerprint = f"{model.sha256[:16]}-{runtime.name}"
        self._heads = heads
        self._kind = KINDS[heads.kind]
        self._share = OF_AN_ANIMAL if heads.of_animals else self._kind.share
        self.doubted = self._kind.doubted
        self._size = heads.width, heads.height
        self._runtime = runtime

    @classmethod
    def open(cls, model: Model, *, fast: bool | None = None) -> JointNetwork:
        """Read a network's file, and look at nothing once; fast, and KeypointError, as of
        `open_runtime`."""
        assert model.heads is not None
        runtime = open_heads(model.file, verified(model), model.heads, fast=fast)
        network = cls(model, model.heads, runtime)
        try:  # what added it was perhaps another runtime, or its note is of another file
            seen_joints = network.infer(np.zeros((8, 8, 3), np.uint8), Region(3.5, 3.5, 8.0))
        except Exception as error:  # noqa: BLE001  ONNX Runtime's have no other base
            raise cannot_run(f"The network {model.name!r}", runtime.name, error) from None
        if len(seen_joints.uv) != len(network.names):
            raise note_damaged(model.name)
        return network

    def infer(self, picture: NDArray[np.uint8], region: Region) -> SeenJoints:
        """The joints of whom a region of a picture (H, W, 3), RGB, is around."""
        shown = replace(region, side=self._share * region.side)
        outputs, to_picture = self._run(picture, shown)
        return _in_picture(*self._kind.decoded(outputs, self._size), to_picture)

    def everybody(self, picture: NDArray[np.uint8], region: Region) -> list[SeenJoints]:
        """The joints of each person in a region of a picture (H, W, 3), RGB, in no order; of kinds
        of networks that tell people apart."""
        assert self._kind.everybody is not None
        outputs, to_picture = self._run(picture, region)
        people = self._kind.everybody(outputs, self._size)
        return [_in_picture(xy, confidence, to_picture) for xy, confidence in people]

    def _run(self, picture: NDArray[np.uint8], region: Region) -> tuple[Sequence[Tensor], Array]:
        """The outputs for a region, and the map (2, 3) from its pixels to the picture's."""
        kind, size = self._kind, self._size
        to_picture = region.to_picture(*size)
        how = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        image = cv2.warpAffine(picture, to_picture, size, flags=how, borderValue=kind.outside)
        levels = np.ascontiguousarray(image.transpose(2, 0, 1), dtype=np.float32)
        return self._runtime.run(prepared(self._heads, levels)), to_picture


def _in_picture(xy: Array, confidence: Array, to_picture: Array) -> SeenJoints:
    """Joints (K, 2) of the input, moved to the picture."""
    known_xy = np.where(np.isfinite(confidence)[:, None], xy, np.nan)
    return SeenJoints(known_xy @ to_picture[:, :2].T + to_picture[:, 2], confidence)


def open_heads(
    file: str, content: bytes, heads: JointHeads, *, fast: bool | None = None
) -> Runtime:
    """Read the file of a network of joints, as `open_runtime`."""
    kind = KINDS[heads.kind]
    needs_fast = kind.needs_fast or heads.needs_fast
    if needs_fast and not fast_is_here(ONNX):
        raise needs_onnx_runtime(kind.title if kind.needs_fast else f"The network {file!r}")
    return open_runtime(file, content, heads.outputs, fast=needs_fast or fast)


def needs_onnx_runtime(network_name: str) -> KeypointError:
    """What is said where ONNX Runtime alone can run a network, and is not here."""
    return KeypointError(
        f"{network_name} needs ONNX Runtime, which is not installed: run `pip install onnxruntime`."
    )
