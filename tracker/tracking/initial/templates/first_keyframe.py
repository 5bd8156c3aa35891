"""Follow what the first keyframe shows of a body to the last one (INITIAL §3.1)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.errors import readable
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.tracking.initial.templates.patch import Rotatable
from keypose.tracker.tracking.initial.templates.search import GreyPicture, Match, find_match
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.video.pyramid import in_grey_levels

TurnAt: TypeAlias = Callable[[int, Array], float]
"""Radians by which the template is turned in the n-th frame if it lies at this place (2,)."""

SPREAD_RAD = np.radians(9.0)
"""A limb may be turned by this much more or less than its predicted place says."""
POOR_GREY = 8.0
"""Grey levels by which a match may be worse than a flat template would be."""
MOST_POOR = 12
"""Frames on end through which a part that is not seen is taken to move on evenly."""
SLOWING = 0.7
"""The share of its speed that remains after each of them."""
SETTLED = 3
"""Pixels within which a place is looked for once more when its turn is known."""


@dataclass(frozen=True, eq=False)
class TemplateTrack:
    """Where a template was found: uv (N, 2) pixels. lost: the frame from which on it was not."""

    uv: Array
    lost: int | None


def follow_template(
    template: Rotatable, shown: Sequence[GreyPicture], turn_at: TurnAt, reach: int
) -> TemplateTrack:
    """Follow a template through all pictures, the first being its own.

    It is expected to move on as it last did, also while it is not found, up to MOST_POOR frames.
    """
    uv = np.tile(np.asarray(template.uv, np.float64), (len(shown), 1))
    step, poor = np.zeros(2), 0
    for n in range(1, len(shown)):
        expected = uv[n - 1] + step
        match = _best_match(template, shown[n], n, expected, turn_at, reach + 2 * poor)
        if match is None:
            poor += 1
            uv[n] = expected
            step *= SLOWING
            if poor > MOST_POOR or not _is_inside(shown[n], expected):
                return TemplateTrack(uv, n - poor + 1)
            continue
        poor, uv[n] = 0, match.uv
        step = uv[n] - uv[n - 1]
    return TemplateTrack(uv, None if not poor else len(shown) - poor)


def _best_match(
    template: Rotatable,
    shown: GreyPicture,
    n: int,
    expected: Array,
    turn_at: TurnAt,
    reach: int,
) -> Match | None:
    """The best match of a few turns; None where none is any good."""
    about = turn_at(n, expected)
    turns = (about, about - SPREAD_RAD, about + SPREAD_RAD)
    tried = [_find_turned(template, shown, expected, turn, reach) for turn in turns]
    matches = [match for match in tried if match is not None]
    if not matches:
        return None
    best = min(matches, key=lambda match: match.miss)  # of equal ones the first
    place = np.array(best.uv)
    again = _find_turned(template, shown, place, turn_at(n, place), SETTLED)
    return again if again is not None and again.miss < best.miss else best


def _find_turned(
    template: Rotatable, shown: GreyPicture, uv: Array, turn: float, reach: int
) -> Match | None:
    piece = template.at(turn)
    if piece is None:
        return None
    match = find_match(piece, shown, uv, reach)
    poor = match.miss > piece.contrast + POOR_GREY or not _is_inside(shown, np.array(match.uv))
    return None if poor else match


def _is_inside(shown: GreyPicture, uv: Array) -> bool:
    height, width = shown.grey.shape
    return bool((uv > -0.5).all() and uv[0] < width - 0.5 and uv[1] < height - 0.5)


HALF_SHARE = 0.55
LEAST_HALF = 5
MOST_HALF = 20
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
        """Prepare what the first keyframe of one segment shows."""
        slots = segment.clip.slots(segment.first_frame, segment.last_frame)
        whole = segment.clip.cover(None).levels[0]  # parts are sought far around
        shown = [GreyPicture.of(in_grey_levels(whole[slot])) for slot in slots]
        Ts = pose_transforms(scene.skeleton, segment.start)
        body_raster = raster(BodyMesh.of(scene.skeleton), Ts, ViewCamera.of(scene.camera))
        return cls(scene, segment, shown, body_raster.part)

    def name(self, part: int) -> str:
        """What a person calls a part."""
        return readable(self.scene.skeleton.body.names[part])

    def template(self, part: int, uv: Array, also: Collection[int] = ()) -> Rotatable:
        """What the first keyframe shows of a part, and of others that go with it."""
        wanted = np.isin(self.shows, [part, *also]).astype(np.uint8)
        pixels = np.argwhere(self.shows == part)
        extent = np.ptp(pixels, axis=0).max() if len(pixels) else 0
        half = int(np.clip(HALF_SHARE * extent, LEAST_HALF, MOST_HALF))
        slot = self.segment.clip.slots(self.segment.first_frame, self.segment.first_frame)[0]
        wide = cv2.dilate(wanted, np.ones((3, 3), np.uint8)) > 0
        picture = in_grey_levels(self.segment.clip.cover(None).levels[0][slot])
        return Rotatable(picture, wide, uv, half)

    def track(
        self, part: int, template: Rotatable, turn_at: TurnAt, keyed: Array, reach: int
    ) -> Array:
        """(N, 2) where a part's template is found, led evenly to its place at the last keyframe.

        NotFollowed where it is hidden, is lost on the way, or comes out elsewhere.
        """
        first, last = self.segment.first_frame, self.segment.last_frame
        if not np.isfinite([keyed, template.uv]).all() or template.at(0.0) is None:
            raise NotFollowed(f"{self.name(part)} is hidden at frame {first}")
        template_track = follow_template(template, self.shown, turn_at, reach)
        if template_track.lost is not None:
            raise NotFollowed(f"{self.name(part)} lost at frame {first + template_track.lost}")
        miss = keyed - template_track.uv[-1]
        if np.linalg.norm(miss) > max(ARRIVAL * template.half, LEAST_HALF):
            raise NotFollowed(f"{self.name(part)} not found where the keyframe at {last} shows it")
        return np.asarray(
            template_track.uv + np.linspace(0.0, 1.0, len(template_track.uv))[:, None] * miss
        )
