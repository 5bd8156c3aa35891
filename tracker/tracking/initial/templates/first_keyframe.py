"""What the first keyframe shows of a body, followed to the last one."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.errors import readable
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.tracking.initial.templates.follow_template import TurnAt, follow_template
from keypose.tracker.tracking.initial.templates.rotatable import Rotatable
from keypose.tracker.tracking.initial.templates.search import GreyPicture
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment

HALF_SHARE, LEAST_HALF, MOST_HALF = 0.55, 5, 20
"""Half a template's side as a share of the followed part's extent, and its limits in pixels."""
ARRIVAL = 0.8
"""Of a template's half side, how far it may miss its place at the last keyframe."""


class NotFollowed(Exception):
    """A part could not be followed; the text says which and why."""


@dataclass(frozen=True, eq=False)
class FirstKeyframe:
    """A segment's pictures, ready to be searched for what its first keyframe shows.

    shows: (h, w) index of the part that each pixel shows in the first keyframe, −1 for none.
    """

    scene: Scene
    segment: Segment
    shown: Sequence[GreyPicture]
    shows: NDArray[np.int16]

    @classmethod
    def of(cls, scene: Scene, segment: Segment) -> FirstKeyframe:
        """Of one segment."""
        slots = segment.clip.slots(segment.first_frame, segment.last_frame)
        shown = [GreyPicture.of(segment.clip.levels[0][slot]) for slot in slots]
        Ts = pose_transforms(scene.skeleton, segment.start)
        seen = raster(BodyMesh.of(scene.skeleton), Ts, ViewCamera.of(scene.camera))
        return cls(scene, segment, shown, seen.part)

    def name(self, part: int) -> str:
        """What a person calls a part."""
        return readable(self.scene.skeleton.body.names[part])

    def template(self, part: int, uv: Array, also: Collection[int] = ()) -> Rotatable:
        """What the first keyframe shows of a part, and of others that go with it."""
        wanted = np.isin(self.shows, [part, *also]).astype(np.uint8)
        seen = np.argwhere(self.shows == part)
        extent = np.ptp(seen, axis=0).max() if len(seen) else 0
        half = int(np.clip(HALF_SHARE * extent, LEAST_HALF, MOST_HALF))
        slot = self.segment.clip.slots(self.segment.first_frame, self.segment.first_frame)[0]
        wide = cv2.dilate(wanted, np.ones((3, 3), np.uint8)) > 0
        return Rotatable(self.segment.clip.levels[0][slot], wide, uv, half)

    def track(
        self, part: int, template: Rotatable, turn_at: TurnAt, keyed: Array, reach: int
    ) -> Array:
        """(N, 2) where a part's template is found, led evenly to its place at the last keyframe.

        NotFollowed where it is hidden, is lost on the way, or comes out elsewhere.
        """
        first, last = self.segment.first_frame, self.segment.last_frame
        if not np.isfinite([keyed, template.uv]).all() or template.at(0.0) is None:
            raise NotFollowed(f"{self.name(part)} is hidden at frame {first}")
        found = follow_template(template, self.shown, turn_at, reach)
        if found.lost is not None:
            raise NotFollowed(f"{self.name(part)} lost at frame {first + found.lost}")
        miss = keyed - found.uv[-1]
        if np.linalg.norm(miss) > max(ARRIVAL * template.half, LEAST_HALF):
            raise NotFollowed(f"{self.name(part)} not found where the keyframe at {last} shows it")
        return np.asarray(found.uv + np.linspace(0.0, 1.0, len(found.uv))[:, None] * miss)
