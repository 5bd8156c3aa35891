"""A person's keypoints in one region of one picture, by a network: BlazePose.

V. Bazarevsky and others, *BlazePose: On-device Real-time Body Pose Tracking*, 2020; the network's
points in metres: I. Grishchenko and others, *BlazePose GHUM Holistic*, 2022. OpenCV runs it, or
LiteRT where that is installed, two to four times as fast and equal to a hundredth of a pixel.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, Final, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import other_side
from keypose.tracker.keypoints.model_files import FULL, Model, verified
from keypose.tracker.keypoints.region import Region

_SIDES = ("left", "right")
NAMES: Final = (
    "nose",
    *(f"{side}_eye{where}" for side in _SIDES for where in ("_inner", "", "_outer")),
    *(f"{side}_ear" for side in _SIDES),
    "mouth_left",
    "mouth_right",
    *(
        f"{side}_{point}"
        for point in (
            *("shoulder", "elbow", "wrist", "pinky", "index", "thumb"),
            *("hip", "knee", "ankle", "heel", "foot_index"),
        )
        for side in _SIDES
    ),
)
"""MediaPipe's 33 names, in the network's order."""

SIDE: Final = 256
"""Pixels of the network's input, along a side."""

_EXCHANGED = [NAMES.index(other_side(name, NAMES)) for name in NAMES]
"""Of each point that of the other side."""
_MIRROR = np.array([[-1.0, 0.0, SIDE - 1], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
"""From pixels of the square as the network is shown it to those of the square as it is."""

_POINTS, _MIDDLE, _RIM = 39, 33, 34
_HEAT_SIDE, _HEAT_WINDOW, _LEAST_HEAT = 64, 3, 0.5
_OUTPUTS = ("Identity", "Identity_1", "Identity_3", "Identity_4")
"""Points, presence, heat maps and metres; Identity_2 is an outline that is not used."""


@dataclass(frozen=True, eq=False)
class Seen:
    """What the network sees in one region.

    uv:         (33, 2) pixels of the whole picture, in the order of NAMES.
    visibility: (33,) from 0 to 1.
    p_hips:     (33, 3) metres in axes parallel to the picture's, the middle of the hips at 0.
    presence:   from 0 to 1, how sure it is that somebody is there.
    next:       the region around this body, to look at in the next frame.
    """

    uv: Array
    visibility: Array
    p_hips: Array
    presence: float
    next: Region

    def exchanged(self) -> Seen:
        """Exchange left and right."""
        return replace(
            self,
            uv=self.uv[_EXCHANGED],
            visibility=self.visibility[_EXCHANGED],
            p_hips=self.p_hips[_EXCHANGED],
        )


class Runtime(Protocol):
    """What runs a network."""

    name: str

    def outputs(self, square: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        """Points, presence, heat maps (64, 64, 39) and metres of a square (256, 256, 3), 0 to 1."""
        ...


class Network:
    """A network that has been read. One thread at a time; the same input gives the same output."""

    def __init__(self, model: Model, runtime: Runtime) -> None:
        self.model = model
        self._runtime = runtime

    @classmethod
    def open(cls, model: Model = FULL, *, fast: bool | None = None) -> Network:
        """Read a network's file.

        fast: by LiteRT; None: where it is installed.
        KeypointError in one sentence when the file is missing, damaged or another one, or LiteRT
        is asked for and not installed.
        """
        path = str(verified(model))
        if fast is None:
            fast = fast_is_here()
        try:
            return cls(model, _LiteRT(path) if fast else _OpenCV(path))
        except ImportError:
            raise KeypointError(
                "LiteRT is not installed: run `pip install keypose[fast-pose]`."
            ) from None
        except (cv2.error, ValueError, RuntimeError) as error:
            first = str(error).strip().splitlines()[0]
            raise KeypointError(
                f"The {model.name} network cannot be run by this version of "
                f"{'LiteRT' if fast else 'OpenCV'}: {first}."
            ) from None

    @property
    def fingerprint(self) -> str:
        """Digest all that decides what it sees: the network and what runs it."""
        return f"{self.model.sha256[:16]}-{self._runtime.name}"

    def infer(self, picture: NDArray[np.uint8], region: Region, *, mirrored: bool = False) -> Seen:
        """The keypoints of the person in a region of a picture (H, W, 3), RGB.

        mirrored: shown to the network as in a mirror; what it sees is told as it is in the picture.
        """
        to_picture = region.to_picture(SIDE) @ (_MIRROR if mirrored else np.eye(3))
        square = cv2.warpAffine(
            picture, to_picture, (SIDE, SIDE), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        points, presence, heat, metres = self._runtime.outputs(
            square.astype(np.float32) / np.float32(255)
        )
        rows = points.reshape(_POINTS, 5).astype(float)
        uv = _sharpened(rows[:, :2], heat)
        uv = uv @ to_picture[:, :2].T + to_picture[:, 2]
        p = metres.reshape(_POINTS, 3)[: len(NAMES)].astype(float)
        p[:, 0] *= -1 if mirrored else 1
        p[:, :2] @= region.R_picture_body.T
        seen = Seen(
            uv[: len(NAMES)],
            _sigmoid(rows[: len(NAMES), 3]),
            p,
            float(presence.ravel()[0]),
            Region.of_circle(uv[_MIDDLE], uv[_RIM]),
        )
        return seen.exchanged() if mirrored else seen


def fast_is_here() -> bool:
    """Return whether LiteRT is installed."""
    return importlib.util.find_spec("ai_edge_litert") is not None


def fingerprint_of(model: Model) -> str:
    """Return what the network would have as `Network.fingerprint`, which is not read for it."""
    return f"{model.sha256[:16]}-{_litert_name() if fast_is_here() else _opencv_name()}"


def _opencv_name() -> str:
    return f"opencv-{cv2.__version__}"


def _litert_name() -> str:
    return f"litert-{importlib.metadata.version('ai-edge-litert')}"


class _OpenCV:
    def __init__(self, path: str) -> None:
        # By path: from bytes, OpenCV 5 takes its new engine whatever is asked for, and that one
        # cannot run this network.
        classic = getattr(cv2.dnn, "ENGINE_CLASSIC", None)
        engine = () if classic is None else (classic,)
        self._net: Any = cv2.dnn.readNetFromTFLite(path, *engine)
        self.name = _opencv_name()

    def outputs(self, square: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        with _one_thread():
            self._net.setInput(np.ascontiguousarray(square.transpose(2, 0, 1))[None])
            points, presence, heat, metres = self._net.forward(list(_OUTPUTS))
        channels_last = heat.shape[-1] == _POINTS
        return [points, presence, heat[0] if channels_last else heat[0].transpose(1, 2, 0), metres]


class _LiteRT:
    def __init__(self, path: str) -> None:
        from ai_edge_litert.interpreter import Interpreter

        self._net: Any = Interpreter(model_path=path, num_threads=1)
        self._net.allocate_tensors()
        self._input = self._net.get_input_details()[0]["index"]
        by_name = {o["name"]: o["index"] for o in self._net.get_output_details()}
        self._wanted = [by_name[name] for name in _OUTPUTS]
        self.name = _litert_name()

    def outputs(self, square: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        self._net.set_tensor(self._input, square[None])
        self._net.invoke()
        points, presence, heat, metres = (self._net.get_tensor(i) for i in self._wanted)
        return [points, presence, heat[0], metres]


_threads_lock = threading.Lock()
_threads_before: list[int] = []
"""OpenCV's number of threads before each network that runs now."""


@contextmanager
def _one_thread() -> Iterator[None]:
    """OpenCV computes on this thread alone; its setting is the program's, so it is put back."""
    with _threads_lock:
        _threads_before.append(cv2.getNumThreads())
        cv2.setNumThreads(1)
    try:
        yield
    finally:
        with _threads_lock:
            before = _threads_before.pop()  # the last one out has the first one's
            if not _threads_before:
                cv2.setNumThreads(before)


def _sharpened(xy: Array, heat: NDArray[np.float32]) -> Array:
    """Points (39, 2) moved to the centre of their heat around them, where that is hot.

    As MediaPipe does; in pixels of the square.
    """
    xy = xy.copy()
    scale = SIDE / _HEAT_SIDE
    for j in range(len(NAMES)):
        if not np.isfinite(xy[j]).all():
            continue
        x, y = (xy[j] / scale).astype(int)
        if not (0 <= x < _HEAT_SIDE and 0 <= y < _HEAT_SIDE):
            continue
        left, top = max(x - _HEAT_WINDOW, 0), max(y - _HEAT_WINDOW, 0)
        logits = heat[top : y + _HEAT_WINDOW + 1, left : x + _HEAT_WINDOW + 1, j]
        patch = _sigmoid(logits.astype(float))
        if patch.max() < _LEAST_HEAT:
            continue
        rows, columns = np.indices(patch.shape)
        total = patch.sum()
        xy[j] = (
            scale * (left + (columns * patch).sum() / total),
            scale * (top + (rows * patch).sum() / total),
        )
    return xy


def _sigmoid(x: Array) -> Array:
    return 1 / (1 + np.exp(-np.clip(x, -50, 50)))
