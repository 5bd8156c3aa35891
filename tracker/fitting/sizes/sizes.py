"""Sizes of a body found from several posed keyframes, and on demand the camera's focal length.

A body of other proportions than the person's can still be posed so that its joints lie right in the
picture. But its contour is then too wide or too narrow, its hands and feet end too early or too
late. Here the sizes of all parts and the poses of all keyframes are unknown together: contours must
lie where the pictures show them, joints stay about where they were posed, and sizes stay what they
were unless the pictures contradict.

Arrays (S + 2,) are as `Shared.values`: logarithms of ratios, S sizes (of each group of parts the
length, then the width), then the focal length, then the distance; and where other films show the
keyframes, how far their cameras are away. One film shows a limb that is turned to it as short as a
short one; several tell them apart. How large everything is they tell where it was measured how far
their cameras are apart.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.modify import height
from keypose.tracker.body.pose import Pose
from keypose.tracker.errors import SessionError
from keypose.tracker.films.mend import SeenInFilm
from keypose.tracker.fitting.sizes.beside import seen_beside
from keypose.tracker.fitting.sizes.estimate import Estimate, estimate
from keypose.tracker.fitting.sizes.messages import (
    NO_GAIN,
    FoundBeside,
    SizesFound,
    describe_sizes,
    films_note,
    unseen_parts,
)
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.fitting.sizes.proposals import UP_CAMERA, KeyframePictures, Proposal
from keypose.tracker.fitting.sizes.residuals import Pictures
from keypose.tracker.fitting.sizes.shared import Shared, SharedFit, covariance, size_count
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.settings import IgnoreMask
from keypose.tracker.solver.sigmas import (
    APART_SHARE,
    DISTANCE_SHARE,
    FOCAL_SHARE,
    LENGTH_SHARE,
    TRUNK_SHARES,
    WIDTH_SHARE,
)
from keypose.tracker.tracking.pool import never
from keypose.tracker.video.clip_loader import WorkingSize

if TYPE_CHECKING:
    from keypose.tracker.video import Video

FIRST_PX = (9.0, 9.0, 6.0, 5.0)
AGAIN_PX = (5.0, 5.0)
"""How far from the body its contour is looked for, round by round: with all sizes free, and then
with those alone that change."""
MOST_LOOKED = 8
"""Keyframes whose pictures are looked at; where there are more, the others are posed anew only."""
PRIOR_WIDER_WHERE_OFF = 2.0
"""So many times wider is the prior on sizes known to be off."""
SURE = 2.5
LEAST_PX = (2.0, 0.8)
"""A size is changed where that is so many standard deviations, and where it moves an end, or
both sides together, by so many pixels."""
PLAUSIBLE = (0.12, 0.26)
"""Logarithms of the largest plausible ratios of length, 13 %, and thickness, 30 %. Lengths differ
by less from those of a body that was posed over the picture by eye; shoes, hair and wide clothes
make parts look thicker by more than that."""
PLAUSIBLE_FOCAL = 0.3
"""The same of the focal length, 35 %."""
LEAST_FOCAL = 0.02
"""The logarithm of the least ratio by which the focal length is changed."""
LEAST_LARGER = 0.005
"""The same of how large everything is."""
OWN_SIGMA = 2.0
"""By how much errors are larger than the equations say: a detector's own places of joints are aside
alike in all frames."""
HEIGHT_STEP = 1e-4


@dataclass(frozen=True, eq=False)
class SizesFitted:
    """What was found, to be chosen from: nothing is changed until somebody does.

    message: for a person.  error_px: of the body's outline as it is, pixels of the video.
    alone: other sizes, every pose as it was set; None where these fit no better.
    with_poses: other sizes, limbs posed anew for them; None where these fit no better either.
    unseen: parts whose sizes the pictures do not determine.  note: what other films told; empty
    without any.
    """

    message: str
    error_px: float = 0.0
    alone: Proposal | None = None
    with_poses: Proposal | None = None
    unseen: tuple[str, ...] = ()
    note: str = ""


def fit_sizes(
    video: Video,
    camera: Camera,
    body: Body,
    keyposes: Mapping[int, Pose],
    focal: bool = False,
    masks: Sequence[IgnoreMask] = (),
    cancelled: Callable[[], bool] = never,
    up: Sequence[float] | None = None,
    path: CameraPath | None = None,
    films: Mapping[int, Sequence[SeenInFilm]] | None = None,
    measured: float | None = None,
) -> SizesFitted:
    """Sizes at which the body, posed at several keyframes, fits all of the pictures.

    up (3,): in the world, −y where left out; along it the feet must not float more than before.
    path: of the camera over the film; None where it is the world. films: by keyframe what others
    show of it. measured: how far their cameras are from the first one, as a multiple of how far
    they are taken to be; None where nobody measured it, and the height stays. SessionError with
    fewer than two keyframes. Sizes that cannot be observed stay.
    """
    if len(keyposes) < 2:
        raise SessionError("Sizes are fitted to two keyframes or more: pose a second one first.")
    frames = sorted(keyposes)
    size = WorkingSize.for_camera(camera, 1)
    looked = np.unique(np.linspace(0, len(frames) - 1, MOST_LOOKED).round().astype(int))
    pictures = Pictures.of(video, camera, size, [frames[k] for k in looked], masks)
    path = (
        CameraPath.standing_still(len(frames)) if path is None else path.sampled(np.array(frames))
    )
    fit = _set_up(
        body, size.camera(camera), [keyposes[frame] for frame in frames], path.zoom, focal
    )
    if films:
        fit = _with_films(fit, [films.get(frame, ()) for frame in frames])
    sizes_found = _find_sizes(fit, pictures, looked.tolist(), focal, measured, cancelled)
    if sizes_found is None:
        return SizesFitted("Fitting was cancelled.")
    beside = sizes_found.beside
    if beside is not None and _is_larger(beside):
        sizes_found.changed[-1] = True
    note = films_note(sizes_found)
    if not sizes_found.changed.any():
        message = f"{describe_sizes(sizes_found)} {note}".rstrip()
        return SizesFitted(message, unseen=unseen_parts(sizes_found), note=note)
    look = KeyframePictures(
        fit, camera, pictures, looked.tolist(), frames, 2.0**size.halvings, cancelled
    )
    alone = look.alone(sizes_found)
    with_poses = look.with_poses(sizes_found, path.Ts_world_camera, up or UP_CAMERA)
    with_poses = with_poses or look.larger(sizes_found)
    if cancelled():
        return SizesFitted("Fitting was cancelled.")
    if alone is None and with_poses is None:
        message = f"{NO_GAIN} {note}".rstrip()
        return SizesFitted(message, unseen=unseen_parts(sizes_found), note=note)
    return SizesFitted(
        describe_sizes(sizes_found),
        look.error_before,
        alone,
        with_poses,
        unseen_parts(sizes_found),
        note,
    )


def _set_up(
    body: Body, camera: Camera, posed: Sequence[Pose], zoom: Array, focal: bool
) -> SharedFit:
    proportions = Proportions.of(body)
    perspective = camera.projection == "perspective"
    free = np.ones(proportions.count + 2, dtype=np.bool_)  # (S + 2,), as what follows
    free[-2:] = focal and perspective, perspective
    is_trunk = proportions.is_trunk[[group[0] for group in proportions.groups]]
    sizes = np.where(is_trunk[:, None], TRUNK_SHARES, (LENGTH_SHARE, WIDTH_SHARE)).ravel()
    share = np.append(sizes, (FOCAL_SHARE, DISTANCE_SHARE))
    allowed = Limits.of(body).widened([pose.Rs_parent_part for pose in posed])
    return SharedFit(
        proportions, camera, tuple(posed), zoom, allowed, free, usual=share, share=share
    )


def _with_films(fit: SharedFit, films: Sequence[Sequence[SeenInFilm]]) -> SharedFit:
    """The same with what other films show of each pose; as it is where they show none of them."""
    beside = seen_beside(fit.proportions, fit.posed, films)
    if not beside:
        return fit
    share = np.append(fit.share, APART_SHARE)
    return replace(fit, free=np.append(fit.free, True), usual=share, share=share, beside=beside)


def _find_sizes(
    fit: SharedFit,
    pictures: Pictures,
    looked: list[int],
    focal: bool,
    measured: float | None,
    cancelled: Callable[[], bool],
) -> SizesFound | None:
    """All sizes first, then again and again those alone that turn out to change."""
    start_values = Shared(np.zeros(len(fit.free)), fit.posed)
    first = estimate(fit, start_values, pictures, looked, FIRST_PX, cancelled)
    if first is None:
        return None
    sizes = fit.proportions.count
    changed, last = fit.free & _is_changed(fit, first), first
    changed &= first.enough
    implausible = np.zeros_like(changed)
    while changed.any():
        free = np.append(changed[: sizes + 1], fit.free[sizes + 1 :])
        step = np.where(free, 0.0, -last.shared.values)  # sizes that are held are the body's again
        chosen = replace(fit, free=free, share=PRIOR_WIDER_WHERE_OFF * fit.usual)
        start = chosen.with_step(last.shared, step)
        again = estimate(chosen, start, pictures, looked, AGAIN_PX, cancelled)
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
        fit.proportions,
        last.shared,
        changed,
        first.observable,
        implausible,
        first.enough,
        focal,
        telephoto,
        _beside(fit, last, None if implausible[:sizes:2].any() else measured)
        if fit.beside
        else None,
    )


def _beside(fit: SharedFit, last: Estimate, measured: float | None) -> FoundBeside:
    """What other films tell besides the sizes."""
    count = 1 + max(len(rows) for rows in fit.beside)
    if measured is None:
        return FoundBeside(count)
    shared, sizes = last.shared, fit.proportions.count
    slopes = np.zeros(len(fit.free))
    for s in range(sizes):
        step = np.zeros(sizes)
        step[s] = HEIGHT_STEP
        slopes[s] = _log_height(fit, shared.sizes + step) - _log_height(fit, shared.sizes)
    slopes /= HEIGHT_STEP
    slopes[-1] = -1.0  # farther cameras, as seen from that body, are a smaller body
    variance = slopes @ covariance(fit, shared, last.rows) @ slopes
    return FoundBeside(count, measured / shared.apart, OWN_SIGMA * float(np.sqrt(variance)))


def _log_height(fit: SharedFit, sizes: Array) -> float:
    return float(np.log(height(fit.proportions.body_at(sizes))))


def _is_larger(beside: FoundBeside) -> bool:
    """Whether a measured distance of cameras shows all of the body larger or smaller."""
    sigma = beside.sigma_share or 0.0
    return bool(abs(np.log(beside.larger)) > max(LEAST_LARGER, SURE * sigma))


def _is_least_likely(changed: NDArray[np.bool_], estimated: Estimate) -> NDArray[np.bool_]:
    """(S + 2,) the one value furthest beyond what is plausible; none where none is."""
    change = np.abs(estimated.shared.values) * changed
    sizes = size_count(change)
    rest = np.full(len(change) - sizes, np.inf)
    rest[0] = PLAUSIBLE_FOCAL
    most = np.append(np.tile(PLAUSIBLE, sizes // 2), rest)
    beyond = change / most
    return np.asarray((beyond > 1) & (beyond == beyond.max()))


def _is_changed(fit: SharedFit, estimated: Estimate) -> NDArray[np.bool_]:
    """(S + 2,) what changes by more than may be chance, and by enough to be seen."""
    change = estimated.shared.values
    focal = np.sqrt(fit.camera.fx * fit.camera.fy)
    distance = np.mean([fit.camera.depth(pose.p_camera_root) for pose in fit.posed])
    moved_px = (
        np.abs(np.expm1(estimated.shared.sizes)) * fit.proportions.metres() * focal / distance
    )
    enough = moved_px > np.tile(LEAST_PX, len(fit.proportions.groups))
    surely = np.abs(change) > SURE * estimated.spread
    sizes = size_count(change)
    rest = np.zeros(len(change) - sizes, np.bool_)
    rest[0] = abs(change[sizes]) > LEAST_FOCAL
    changed = surely & np.append(enough, rest)
    if fit.beside and (surely & _of_limbs(fit)).any():
        changed |= _of_limbs(fit) & estimated.observable
    return np.asarray(changed)


def _of_limbs(fit: SharedFit) -> NDArray[np.bool_]:
    """(S + 3,) the lengths of limbs. Where another film shows a limb's length, each is nearer as it
    is estimated, sure or not, once one of them is surely another."""
    is_limb = np.zeros(len(fit.free), np.bool_)
    is_limb[: fit.proportions.count : 2] = [
        not fit.proportions.is_trunk[group[0]] for group in fit.proportions.groups
    ]
    return is_limb
