"""What to do next, by what the body is compared with; and why nothing can be done."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from keypose.app.editor.judged import Judged
from keypose.app.editor.suggest import Fitting, Suggestion, suggestion
from keypose.app.editor.suggest_ahead import followed_suggestion, with_way_ahead
from keypose.app.editor.suggest_surfaces import surface_suggestion
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.session.schema import Session

_BOX_OR_POSE = ("Press B and draw a box around the person", "Or pose this frame and press K")


@dataclass(frozen=True)
class _Advice:
    """next: of the keyframes' frames, the session and its results.  missing: of a session without
    a segment, what it lacks."""

    next: Callable[[Sequence[int], Session, Judged], Suggestion]
    missing: Callable[[Session], str]


def next_step(
    keys: Sequence[int], session: Session, fitting: Fitting, known: Judged | None = None
) -> Suggestion:
    """The one thing that helps most. keys: frames of the keyframes, ascending.

    fitting: the results of the present segments; unfinished ones count as none.
    known: the same, where what is wrong with them was asked for already.
    """
    return _ADVICE.of(session).next(keys, session, known or Judged.over(session, fitting))


def why_nothing_to_do(session: Session) -> str:
    """Why there is no segment whose motion could be found."""
    return _ADVICE.of(session).missing(session)


def _next_of_film(keys: Sequence[int], session: Session, known: Judged) -> Suggestion:
    followed = followed_suggestion(session)
    if followed is not None:
        return followed
    if not keys and not session.drafts and is_persons(session.body):
        return Suggestion(None, *_BOX_OR_POSE, "pose")
    found = suggestion(keys, session.video.frame_count, known.tracks, known.parts, known)
    return with_way_ahead(found, keys, session)


def _missing_of_film(session: Session) -> str:
    few = bool(session.keyframes)
    return "Add a second keyframe first." if few else "Add two keyframes first."


def _next_of_surfaces(keys: Sequence[int], session: Session, known: Judged) -> Suggestion:
    return surface_suggestion(keys, session.spans, known.tracks, known)


def _missing_of_surfaces(session: Session) -> str:
    if session.video.frame_count < 2:
        return "Nothing to fit: there is only one mesh."
    return "Add a keyframe first: pose the body in one of the meshes."


_ADVICE = ByEvidence(
    {
        FilmEvidence: _Advice(_next_of_film, _missing_of_film),
        SurfaceEvidence: _Advice(_next_of_surfaces, _missing_of_surfaces),
    }
)
