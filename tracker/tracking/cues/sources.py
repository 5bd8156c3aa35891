"""Where the keypoints of a segment come from: a network that looks for them, or a file of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from threading import Lock
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from tracker.errors import KeypointError
from tracker.keypoints.detect import Kept, Progress, Seed, detect
from tracker.keypoints.keypoints import Keypoints
from tracker.keypoints.model_files import FULL, Model
from tracker.keypoints.network import Network
from tracker.keypoints.region import Region
from tracker.video.info import MissingFrame

if TYPE_CHECKING:
    from tracker.body.pose import Pose
    from tracker.body.skeleton import Skeleton
    from tracker.geometry.camera import Camera
    from tracker.tracking.segment import Segment
    from tracker.video import Video

ROUNDING = 16
"""Regions start at whole parts of their size: a keyframe that is moved a little is looked at from
where it was, and what was found there can be used again."""


_LOOKING = Lock()
"""A network looks at one picture at a time."""


@cache
def _network(model: Model) -> Network:
    return Network.open(model)


class KeypointSource(Protocol):
    """What tells keypoints. A segment's depend on nothing but its own frames and keyposes."""

    def over(
        self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
    ) -> Keypoints | None:
        """Those of a segment's frames; None where nobody is found.

        report: called again and again; what it raises ends the search within a frame.
        """


@dataclass(frozen=True, eq=False)
class GivenKeypoints:
    """Keypoints that somebody found, such as those of a file."""

    keypoints: Keypoints

    def over(
        self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
    ) -> Keypoints | None:
        return self.keypoints.over(segment.first_frame, segment.last_frame)


@dataclass(frozen=True, eq=False)
class DetectedKeypoints:
    """Keypoints by a network, which looks for the body from both of its keyposes.

    camera: of the video, with its distortion.  film: the video's fingerprint, under which what is
    found is kept.  model: the network.
    """

    video: Video
    camera: Camera
    film: str = ""
    kept: Kept | None = None
    model: Model = FULL

    def over(
        self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
    ) -> Keypoints | None:
        first, last = segment.first_frame, segment.last_frame
        posed = ((first, segment.start), (last, segment.end))
        seeds = [self._seed(frame, skeleton, pose) for frame, pose in posed]

        def leave(progress: Progress) -> None:
            report()

        with _LOOKING:
            network = _network(self.model)  # a KeypointError of its own where it is not here
            try:
                return detect(
                    self._frame, (first, last), seeds, network,
                    report=leave, film=self.film, kept=self.kept,
                )  # fmt: skip
            except KeypointError:  # nobody is seen there: a body that is no person
                return None

    def _seed(self, frame: int, skeleton: Skeleton, pose: Pose) -> Seed:
        return Seed(frame, _rounded(Region.of_pose(skeleton, pose, self.camera)))

    def _frame(self, number: int) -> NDArray[np.uint8] | None:
        try:
            return self.video.frame(number)
        except MissingFrame:
            return None


def _rounded(region: Region) -> Region:
    side = float(2 ** (np.round(np.log2(region.side) * ROUNDING) / ROUNDING))
    step = side / ROUNDING
    x, y = (float(np.round(value / step) * step) for value in (region.x, region.y))
    turn = float(np.round(region.turn_rad * ROUNDING) / ROUNDING)
    return replace(region, x=x, y=y, side=side, turn_rad=turn)
