"""`keypose review`: where the motion is least sure, the worst first."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from keypose.app.cli.arguments import Subcommands, add_command, add_json, add_session, note
from keypose.app.cli.json_output import print_json

if TYPE_CHECKING:
    from keypose.tracker.review.places import Place, Review

GOALS = (3, 5, 8, 12)
"""As in app.editor.review, which would load more than help needs."""

_EXAMPLES = """\
  keypose review session.json
  keypose review session.json --above 8
  keypose review session.json --json
"""


def add(commands: Subcommands) -> None:
    details = (
        "Each with its frame, its part, the error expected there and the reason; what a person has "
        "answered on the page is left out. Drafts to confirm come first."
    )
    command = add_command(commands, "review", run, details, _EXAMPLES)
    add_session(command)
    command.add_argument(
        "--above",
        metavar="PIXELS",
        type=int,
        choices=GOALS,
        help="list what is expected to be off by more: 3, 5, 8 or 12; default: 5, or the least "
        "that this video allows",
    )
    add_json(command)


def run(arguments: argparse.Namespace) -> int:
    from keypose.tracker.review.places import review_of
    from keypose.tracker.storage.files import load_session
    from keypose.tracker.storage.results import load_results

    session = load_session(arguments.session)
    found = review_of(session, load_results(session, arguments.session))
    goal = arguments.above or found.goal_px
    if arguments.json:
        print_json(_facts(found, goal), indent=2)
        return 0
    for line in _table(found, goal):
        print(line)
    return 0


def _facts(found: Review, goal: int) -> dict[str, Any]:
    return {
        "above_px": goal,
        "right_px": found.right_px,
        "expected_px": found.px,
        "expected_cm": found.cm,
        "places": [_place_as_json(place) for place in found.above(goal)],
        "answered": [one.model_dump(mode="json") for one in found.answered],
        "untracked": found.untracked,
    }


def _place_as_json(place: Place) -> dict[str, Any]:
    from keypose.app.words.review import reason_of_place

    return {
        "frame": place.frame,
        "part": place.part,
        "frames": place.frames,
        "px": place.px,
        "cm": place.cm,
        "cause": place.cause,
        "reason": reason_of_place(place),
    }


def _table(found: Review, goal: int) -> list[str]:
    from keypose.app.words.problems import size_of
    from keypose.app.words.review import (
        answers_words,
        label_of_place,
        left_words,
        reason_of_place,
        right_words,
    )

    places = found.above(goal)
    rows = [
        (str(p.frame), label_of_place(p), size_of(p.px, p.cm) or "–", reason_of_place(p))
        for p in places
    ]
    head = ("frame", "part", "expected error", "reason")
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(3)]
    lines = [
        f"{row[0]:>{widths[0]}}  {row[1]:<{widths[1]}}  {row[2]:<{widths[2]}}  {row[3]}"
        for row in ([head] if rows else []) + rows
    ]
    if found.answered:
        lines.append(answers_words(found.answered))
    if found.untracked:
        count = len(found.untracked)
        note(f"{count} segment{'s need' if count > 1 else ' needs'} tracking first.")
    return [*lines, f"{left_words(len(places), goal)}{right_words(found, goal)}."]
