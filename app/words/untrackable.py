"""Words for what a session lacks to be tracked."""

from __future__ import annotations

import shlex
from pathlib import Path

from keypose.tracker.session import Session
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence


def why_untrackable(session: Session, session_path: Path) -> str:
    """What a session without segments lacks, in a sentence that names its file."""
    return _LACKING.of(session)(session, session_path)


def _of_film(session: Session, session_path: Path) -> str:
    count = "one keyframe" if session.subject.keyframes else "no keyframes"
    words = f"{session.subject_in(session_path.name)} has {count}; tracking needs two."
    if not session.subject.drafts:
        return words
    accept = f"keypose draft {shlex.quote(str(session_path))} --accept"
    return f"{words} Confirm its drafts in the page, or take those proposed with `{accept}`."


def _of_surfaces(session: Session, session_path: Path) -> str:
    if session.subject.keyframes:
        return f"{session_path.name} has only one mesh: there is no motion to fit."
    return (
        f"{session.subject_in(session_path.name)} has no keyframe: pose the body in one of the "
        f"meshes first, with `keypose open {shlex.quote(str(session_path))}`."
    )


_LACKING = ByEvidence({FilmEvidence: _of_film, SurfaceEvidence: _of_surfaces})
