"""Why a saved session cannot be tracked: what it lacks, by what its body is compared with."""

from __future__ import annotations

import shlex
from pathlib import Path

from keypose.tracker.session import Session
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence


def why_untrackable(session: Session, session_path: Path) -> str:
    """What a session without segments lacks, in a sentence that names its file."""
    return _LACKING.of(session)(session, session_path)


def _of_film(session: Session, session_path: Path) -> str:
    count = "one keyframe" if session.keyframes else "no keyframes"
    return f"{session_path.name} has {count}; tracking needs two."


def _of_surfaces(session: Session, session_path: Path) -> str:
    if session.keyframes:
        return f"{session_path.name} has only one mesh: there is no motion to fit."
    return (
        f"{session_path.name} has no keyframe: pose the body in one of the meshes first, with "
        f"`keypose open {shlex.quote(str(session_path))}`."
    )


_LACKING = ByEvidence({FilmEvidence: _of_film, SurfaceEvidence: _of_surfaces})
