"""Keypoints that a person set right, or out: plain data, a few a session."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated

from pydantic import Field

from keypose.tracker.session.settings import FrameIndex, Pixel, Plain


class KeypointCorrection(Plain):
    """Where one joint is seen in one frame, as a person says, whatever a detector found there."""

    frame: FrameIndex
    joint: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,59}$")] = Field(
        description="Name of the keypoint, such as left_wrist."
    )
    uv: Pixel | None = Field(
        default=None,
        description="Where it is, in pixels of the video as it was filmed; null: not seen, what "
        "was found there does not count.",
    )


def require_corrections(
    given: Sequence[KeypointCorrection], frame_count: int, width: int, height: int
) -> None:
    """ValueError in one sentence where corrections are not of this video, or two of one joint."""
    for one, other in pairwise(given):
        if (one.frame, one.joint) >= (other.frame, other.joint):
            raise ValueError(
                f"keypoint_corrections: {other.joint} at frame {other.frame} stands after "
                f"{one.joint} at frame {one.frame}; sort them by frame and joint, each once"
            )
    for each in given:
        if each.frame >= frame_count:
            raise ValueError(
                f"keypoint_corrections: frame {each.frame} is beyond the video, whose frames are "
                f"0 to {frame_count - 1}"
            )
        if each.uv is not None and not _is_near(each.uv, width, height):
            u, v = each.uv
            raise ValueError(
                f"keypoint_corrections: {each.joint} at frame {each.frame} is at ({u:g}, {v:g}), "
                f"far outside the picture of {width}×{height}"
            )


def _is_near(uv: Pixel, width: int, height: int) -> bool:
    """In the picture, or beside it by less than its size: a limb may reach out of it."""
    return all(-size < at < 2 * size for at, size in zip(uv, (width, height), strict=True))
