"""BlazePose and a network of joints, put together: what two see differs, and their mean is nearer.

Several looks of one network share its errors; two networks hardly do. The network of joints is the
better one at limbs, and at feet and hands where it has these. BlazePose gives depth, visibility,
and where to look next, and now and then exchanges left and right of a whole body: then its look is
exchanged back.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Final, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.blazepose import NAMES, Seen
from keypose.tracker.keypoints.detect import LEAST_PRESENCE, Detector
from keypose.tracker.keypoints.joint_kinds import KINDS
from keypose.tracker.keypoints.joint_network import SeenJoints
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.region import Region

BLAZEPOSE_SHARE: Final = 0.3
"""Of BlazePose's joint in the mean of both, ..."""
APART: Final = 0.045
"""... and half of that where they lie so far apart, a share of the region's side."""
DOWN_TRUNK: Final = {"shoulder": 0.04, "hip": 0.043, "ankle": -0.02}
"""How far MoveNet's joints are moved from shoulders toward hips, as shares of the trunk, so that
they lie where BlazePose puts them on the body: means of three people's films. With ankles where
MoveNet puts them a walker was drafted 1.4 % too large. Networks trained on the same marks, COCO's,
are taken to do likewise."""
ENDS: Final = {
    "heel": "heel",
    "foot_index": "big_toe",
    "pinky": "pinky_finger1",
    "index": "forefinger1",
    "thumb": "thumb2",
}
"""Of feet and hands what BlazePose calls a point, and what layouts do."""
SURE: Final = 0.3
"""Confidence from which on such a point is taken from the network of joints, where it has it."""


Indices: TypeAlias = NDArray[np.int64]


class JointDetector(Protocol):
    """What sees joints in a region, as `JointNetwork`."""

    @property
    def names(self) -> Sequence[str]: ...
    @property
    def fingerprint(self) -> str: ...
    @property
    def doubted(self) -> tuple[float, float]: ...
    def infer(self, picture: NDArray[np.uint8], region: Region) -> SeenJoints: ...


class PairedNetwork:
    """Two networks that look at each frame once, at the same time; as `BlazePose` otherwise."""

    def __init__(self, blazepose: Detector, joints: JointDetector) -> None:
        self.plain = blazepose
        self._joints = joints
        self.fingerprint = paired_fingerprint(blazepose.fingerprint, joints.fingerprint)
        self._thread = ThreadPoolExecutor(1)
        own_names = {name: name for name in JOINTS if name in joints.names}
        self._at, self._from = _places(own_names, joints.names)
        ends = {
            f"{side}_{end}": f"{side}_{its}"
            for side in ("left", "right")
            for end, its in ENDS.items()
        }
        self._ends_at, self._ends_from = _places(ends, joints.names)
        self._down = down_trunk(list(own_names))

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        """The keypoints of the person in a region of a picture (H, W, 3), RGB."""
        pending = self._thread.submit(self._joints.infer, picture, region)
        try:
            detection = self.plain.infer(picture, region)
        finally:
            joints = pending.result()
        if detection.presence < LEAST_PRESENCE or not np.isfinite(detection.uv).all():
            return detection
        uv = joints.uv[self._from]
        if not np.isfinite(uv).all():
            return detection
        trust = self._trust(joints.confidence[self._from])
        if trust > 0.5:
            detection = min(
                detection, detection.exchanged(), key=lambda each: _distance(each.uv[self._at], uv)
            )
        trunk = detection.uv[_SHOULDERS].mean(axis=0) - detection.uv[_HIPS].mean(axis=0)
        uv = uv - self._down[:, None] * trunk
        both = detection.uv.copy()
        both[self._at] = weighted_mean(uv, detection.uv[self._at], APART * region.side, trust)
        ends = joints.uv[self._ends_from]
        sure = (joints.confidence[self._ends_from] >= SURE) & np.isfinite(ends).all(axis=1)
        both[self._ends_at[sure]] = ends[sure]
        return replace(detection, uv=both)

    def _trust(self, confidence: Array) -> float:
        """How far the joints are believed, from 0 to 1."""
        low, high = self._joints.doubted
        return float(np.clip((confidence.mean() - low) / max(high - low, 1e-9), 0.0, 1.0))


def weighted_mean(
    uv: Array, uv_blazepose: Array, apart_px: Array | float, trust: float = 1.0
) -> Array:
    """Joints (..., K, 2) between where a network of joints and BlazePose see them.

    apart_px: distance, of all or (..., K), at which BlazePose's share is halved.
    """
    away = uv_blazepose - uv
    apart = np.linalg.norm(away, axis=-1) / apart_px
    share = 1 - trust * (1 - BLAZEPOSE_SHARE / (1 + apart**4))
    return np.asarray(uv + share[..., None] * away)


def down_trunk(names: Sequence[str]) -> Array:
    """(K,) `DOWN_TRUNK` of joints such as left_hip."""
    return np.array([DOWN_TRUNK.get(name.split("_")[1], 0.0) for name in names])


def _places(names: Mapping[str, str], of: Sequence[str]) -> tuple[Indices, Indices]:
    """Where points are among BlazePose's, and where the same are among others."""
    common_names = {name: its for name, its in names.items() if its in of}
    at, there = (
        [NAMES.index(name) for name in common_names],
        [of.index(its) for its in common_names.values()],
    )
    return np.array(at, dtype=np.int64), np.array(there, dtype=np.int64)


def paired_fingerprint(blazepose: str, joints: str) -> str:
    """What `PairedNetwork.fingerprint` is of networks of these fingerprints."""
    kinds = {name: (kind.share, kind.doubted) for name, kind in KINDS.items()}
    how = repr((BLAZEPOSE_SHARE, APART, DOWN_TRUNK, ENDS, SURE, kinds))
    return f"{blazepose}-{joints}-{hashlib.sha256(how.encode()).hexdigest()[:8]}"


_HIPS = [NAMES.index(f"{side}_hip") for side in ("left", "right")]
_SHOULDERS = [NAMES.index(f"{side}_shoulder") for side in ("left", "right")]


def _distance(first: Array, second: Array) -> float:
    return float(np.linalg.norm(first - second, axis=1).sum())
