"""The keypoints of a clip as a draft needs them: of an ideal lens, in the order of `JOINTS`."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tracker.errors import KeypointError
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array
from tracker.keypoints.keypoints import JOINTS, Keypoints

SEEN = 0.3
"""Visibility from which a joint counts as seen."""
FEWEST_SEEN = 6
"""Joints with which a frame is drafted."""
GAP = 5
"""So many frames without a person are bridged: the motion before and after is one."""


@dataclass(frozen=True, eq=False)
class Observed:
    """The twelve joints in N consecutive frames.

    first_frame: of the video.
    uv (N, 12, 2): pixels of an ideal lens, 0 where unknown.  known (N, 12).
    visibility (N, 12): 0 where unknown.
    p_hips (N, 12, 3): metres in axes parallel to the picture's, NaN where unknown.
    usable (N,): frames that show enough of a person.
    """

    first_frame: int
    uv: Array
    known: NDArray[np.bool_]
    visibility: Array
    p_hips: Array
    usable: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.uv)

    @classmethod
    def of(cls, keypoints: Keypoints, camera: Camera) -> Observed:
        """KeypointError where joints or their depths are not known at all."""
        missing = [name for name in JOINTS if name not in keypoints.names]
        if keypoints.p_hips is None or missing:
            what = missing[0].replace("_", " ") if missing else "depth"
            raise KeypointError(
                f"These keypoints tell no {what}: a draft needs a person's arms and legs with "
                "their depth, as the bundled network finds them."
            )
        index = [keypoints.names.index(name) for name in JOINTS]
        ideal = camera.without_distortion()
        uv = ideal.project(camera.back_project(keypoints.uv[:, index], 1.0))
        p_hips = keypoints.p_hips[:, index]
        known = np.asarray(np.isfinite(uv).all(-1) & np.isfinite(p_hips).all(-1))
        visibility = np.where(known, keypoints.visibility[:, index], 0.0)
        usable = (visibility >= SEEN).sum(axis=1) >= FEWEST_SEEN
        uv = np.where(known[..., None], uv, 0.0)
        return cls(keypoints.first_frame, uv, known, visibility, p_hips, np.asarray(usable))

    def rows(self, rows: slice) -> Observed:
        """Some of the frames."""
        first = self.first_frame + (rows.start or 0)
        return replace(
            self, first_frame=first, uv=self.uv[rows], known=self.known[rows],
            visibility=self.visibility[rows], p_hips=self.p_hips[rows], usable=self.usable[rows],
        )  # fmt: skip

    def runs(self) -> list[slice]:
        """Stretches of frames that show the person, short gaps included."""
        seen = np.flatnonzero(self.usable)
        if not len(seen):
            return []
        ends = np.flatnonzero(np.diff(seen) > GAP + 1)
        firsts, lasts = [0, *(ends + 1)], [*ends, len(seen) - 1]
        return [slice(int(seen[a]), int(seen[b]) + 1) for a, b in zip(firsts, lasts, strict=True)]
