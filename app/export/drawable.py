"""What can be drawn of a session, and how large: the same for command line and page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from keypose.tracker.errors import FormatError, SessionError

if TYPE_CHECKING:
    from keypose.tracker.session import Session


def require_tint(session: Session, tint: str) -> None:
    """Refused where there is nothing to colour, or nothing that colours it."""
    evidence = session.evidence
    if tint != "clay" and not evidence.has_surface:
        about = f"This session is about a {evidence.words.noun}"
        raise FormatError(f"{about}: it has no surface to colour by {tint}.")
    if tint in ("contact", "distance") and session.model_keyframe is None:
        raise FormatError(
            f"No surface moves with the body yet, so nothing is known of {tint}: set a keyframe "
            "first."
        )


def require_frame(session: Session, frame: int) -> None:
    """SessionError unless the video has the frame."""
    count = session.view.video.frame_count
    if frame >= count:
        raise SessionError(f"There is no frame {frame}; the video's frames are 0 to {count - 1}.")
