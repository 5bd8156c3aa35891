"""What there is to review, as JSON."""

from __future__ import annotations

from keypose.app.editor.problem_words import size_of
from keypose.app.editor.review import GOALS_PX, Place, Review, review_of
from keypose.app.editor.review_words import label_of_place, reason_of_place
from keypose.app.store.sections.body_values import side_of
from keypose.app.store.sections.json_value import Json
from keypose.app.store.state import AppState
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.annotations import DraftPlace
from keypose.tracker.session.schema import Session

CROP_SHARE, LEAST_CROP_PX = 0.25, 40
"""Side of the picture beside a place: of the body's height, and at least."""


def review(app_state: AppState) -> Json:
    """The places to look at, the worst first, the answers that count, and the goals."""
    edit = app_state.edit
    if edit is None:
        return None
    doc = edit.settled
    found = review_of(doc, edit.results)
    return {
        "places": [_place(doc, found, place) for place in found.places],
        "answered": [
            {"frame": one.frame, "part": one.part, "answer": one.answer} for one in found.answered
        ],
        "goal": found.goal_px,
        "goals": list(GOALS_PX),
        "right_px": _rounded(found.right_px),
        "px": _rounded(found.px),
        "cm": _rounded(found.cm),
        "untracked": len(found.untracked),
    }


def _place(doc: Session, found: Review, place: Place) -> Json:
    """`end` is in the camera frame, metres; `at` and `box` pixels of the picture as it is shown."""
    camera = doc.camera.without_distortion()
    limb = camera.project(place.limb_m)
    crop = max(CROP_SHARE * found.body_m * place.px_per_m, LEAST_CROP_PX)
    return {
        "id": place.id,
        "kind": "draft" if isinstance(place.why, DraftPlace) else "tracked",
        "frame": place.frame,
        "part": place.part,
        "label": label_of_place(place),
        "side": "C" if place.part is None else side_of(doc.body, place.part),
        "cause": place.cause,
        "first": place.frames[0],
        "last": place.frames[1],
        "px": _rounded(place.px),
        "cm": _rounded(place.cm),
        "size": size_of(place.px, place.cm),
        "reason": reason_of_place(place),
        "end": _listed(place.end_m, 4),
        "radius_m": round((place.px or 0.0) / place.px_per_m, 4),
        "at": _listed(camera.project(place.end_m), 1),
        "crop": round(crop, 1),
        "box": [*_listed(limb.min(axis=0), 1), *_listed(limb.max(axis=0), 1)],
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 2)


def _listed(values: Array, digits: int) -> list[float]:
    return [round(float(value), digits) for value in values]
