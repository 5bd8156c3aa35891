"""Where on a body the keypoints are that every detector of people knows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body, Point
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS

FACE: Final = ("nose", "left_ear", "right_ear")
FEWEST: Final = 4
"""Joints with which a body, or what is seen of it, can be compared with keypoints."""
OTHER_PERSON: Final = 0.10
"""Keypoints that miss a posed body by this share of its height lie on another person."""
_LIMB_PARTS: Final = {
    "shoulder": (None, "upper_arm"),
    "elbow": ("upper_arm", "forearm"),
    "wrist": ("forearm", "hand"),
    "hip": (None, "thigh"),
    "knee": ("thigh", "shin"),
    "ankle": ("shin", "foot"),
}
"""By joint the limb's part before it and the one after it; a limb's first joint is on the trunk."""
_FOOT_LANDMARKS: Final = {"heel": "heel", "foot_index": "toe"}
HEAD_POINTS: Final = {"nose": (0.0, 0.42, -0.55), "left_ear": (0.4, 0.45, 0.0)}
"""On a head whose top is so far from its joint: shares of that height, forward being −z."""


class PointsOnBody(NamedTuple):
    """Which keypoints are on the body, and where.

    indices: (L,) among the names that were asked for.
    part:    (L,) index of the part that carries the point, the one nearer to the trunk.
    point:   (L, 3) metres in that part's frame.
    """

    indices: NDArray[np.int64]
    part: NDArray[np.int64]
    point: Array


def points_on_body(body: Body, names: Sequence[str]) -> PointsOnBody:
    """The points of a body at which these keypoints are seen, in the order of the names.

    Known are `JOINTS`, by the parts' names as in the presets: a joint lies on the part nearer to
    the trunk, where the next part begins; and nose and ears, where the body has a head as theirs. A
    body without such parts, a box, has none. (Heels and toes made a tracked ankle shake half as
    much again, and nothing more accurate.)
    """
    return _points(body, names, _place)


def foot_ends(body: Body, names: Sequence[str]) -> PointsOnBody:
    """The heels and toes of a body among these keypoints, in the order of the names."""
    return _points(body, names, foot_end)


def _points(
    body: Body, names: Sequence[str], place_of: Callable[[Body, str], tuple[int, Point] | None]
) -> PointsOnBody:
    located = [(index, *at) for index, name in enumerate(names) if (at := place_of(body, name))]
    return PointsOnBody(
        np.array([index for index, _, _ in located], dtype=np.int64),
        np.array([part for _, part, _ in located], dtype=np.int64),
        np.array([point for _, _, point in located], dtype=np.float64).reshape(-1, 3),
    )


def foot_end(body: Body, name: str) -> tuple[int, Point] | None:
    """The foot that carries a heel or a toe, such as left_heel and left_foot_index, and where; None
    of another keypoint, or on a body without it."""
    side, _, end = name.partition("_")
    part, landmark = f"{side}_foot", _FOOT_LANDMARKS.get(end)
    if landmark is None or part not in body.names:
        return None
    index = body.index(part)
    place = body.parts[index].landmarks.get(f"{side}_{landmark}")
    return None if place is None else (index, place)


def is_persons(body: Body) -> bool:
    """Whether enough of a person's joints are on a body for keypoints to be compared with
    it.
    """
    return len(points_on_body(body, JOINTS).indices) >= FEWEST


def height_px(skeleton: Skeleton, camera: Camera, pose: Pose) -> float:
    """How tall the body is in the picture, were it to stand where it is."""
    rest = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))[:, :3, 3]
    tall = float(np.ptp(rest, axis=0).max()) * 1.1  # joints end at ankles and neck
    return tall * camera.fy / float(camera.depth(pose.p_camera_root))


def _place(body: Body, name: str) -> tuple[int, Point] | None:
    """The part that carries a joint, and the joint in its frame.

    It is where the limb's next part begins. A limb that ends there, a forearm without a hand, has
    the joint as a landmark of the same name, or not at all.
    """
    if name not in JOINTS:
        return _on_head(body, name)
    side, joint = name.split("_")
    before, after = (part and f"{side}_{part}" for part in _LIMB_PARTS[joint])
    if after in body.names:
        part = body.parts[body.index(after)]
        if part.parent is not None and before in (None, part.parent):
            return body.index(part.parent), part.joint_m
    if before in body.names:
        index = body.index(before)
        landmark = body.parts[index].landmarks.get(name)
        return None if landmark is None else (index, landmark)
    return None


def _on_head(body: Body, name: str) -> tuple[int, Point] | None:
    """The nose or an ear; None where there is no head, or nothing says how tall it is."""
    share = HEAD_POINTS.get(name.replace("right_", "left_"))
    if share is None or "head" not in body.names:
        return None
    index = body.index("head")
    top = body.parts[index].landmarks.get("head_top")
    if top is None:
        return None
    tall = -top[1]
    sideways = -1.0 if name.startswith("right_") else 1.0
    return index, (sideways * share[0] * tall, -share[1] * tall, share[2] * tall)
