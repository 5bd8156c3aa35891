"""Where a posed body and what the picture shows of it disagree.

Before a camera that stands still the loader marks pixels that look as the empty scene does; before
one that moves a network's mask says where a person is. Pixels near the body that move, or are the
person's, and that no part covers are missing from the pose; a part's pixels that stand still, or
are not the person's, show no body there. Neither needs the truth, and both grow with the error of
a pose. Below, "moves" stands for either.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, frozen
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.kernels.layout import STEPS
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import extent_px
from keypose.tracker.video.clip_loader import WorkingSize
from keypose.tracker.video.pyramid import IGNORED, TARGET_ONLY, USABLE, Clip, Window

Outlines: TypeAlias = Callable[[int], NDArray[np.bool_] | None]
"""Where a person is, (h, w) at the finest level of a clip, by frame; None where that is unknown."""

REACH = 0.07
"""Share of the body's extent: how far from the body what moves is taken to be the body's."""
RIM = 0.012
"""Of the same: on either side of the outline nothing counts, since clothes are no exact shape."""
HALO_PX = 3.0
"""Outside it is no narrower than this: a bright body shines as far into the smoothed picture."""
SPECK_PX = 3
"""What moves and is narrower than this is noise."""
FINE_PX = 320.0
"""A body that is larger in the picture is compared at half size, or a quarter."""
CHANGED = 0.20
"""Where more than this share of what is around the body moves, or of the rest of the picture, all
of it has changed, as when the exposure does: a person near by makes up less."""
TONES = (5.0, 95.0)
"""Percentiles of a part's brightness at the keyframes: a still pixel between them may be the part
itself before a background that is as bright."""
HALF_LEVEL = 128
"""Of 255, from which a pixel of a mask is the person's."""
FEWEST_PIXELS = 12
"""A part that shows fewer at the keyframes gives no tones."""


@dataclass(frozen=True, eq=False)
class SilhouetteMismatch:
    """Mismatch of N poses of P parts with what moves, as shares of the body's area in its frame.

    uncovered_by_part: (N, P) moving pixels that no part covers, by the part that lies nearest.
    unmoved_by_part: (N, P) pixels of a part that look as the empty scene does.
    Both are NaN in frames without anything to compare with, as where the picture is missing, has
    changed all around the body, or nobody is seen, and in those whose picture shows nothing of the
    body.
    """

    uncovered_by_part: Array
    unmoved_by_part: Array

    @property
    def by_part(self) -> Array:
        """(N, P) the sum of both."""
        return self.uncovered_by_part + self.unmoved_by_part

    @property
    def uncovered(self) -> Array:
        """(N,) moving pixels near the body that no part covers."""
        return np.asarray(self.uncovered_by_part.sum(axis=1))

    @property
    def unmoved(self) -> Array:
        """(N,) pixels of the body that look as the empty scene does."""
        return np.asarray(self.unmoved_by_part.sum(axis=1))

    @property
    def total(self) -> Array:
        """(N,) the sum of both."""
        return self.uncovered + self.unmoved

    @property
    def excess(self) -> Array:
        """(N,) by how much the total is above that of the first and the last pose, linearly between
        them: shadows, and clothes like the background, are there as well. 0 where nothing is known.
        """
        total, share = self.total, np.linspace(0.0, 1.0, len(self.total))
        ends = total[[0, -1]]
        ends = np.where(np.isfinite(ends), ends, ends[::-1])  # one keyframe may lack it
        return np.asarray(np.nan_to_num(total - (1 - share) * ends[0] - share * ends[1]))


def silhouette_mismatch(
    scene: Scene, clip: Clip, trajectory: Trajectory, outlines: Outlines | None = None
) -> SilhouetteMismatch:
    """The mismatch of every pose of a trajectory whose frames are all in the clip.

    outlines: of the person; without them the clip is one of a loader with `static_camera`: of any
    other, everything is NaN.  IndexError where the clip lacks a frame.
    """
    windows = list(_windows(scene, clip, trajectory, outlines))
    parts = scene.skeleton.part_count
    tones = _tones([window for window in (windows[0], windows[-1]) if window is not None], parts)
    shares = np.full((2, len(trajectory), parts), np.nan)
    for n, window in enumerate(windows):
        if window is not None:
            shares[:, n] = _shares(window, tones)
    return SilhouetteMismatch(*frozen(shares))


def outlines_of(keypoints: Keypoints | None, camera: Camera, size: WorkingSize) -> Outlines:
    """Where a network saw the person, in the pictures of a clip; nowhere where it did not.

    camera: of the video, with its distortion.  size: of the clip.
    """

    def outline(frame: int) -> NDArray[np.bool_] | None:
        mask = None if keypoints is None else keypoints.mask(frame)
        if mask is None:
            return None
        share = mask.in_picture(camera.width, camera.height)
        levels = np.round(255 * share).astype(np.uint8)
        return np.asarray(size.picture(camera.rectify(levels)) >= HALF_LEVEL)

    return outline


@dataclass(frozen=True, eq=False)
class _Window:
    """The picture around the body in one frame, (h, w) each.

    shown: part of every pixel or −1.  use: what a pixel may be used for.  grey: its brightness.
    extent: of the body, pixels.  elsewhere: share of the rest of the picture that moves.
    """

    shown: NDArray[np.int16]
    use: NDArray[np.int16]
    grey: NDArray[np.float64]
    extent: float
    elsewhere: float


def _windows(
    scene: Scene, clip: Clip, trajectory: Trajectory, outlines: Outlines | None
) -> Iterator[_Window | None]:
    """One for every frame; None where nothing can be compared."""
    mesh = BodyMesh.of(scene.skeleton)
    level, coarsest = _level(extent_px(scene, trajectory), clip), len(clip.levels) - 1
    camera = WorkingSize(level).camera(scene.camera)
    view, Ts = ViewCamera.of(camera), trajectory.transforms(scene.skeleton)
    slots = clip.slots(trajectory.first_frame, trajectory.last_frame)
    marks = scene.mark_pixels(trajectory) / 2**level
    extents = (marks.max(axis=1) - marks.min(axis=1)).max(axis=-1)
    sizes = camera.width, camera.height
    around = [_around(uv, 2 * REACH * e, sizes) for uv, e in zip(marks, extents, strict=True)]
    shown = clip.cover(_joined(around).doubled(level))
    for slot, extent, window, T in zip(slots, extents, around, Ts, strict=True):
        outline = None if outlines is None else outlines(clip.first_frame + int(slot))
        used = _by_outline(clip.overview.use[slot], outline, coarsest)
        if window is None or not (used == TARGET_ONLY).any():
            yield None
            continue
        part = raster(mesh, T, _within(view, window)).part
        picture = shown.cut(int(slot), level, window)
        use = _by_outline(picture[..., 3], outline, level, window)
        moving = used == USABLE
        inside = window.halved(coarsest - level).of(moving)
        rest = max(moving.size - inside.size, 1)
        elsewhere = float(moving.sum() - inside.sum()) / rest
        yield _Window(part, use, picture[..., 0] / STEPS, float(extent), elsewhere)


def _joined(windows: Sequence[Window | None]) -> Window:
    """The smallest window that holds all of these."""
    present = [window for window in windows if window is not None]
    return reduce(Window.joined, present) if present else Window(0, 0, 0, 0)


def _by_outline(
    used: NDArray[Any], outline: NDArray[np.bool_] | None, level: int, window: Window | None = None
) -> NDArray[Any]:
    """What pixels of a level may be used for by where the person is; as it was where that is
    unknown. window: what is shown of that level; None for all of it."""
    if outline is None:
        return used
    there = outline[:: 2**level, :: 2**level]
    there = there if window is None else window.of(there)
    person = np.where(there, np.uint8(USABLE), np.uint8(TARGET_ONLY))
    return np.where(used == IGNORED, used, person)


def _level(extent: float, clip: Clip) -> int:
    """The finest level of the clip at which a body of this extent, pixels, is small enough."""
    halvings = max(0, int(np.ceil(np.log2(extent / FINE_PX))))
    return min(halvings, len(clip.levels) - 1)


def _around(uv: Array, margin: float, sizes: tuple[int, int]) -> Window | None:
    """A window of a picture (width, height) around pixels (M, 2); None where they are not in it."""
    if not np.isfinite(uv).all():
        return None
    low = np.clip(np.floor(uv.min(axis=0) - margin), 0, sizes).astype(int)
    high = np.clip(np.ceil(uv.max(axis=0) + margin) + 1, 0, sizes).astype(int)
    return Window(*low.tolist(), *high.tolist()) if (low < high).all() else None


def _within(view: ViewCamera, window: Window) -> ViewCamera:
    """The view of a window of the picture alone."""
    centre = (view.centre[0] - window.left, view.centre[1] - window.top)
    width, height = window.right - window.left, window.bottom - window.top
    return replace(view, centre=centre, width=width, height=height)


def _tones(keyed: Sequence[_Window], parts: int) -> Array:
    """(P, 2) the range of brightness of every part where it moves at the keyframes; an empty range
    where that is not known."""
    tones = np.tile((np.inf, -np.inf), (parts, 1))
    if not keyed:
        return tones
    of = [(w.shown[w.use == USABLE], w.grey[w.use == USABLE]) for w in keyed]
    shown, grey = (np.concatenate(arrays) for arrays in zip(*of, strict=True))
    for part in range(parts):
        own = grey[shown == part]
        if len(own) >= FEWEST_PIXELS:
            tones[part] = np.percentile(own, TONES)
    return tones


def _shares(window: _Window, tones: Array) -> Array:
    """(2, P) uncovered and unmoved shares of one frame."""
    shown, use, extent, parts = window.shown, window.use, window.extent, len(tones)
    covered = shown >= 0
    area = int(covered.sum())
    if not area:
        return np.full((2, parts), np.nan)
    rim = RIM * extent
    outside, nearest = _nearest_part(shown, covered)
    around = use[outside > REACH * extent] == USABLE
    if max(window.elsewhere, around.sum() / max(around.size, 1)) > CHANGED:
        return np.full((2, parts), np.nan)
    kernel = np.ones((SPECK_PX, SPECK_PX), np.uint8)
    moving = cv2.morphologyEx((use == USABLE).astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0
    uncovered = moving & (outside > max(rim, HALO_PX)) & (outside <= REACH * extent)
    inside = cv2.distanceTransform(covered.astype(np.uint8), cv2.DIST_L2, 3)
    low, high = tones[shown, 0], tones[shown, 1]
    alike = (low <= window.grey) & (window.grey <= high)
    unmoved = (use == TARGET_ONLY) & (inside > max(rim, 1.0)) & ~alike
    counts = [np.bincount(p, minlength=parts) for p in (nearest[uncovered], shown[unmoved])]
    return np.array(counts) / area


def _nearest_part(
    shown: NDArray[np.int16], covered: NDArray[np.bool_]
) -> tuple[NDArray[np.float32], NDArray[np.int16]]:
    """How far every pixel lies from the body, pixels, and which part lies nearest."""
    distance, label = cv2.distanceTransformWithLabels(
        (~covered).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    part_of = np.zeros(int(label.max()) + 1, np.int16)
    part_of[label[covered]] = shown[covered]
    return np.asarray(distance, np.float32), part_of[label]
