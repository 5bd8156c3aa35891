"""Name joint markers, and the markers of files (TRC, C3D) by the name of their set.

keypose:  every joint and landmark of the body, under its own name.
halpe26:  the markers of HALPE_26 by the names of Pose2Sim (Pagnon et al. 2021) and its marker file
          for full-body models after Rajagopal et al. (2016), eyes and ears left out as there.

They lie in the world of all files (`keypose.tracker.body.ground`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body, Point
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import column_names
from keypose.tracker.formats.recording import MarkerSetName, Recording
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.solver.posed import BodyPoint, BodyPoints

_LIMBS = {
    "Shoulder": "upper_arm",
    "Elbow": "forearm",
    "Wrist": "hand",
    "Hip": "thigh",
    "Knee": "shin",
    "Ankle": "foot",
}

JOINT_MARKERS = {
    **{f"L{joint}": (f"left_{part}",) for joint, part in _LIMBS.items()},
    **{f"R{joint}": (f"right_{part}",) for joint, part in _LIMBS.items()},
    "Neck": ("neck",),
    "hip": ("left_thigh", "right_thigh"),
    "Hip": ("left_thigh", "right_thigh"),
}
"""Markers with the parts at whose joint they are, or in the middle of whose joints."""

CENTRE_MARKERS = {"Head": "head"}
"""Markers with the part in the middle of whose shape they are."""

_ORIGIN = (0.0, 0.0, 0.0)


def places_of(skeleton: Skeleton, names: Sequence[str], file: str) -> tuple[BodyPoint, ...]:
    """Where on the body each named joint is; FormatError names the first one it does not
    have.
    """
    return tuple(_place(skeleton, name, file) for name in names)


def _place(skeleton: Skeleton, name: str, file: str) -> BodyPoint:
    """A part's joint, a landmark, or a marker of the usual names, in this order."""
    body = skeleton.body
    if name in body.names:
        return ((body.index(name), _ORIGIN),)
    for i, part in enumerate(body.parts):
        if name in part.landmarks:
            return ((i, part.landmarks[name]),)
    centred = CENTRE_MARKERS.get(name)
    if centred in body.names:
        i = body.index(centred)
        return ((i, body.parts[i].shape.centre),)
    parts = JOINT_MARKERS.get(name, ())
    if parts and set(parts) <= set(body.names):
        return tuple((body.index(part), _ORIGIN) for part in parts)
    raise FormatError(
        f"{file} names {name!r}, which is no joint of the body and no marker of it; its joints are "
        f"{', '.join(body.names)}."
    )


_HALPE_26: Final[Mapping[str, str]] = {
    "Nose": "nose",
    "Head": "head_top",
    "Neck": "neck",
    "LShoulder": "left_shoulder",
    "RShoulder": "right_shoulder",
    "LElbow": "left_elbow",
    "RElbow": "right_elbow",
    "LWrist": "left_wrist",
    "RWrist": "right_wrist",
    "Hip": "mid_hip",
    "LHip": "left_hip",
    "RHip": "right_hip",
    "LKnee": "left_knee",
    "RKnee": "right_knee",
    "LAnkle": "left_ankle",
    "RAnkle": "right_ankle",
    "LBigToe": "left_big_toe",
    "LSmallToe": "left_small_toe",
    "LHeel": "left_heel",
    "RBigToe": "right_big_toe",
    "RSmallToe": "right_small_toe",
    "RHeel": "right_heel",
}
"""Markers, in the order of Pose2Sim's file, by the keypoint each is."""

BIG_TOE = (0.35, 1.0)
SMALL_TOE = (-0.65, 0.8)
"""Estimates: shares of half the foot's width inward, and of its length before the ankle."""


@dataclass(frozen=True)
class Marker:
    """A point that moves with a part; p_part in metres."""

    name: str
    part: str
    p_part: Point


def markers_of(body: Body, marker_set: MarkerSetName) -> tuple[Marker, ...]:
    """The markers of a set on a body. FormatError where the body has no place for one.

    A joint is on the part nearer to the root, as it is between both.
    """
    if marker_set == "keypose":
        return _own_markers(body)
    places = {name: _halpe_place(body, keypoint) for name, keypoint in _HALPE_26.items()}
    missing = [name for name, place in places.items() if place is None]
    if missing:
        raise FormatError(
            f"The markers of {marker_set} are those of a person, and this body has no "
            f"{missing[0]}: choose the markers keypose."
        )
    return tuple(Marker(name, *place) for name, place in places.items() if place is not None)


def marked(recording: Recording) -> tuple[tuple[str, ...], Array]:
    """The markers' names and where they are in the world (N, M, 3), metres, of the set that the
    recording is to be written with."""
    if recording.marker_set == "keypose":
        names = column_names(recording.skeleton)
        return names, recording.world.points(recording.ps_camera_joint)
    body = recording.skeleton.body
    markers = markers_of(body, recording.marker_set)
    points = tuple(((body.index(each.part), each.p_part),) for each in markers)
    places = BodyPoints(recording.skeleton, points)
    ps_camera = places.at(recording.trajectory.transforms(recording.skeleton))
    return tuple(marker.name for marker in markers), recording.world.points(ps_camera)


def detected(body: Body, markers: Sequence[Marker]) -> NDArray[np.int64]:
    """(M,) which of `JOINTS` each marker is; −1 of one that no detector knows."""
    index, parts, points = points_on_body(body, JOINTS)
    joints = np.full(len(markers), -1, np.int64)
    for number, marker in enumerate(markers):
        part = body.index(marker.part)
        same = (parts == part) & np.isclose(points, marker.p_part).all(axis=-1)
        if same.any():
            joints[number] = index[same][0]
    return joints


def _own_markers(body: Body) -> tuple[Marker, ...]:
    names = iter(column_names(Skeleton.of(body)))
    places = [
        (part.name, (0.0, 0.0, 0.0)) if part.parent is None else (part.parent, part.joint_m)
        for part in body.parts
    ]
    places += [(part.name, point) for part in body.parts for point in part.landmarks.values()]
    return tuple(Marker(next(names), part, point) for part, point in places)


def _halpe_place(body: Body, keypoint: str) -> tuple[str, Point] | None:
    """The part and the point in its frame; None where the body has not what it takes."""
    points = points_on_body(body, (keypoint,))
    if len(points.indices):
        x, y, z = points.point[0].tolist()
        return body.names[int(points.part[0])], (x, y, z)
    side, _, joint = keypoint.partition("_")
    foot = f"{side}_foot"
    if joint in ("big_toe", "small_toe", "heel") and foot in body.names:
        return _on_foot(body, side, joint)
    if keypoint == "mid_hip" and {"left_thigh", "right_thigh"} <= set(body.names):
        thighs = [body.parts[body.index(f"{s}_thigh")] for s in ("left", "right")]
        x, y, z = np.mean([thigh.joint_m for thigh in thighs], axis=0).tolist()
        return (thighs[0].parent or "", (x, y, z))
    if keypoint == "neck" and "neck" in body.names:
        neck = body.parts[body.index("neck")]
        return (neck.parent or "", neck.joint_m)
    head = next((p for p in body.parts if "head_top" in p.landmarks), None)
    if keypoint == "head_top" and head is not None:
        return head.name, head.landmarks["head_top"]
    return None


def _on_foot(body: Body, side: str, joint: str) -> tuple[str, Point] | None:
    """Heel and toes; forward is −z, and the middle lies at +x of a right foot."""
    foot = body.parts[body.index(f"{side}_foot")]
    heel, toe = (foot.landmarks.get(f"{side}_{end}") for end in ("heel", "toe"))
    if heel is None or toe is None:
        return None
    if joint == "heel":
        return foot.name, heel
    inward, along = BIG_TOE if joint == "big_toe" else SMALL_TOE
    vertices = foot.shape.mesh().vertices
    half = float(np.ptp(vertices[:, 0])) / 2 * (-1.0 if side == "left" else 1.0)
    return foot.name, (toe[0] + inward * half, toe[1], along * toe[2])
