"""`keypose review`: where the motion is least sure, the worst first."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from keypose.app.cli.bodies import about_each, by_body, heading
from keypose.app.cli.json_output import print_json
from keypose.app.words.review import (
    answers_words,
    noise_floor_words,
    reason_of_place,
    remaining_words,
    row_of_place,
)
from keypose.app.words.untrackable import why_untrackable
from keypose.tracker.review.places import Place, Review, review_of
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.storage.results import load_results
from keypose.tracker.storage.tracks import load_tracks


def run(arguments: argparse.Namespace) -> int:
    session = load_session(arguments.session)
    bodies = about_each(session, arguments)
    reviews = {about.subject.id: _review(about, arguments) for about in bodies}
    if arguments.json:
        facts = {
            name: _facts(review, arguments.above or review.goal_px)
            for name, review in reviews.items()
        }
        print_json(by_body(facts, session), indent=2)
        return 0
    for about, review in zip(bodies, reviews.values(), strict=True):
        path, goal = arguments.session, arguments.above or review.goal_px
        motion = None if about.subject.results is None else load_tracks(about, path)
        outdated = None if motion is None else outdated_words(about, motion)
        for line in (
            *heading(about, session),
            *_to_track(review, outdated),
            *_table(review, goal),
            *_remaining(about, review, goal, path),
        ):
            print(line)
    return 0


def _review(session: Session, arguments: argparse.Namespace) -> Review:
    review = review_of(session, load_results(session, arguments.session))
    return review if arguments.frames is None else review.between(*arguments.frames)


def _facts(review: Review, goal: int) -> dict[str, Any]:
    return {
        "above_px": goal,
        "right_px": review.right_px,
        "expected_px": review.px,
        "expected_cm": review.cm,
        "places": [_place_as_json(place) for place in review.above(goal)],
        "answered": [reviewed.model_dump(mode="json") for reviewed in review.answered],
        "untracked": review.untracked,
    }


def _place_as_json(place: Place) -> dict[str, Any]:
    return {
        "frame": place.frame,
        "part": place.part,
        "frames": place.frames,
        "px": place.px,
        "cm": place.cm,
        "cause": place.cause,
        "reason": reason_of_place(place),
    }


def _to_track(review: Review, outdated: str | None) -> list[str]:
    """What is to be tracked before it can be reviewed, and why it is out of date."""
    if not review.untracked:
        return []
    count = len(review.untracked)
    words = f"{count} segment{'s need' if count > 1 else ' needs'} tracking first"
    return [f"{words}: {outdated}" if outdated else f"{words}."]


def _table(review: Review, goal: int) -> list[str]:
    places = review.above(goal)
    rows = [row_of_place(place) for place in places]
    head = ("frame", "part", "expected error", "reason")
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(3)]
    return [
        f"{row[0]:>{widths[0]}}  {row[1]:<{widths[1]}}  {row[2]:<{widths[2]}}  {row[3]}"
        for row in ([head] if rows else []) + rows
    ]


def _nothing_yet(session: Session, review: Review, path: Path) -> list[str]:
    """Why a body without a motion has no place to review, where that is not said yet."""
    if not session.spans:
        return [why_untrackable(session, path)]
    return [] if review.untracked else ["Not tracked yet."]


def _remaining(session: Session, review: Review, goal: int, path: Path) -> list[str]:
    """What was answered and what is left, or why there is nothing to review yet."""
    answers = [answers_words(review.answered)] if review.answered else []
    count = len(review.above(goal))
    if not count and session.subject.results is None:
        return [*answers, *_nothing_yet(session, review, path)]
    so_far = " so far" if review.untracked else ""
    return [
        *answers,
        f"{remaining_words(count, goal)}{noise_floor_words(review, goal)}{so_far}.",
    ]
