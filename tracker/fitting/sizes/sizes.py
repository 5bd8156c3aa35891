"""Sizes of a body found from several posed keyframes, and on demand the camera's focal length.

A body of other proportions than the person's can still be posed so that its joints lie right in the
picture. But its contour is then too wide or too narrow, its hands and feet end too early or too
late. Here the sizes of all parts and the poses of all keyframes are unknown together: contours must
lie where the pictures show them, joints stay about where they were posed, and sizes stay what they
were unless the pictures contradict.
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
from tracker.fitting.sizes.messages import SizesFound, describe_sizes, size_changes
from tracker.fitting.sizes.proportions import Proportions
from tracker.fitting.sizes.residuals import Pictures, contours, joint_rows, residuals_by_pose
from tracker.fitting.sizes.shared import Residuals, Shared, SharedFit, solve
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array
from tracker.session.settings import IgnoreMask
from tracker.tracking.pool import never
from tracker.video.clip_loader import WorkingSize

if TYPE_CHECKING:
    from tracker.video import Video

FIRST_PX, AGAIN_PX = (9.0, 9.0, 6.0, 5.0), (5.0, 5.0)
"""How far from the body its contour is looked for, round by round: with all sizes free, and then
with those alone that change."""
STEPS = 3
MOST_LOOKED = 8
"""Keyframes whose pictures are looked at; where there are more, the others are posed anew only."""
LENGTH_SHARE, THICKNESS_SHARE, FOCAL_SHARE, DISTANCE_SHARE = 0.06, 0.15, 0.2, 0.05
"""Sigmas of the priors on lengths, thicknesses, the focal length and the distance; people, and what
they wear, differ more in girth than in length."""
SEEN_SHARE, FEW_SHARE = 2.0, 0.015
"""So many times wider is the prior on sizes known to be off; the sigma of one that is right."""
SURE, LEAST_PX = 2.5, (2.0, 0.8)
"""A size is changed where that is so many standard deviations, and where it moves an end, or
both sides together, by so many pixels."""
PLAUSIBLE = (0.12, 0.26)
"""Logarithms of length and thickness beyond which a size is implausible: people differ less from
a body that was once fitted by eye, and shoes, hair and wide clothes ask for more."""
PLAUSIBLE_FOCAL = 0.3
LEAST_FOCAL = 0.02
OBSERVABLE_SHARE = 0.05
"""A size whose sigma is larger is not observable."""
FEWEST_POINTS = 40
"""Points of the contour that must be seen in a picture, on average."""


@dataclass(frozen=True, eq=False)
class SizesFitted:
    """A body, a camera and keyposes that agree better with the pictures.

    message: what was found, for a person. changes: (part, what, before, after), centimetres.
    """

    body: Body
    camera: Camera
    keyposes: dict[int, Pose]
    message: str
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

    SessionError with fewer than two keyframes. Sizes that cannot be observed stay, and so do the
    poses where no size changes.
    """
    if len(keyposes) < 2:
        raise SessionError("Sizes are fitted to two keyframes or more: pose a second one first.")
    frames = sorted(keyposes)
    size = WorkingSize.for_camera(camera, 1)
    looked = np.unique(np.linspace(0, len(frames) - 1, MOST_LOOKED).round().astype(int))
    pictures = Pictures.of(video, camera, size, [frames[k] for k in looked], masks)
    fit = _set_up(body, size.camera(camera), [keyposes[frame] for frame in frames], focal)
    found = _find_sizes(fit, pictures, looked.tolist(), focal, cancelled)
    if found is None or not found.changed.any():
        message = "Fitting was cancelled." if found is None else describe_sizes(found)
        return SizesFitted(body, camera, dict(keyposes), message, ())
    return SizesFitted(
        fit.proportions.body_at(found.shared.sizes),
        found.shared.focus(camera) if found.changed[-2] else camera,
        dict(zip(frames, found.shared.poses, strict=True)),
        describe_sizes(found),
        size_changes(found),
    )


def _set_up(body: Body, camera: Camera, posed: Sequence[Pose], focal: bool) -> SharedFit:
    proportions = Proportions.of(body)
    perspective = camera.projection == "perspective"
    free = np.ones(proportions.count + 2, dtype=np.bool_)
    free[-2:] = focal and perspective, perspective
    sizes = np.tile((LENGTH_SHARE, THICKNESS_SHARE), len(proportions.groups))
    share = np.append(sizes, (FOCAL_SHARE, DISTANCE_SHARE))
    allowed = Limits.of(body).widened([pose.Rs_parent_part for pose in posed])
    return SharedFit(proportions, camera, tuple(posed), allowed, free, share, share)


def _find_sizes(
    fit: SharedFit,
    pictures: Pictures,
    looked: list[int],
    focal: bool,
    cancelled: Callable[[], bool],
) -> SizesFound | None:
    """All sizes first, then again and again those alone that turn out to change."""
    start_values = Shared(np.zeros(len(fit.free)), fit.posed)
    first = _estimate(fit, start_values, pictures, looked, FIRST_PX, cancelled)
    if first is None:
        return None
    changed, last = fit.free & _is_changed(fit, first), first
    changed &= first.enough
    implausible = np.zeros_like(changed)
    while changed.any():
        free = np.append(changed[:-1], fit.free[-1])
        step = np.where(free, 0.0, -last.shared.values)
        chosen = replace(fit, free=free, share=SEEN_SHARE * fit.usual)
        start = chosen.with_step(last.shared, step)
        again = _estimate(chosen, start, pictures, looked, AGAIN_PX, cancelled)
        if again is None:
            return None
        last, still = again, changed & _is_changed(fit, again)
        if (still == changed).all():  # without the implausible one, the others may be right
            still = changed & ~_is_least_likely(changed, again)
            implausible |= changed & ~still
        if (still == changed).all():
            break
        changed = still
    telephoto = fit.camera.projection == "telephoto"
    return SizesFound(
        fit.proportions, last.shared, changed, first.observable, implausible, first.enough,
        focal, telephoto,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Estimate:
    """Sizes and poses after some rounds, sigmas of the sizes, which of them are observable, and
    whether the pictures show the contour at all."""

    shared: Shared
    spread: Array
    observable: NDArray[np.bool_]
    enough: bool


def _estimate(
    fit: SharedFit, start: Shared, pictures: Pictures, looked: list[int],
    reaches: Sequence[float], cancelled: Callable[[], bool],
) -> _Estimate | None:  # fmt: skip
    """Look for the contours and fit to them, again and again; None when cancelled."""
    joints = [joint_rows(fit, pose) for pose in fit.posed]
    seen = contours(fit, start, looked)
    colour_models = pictures.colour_models(seen, fit)
    shared, observable, enough = start, np.ones(len(fit.free), dtype=np.bool_), False
    spread = np.zeros(len(fit.free))
    for number, reach in enumerate(reaches):
        if cancelled():
            return None
        if number:
            seen = contours(fit, shared, looked)
        found = residuals_by_pose(fit, shared, looked, seen, colour_models, reach)
        rows = [
            Residuals.concatenate([joints[k], *([found[k]] if k in found else [])])
            for k in range(len(joints))
        ]
        result = solve(fit, shared, rows, STEPS)
        shared, spread = result.shared, result.spread
        if not number:
            observable = spread < OBSERVABLE_SHARE
            enough = bool(np.mean([len(some.parts) for some in found.values()]) >= FEWEST_POINTS)
        fit = replace(fit, share=_favour_few(fit, shared)) if fit.free[:-2].all() else fit
    return _Estimate(shared, spread, observable, enough)


def _is_least_likely(changed: NDArray[np.bool_], rounds: _Estimate) -> NDArray[np.bool_]:
    """(S + 2,) the one value furthest beyond what is plausible; none where none is."""
    change = np.abs(rounds.shared.values) * changed
    most = np.append(np.tile(PLAUSIBLE, (len(change) - 2) // 2), (PLAUSIBLE_FOCAL, np.inf))
    beyond = change / most
    return np.asarray((beyond > 1) & (beyond == beyond.max()))


def _favour_few(fit: SharedFit, shared: Shared) -> Array:
    """(S + 2,) sigmas of a prior that favours few changes: narrow where a value hardly changed.

    Else all would change a little, and the distance with them, instead of the few.
    """
    share = np.minimum(np.hypot(shared.values, FEW_SHARE), fit.usual)
    return np.append(share[:-2], fit.usual[-2:])


def _is_changed(fit: SharedFit, rounds: _Estimate) -> NDArray[np.bool_]:
    """(S + 2,) what changes by more than may be chance, and by enough to be seen."""
    change = rounds.shared.values
    focal = np.sqrt(fit.camera.fx * fit.camera.fy)
    distance = np.mean([fit.camera.depth(pose.p_camera_root) for pose in fit.posed])
    moved_px = np.abs(np.expm1(rounds.shared.sizes)) * fit.proportions.metres() * focal / distance
    enough = moved_px > np.tile(LEAST_PX, len(fit.proportions.groups))
    surely = np.abs(change) > SURE * rounds.spread
    return np.asarray(surely & np.append(enough, (abs(change[-2]) > LEAST_FOCAL, False)))
