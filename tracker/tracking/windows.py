"""Show a body's pictures in a window around it, which is widened where the body leaves it.

What leaves the window is seen nowhere, as if it left the picture; so whoever follows the body looks
whether it led out of it, and then follows it again in a wider one. Where solves on the way left it
and came back is not looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import product
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.layout import Lens
from keypose.tracker.kernels.places import find_windows
from keypose.tracker.solver.placed import articulation
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.video.pyramid import Clip, Prepared, Window

Poses: TypeAlias = tuple[Array, Array]
"""Rs_parent_part (N, P, 3, 3), ps_camera_root (N, 3)."""
EDGE_PX = 12
"""Around the body: interpolation at the coarsest level reaches four pixels from a point."""
MARGIN = 0.25
"""Of the body's extent, by which windows are wider than what is known of its motion."""
MOST_TURNS = 4
"""So often a window is widened a little for a motion that leaves it; then it is all the picture."""
FAR_PX = 1e6
"""Beyond every picture."""
NEAREST_M = 0.05
"""Nothing nearer is seen; where it would be seen, nobody knows."""


def body_windows(skeleton: Skeleton, lens: Lens, Rs: Array, ps: Array) -> NDArray[np.float64]:
    """(N, 4) left, top, right and bottom pixel of a body's surface in poses Rs (N, P, 3, 3), ps
    (N, 3); infinite where a part of it comes too near to the camera, or is nowhere."""
    windows = np.empty((len(ps), 4))
    corners = _corners(skeleton)
    find_windows(articulation(skeleton), corners, lens, NEAREST_M, Rs, ps, windows)
    return windows


@lru_cache(maxsize=8)
def _corners(skeleton: Skeleton) -> Array:
    """(P, 8, 3) corners of a box around every part, in its frame."""
    surfaces = [part.shape.mesh().vertices for part in skeleton.body.parts]
    ends = np.array([[own.min(axis=0), own.max(axis=0)] for own in surfaces])  # (P, 2, 3)
    which = np.array(list(product((0, 1), repeat=3)))  # (8, 3)
    return np.ascontiguousarray(ends[:, which, np.arange(3)])


def window_around(windows: NDArray[np.float64], margin: float = 0.0) -> Window | None:
    """One around these (N, 4), wider by a share of the body's extent; None for all of the
    picture."""
    low, high = windows[:, :2].min(axis=0), windows[:, 2:].max(axis=0)
    if not np.isfinite([low, high]).all():
        return None
    extent = float((windows[:, 2:] - windows[:, :2]).max())
    left, top, right, bottom = np.clip([*low, *high], -FAR_PX, FAR_PX).round().astype(int).tolist()
    return Window(left, top, right, bottom).grown(EDGE_PX + margin * extent)


def show(scene: Scene, clip: Clip, Rs: Array, ps: Array) -> Prepared:
    """The pictures of a clip, which show the body in poses Rs (N, P, 3, 3), ps (N, 3)."""
    windows = body_windows(scene.skeleton, scene.lens, Rs, ps)
    return clip.cover(window_around(windows), window_around(windows, MARGIN))


def show_all(
    scene: Scene, clip: Clip, trajectories: Sequence[Trajectory], more_px: float
) -> tuple[Window, Prepared]:
    """A window around several trajectories that they alone decide, wider by some pixels; and
    pictures that show it."""
    windows = np.concatenate(
        [body_windows(scene.skeleton, scene.lens, *each.writable()) for each in trajectories]
    )
    around = window_around(windows)
    whole = Window.whole(scene.camera.width, scene.camera.height)
    window = whole if around is None else around.grown(more_px).within(whole)
    window = whole if window.is_empty else window
    return window, clip.cover(window)


def follow_within(
    scene: Scene, clip: Clip, start: Poses, follow: Callable[[Prepared], Poses], *, is_chain: bool
) -> Poses:
    """Follow the body from some poses to others, again in wider pictures where it leaves them.

    is_chain: each pose follows from the one before, so that none counts after the first that left.
    """
    skeleton = scene.skeleton
    windows = body_windows(skeleton, scene.lens, *start)
    shown = clip.cover(window_around(windows), window_around(windows, MARGIN))
    for turn in range(MOST_TURNS):
        poses = follow(shown)
        led = body_windows(skeleton, scene.lens, *poses)
        if _shows(clip, shown, led):
            return poses
        left = np.array([not _shows(clip, shown, each) for each in led[:, None]])
        if is_chain:
            led = led[: int(left.argmax()) + 1]
        wider = window_around(np.concatenate([windows, led]), MARGIN)
        shown = clip.cover(wider if turn < MOST_TURNS - 1 else None)
    return follow(shown)


def _shows(clip: Clip, shown: Prepared, windows: NDArray[np.float64]) -> bool:
    """Whether pictures show all of these windows (N, 4) that lies within the picture."""
    wanted = clip.within(window_around(windows))
    return wanted is None or shown.holds(wanted)
