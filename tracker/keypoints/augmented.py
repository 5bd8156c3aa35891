"""Several looks at one frame, put together: test-time augmentation.

A network errs by chance as well as by what it learned, and by chance otherwise in a picture that
was cut out a little larger, turned or mirrored. The median of what it sees in these lies nearer to
the body (A. Newell and others, *Stacked Hourglass Networks for Human Pose Estimation*, 2016, take
the mean of a picture and its mirror image). Where a look exchanges left and right, it is exchanged
back to how the plain look has them.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from queue import SimpleQueue
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.blazepose import BlazePose, Seen, fingerprint_of
from keypose.tracker.keypoints.detect import LEAST_PRESENCE
from keypose.tracker.keypoints.model_files import FULL, Model
from keypose.tracker.keypoints.region import Region


@dataclass(frozen=True)
class Variation:
    """How a region is looked at: scale of its side, turned by an angle, mirrored."""

    scale: float = 1.0
    turn_rad: float = 0.0
    mirrored: bool = False

    def of(self, region: Region) -> Region:
        side, turn = region.side * self.scale, region.turn_rad + self.turn_rad
        return replace(region, side=side, turn_rad=turn)


NEARER = 0.88
TURN_RAD = float(np.radians(15.0))
VARIATIONS: Final = (
    Variation(NEARER),
    Variation(NEARER, mirrored=True),
    Variation(turn_rad=-TURN_RAD),
    Variation(turn_rad=TURN_RAD, mirrored=True),
)
"""Beside the plain look."""


class Mirrors(Protocol):
    """What also sees a region as in a mirror, as `BlazePose`."""

    @property
    def fingerprint(self) -> str: ...
    def infer(
        self, picture: NDArray[np.uint8], region: Region, *, mirrored: bool = False
    ) -> Seen: ...


class AugmentedNetwork:
    """A network that looks at each frame several times; as `BlazePose` otherwise.

    networks: the same one, read once for each thread that looks.  plain: one that looks once.
    """

    def __init__(self, networks: Sequence[Mirrors]) -> None:
        self.plain = networks[0]
        self.fingerprint = _marked(self.plain.fingerprint)
        self._threads = ThreadPoolExecutor(len(networks))
        self._idle: SimpleQueue[Mirrors] = SimpleQueue()
        for network in networks:
            self._idle.put(network)

    @classmethod
    def open(cls, model: Model = FULL, *, fast: bool | None = None) -> AugmentedNetwork:
        """Read a network's file; KeypointError as `BlazePose.open`."""
        threads = min(len(VARIATIONS), os.cpu_count() or 1)
        return cls([BlazePose.open(model, fast=fast) for _ in range(threads)])

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        """The median of the keypoints of the person in a region of a picture (H, W, 3), RGB;
        whether somebody is there, and where to look next, are the plain look's."""
        plain = self._look(picture, region, Variation())
        if plain.presence < LEAST_PRESENCE:
            return plain
        varied = self._threads.map(partial(self._look, picture, region), VARIATIONS)
        looks = [plain, *(_with_sides_of(plain, look) for look in varied if _is_finite(look))]
        return replace(
            plain,
            uv=_median([look.uv for look in looks]),
            visibility=_median([look.visibility for look in looks]),
            p_hips=_median([look.p_hips for look in looks]),
        )

    def _look(self, picture: NDArray[np.uint8], region: Region, varied: Variation) -> Seen:
        network = self._idle.get()
        try:
            return network.infer(picture, varied.of(region), mirrored=varied.mirrored)
        finally:
            self._idle.put(network)


def augmented_fingerprint(model: Model) -> str:
    """What the network would have as `Augmented.fingerprint`, which is not read for it."""
    return _marked(fingerprint_of(model))


def _marked(fingerprint: str) -> str:
    """Extend a fingerprint by the variations, which decide what is seen as well."""
    digest = hashlib.sha256(repr(VARIATIONS).encode()).hexdigest()[:8]
    return f"{fingerprint}-{len(VARIATIONS) + 1}-{digest}"


def _is_finite(look: Seen) -> bool:
    return bool(np.isfinite(look.uv).all() and np.isfinite(look.p_hips).all())


def _with_sides_of(plain: Seen, look: Seen) -> Seen:
    """Set left and right as the plain pass has them."""
    return min(look, look.exchanged(), key=lambda each: _apart(plain, each))


def _apart(first: Seen, second: Seen) -> float:
    return float(np.linalg.norm(first.uv - second.uv, axis=1).sum())


def _median(values: list[Array]) -> Array:
    return np.asarray(np.median(values, axis=0))
