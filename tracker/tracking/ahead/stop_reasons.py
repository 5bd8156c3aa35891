"""Decide where a followed motion stops to be trusted, and why: occlusion, doubt, damage, a cut."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.trajectory import runs
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.session.annotations import Stop, StopCause
from keypose.tracker.tracking.diagnostics.judge import SHORTEST_RUN

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from keypose.tracker.tracking.ahead.forward_pass import ForwardPass
    from keypose.tracker.tracking.scene import Scene
    from keypose.tracker.video.pyramid import Clip


def occluded_fraction(scene: Scene, pose: Pose, part: int) -> tuple[float, int | None]:
    """The share of a part's near side that other parts cover or that lies outside the picture; and
    the part that covers most of it, None where more of it is outside."""
    skeleton, points, camera = scene.skeleton, scene.points, scene.camera
    Ts = pose_transforms(skeleton, pose)
    own = slice(points.starts[part], points.starts[part + 1])
    R, p = Ts[part, :3, :3], Ts[part, :3, 3]
    p_camera = points.points[own] @ R.T + p
    near = ((points.normals[own] @ R.T) * p_camera).sum(axis=-1) < 0
    if not near.any():
        return 0.0, None
    uv = np.round(camera.project(p_camera[near])).astype(int)
    inside = ((uv >= 0) & (uv < np.array([camera.width, camera.height]))).all(axis=-1)
    u, v = uv[inside].T
    shown = raster(BodyMesh.of(skeleton), Ts, ViewCamera.of(camera)).part[v, u]
    covering = shown[(shown >= 0) & (shown != part)]
    outside = int((~inside).sum())
    behind = int(np.bincount(covering).argmax()) if len(covering) > outside else None
    return (len(covering) + outside) / len(uv), behind


INSIDE_SHARE: Final = 0.5
"""Of the marks that are in the picture at the keyframe: with fewer the body has left it."""
CUT_GREY = 20.0
CUT_TIMES = 6.0
"""Another scene begins where pictures differ by so many grey levels in the mean, and by so many
times as much as they do as a rule."""
HIDDEN_SHARE: Final = 0.5
"""A part is hidden where others cover so much of its near side."""


@dataclass(frozen=True)
class Stopped:
    """step: the last that can be trusted."""

    step: int
    stop: Stop


def pictures_end(clip: Clip) -> Stopped | None:
    """Where the pictures themselves end a motion; None where they do not. clip: by step."""
    stops = [*_bare(_damaged(clip), "damaged"), *_bare(_cut(clip), "cut")]
    return min(stops, key=lambda each: each.step, default=None)


def stopped(scene: Scene, followed: ForwardPass, *, is_last: bool) -> Stopped | None:
    """Where a followed motion stops first; None where nothing speaks against it so far.

    is_last: nothing is followed beyond it. A doubt that has only begun counts then, which may else
    pass again.
    """
    stops = [*_bare(_leaves(scene, followed), "left_picture"), *_doubted(scene, followed, is_last)]
    return min(stops, key=lambda each: each.step, default=None)


def _bare(first_bad: int | None, cause: StopCause) -> Iterator[Stopped]:
    if first_bad is not None:
        yield Stopped(first_bad - 1, Stop(cause=cause))


def _first(bad: NDArray[np.bool_]) -> int | None:
    return int(bad.argmax()) if bad.any() else None


def _damaged(clip: Clip) -> int | None:
    return min((step for step in clip.damaged if step > 0), default=None)


def _cut(clip: Clip) -> int | None:
    """Find a cut in the coarsest pictures."""
    grey = clip.overview.grey[clip.slots(0, len(clip) - 1)].astype(np.float32)
    change = np.abs(np.diff(grey, axis=0)).mean(axis=(1, 2))
    if not len(change):
        return None
    first = _first(change > max(CUT_GREY, CUT_TIMES * float(np.median(change))))
    return None if first is None else first + 1


def _leaves(scene: Scene, followed: ForwardPass) -> int | None:
    uv, camera = scene.mark_pixels(followed.motion), scene.camera
    size = np.array([camera.width, camera.height])
    inside = np.asarray(((uv > -0.5) & (uv < size - 0.5)).all(axis=-1))
    at_first = inside[0]
    if not at_first.any():
        return 1
    return _first(inside[:, at_first].mean(axis=1) < INSIDE_SHARE)


def _doubted(scene: Scene, followed: ForwardPass, is_last: bool) -> Iterator[Stopped]:
    """Parts that may be wrong for more than a moment."""
    error = np.nan_to_num(followed.expected_error)
    bad, count = error > followed.most_error, len(error)
    for part in np.flatnonzero(bad.any(axis=0)):
        for first, last in runs(bad[:, part]):
            lasts = last - first + 1 >= SHORTEST_RUN
            if lasts or (is_last and last == count - 1):
                worst = first + int(error[first : last + 1, part].argmax())
                stop = _about(scene, followed, int(part), (first + worst) // 2)
                yield Stopped(first - 1, stop)
                break


def _about(scene: Scene, followed: ForwardPass, part: int, step: int) -> Stop:
    name = scene.skeleton.body.names
    share, behind = occluded_fraction(scene, followed.motion.pose(step), part)
    if share < HIDDEN_SHARE:
        return Stop(cause="uncertain", part=name[part])
    return Stop(cause="not_seen", part=name[part], behind=None if behind is None else name[behind])
