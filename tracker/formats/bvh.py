"""The motion as BVH (Biovision hierarchy), which animation programs read.

World of the file: x to the picture's right, y up, z from the scene toward the camera; its origin is
the camera. It is the camera frame turned by half a turn about x, F = diag(1, −1, −1). Every part's
frame is turned likewise, R' = F R F and offset' = F offset, so that in the rest pose all frames of
the file are parallel to its world, and a body that stands has its legs along −y.

Lengths are centimetres, angles degrees. Channels: position, then Z, Y, X rotation for the root;
Z, Y, X rotation for the others: R' = Rz·Ry·Rx, as the order of the channels says. Angles run on
smoothly from frame to frame, past half a turn where the motion does. The root's offset is zero: its
channels hold the whole position. A part without children ends in its farthest landmark or, when it
has none, in the end of its shape. Frames are evenly spaced, as BVH knows nothing else.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tracker.body.body import Part
from tracker.body.skeleton import Skeleton
from tracker.body.trajectory import Trajectory
from tracker.errors import FormatError
from tracker.formats.axes import flipped, flipped_rotations
from tracker.formats.decimals import fixed_decimals
from tracker.formats.euler_curves import smooth_euler
from tracker.formats.names import single_words
from tracker.geometry.rotations import Array

CM_PER_M = 100.0
DECIMALS = 6


def bvh(skeleton: Skeleton, trajectory: Trajectory, seconds_per_frame: float) -> str:
    """The text of the file. FormatError when the time between frames is not positive."""
    if not 0.0 < seconds_per_frame < np.inf:
        raise FormatError("A BVH file needs a positive time between its frames.")
    hierarchy = _part_lines(skeleton, 0, single_words(skeleton.body.names), indent="")
    motion = [
        "MOTION",
        f"Frames: {len(trajectory)}",
        f"Frame Time: {seconds_per_frame:.9f}",
        *(_row(values) for values in _channels(skeleton, trajectory)),
    ]
    return "\n".join(["HIERARCHY", *hierarchy, *motion]) + "\n"


def end_site(part: Part) -> tuple[float, float, float]:
    """Where a part without children ends, in its own frame, metres."""
    if part.landmarks:
        return max(part.landmarks.values(), key=lambda p: float(np.linalg.norm(p)))
    return part.shape.far_end


def _part_lines(
    skeleton: Skeleton, index: int, names: tuple[str, ...], indent: str
) -> Iterator[str]:
    is_root = skeleton.parents[index] < 0
    offset = np.zeros(3) if is_root else skeleton.joints[index]
    inner = f"{indent}  "
    yield f"{indent}{'ROOT' if is_root else 'JOINT'} {names[index]}"
    yield f"{indent}{{"
    yield f"{inner}OFFSET {_row(_flipped_cm(offset))}"
    rotations = "Zrotation Yrotation Xrotation"
    if is_root:
        yield f"{inner}CHANNELS 6 Xposition Yposition Zposition {rotations}"
    else:
        yield f"{inner}CHANNELS 3 {rotations}"
    children = np.flatnonzero(skeleton.parents == index)
    for child in children:
        yield from _part_lines(skeleton, int(child), names, inner)
    if not len(children):
        end = _row(_flipped_cm(np.array(end_site(skeleton.body.parts[index]))))
        yield from (f"{inner}End Site", f"{inner}{{", f"{inner}  OFFSET {end}", f"{inner}}}")
    yield f"{indent}}}"


def _channels(skeleton: Skeleton, trajectory: Trajectory) -> Array:
    """(N, 3 + 3P): the root's position, then the angles of the parts in the file's order."""
    angles = smooth_euler(flipped_rotations(trajectory.Rs_parent_part))
    angles = np.rad2deg(angles)[:, list(_depth_first(skeleton, 0))]
    positions = _flipped_cm(trajectory.ps_camera_root)
    return np.concatenate([positions, angles.reshape(len(trajectory), -1)], axis=1)


def _depth_first(skeleton: Skeleton, index: int) -> Iterator[int]:
    yield index
    for child in np.flatnonzero(skeleton.parents == index):
        yield from _depth_first(skeleton, int(child))


def _flipped_cm(points_m: Array) -> Array:
    return flipped(points_m) * CM_PER_M


def _row(values: Sequence[float] | Array) -> str:
    return " ".join(fixed_decimals(values, DECIMALS))
