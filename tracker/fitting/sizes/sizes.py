"""Sizes of a body found from several posed keyframes, and on demand the camera's focal length.

A body of other proportions than the person's can still be posed so that its joints lie right in the
picture. But its contour is then too wide or too narrow, its hands and feet end too early or too
late. Here the sizes of all parts and the poses of all keyframes are unknown together: contours must
lie where the pictures show them, joints stay about where they were posed, and sizes stay what they
were unless the pictures tell otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracker.body.body import Body
from tracker.body.joint_limits import Limits
from tracker.body.pose import Pose
from tracker.errors import SessionError
from tracker.fitting.sizes.proportions import Proportions
from tracker.fitting.sizes.residuals import Pictures, contours, joint_rows, residuals_by_pose
from tracker.fitting.sizes.shared import Residuals, Shared, SharedFit, solve
from tracker.fitting.sizes.words import Found, changes_of, words_of
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array
from tracker.session.settings import IgnoreMask
from tracker.tracking.pool import never
from tracker.video.clip_loader import WorkingSize

if TYPE_CHECKING:
    from tracker.video import Video

FIRST_PX, AGAIN_PX = (9.0, 9.0, 6.0, 5.0), (5.0, 5.0)
"""How far from the body its contour is looked for, round by round: with all sizes free, and then
with those alone that the pictures tell."""
STEPS = 3
MOST_LOOKED = 8
"""Keyframes whose pictures are looked at; where there are more, the others are posed anew only."""
LENGTH_SHARE, THICKNESS_SHARE, FOCAL_SHARE, DISTANCE_SHARE = 0.06, 0.15, 0.2, 0.05
"""How far lengths, thicknesses, the focal length and the distance may be expected to be off;
people, and what they wear, differ more in girth than in length."""
SEEN_SHARE, FEW_SHARE = 2.0, 0.015
"""So many times as far sizes may be off of which it is known that they are; how far right ones."""
SURE, LEAST_PX = 2.5, (2.0, 0.8)
"""A size is changed where that is so many standard deviations, and where it moves an end, or a
both sides together, by so many pixels."""
BELIEVED = (0.12, 0.26)
"""Logarithms of length and thickness beyond which a size is not believed: people differ less from
a body that was once fitted by eye, and shoes, hair and wide clothes ask for more."""
BELIEVED_FOCAL = 0.3
LEAST_FOCAL = 0.02
TOLD_SHARE = 0.05
"""A size that could be off by more than this share, for all the pictures show, is not told."""
FEWEST_POINTS = 40
"""Points of the contour that must be seen in a picture, on average."""


@dataclass(frozen=True, eq=False)
class SizesFitted:
    """A body, a camera and keyposes that agree better with the pictures.

    words: what was found, for a person. changes: (part, what, before, after), centimetres.
    """

    body: Body
    camera: Camera
    keyposes: dict[int, Pose]
    words: str
    changes: tuple[tuple[str, str, float, float], ...]


def fit_sizes(
    video: Video,
    camera: Camera,
    body: Body,
    keyposes: Mapping[int, Pose],
    focal: bool = False,
    masks: Sequence[IgnoreMask] = (),
    cancelled: Callable[[], bool] = never,
) -> SizesFitted:
    """Sizes at which the body, posed at several keyframes, fits all of the pictures.

    SessionError with fewer than two keyframes. What the pictures do not tell stays as it was, and
    so do the poses where no size changes.
    """
    if len(keyposes) < 2:
        raise SessionError("Sizes are fitted to two keyframes or more: pose a second one first.")
    frames = sorted(keyposes)
    size = WorkingSize.for_camera(camera, 1)
    looked = np.unique(np.linspace(0, len(frames) - 1, MOST_LOOKED).round().astype(int))
    pictures = Pictures.of(video, camera, size, [frames[k] for k in looked], masks)
    fit = _beginning(body, size.camera(camera), [keyposes[frame] for frame in frames], focal)
    found = _found(fit, pictures, looked.tolist(), focal, cancelled)
    if found is None:
        return SizesFitted(body, camera, dict(keyposes), "Fitting was cancelled.", ())
    if not found.changed.any():
        return SizesFitted(body, camera, dict(keyposes), words_of(found), ())
    ratio = float(np.exp(found.shared.values[-2]))
    longer = {"fx": camera.fx * ratio, "fy": camera.fy * ratio}
    return SizesFitted(
        fit.proportions.body_at(found.shared.sizes),
        camera.model_copy(update=longer) if found.changed[-2] else camera,
        dict(zip(frames, found.shared.poses, strict=True)),
        words_of(found),
        changes_of(found),
    )


def _beginning(body: Body, camera: Camera, posed: Sequence[Pose], focal: bool) -> SharedFit:
    proportions = Proportions.of(body)
    perspective = camera.projection == "perspective"
    free = np.ones(proportions.count + 2, dtype=np.bool_)
    free[-2:] = focal and perspective, perspective
    sizes = np.tile((LENGTH_SHARE, THICKNESS_SHARE), len(proportions.groups))
    share = np.append(sizes, (FOCAL_SHARE, DISTANCE_SHARE))
    allowed = Limits.of(body).widened([pose.Rs_parent_part for pose in posed])
    return SharedFit(proportions, camera, tuple(posed), allowed, free, share, share)


def _found(
    fit: SharedFit,
    pictures: Pictures,
    looked: list[int],
    focal: bool,
    cancelled: Callable[[], bool],
) -> Found | None:
    """All sizes first, then again and again those alone that turn out to change."""
    begun = Shared(np.zeros(len(fit.free)), fit.posed)
    first = _rounds(fit, begun, pictures, looked, FIRST_PX, cancelled)
    if first is None:
        return None
    changed, last = fit.free & _is_changed(fit, first), first
    changed &= first.enough
    doubted = np.zeros_like(changed)
    while changed.any():
        free = np.append(changed[:-1], fit.free[-1])
        step = np.where(free, 0.0, -last.shared.values)
        chosen = replace(fit, free=free, share=SEEN_SHARE * fit.usual)
        start = chosen.changed(last.shared, step)
        again = _rounds(chosen, start, pictures, looked, AGAIN_PX, cancelled)
        if again is None:
            return None
        last, still = again, changed & _is_changed(fit, again)
        if (still == changed).all():  # with one that is wrong left out, the others may be right
            still = changed & ~_is_least_likely(changed, again)
            doubted |= changed & ~still
        if (still == changed).all():
            break
        changed = still
    telephoto = fit.camera.projection == "telephoto"
    return Found(
        fit.proportions, last.shared, changed, first.told, doubted, first.enough, focal, telephoto
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Rounds:
    """What came of some rounds: sizes and poses, the spread of the sizes, which of them the
    pictures tell, and whether they show the contour at all."""

    shared: Shared
    spread: Array
    told: NDArray[np.bool_]
    enough: bool


def _rounds(
    fit: SharedFit, start: Shared, pictures: Pictures, looked: list[int],
    reaches: Sequence[float], cancelled: Callable[[], bool],
) -> _Rounds | None:  # fmt: skip
    """Look for the contours and fit to them, again and again; None when cancelled."""
    joints = [joint_rows(fit, pose) for pose in fit.posed]
    seen = contours(fit, start, looked)
    grounds = pictures.grounds(seen, fit)
    shared, told, enough = start, np.ones(len(fit.free), dtype=np.bool_), False
    spread = np.zeros(len(fit.free))
    for number, reach in enumerate(reaches):
        if cancelled():
            return None
        if number:
            seen = contours(fit, shared, looked)
        found = residuals_by_pose(fit, shared, looked, seen, grounds, reach)
        rows = [
            Residuals.joined([joints[k], *([found[k]] if k in found else [])])
            for k in range(len(joints))
        ]
        result = solve(fit, shared, rows, STEPS)
        shared, spread = result.shared, result.spread
        if not number:
            told = spread < TOLD_SHARE
            enough = bool(np.mean([len(some.parts) for some in found.values()]) >= FEWEST_POINTS)
        fit = replace(fit, share=_fewer(fit, shared)) if fit.free[:-2].all() else fit
    return _Rounds(shared, spread, told, enough)


def _is_least_likely(changed: NDArray[np.bool_], rounds: _Rounds) -> NDArray[np.bool_]:
    """(S + 2,) the one value that lies furthest beyond what is believed; none where none does."""
    change = np.abs(rounds.shared.values) * changed
    most = np.append(np.tile(BELIEVED, (len(change) - 2) // 2), (BELIEVED_FOCAL, np.inf))
    beyond = change / most
    return np.asarray((beyond > 1) & (beyond == beyond.max()))


def _fewer(fit: SharedFit, shared: Shared) -> Array:
    """(S + 2,) how far values may be off where few are: those that have hardly changed are held.

    Else all would change a little, and the distance with them, to spare the few.
    """
    share = np.minimum(np.hypot(shared.values, FEW_SHARE), fit.usual)
    return np.append(share[:-2], fit.usual[-2:])


def _is_changed(fit: SharedFit, rounds: _Rounds) -> NDArray[np.bool_]:
    """(S + 2,) what changes by more than may be chance, and by enough to be seen."""
    change = rounds.shared.values
    focal = np.sqrt(fit.camera.fx * fit.camera.fy)
    distance = np.mean([fit.camera.depth(pose.p_camera_root) for pose in fit.posed])
    moved_px = np.abs(np.expm1(rounds.shared.sizes)) * fit.proportions.metres() * focal / distance
    enough = moved_px > np.tile(LEAST_PX, len(fit.proportions.groups))
    surely = np.abs(change) > SURE * rounds.spread
    return np.asarray(surely & np.append(enough, (abs(change[-2]) > LEAST_FOCAL, False)))
