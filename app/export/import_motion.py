"""Bring motion from elsewhere to a session, as a first motion. Keyframes are never touched.

Recorded joints live in a world of their own. Where keyframes overlap with them, one rigid transform
aligns them with the keyframes' joints in the world, so that the motion of a camera is none of
theirs; without any, they are put upright before the camera as it was at the first frame.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from keypose.app.editor.documents import keyframe_of
from keypose.app.export.import_keypoints import (
    NEAREST_M,
    SHOWN,
    Draft,
    between,
)
from keypose.app.export.plausibility import (
    bone_ratios,
    implausible,
    lying,
    median_ratio,
    require_limbs,
    world_at_rest,
)
from keypose.tracker.body.film_camera import FilmCamera
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import JointMotion, World
from keypose.tracker.formats.joint_names import Matched, match_also, matched
from keypose.tracker.formats.text import Note
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session import Session
from keypose.tracker.solver.fit_joints import JointFit, fit_motion, rigid
from keypose.tracker.solver.posed import BodyPoints

LEAST_JOINTS = 3
"""Fewer do not say how a body is turned."""
FAR_M = 0.08
"""Mean distance from the keyframes' joints above which a motion starts elsewhere, or is another."""
CLEARLY = 0.5
"""Another start is taken where the motion is nearer to the keyframes than so large a share of its
distance from them with the first one."""
MOST_STARTS = 5_000
"""Frames of a video among which the start of a motion is searched."""
FILLED = 0.8
"""Share of the picture that a body put before the camera fills."""
MOST_UNLIKE = 3.0
"""How many times larger or smaller than the body a motion in known units may be."""


Placed: TypeAlias = tuple[Array, Array]
"""R (3, 3) and p (3,), metres: a place x of a file lies at R x + p."""


@dataclass(frozen=True, eq=False)
class ImportedMotion:
    """A recorded motion fitted to the body, and how well.

    size: the body's size as a share of the motion's.
    scale: by which the file's lengths were multiplied to suit the body, 1 where its unit counts.
    aligned: frames of the keyframes that it was aligned with.
    keyframes_m: mean distance of its joints from theirs, NaN without any.
    miss_px: (N,) mean distance of its joints from the file's in the picture, pixels.
    notes: what of it may be wrong, and what was odd about the file.
    placed: where the file's world lies in the session's, where its unit counts: R (3, 3), p (3,)
        metres.
    """

    fit: JointFit
    matched: Matched
    size: float
    scale: float
    aligned: tuple[int, ...]
    keyframes_m: float
    miss_px: Array
    notes: tuple[Note, ...]
    placed: Placed | None = None


def fit_to_session(
    session: Session,
    motion: JointMotion,
    file: str,
    times_s: Array,
    offset_s: float | None = None,
    names: Mapping[str, str] | None = None,
    also: Mapping[str, str] | None = None,
    progress: Callable[[int, int], None] | None = None,
    beside: Placed | None = None,
) -> ImportedMotion:
    """The motion as poses of the session's body in its camera's frame, at the video's frames.

    times_s: (N,) of the video's frames; the motion's time 0 is at `offset_s`. None: at 0, or where
        the motion meets the keyframes clearly better.
    names: our joints by the file's names; the usual names when left out.
    also: places of the body by names in the file, said by a person, beside what is known.
    progress: receives how many frames of how many are fitted.
    beside: where another individual of the file has put its world, which counts where no keyframe
        says it.
    FormatError in one sentence where the motion does not suit the session.
    """
    skeleton = Skeleton.of(session.subject.body)
    motion = motion.on_video(file, times_s)
    matches = matched(skeleton, motion.names, file, names)
    if also:
        matches = match_also(skeleton, matches, motion.names, file, also)
    _require_joints(matches, motion, file)
    require_limbs(skeleton, matches.places, file)
    points = BodyPoints(skeleton, tuple(matches.places))
    film_camera = session.film_camera
    if motion.world == "camera":  # then it lies where the camera was, wherever that went
        film_camera = FilmCamera(film_camera.lens)
    posed = {k.frame: k.pose(skeleton) for k in session.subject.keyframes}
    start, notes = 0, motion.notes
    if offset_s is None:
        keyed = film_camera.poses_to_world(posed)
        start = _best_start(points, motion, matches.indices, times_s, keyed)
        offset_s = float(times_s[start])
        notes += (Note("starts at", (start,)),) if start else ()
    first, ps = _within(motion.at(times_s - offset_s)[:, matches.indices], file, len(motion))
    bones = bone_ratios(points, ps)
    size = median_ratio(bones)
    scale = size if motion.unit is None else 1.0
    _require_a_size(size / scale, file)
    near = _pose_per_frame(session.film_camera, posed, first, len(ps))
    reached = {f: p for f, p in posed.items() if _has_enough_joints(ps, f - first)}
    if len(ps) == 1 and near[0] is not None:  # a pose is put where the body is about then
        reached = {first: near[0]}
    ps = ps * scale
    in_file = ps
    if reached:
        ps = _on_keyframes(points, ps, first, film_camera.poses_to_world(reached))
    elif beside is not None and motion.unit is not None:
        ps = ps @ beside[0].T + beside[1]
    elif motion.world is None:
        raise FormatError(
            f"{file} does not say in which frame it is: choose its world, or set a keyframe."
        )
    elif motion.world != "camera":
        world = world_at_rest(points, motion.world, motion.rest_m, matches.indices)
        notes += () if world == motion.world else (Note("z up at rest"),)
        ps = _before_camera(session, ps, world)
    placed = None if motion.unit is None else rigid(in_file.reshape(-1, 3), ps.reshape(-1, 3))
    if film_camera.path is not None:
        ps = _as_seen(film_camera.path.between(first, first + len(ps) - 1), ps)
    fit = fit_motion(session.subject.body, matches.places, ps, first, near, progress)
    _require_before_camera(fit, skeleton, file)
    notes += implausible(skeleton, matches.places, bones, size, ps, fit)
    if not reached:
        in_world = session.film_camera.motion_to_world(fit.trajectory)
        notes += lying(in_world, session.world.up)
    from_keyframes = _from_keyframes(points, fit, reached)
    if from_keyframes > FAR_M:
        notes += (Note("far from keyframes", (100 * from_keyframes,)),)
    miss_px = _miss_px(session, points, fit, ps)
    aligned = tuple(frame for frame in reached if frame in posed)
    return ImportedMotion(
        fit, matches, size, scale, aligned, from_keyframes, miss_px, notes, placed
    )


def pose_draft(
    session: Session, imported_motion: ImportedMotion, file: str, times_s: Array
) -> Draft:
    """Make a draft of a motion of one frame; FormatError where that frame is posed already."""
    frame = imported_motion.fit.trajectory.first_frame
    if frame in {k.frame for k in (*session.subject.keyframes, *session.subject.drafts)}:
        raise FormatError(
            f"{file} holds one frame, a pose to draft, and frame {frame} of the video is posed "
            "already: choose another frame for it."
        )
    skeleton, pose = Skeleton.of(session.subject.body), imported_motion.fit.trajectory.pose(frame)
    keyframe = keyframe_of(skeleton, pose, frame, times_s)
    doubtful = bool(imported_motion.notes)
    converged = bool(imported_motion.fit.converged[0])
    miss_px = float(imported_motion.miss_px[0])
    return Draft(keyframe, len(imported_motion.matched.known), miss_px, converged, doubtful)


def _require_joints(matches: Matched, motion: JointMotion, file: str) -> None:
    if len(matches.known) < LEAST_JOINTS:
        few = ", ".join(motion.names[:SHOWN])
        raise FormatError(
            f"{file} has {len(motion.names)} joints, such as {few}, of which {len(matches.known)} "
            "are known: name their counterparts on the body."
        )


def _within(ps: Array, file: str, rows: int) -> tuple[int, Array]:
    """The first frame at which the motion says enough, and its positions from there to the last."""
    says = [n for n in range(len(ps)) if _has_enough_joints(ps, n)]
    if not says or (len(says) == 1 and rows > 1):
        raise FormatError(
            f"{file} has no joints while the video runs: choose the frame at which it starts."
        )
    return says[0], ps[says[0] : says[-1] + 1]


def _has_enough_joints(ps: Array, n: int) -> bool:
    return 0 <= n < len(ps) and int(np.isfinite(ps[n]).all(-1).sum()) >= LEAST_JOINTS


def _require_a_size(size: float, file: str) -> None:
    """Nobody is three times as tall as another one: the unit is wrong."""
    if not 1 / MOST_UNLIKE < size < MOST_UNLIKE:
        times = f"{1 / size:.0f}" if size < 1 else f"{1 / size:.1g}"
        raise FormatError(
            f"{file} has a body {times} times the size of the session's: check its unit, or "
            "have it scaled to the body (unit auto)."
        )


def _best_start(
    points: BodyPoints,
    motion: JointMotion,
    indices: Sequence[int],
    times_s: Array,
    posed: Mapping[int, Pose],
) -> int:
    """The video's frame at the motion's time 0: 0, or that at which it lies by far nearer to the
    keyframes."""
    frames = sorted(posed)
    if len(frames) < 2 or len(times_s) > MOST_STARTS:
        return 0
    Ts = np.stack([pose_transforms(points.skeleton, posed[frame]) for frame in frames])
    ours, at_keys = points.at(Ts), times_s[frames]
    scale = median_ratio(bone_ratios(points, motion.ps_world_joint[:, indices]))

    def miss(start: int) -> tuple[int, float]:
        """How many keyframes it reaches, and its root mean square distance from these,
        metres.
        """
        theirs = motion.at(at_keys - times_s[start])[:, indices]
        reached = np.isfinite(theirs).all(-1).sum(-1) >= LEAST_JOINTS
        if reached.sum() < 2:
            return 0, np.inf
        theirs = theirs[reached] * scale
        R, p = rigid(theirs, ours[reached])
        away = np.linalg.norm(theirs @ R.T + p - ours[reached], axis=-1)
        return int(reached.sum()), float(np.sqrt(np.nanmean(away**2)))

    count, usual = miss(0)
    if usual < FAR_M:
        return 0
    miss_of_start = {start: miss(start) for start in range(1, len(times_s))}
    enough = {
        start: away for start, (reached, away) in miss_of_start.items() if reached >= count / 2
    }
    best = min(enough, key=enough.__getitem__, default=0)
    return best if best and enough[best] < CLEARLY * usual else 0


def _on_keyframes(points: BodyPoints, ps: Array, first: int, posed: Mapping[int, Pose]) -> Array:
    """The positions aligned with the keyframes' joints, all of them by one transform."""
    theirs = np.concatenate([ps[frame - first] for frame in posed])
    ours = np.concatenate(
        [points.at(pose_transforms(points.skeleton, pose)) for pose in posed.values()]
    )
    R, p = rigid(theirs, ours)
    return ps @ R.T + p


def _as_seen(path: CameraPath, ps_world: Array) -> Array:
    """Places (N, J, 3) of the world in the camera's frame at every one of N frames."""
    T = path.Ts_camera_world
    return np.asarray(ps_world @ np.swapaxes(T[:, :3, :3], 1, 2) + T[:, None, :3, 3])


def _before_camera(session: Session, ps: Array, world: World) -> Array:
    """Upright, as it faces, in the middle of the picture and at a distance that fills it."""
    up = session.world.up
    right = np.cross(-up, (0.0, 0.0, 1.0))
    if np.linalg.norm(right) < 1e-6:  # the camera looks straight up or down
        right = np.array([1.0, 0.0, 0.0])
    y, x = up, right / np.linalg.norm(right)
    R = np.stack([x, y, np.cross(x, y)], axis=1)  # from a world with y up
    if world == "z up":
        R = R @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    turned = ps @ R.T
    low, high = np.nanmin(turned, axis=(0, 1)), np.nanmax(turned, axis=(0, 1))
    camera, size = session.view.camera, high - low
    near = max(camera.fx * size[0] / camera.width, camera.fy * size[1] / camera.height) / FILLED
    z = camera.telephoto_distance_m or max(near, 0.5) + size[2] / 2
    middle = _middle(camera, z)
    return np.asarray(turned - (low + high) / 2 + middle)


def _middle(camera: Camera, z: float) -> Array:
    return camera.back_project(np.array([(camera.width - 1) / 2, (camera.height - 1) / 2]), z)


def _pose_per_frame(
    film_camera: FilmCamera, posed: Mapping[int, Pose], first: int, count: int
) -> list[Pose | None]:
    """For every frame the pose between its keyframes, or that of the nearest, in the world,
    as the camera sees it there; None without any.
    """
    frames, placed = sorted(posed), film_camera.poses_to_world(posed)
    near = {frame: between(placed, frames, frame) for frame in range(first, first + count)}
    return [pose and film_camera.pose_to_camera(frame, pose) for frame, pose in near.items()]


def _require_before_camera(fit: JointFit, skeleton: Skeleton, file: str) -> None:
    z = fit.trajectory.transforms(skeleton)[..., 2, 3].min(axis=1)
    behind = np.flatnonzero(~(z > NEAREST_M))
    if len(behind):
        frame = fit.trajectory.first_frame + int(behind[0])
        raise FormatError(
            f"{file} comes to lie behind the camera at frame {frame}: check its offset and its "
            "unit against the keyframes."
        )


def _from_keyframes(points: BodyPoints, fit: JointFit, posed: Mapping[int, Pose]) -> float:
    def at(pose: Pose) -> Array:
        return points.at(pose_transforms(points.skeleton, pose))

    away = [
        np.linalg.norm(at(fit.trajectory.pose(f)) - at(p), axis=-1).mean() for f, p in posed.items()
    ]
    return float(np.mean(away)) if away else np.nan


def _miss_px(session: Session, points: BodyPoints, fit: JointFit, ps: Array) -> Array:
    camera, path = session.view.camera, session.film_camera.path_over(fit.trajectory)
    ps_fitted = points.at(fit.trajectory.transforms(points.skeleton))
    with np.errstate(invalid="ignore", divide="ignore"):
        away = np.linalg.norm(camera.project(ps_fitted) - camera.project(ps), axis=-1)
    return np.asarray(np.nanmean(away, axis=-1) * (1.0 if path is None else path.zoom))
