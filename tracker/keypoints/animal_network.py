"""An animal's keypoints in one region of one picture, and where to look next: a network of joints
that nothing else looks beside.
"""

from __future__ import annotations

from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.keypoints.blazepose import Seen
from keypose.tracker.keypoints.joint_network import SeenJoints
from keypose.tracker.keypoints.region import Region

SEEN: Final = 0.3
"""Confidence from which on a keypoint says where the animal is."""
FEWEST: Final = 5
"""Such keypoints without which there is no animal."""

SHRINKS: Final = 0.97
"""By how much a region is smaller than the one before at most: a head that is not seen for some
frames would be left out of the picture, and never be seen again."""


class SeesJoints(Protocol):
    """What sees keypoints in a region, as `JointNetwork`."""

    @property
    def fingerprint(self) -> str: ...
    def infer(self, picture: NDArray[np.uint8], region: Region) -> SeenJoints: ...


class AnimalNetwork:
    """A network of animals that follows one from frame to frame, as `detect` asks for it."""

    def __init__(self, joints: SeesJoints) -> None:
        self._joints = joints
        self.fingerprint = animal_fingerprint(joints.fingerprint)

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        """The keypoints of the animal in a region of a picture (H, W, 3), RGB. Their depth is not
        known: it is 0 throughout."""
        joints = self._joints.infer(picture, region)
        uv = joints.uv
        visibility = np.where(np.isfinite(uv).all(axis=1), joints.confidence, 0.0)
        sure = visibility >= SEEN
        present = int(sure.sum()) >= FEWEST
        around = _hardly_smaller(region, Region.of_joints(uv[sure])) if present else region
        return Seen(
            uv=np.nan_to_num(uv),
            visibility=visibility,
            p_hips=np.zeros((len(uv), 3)),
            presence=float(present),
            next=around,
        )


def _hardly_smaller(before: Region, around: Region) -> Region:
    """The region that was seen, made no smaller than nearly the one before, from which it then is
    moved as little as it can be."""
    side = max(around.side, SHRINKS * before.side)
    room = (side - around.side) / 2
    x = min(max(before.x, around.x - room), around.x + room)
    y = min(max(before.y, around.y - room), around.y + room)
    return Region(x, y, side)


def animal_fingerprint(joints: str) -> str:
    """What `AnimalNetwork.fingerprint` is of a network of this fingerprint."""
    return f"{joints}-animal"
