"""What is to be checked of a segment in words: every cause once, for files, command line and page.

Words of files name {part}, {first} and {last} frame; of the page also {frames}, as "frames 31–36
are". A row, and a sentence by itself, name {Part}, {range} as "31–36", the segment's {span} and
{length}, {within} as ", frames 31–36" where that is not all of it, {hidden} behind what, and from
what it {differs}.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class CauseWords:
    """The words of one cause.

    file: in files and on the command line, after what is to be checked.
    page: where part and frames are shown beside it; as in files where left out.
    row:  beside its part in a list; as on the page with its frames where left out.
    alone: a sentence by itself; that of the verdict where left out.
    """

    file: str = ""
    page: str = ""
    row: str = ""
    alone: str = ""

    @property
    def shown(self) -> str:
        """What the page says."""
        return self.page or self.file


PASSES: Final = "tracked from either keyframe, it differs"
FOOT: Final = "heel and toe are seen elsewhere"

CAUSE_WORDS: Final[Mapping[str, CauseWords]] = {
    "good": CauseWords("good"),
    "uncertain": CauseWords(
        file="{part} uncertain",
        page="{part} may be wrong",
        row="{differs}",
        alone="{Part} may be wrong{within}: {differs}",
    ),
    "not_seen": CauseWords(
        file="{part} not seen",
        page="{part} hidden",
        row="{hidden}, {range}",
        alone="{Part} {hidden}{within}",
    ),
    "beyond_limits": CauseWords("{part} beyond its joint limits"),
    "diverged": CauseWords("a pass diverged", row=PASSES),
    "damaged": CauseWords("damaged in the video", page="{frames} damaged in the video"),
    "no_surface": CauseWords("no surface that can be used"),
    "not_fitted": CauseWords("not fitted yet"),
    "one_keyframe": CauseWords("fitted from one keyframe only so far"),
    "keyframe_off_surface": CauseWords(
        file="the keyframe lies off its surface",
        page="the keyframe is off its surface",
    ),
    "body_off_surface": CauseWords(
        file="the body lies off the surface that moves with it",
        page="at key {first} the body is off its surface",
    ),
    "keyframe_off_keypoints": CauseWords(
        file="the keyframe's {part} is not where it is seen",
        page="at key {first} the {part} is not where it is seen",
    ),
    "moves_beside_body": CauseWords("the body does not match the silhouette"),
    "depth": CauseWords("{part} a guess in depth", row="a guess in depth, {range}"),
    "not_followed": CauseWords(
        file="add a keyframe near {first}",
        page="lost near {first}",
        row=PASSES,
        alone="Forward and backward differ in {span}",
    ),
    "nothing_seen": CauseWords(
        file="nothing of the body is seen; check keyframes, camera and masks",
        page="the body is not visible: check keyframes, camera and masks",
    ),
    "contradiction": CauseWords(
        file="the keyframes at {first} and {last} contradict each other",
        page="keys {first} and {last} contradict each other",
    ),
    "fast_motion": CauseWords(row="fast motion, blurred", alone="Fast motion {range}"),
    "longest_interval": CauseWords(
        row="longest interval, {length} frames",
        alone="Longest interval, {length} frames",
    ),
    "drift": CauseWords(row="most drift in {span}", alone="Most drift in {span}"),
}
