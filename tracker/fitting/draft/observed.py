"""Prepare the keypoints of a clip for drafts, with a person's limbs as chains of joints."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import ROTATIONS, Body, Point
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.on_body import foot_end, points_on_body
from keypose.tracker.keypoints.outliers import excursions
from keypose.tracker.solver.posed import BodyPoints

SIDES: Final = ("left", "right")
LIMBS: Final = (("shoulder", "elbow", "wrist"), ("hip", "knee", "ankle"))
ENDS: Final = (
    *("nose", "left_ear", "right_ear", "left_heel", "right_heel"),
    *("left_foot_index", "right_foot_index"),
)
"""Keypoints that show how head and feet are turned."""
POINTS: Final = (*JOINTS, *ENDS)
_ON_HEAD: Final = {
    "nose": (0.0, 0.4, -0.55), "left_ear": (0.4, 0.45, 0.0), "right_ear": (-0.4, 0.45, 0.0)
}  # fmt: skip
"""Where on a head they are: to the side, up and forward, as shares of its height."""
_NEARER_M: Final = {"elbow": 0.02, "wrist": 0.01, "ankle": 0.02}
"""The network puts these so much nearer to the trunk, along the limb, than where the limb turns:
the mean over four people in five clips, two of them rendered. With it 13 % fewer joints of their
drafts are more than 7 px off."""
_FARTHER_M: Final = {"hip": 0.022, "shoulder": -0.012}
"""The network puts these so much farther from the middle of the body than where the limb turns:
two people with markers. Hips at their joints turned the line between them by 10° too little."""


class Bone(NamedTuple):
    """From one joint to the next: places among `JOINTS`, and the part between them."""

    near: int
    far: int
    part: int


class Limb(NamedTuple):
    """An arm or a leg: its upper and its lower bone, and where its hinge bends to: the far joint
    goes along this direction of the upper part when the limb is bent."""

    upper: Bone
    lower: Bone
    bends_to: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Joints:
    """The twelve `JOINTS` of a person's body.

    parts (12,): the part that carries each.  points: them on the body.  seen: where on it the
    network puts them.
    rest (12, 3): where they are in the rest pose, metres from the root.
    limbs: arms and legs, left before right.
    ends: where the body has points of `ENDS`, places among `POINTS`, and these points on it.
    """

    skeleton: Skeleton
    parts: NDArray[np.int64]
    points: BodyPoints
    seen: BodyPoints
    rest: Array
    limbs: tuple[Limb, ...]
    ends: tuple[NDArray[np.int64], BodyPoints]

    @classmethod
    def of(cls, skeleton: Skeleton) -> Joints:
        """KeypointError for a body without one of them."""
        body = skeleton.body
        index, parts, places = points_on_body(body, JOINTS)
        if len(index) < len(JOINTS):
            raise KeypointError(
                f"The body {body.name!r} has no joints of a person's arms and legs: a draft is "
                "made of people only."
            )
        points = BodyPoints.single(skeleton, parts, places)
        rest = points.at(pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0))))
        limbs = tuple(_limb(body, parts, side, names) for names in LIMBS for side in SIDES)
        body_points = BodyPoints.single(skeleton, parts, places - _nearer(places))
        return cls(skeleton, parts, points, body_points, rest, limbs, _ends(skeleton))

    def length_m(self, bone: Bone) -> float:
        """The length of a bone on this body."""
        return float(np.linalg.norm(self.rest[bone.far] - self.rest[bone.near]))

    def seen_length_m(self, bone: Bone) -> float:
        """Between the points that the network sees at its ends."""
        near, far = (_NEARER_M.get(JOINTS[end].split("_")[1], 0.0) for end in (bone.near, bone.far))
        return self.length_m(bone) + near - far

    def on_joints(self, p_hips: Array) -> Array:
        """(N, 12, 3) landmarks with hips and shoulders where the joints are, of those where the
        network puts them: as much nearer to each other as on this body."""
        p, width = p_hips.copy(), np.abs(self.rest[:, 0])
        for joint, farther_m in _FARTHER_M.items():
            left, right = (place_of(side, joint) for side in SIDES)
            share = width[left] / (width[left] + farther_m)
            half = 0.5 * share * (p_hips[:, left] - p_hips[:, right])
            middle = 0.5 * (p_hips[:, left] + p_hips[:, right])
            p[:, left], p[:, right] = middle + half, middle - half
        return p

    @property
    def bones(self) -> tuple[Bone, ...]:
        """Upper and lower ones of all limbs."""
        return tuple(bone for limb in self.limbs for bone in (limb.upper, limb.lower))


def place_of(side: str, joint: str) -> int:
    """Among `JOINTS`."""
    return JOINTS.index(f"{side}_{joint}")


def _nearer(places: Array) -> Array:
    """(12, 3) from where the network puts the joints to where they are, in their parts' frames."""
    length = np.linalg.norm(places, axis=-1, keepdims=True)
    by_m = np.array([_NEARER_M.get(name.split("_")[1], 0.0) for name in JOINTS])
    nearer = np.asarray(places / np.maximum(length, 1e-9) * by_m[:, None])
    aside_m = np.array([_FARTHER_M.get(name.split("_")[1], 0.0) for name in JOINTS])
    nearer[:, 0] -= np.sign(places[:, 0]) * aside_m
    return nearer


def turning_ends(joints: Joints) -> Skeleton:
    """The body with those parts alone free to turn that carry `ENDS`."""
    body = joints.skeleton.body
    ends = {body.names[part] for place in joints.ends[1].points for part, _ in place}
    parts = (
        part.model_copy(update={"tracked": ROTATIONS if part.name in ends else ()})
        for part in body.parts
    )
    return Skeleton.of(body.replaced(parts))


def _ends(skeleton: Skeleton) -> tuple[NDArray[np.int64], BodyPoints]:
    place_of_end = {name: place for name in ENDS if (place := _end(skeleton.body, name))}
    index = np.array([POINTS.index(name) for name in place_of_end], dtype=np.int64)
    return index, BodyPoints(skeleton, tuple((place,) for place in place_of_end.values()))


def _end(body: Body, name: str) -> tuple[int, Point] | None:
    """The part that carries an end and where; None on a body without it."""
    if name in _ON_HEAD:
        top = _landmark(body, "head", "head_top")
        if top is None:
            return None
        aside, up, forward = _ON_HEAD[name]
        size = -top[1]
        return body.index("head"), (aside * size, -up * size, forward * size)
    return foot_end(body, name)


def _landmark(body: Body, part: str, name: str) -> Point | None:
    return body.parts[body.index(part)].landmarks.get(name) if part in body.names else None


def _limb(body: Body, parts: NDArray[np.int64], side: str, names: tuple[str, ...]) -> Limb:
    near, middle, far = (place_of(side, name) for name in names)
    upper, lower = int(parts[middle]), int(parts[far])
    low, high = body.parts[lower].limits_deg.get("x", (0.0, 0.0))
    # a turn by a positive angle about x brings a point from +y to +z
    bends_to = (0.0, 0.0, float(np.sign(low + high)))
    return Limb(Bone(near, middle, upper), Bone(middle, far, lower), bends_to)


SEEN = 0.3
"""Visibility from which a joint counts as seen."""
FEWEST_SEEN = 6
"""Joints with which a frame is drafted."""
JUMP = 0.35
"""Of the person's extent in the picture: nobody moves so far from one frame to the next."""
GAP = 5
"""So many frames without a person are bridged: the motion before and after is one."""


@dataclass(frozen=True, eq=False)
class Observed:
    """Keypoints in N consecutive frames: the twelve `JOINTS`, then `ENDS`, K together.

    first_frame: of the video.
    uv (N, K, 2): pixels of an ideal lens, 0 where unknown.  known (N, K).
    visibility (N, K): 0 where unknown.
    p_hips (N, K, 3): metres in axes parallel to the picture's, NaN where unknown.
    depth_sigma_m (N, K): of p_hips along the view, NaN where that is not known.
    usable (N,): frames that show enough of a person.
    jumped (N,): frames from which on this may be another person: they are suddenly elsewhere, or
    followed back the body comes to another place.
    """

    first_frame: int
    uv: Array
    known: NDArray[np.bool_]
    visibility: Array
    p_hips: Array
    usable: NDArray[np.bool_]
    jumped: NDArray[np.bool_]
    depth_sigma_m: Array

    @property
    def is_lifted(self) -> bool:
        """Whether depth was lifted from what is seen around a frame."""
        return bool(np.isfinite(self.depth_sigma_m).any())

    def __len__(self) -> int:
        return len(self.uv)

    @classmethod
    def of(cls, keypoints: Keypoints, camera: Camera, changes: Collection[int] = ()) -> Observed:
        """KeypointError where joints or their depths are not known at all.

        changes: frames from which on they may be another person's, besides those they jump at.
        """
        missing = [name for name in JOINTS if name not in keypoints.names]
        if keypoints.p_hips is None or missing:
            lacking = missing[0].replace("_", " ") if missing else "depth"
            raise KeypointError(
                f"These keypoints have no {lacking}: a draft needs a person's arms and legs with "
                "their depth, as Keypose finds them."
            )
        columns = [_column(keypoints, keypoints.p_hips, name) for name in POINTS]
        filmed, visibilities, p_hips = (
            np.stack(values, axis=1) for values in zip(*columns, strict=True)
        )
        uv = camera.without_distortion().project(camera.back_project(filmed, 1.0))
        is_known = np.asarray(np.isfinite(uv).all(-1) & np.isfinite(p_hips).all(-1))
        visibility = np.where(is_known, visibilities, 0.0)
        usable = (visibility[:, : len(JOINTS)] >= SEEN).sum(axis=1) >= FEWEST_SEEN
        uv = np.where(is_known[..., None], uv, 0.0)
        usable = np.asarray(usable)
        jumped = jumps(uv, is_known, usable) | _begins(changes, keypoints.first_frame, usable)
        sigma_m = _sigmas_m(keypoints)
        return cls(keypoints.first_frame, uv, is_known, visibility, p_hips, usable, jumped, sigma_m)

    def rows(self, rows: slice) -> Observed:
        """Some of the frames."""
        first = self.first_frame + (rows.start or 0)
        return replace(
            self,
            first_frame=first,
            uv=self.uv[rows],
            known=self.known[rows],
            visibility=self.visibility[rows],
            p_hips=self.p_hips[rows],
            usable=self.usable[rows],
            jumped=self.jumped[rows],
            depth_sigma_m=self.depth_sigma_m[rows],
        )

    def without_jumps(self, height_px: float) -> Observed:
        """Mark as unknown the keypoints that are outliers for a few frames. height_px: of
        the body.
        """
        return self.without(excursions(self.uv, self.known, height_px, POINTS, self.p_hips))

    def without(self, disbelieved: NDArray[np.bool_]) -> Observed:
        """Mark some of the keypoints (N, K) as unknown."""
        is_known = self.known & ~disbelieved
        return replace(self, known=is_known, visibility=np.where(is_known, self.visibility, 0.0))

    def with_depth_of(self, observed: Observed) -> Observed:
        """Take over where keypoints are in space."""
        return replace(self, p_hips=observed.p_hips, depth_sigma_m=observed.depth_sigma_m)

    def keypoints(self) -> Keypoints:
        """The same as keypoints of an ideal lens, unseen where unknown."""
        uv = np.where(self.known[..., None], self.uv, np.nan)
        return Keypoints(self.first_frame, POINTS, uv, self.visibility, self.p_hips)

    def bridged(self, rest: Array) -> Array:
        """(N, 12, 3) the joints' p_hips: where a joint is not known, linear between the frames
        that know it, and as in the rest pose (12, 3) where none does."""
        out, frames = self.p_hips[:, : len(JOINTS)].copy(), np.arange(len(self))
        for k in range(len(JOINTS)):
            known_frames = np.flatnonzero(self.known[:, k])
            for axis in range(3):
                values = out[known_frames, k, axis] if len(known_frames) else [rest[k, axis]]
                out[:, k, axis] = np.interp(
                    frames, known_frames if len(known_frames) else [0], values
                )
        return out

    def runs(self) -> list[slice]:
        """Stretches of frames that show one person, short gaps included."""
        usable_frames = np.flatnonzero(self.usable)
        if not len(usable_frames):
            return []
        ends = np.flatnonzero((np.diff(usable_frames) > GAP + 1) | self.jumped[usable_frames[1:]])
        firsts, lasts = [0, *(ends + 1)], [*ends, len(usable_frames) - 1]
        return [
            slice(int(usable_frames[a]), int(usable_frames[b]) + 1)
            for a, b in zip(firsts, lasts, strict=True)
        ]


def _column(keypoints: Keypoints, p_hips: Array, name: str) -> tuple[Array, Array, Array]:
    """One keypoint in all frames uv (N, 2), visibility (N,) and p_hips (N, 3); NaN and 0
    where there is none of that name.
    """
    if name in keypoints.names:
        k = keypoints.names.index(name)
        return keypoints.uv[:, k], keypoints.visibility[:, k], p_hips[:, k]
    count = len(keypoints)
    return np.full((count, 2), np.nan), np.zeros(count), np.full((count, 3), np.nan)


def _sigmas_m(keypoints: Keypoints) -> Array:
    """(N, K) the deviation of the depth of `POINTS`; NaN where it is not known."""
    sigma_m = np.full((len(keypoints), len(POINTS)), np.nan)
    if keypoints.depth_sigma_m is not None:
        for k, name in enumerate(POINTS):
            if name in keypoints.names:
                sigma_m[:, k] = keypoints.depth_sigma_m[:, keypoints.names.index(name)]
    return sigma_m


def _begins(frames: Collection[int], first: int, usable: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(N,) the first usable frame at or after each of these."""
    out, rows = np.zeros(len(usable), np.bool_), np.flatnonzero(usable)
    for frame in frames:
        out[rows[rows >= frame - first][:1]] = True
    return out


def jumps(uv: Array, is_known: NDArray[np.bool_], usable: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(N,) whether the joints are elsewhere than in the usable frame before."""
    out = np.zeros(len(uv), np.bool_)
    rows = np.flatnonzero(usable)
    for before, here in pairwise(rows.tolist()):
        both = is_known[before] & is_known[here]
        a, b = uv[before, both], uv[here, both]
        extent = max(np.ptp(a, axis=0).max(initial=0.0), np.ptp(b, axis=0).max(initial=0.0))
        step = np.linalg.norm(np.median(b - a, axis=0)) if both.any() else 0.0
        out[here] = step > JUMP * max(extent, 1.0) * np.sqrt(here - before)
    return out


def unit(v: Array) -> Array:
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-9))
