"""What a report says otherwise of a film than of observed surfaces."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from keypose.app.export.report.figures import best_score, figure
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence, surface_of
from keypose.tracker.session.results import Results
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import Weights
from keypose.tracker.tracking.result import SegmentResult


@dataclass(frozen=True)
class ReportWords:
    """too_few: where there is no segment.  seen_in: what a motion is seen in.  led_by: what leads
    it where it is not.  material: what may not be at hand.  score_heads: of a segment's figures,
    which `scores` makes of its finished result, if there is one.  has_passes: whether its score
    changes from pass to pass.  subject: what was observed.  way: how its motion was found.
    """

    too_few: str
    seen_in: str
    led_by: str
    material: str
    score_heads: tuple[str, ...]
    scores: Callable[[SegmentResult | None], tuple[str, ...]]
    has_passes: bool
    subject: Callable[[Session], str]
    way: Callable[[Session, Results], str]


def words_for(session: Session) -> ReportWords:
    """Those of a session's evidence."""
    return _WORDS.of(session)


def _film_scores(track: SegmentResult | None) -> tuple[str, ...]:
    if track is None:
        return "–", figure(math.nan, 2)
    return str(len(track.scores)), figure(best_score(track), 2)


def _film_subject(session: Session) -> str:
    return f"{session.video.width} × {session.video.height} pixels"


def _film_way(_session: Session, results: Results) -> str:
    return f"method {results.method}, quality {results.quality}"


def _surface_scores(track: SegmentResult | None) -> tuple[str, ...]:
    """Millimetres between the surfaces and the body's."""
    return (figure(1000 * (math.nan if track is None else best_score(track)), 1),)


def _surface_subject(session: Session) -> str:
    surface = surface_of(session)
    up = surface.up.replace("-", "−").upper()
    return f"observed surfaces in {surface.units}, {up} up"


def _surface_way(session: Session, results: Results) -> str:
    return f"{_WEIGHTS[surface_of(session).weights]}, quality {results.quality}"


_WEIGHTS: Mapping[Weights, str] = {
    "both": "doubts by contact and cameras",
    "contact": "doubts by contact",
    "photo": "doubts by cameras",
    "none": "no doubts",
}

_WORDS = ByEvidence(
    {
        FilmEvidence: ReportWords(
            too_few="Two keyframes make the first segment; there is none yet.",
            seen_in="picture",
            led_by="keyframes",
            material="video",
            score_heads=("Passes", "Best score"),
            scores=_film_scores,
            has_passes=True,
            subject=_film_subject,
            way=_film_way,
        ),
        SurfaceEvidence: ReportWords(
            too_few="One keyframe is enough to fit the body to the surfaces; there is none yet.",
            seen_in="surface",
            led_by="steps before",
            material="surfaces",
            score_heads=("Apart, mm",),
            scores=_surface_scores,
            has_passes=False,
            subject=_surface_subject,
            way=_surface_way,
        ),
    }
)
