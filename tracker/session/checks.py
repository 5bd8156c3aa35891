"""Whether the values of a session, each valid by itself, fit together."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import rotation_from_quaternion
from keypose.tracker.session.ahead import require_ahead
from keypose.tracker.session.annotations import require_corrections
from keypose.tracker.session.keyframe import Keyframe, quaternions_of
from keypose.tracker.session.notes import require_notes
from keypose.tracker.session.part_keyframes import require_part_keyframes
from keypose.tracker.session.pins import require_pins
from keypose.tracker.session.settings import Position

if TYPE_CHECKING:
    from keypose.tracker.session.schema import Session

NEAREST_M = 0.05
"""The least depth of a joint."""

MOST: Mapping[str, int] = {
    "keyframes": 10_000,
    "part_keyframes": 10_000,
    "drafts": 10_000,
    "ignore_masks": 10_000,
    "keypoint_corrections": 10_000,
    "pins": 1_000,
    "notes": 1_000,
    "reviewed": 10_000,
    "ahead": 100,
}
"""Far above what a person sets in a session."""

POSES_AT_A_TIME = 500


def require_fit(session: Session, poses: Sequence[Keyframe]) -> None:
    """ValueError in one sentence unless the session's values, each valid by itself, fit together.

    poses: the keyframes, of parts too, and drafts to check against body and video; the others are
        known to fit.
    """
    require_few({name: getattr(session, name) for name in MOST})
    camera, video = session.camera, session.video
    if (camera.width, camera.height) != (video.width, video.height):
        raise ValueError(
            f"camera.width × height is {camera.width}×{camera.height} but video.width × height is "
            f"{video.width}×{video.height}; the sizes must agree, both the video's own"
        )
    _require_sorted(session.keyframes)
    _require_sorted(session.drafts)
    _require_sorted(session.part_keyframes)
    require_part_keyframes(session)
    _require_direction(session.up_camera)
    _require_parts(session.settings.left_out, session.body)
    require_pins(session.pins, session.body, video.frame_count)
    require_notes(session.notes, video.frame_count)
    require_ahead(session.ahead, session.body, video.frame_count)
    require_corrections(session.keypoint_corrections, video.frame_count, video.width, video.height)
    for keyframe in poses:
        _require_in_video(keyframe, video.frame_count)
        _require_known_parts(keyframe, session.body)
    skeleton = Skeleton.of(session.body)
    for start in range(0, len(poses), POSES_AT_A_TIME):
        _require_before_camera(poses[start : start + POSES_AT_A_TIME], skeleton)


def _require_sorted(keyframes: Sequence[Keyframe]) -> None:
    for one, other in pairwise(keyframes):
        before, after = one.frame, other.frame
        if before == after:
            raise ValueError(f"keyframes: frame {before} has two keyframes; one is allowed")
        if before > after:
            raise ValueError(f"keyframes: frame {after} stands after {before}; sort them by frame")
        if one.time_s >= other.time_s:
            raise ValueError(
                f"keyframes: time_s of frame {after} is {other.time_s:g}; it must be later than "
                f"{one.time_s:g}, the time of frame {before}"
            )


def _require_parts(left_out: tuple[str, ...], body: Body) -> None:
    unknown = sorted(set(left_out) - set(body.names))
    if unknown:
        raise ValueError(
            f"settings.left_out names {unknown[0]!r}, which the body does not have; its parts are "
            f"{', '.join(body.names)}"
        )


def _require_direction(up_camera: Position | None) -> None:
    if up_camera is not None and math.hypot(*up_camera) < 1e-6:
        raise ValueError("up_camera: [0, 0, 0] is no direction")


def _require_in_video(keyframe: Keyframe, frame_count: int) -> None:
    if keyframe.frame >= frame_count:
        raise ValueError(
            f"keyframes: frame {keyframe.frame} is beyond the video, "
            f"whose frames are 0 to {frame_count - 1}"
        )


def _require_known_parts(keyframe: Keyframe, body: Body) -> None:
    unknown = sorted(keyframe.rotations_wxyz.keys() - set(body.names))
    if unknown:
        raise ValueError(
            f"keyframes: frame {keyframe.frame} poses {unknown[0]!r}, which the body does not "
            f"have; its parts are {', '.join(body.names)}"
        )


def _require_before_camera(keyframes: Sequence[Keyframe], skeleton: Skeleton) -> None:
    names = skeleton.body.names
    quaternions = np.array([quaternions_of(keyframe, names) for keyframe in keyframes])
    roots = np.array([keyframe.root_m for keyframe in keyframes])
    z = part_transforms(skeleton, rotation_from_quaternion(quaternions), roots)[..., 2, 3]
    behind = np.flatnonzero(~(z.min(axis=-1) > NEAREST_M))
    if len(behind):
        first = behind[0]
        raise ValueError(
            f"keyframes: frame {keyframes[first].frame} has {names[int(np.argmin(z[first]))]!r} "
            f"behind the camera; every joint needs a depth of more than {NEAREST_M} m"
        )


def require_few(data: Mapping[str, Any]) -> None:
    """ValueError when a list is longer than a session may have; checked before any of it is read,
    which could take minutes."""
    for name, most in MOST.items():
        given = data.get(name)
        if isinstance(given, list | tuple) and len(given) > most:
            raise ValueError(f"{name}: {len(given)} are more than the {most} a session may have")
