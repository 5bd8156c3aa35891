"""Draft poses from 2D keypoints. Keyframes are never touched."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from keypose.app.editor.documents import keyframe_of
from keypose.app.editor.frames import up_of
from keypose.app.posing import opening_pose
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import interpolate
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_names import Matched, match_also, matched
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.layouts import keypoint_name
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.settings import Position
from keypose.tracker.solver.fit_joints import fit_picture
from keypose.tracker.solver.posed import BodyPoints

LEAST_KEYPOINTS = 5
SHOWN = 6
"""Names of a file in a sentence."""
NEAREST_M = 0.06
POOR_PX = 0.05
"""Mean miss of a draft's joints, as a share of the keypoints' extent, above which it is poor."""


@dataclass(frozen=True, eq=False)
class Draft:
    """A pose begun from keypoints: how many were used, and by how many pixels it misses them."""

    keyframe: Keyframe
    keypoints: int
    miss_px: float
    converged: bool
    doubtful: bool


def match_keypoints(
    session: Session, keypoints: Keypoints, file: str, also: Mapping[str, str] | None = None
) -> Matched:
    """Which keypoints are where on the session's body, by their names.

    also: places of the body by names in the file, said by a person, beside what is known.
    FormatError in one sentence where too few are known to pose the body.
    """
    skeleton, names = Skeleton.of(session.subject.body), keypoints.names
    matches = matched(skeleton, names, file)
    if also:
        place_of_name = {keypoint_name(name): place for name, place in also.items()}
        matches = match_also(skeleton, matches, names, file, place_of_name)
    if len(matches.known) < LEAST_KEYPOINTS:
        few = ", ".join(matches.left_out[:SHOWN])
        raise FormatError(
            f"{file} names {len(matches.known)} places of the session's body, {LEAST_KEYPOINTS} "
            f"are needed to pose it: say where others lie on the body, such as {few}."
        )
    return matches


def drafts_of(
    session: Session,
    keypoints: Keypoints,
    matches: Matched,
    frames: Sequence[int],
    times_s: Array,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Draft, ...]:
    """A draft at each of these frames that has keypoints and is neither a keyframe nor a draft.

    progress: receives how many frames of how many have been looked at.
    """
    skeleton, film_camera = Skeleton.of(session.subject.body), session.film_camera
    known_poses = (*session.subject.keyframes, *session.subject.drafts)
    posed = film_camera.poses_to_world({k.frame: k.pose(skeleton) for k in known_poses})
    drafts = []
    for done, frame in enumerate(frames):
        if progress is not None:
            progress(done, len(frames))
        if frame in posed or not keypoints.first_frame <= frame <= keypoints.last_frame:
            continue
        row = frame - keypoints.first_frame
        uv = keypoints.uv[row, matches.indices]
        sure = keypoints.visibility[row, matches.indices]
        if np.isfinite(uv).all(-1).sum() < LEAST_KEYPOINTS:
            continue
        near = between(posed, sorted(posed), frame)
        near = near and film_camera.pose_to_camera(frame, near)
        draft = _draft(session, matches, uv, sure, frame, near, times_s)
        if draft is not None:
            posed[frame] = film_camera.pose_to_world(frame, draft.keyframe.pose(skeleton))
            drafts.append(draft)
    return tuple(drafts)


def _draft(
    session: Session,
    matches: Matched,
    uv: Array,
    sure: Array,
    frame: int,
    near: Pose | None,
    times_s: Array,
) -> Draft | None:
    """The pose that is seen at the keypoints; None where none lies before the camera."""
    skeleton, camera = Skeleton.of(session.subject.body), session.film_camera.at(frame)
    points = BodyPoints(skeleton, tuple(matches.places))
    starts = _starts(session, camera, up_of(session, frame), points, uv, near)
    solved = fit_picture(session.subject.body, camera, matches.places, uv, sure, starts, near)
    Ts = pose_transforms(skeleton, solved.pose)
    if not Ts[:, 2, 3].min() > NEAREST_M:
        return None
    away = np.linalg.norm(camera.project(points.at(Ts)) - uv, axis=-1)
    miss, extent = float(np.nanmean(away)), float(np.ptp(uv[np.isfinite(uv).all(-1)], axis=0).max())
    keyframe = keyframe_of(skeleton, solved.pose, frame, times_s)
    count = int(np.isfinite(away).sum())
    return Draft(keyframe, count, miss, solved.converged, miss > POOR_PX * extent)


def _starts(
    session: Session,
    camera: Camera,
    up_camera: Position,
    points: BodyPoints,
    uv: Array,
    near: Pose | None,
) -> list[Pose]:
    """The pose known nearby, and the body at rest, seen from its four sides, where it is seen."""
    rest = opening_pose(session.subject.body, camera, up_camera)
    camera = camera.without_distortion()
    is_detected = np.isfinite(uv).all(-1)
    middle = uv[is_detected].mean(0)
    starts = [] if near is None else [near]
    for quarter in range(4):
        Rs = rest.Rs_parent_part.copy()
        Rs[0] = Rs[0] @ exp_rotation((0.0, quarter * np.pi / 2, 0.0))
        there = points.at(pose_transforms(points.skeleton, Pose(Rs, np.zeros(3))))[is_detected]
        z = _distance(camera, there, uv[is_detected]) if near is None else near.p_camera_root[2]
        p_middle = camera.back_project(middle, z)
        starts.append(Pose(Rs, p_middle - there.mean(0)))
    return starts


def _distance(camera: Camera, ps: Array, uv: Array) -> float:
    """The distance at which points are as large as seen, by their height, which turning keeps."""
    if camera.telephoto_distance_m is not None:
        return camera.telephoto_distance_m
    z = camera.fy * float(np.std(ps[:, 1])) / max(float(np.std(uv[:, 1])), 1.0)
    return max(z, 1.0)


def between(posed: Mapping[int, Pose], frames: Sequence[int], frame: int) -> Pose | None:
    before = [f for f in frames if f <= frame]
    after = [f for f in frames if f >= frame]
    if not before or not after:
        return posed[(after or before[::-1])[0]] if frames else None
    a, b = before[-1], after[0]
    return posed[a] if a == b else interpolate(posed[a], posed[b], a, b).pose(frame)
