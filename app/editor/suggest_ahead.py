"""What to do next where the body was tracked ahead, or could be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from keypose.app.editor.ahead import stands
from keypose.app.editor.ahead_text import tracked_to, why_stopped
from keypose.app.editor.problems import SHORT_FRAMES
from keypose.app.editor.suggest import Suggestion
from keypose.tracker.session.annotations import Ahead, Direction
from keypose.tracker.session.schema import Session


def followed_suggestion(session: Session) -> Suggestion | None:
    """The last frame that can be trusted of what was tracked ahead: its pose is all but a keyframe.
    None where nothing was, or so little that a keyframe there is no gain."""
    found = [one for one in session.ahead if _is_worth_keying(session, one)]
    if not found:
        return None
    record = max(found, key=lambda one: one.is_forward)
    title = f"Check frame {record.to_frame}, then press K"
    why = f"{tracked_to(record)}. {why_stopped(record)}"
    return Suggestion(record.to_frame, title, why, "key")


def _is_worth_keying(session: Session, record: Ahead) -> bool:
    first, last = record.span
    return last - first >= SHORT_FRAMES and stands(session, record)


def with_way_ahead(found: Suggestion, keys: Sequence[int], session: Session) -> Suggestion:
    """With the way in which tracking ahead leads on, unless something is to be tracked first.

    Where a keyframe is asked for and the film was drafted, what lies beyond has poses already.
    """
    about_a_frame = found.kind in ("key", "look")
    if not keys or found.kind == "track" or (about_a_frame and session.drafted is not None):
        return found
    way = _way(keys, session)
    return found if way is None else replace(found, ahead=way)


def _way(keys: Sequence[int], session: Session) -> Direction | None:
    """Forward before backward; not again where it led to next to nothing."""
    tried = {one.is_forward for one in session.ahead if stands(session, one)}
    after, before = session.video.frame_count - 1 - keys[-1], keys[0]
    if after >= SHORT_FRAMES and True not in tried:
        return "forward"
    if before >= SHORT_FRAMES and False not in tried:
        return "backward"
    return None
