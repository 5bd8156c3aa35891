"""The keypoints of a clip as a draft needs them: of an ideal lens, in the order of `POINTS`."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import KeypointError
from keypose.tracker.fitting.draft.limbs import POINTS
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.jumps import jumped_away
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints

SEEN = 0.3
"""Visibility from which a joint counts as seen."""
FEWEST_SEEN = 6
"""Joints with which a frame is drafted."""
JUMP = 0.35
"""Of the person's extent in the picture: nobody moves so far from one frame to the next."""
GAP = 5
"""So many frames without a person are bridged: the motion before and after is one."""


@dataclass(frozen=True, eq=False)
class Observed:
    """Keypoints in N consecutive frames: the twelve `JOINTS`, then `ENDS`, K together.

    first_frame: of the video.
    uv (N, K, 2): pixels of an ideal lens, 0 where unknown.  known (N, K).
    visibility (N, K): 0 where unknown.
    p_hips (N, K, 3): metres in axes parallel to the picture's, NaN where unknown.
    usable (N,): frames that show enough of a person.
    jumped (N,): frames from which on this may be another person: they are suddenly elsewhere, or
    followed back the body comes to another place.
    """

    first_frame: int
    uv: Array
    known: NDArray[np.bool_]
    visibility: Array
    p_hips: Array
    usable: NDArray[np.bool_]
    jumped: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.uv)

    @classmethod
    def of(cls, keypoints: Keypoints, camera: Camera, changes: Collection[int] = ()) -> Observed:
        """KeypointError where joints or their depths are not known at all.

        changes: frames from which on they may be another person's, besides those they jump at.
        """
        missing = [name for name in JOINTS if name not in keypoints.names]
        if keypoints.p_hips is None or missing:
            what = missing[0].replace("_", " ") if missing else "depth"
            raise KeypointError(
                f"These keypoints have no {what}: a draft needs a person's arms and legs with "
                "their depth, as the bundled network finds them."
            )
        columns = [_column(keypoints, keypoints.p_hips, name) for name in POINTS]
        filmed, seen, p_hips = (np.stack(values, axis=1) for values in zip(*columns, strict=True))
        uv = camera.without_distortion().project(camera.back_project(filmed, 1.0))
        known = np.asarray(np.isfinite(uv).all(-1) & np.isfinite(p_hips).all(-1))
        visibility = np.where(known, seen, 0.0)
        usable = (visibility[:, : len(JOINTS)] >= SEEN).sum(axis=1) >= FEWEST_SEEN
        uv = np.where(known[..., None], uv, 0.0)
        usable = np.asarray(usable)
        jumped = _jumped(uv, known, usable) | _begins(changes, keypoints.first_frame, usable)
        return cls(keypoints.first_frame, uv, known, visibility, p_hips, usable, jumped)

    def rows(self, rows: slice) -> Observed:
        """Some of the frames."""
        first = self.first_frame + (rows.start or 0)
        return replace(
            self, first_frame=first, uv=self.uv[rows], known=self.known[rows],
            visibility=self.visibility[rows], p_hips=self.p_hips[rows], usable=self.usable[rows],
            jumped=self.jumped[rows],
        )  # fmt: skip

    def without_jumps(self, height_px: float) -> Observed:
        """With those unknown that are for a few frames elsewhere. height_px: of the body."""
        away = jumped_away(self.uv, self.known, height_px, POINTS, self.p_hips)
        known = self.known & ~away
        return replace(self, known=known, visibility=np.where(known, self.visibility, 0.0))

    def bridged(self, rest: Array) -> Array:
        """(N, 12, 3) the joints' p_hips: where a joint is not known, linear between the frames
        that know it, and as in the rest pose (12, 3) where none does."""
        out, frames = self.p_hips[:, : len(JOINTS)].copy(), np.arange(len(self))
        for k in range(len(JOINTS)):
            known = np.flatnonzero(self.known[:, k])
            for axis in range(3):
                values = out[known, k, axis] if len(known) else [rest[k, axis]]
                out[:, k, axis] = np.interp(frames, known if len(known) else [0], values)
        return out

    def runs(self) -> list[slice]:
        """Stretches of frames that show one person, short gaps included."""
        seen = np.flatnonzero(self.usable)
        if not len(seen):
            return []
        ends = np.flatnonzero((np.diff(seen) > GAP + 1) | self.jumped[seen[1:]])
        firsts, lasts = [0, *(ends + 1)], [*ends, len(seen) - 1]
        return [slice(int(seen[a]), int(seen[b]) + 1) for a, b in zip(firsts, lasts, strict=True)]


def _column(keypoints: Keypoints, p_hips: Array, name: str) -> tuple[Array, Array, Array]:
    """Of one keypoint in all frames uv (N, 2), visibility (N,) and p_hips (N, 3); NaN and 0 where
    there is none of that name."""
    if name in keypoints.names:
        k = keypoints.names.index(name)
        return keypoints.uv[:, k], keypoints.visibility[:, k], p_hips[:, k]
    count = len(keypoints)
    return np.full((count, 2), np.nan), np.zeros(count), np.full((count, 3), np.nan)


def _begins(frames: Collection[int], first: int, usable: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(N,) the first usable frame at or after each of these."""
    out, rows = np.zeros(len(usable), np.bool_), np.flatnonzero(usable)
    for frame in frames:
        out[rows[rows >= frame - first][:1]] = True
    return out


def _jumped(uv: Array, known: NDArray[np.bool_], usable: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(N,) whether the joints are elsewhere than in the usable frame before."""
    out = np.zeros(len(uv), np.bool_)
    rows = np.flatnonzero(usable)
    for before, here in pairwise(rows.tolist()):
        both = known[before] & known[here]
        a, b = uv[before, both], uv[here, both]
        extent = max(np.ptp(a, axis=0).max(initial=0.0), np.ptp(b, axis=0).max(initial=0.0))
        step = np.linalg.norm(np.median(b - a, axis=0)) if both.any() else 0.0
        out[here] = step > JUMP * max(extent, 1.0) * np.sqrt(here - before)
    return out
