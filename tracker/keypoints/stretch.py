"""A stretch of frames in which one body is followed, each looked at where it was in the last.

Regions are rounded: chains that come from different keyframes soon look at the same ones, and what
one of them found serves the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.network import NAMES, Seen
from keypose.tracker.keypoints.region import Region

LEAST_PRESENCE: Final = 0.5
LOOK_PARTS: Final = 32
"""Regions are rounded to so many parts of their size before each look."""


class Looks(Protocol):
    """What sees keypoints in a region, as `Network`."""

    @property
    def fingerprint(self) -> str: ...
    def look(self, picture: NDArray[np.uint8], region: Region) -> Seen: ...


@dataclass(frozen=True, eq=False)
class Stretch:
    """A piece of a chain: N frames in its direction.

    uv, visibility, p_hips: (N, 33, ...) as of Keypoints, NaN and 0 where nobody was seen.
    regions: (N, 4) where to look after each frame.
    lost_for: (N,) since how many frames the body is lost.
    """

    uv: Array
    visibility: Array
    p_hips: Array
    regions: Array
    lost_for: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.uv)

    def region(self, row: int) -> Region:
        """Where to look after a frame."""
        x, y, side, turn = self.regions[row].tolist()
        return Region(x, y, side, turn)

    def __getitem__(self, rows: slice) -> Stretch:
        """Some of its frames, or all in the other direction."""
        uv, visibility, p_hips = self.uv[rows], self.visibility[rows], self.p_hips[rows]
        return Stretch(uv, visibility, p_hips, self.regions[rows], self.lost_for[rows])

    @classmethod
    def joined(cls, pieces: Sequence[Stretch]) -> Stretch:
        """Pieces that follow one another."""
        return cls(
            np.concatenate([p.uv for p in pieces]),
            np.concatenate([p.visibility for p in pieces]),
            np.concatenate([p.p_hips for p in pieces]),
            np.concatenate([p.regions for p in pieces]),
            np.concatenate([p.lost_for for p in pieces]),
        )


class Rows:
    """A stretch while it grows: looked at frame by frame, each where the body was last."""

    def __init__(self, region: Region, lost_for: int = 0) -> None:
        self.region, self.lost_for = region, lost_for
        self._seen: list[Seen | None] = []
        self._regions: list[Region] = []
        self._lost_for: list[int] = []

    @classmethod
    def begun(
        cls, region: Region, network: Looks, picture: NDArray[np.uint8] | None, looks: int
    ) -> Rows:
        """One frame, looked at so often, each time where the body was seen the last time."""
        rows = cls(region)
        for _ in range(looks if picture is not None else 1):
            rows = cls(rows.region)
            rows.add(network, picture)
        return rows

    def add(self, network: Looks, picture: NDArray[np.uint8] | None) -> None:
        """The next frame; None where it cannot be decoded, or is not to be looked at."""
        seen = None
        if picture is not None:
            height, width = picture.shape[:2]
            if self.region.is_within(width, height):
                seen = network.look(picture, self.region.rounded(LOOK_PARTS))
                if not _is_somebody(seen, width, height):
                    seen = None
        if seen is None:
            self.lost_for += 1
        else:
            self.region, self.lost_for = seen.next, 0
        self._seen.append(seen)
        self._regions.append(self.region)
        self._lost_for.append(self.lost_for)

    def stretch(self) -> Stretch:
        points = len(NAMES)
        uv, metres = np.full((points, 2), np.nan), np.full((points, 3), np.nan)
        unseen = np.zeros(points)
        return Stretch(
            _stack([uv if s is None else s.uv for s in self._seen], (points, 2)),
            _stack([unseen if s is None else s.visibility for s in self._seen], (points,)),
            _stack([metres if s is None else s.p_hips for s in self._seen], (points, 3)),
            _stack([np.array(astuple(region)) for region in self._regions], (4,)),
            np.array(self._lost_for, dtype=np.int64),
        )


def _is_somebody(seen: Seen, width: int, height: int) -> bool:
    finite = np.isfinite(seen.uv).all() and np.isfinite(seen.p_hips).all()
    return bool(finite and seen.presence >= LEAST_PRESENCE and seen.next.is_within(width, height))


def _stack(rows: list[Array], shape: tuple[int, ...]) -> Array:
    return np.array(rows, dtype=float).reshape(len(rows), *shape)
