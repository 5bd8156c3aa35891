"""Keyframes of some parts alone: what they may name, and where they may stand."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from keypose.tracker.session.schema import Session


def require_part_keyframes(session: Session) -> None:
    """ValueError in one sentence unless each names parts of the body besides its root, at a frame
    of a film that is no keyframe."""
    if not session.part_keyframes:
        return
    if session.surface is not None:
        raise ValueError(
            "part_keyframes: a body is fitted to surfaces as a whole; make them keyframes"
        )
    root, keyed = session.body.names[0], {keyframe.frame for keyframe in session.keyframes}
    for each in session.part_keyframes:
        if each.frame in keyed:
            raise ValueError(f"part_keyframes: frame {each.frame} is a keyframe; one is allowed")
        unknown = sorted(set(each.parts) - set(session.body.names))
        if unknown:
            raise ValueError(
                f"part_keyframes: frame {each.frame} names {unknown[0]!r}, which the body does not "
                f"have; its parts are {', '.join(session.body.names)}"
            )
        if root in each.parts:
            raise ValueError(
                f"part_keyframes: frame {each.frame} names {root!r}, which carries all others; "
                "make it a keyframe"
            )
        if len(set(each.parts)) < len(each.parts):
            raise ValueError(f"part_keyframes: frame {each.frame} names a part twice")
