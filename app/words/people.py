"""Words for the people that were found in a film."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from keypose.tracker.errors import listed, readable
from keypose.tracker.keypoints.find_people import PeopleInFilm
from keypose.tracker.keypoints.region import Box
from keypose.tracker.session.annotations import FlippedDrafts

MOST_NAMED: Final = 12
"""Frames that a sentence lists one by one."""

NOBODY: Final = (
    "No person was found in the film. Draw a box around the person with --box L,T,R,B --frame N, "
    "or pose the body by hand in the page."
)


def box_text(box: Box) -> str:
    """A box as the command line takes it: "210,80,420,610"."""
    return ",".join(f"{edge:.0f}" for edge in box)


def found_person_words(people_in_film: PeopleInFilm) -> str:
    """Which boxes were taken that nobody drew, and who was left out as they are much smaller."""
    people = people_in_film.people
    count = "One person" if len(people) == 1 else f"{len(people)} people"
    boxes = " ".join(f"--box {box_text(person.box)}" for person in people)
    words = f"{count} found: {boxes} --frame {people_in_film.frame}."
    if not people_in_film.smaller:
        return words
    frames = ", ".join(str(frame) for frame in sorted(people_in_film.smaller))
    plural = "s" * (len(people_in_film.smaller) > 1)
    return f"{words} Smaller people were left out (frame{plural} {frames})."


def assumed_words(height_cm: float | None, lens_mm: float | None, subject: str = "person") -> str:
    """Say how tall the subject is taken to be, and through which lens they are taken to be filmed,
    with how to say otherwise; empty where both are known. Depth and lengths rest on them.

    height_cm, lens_mm: None where somebody said it.
    """
    taken = []
    if height_cm is not None:
        taken.append(f"{height_cm:.0f} cm tall (--height says otherwise)")
    if lens_mm is not None:
        taken.append(f"filmed through a lens of {lens_mm:.0f} mm on 35 mm film (--lens)")
    return f"The {subject} is taken to be {' and '.join(taken)}." if taken else ""


def several_words(people_in_film: PeopleInFilm) -> str:
    """Ask which of several people is meant, each with the options that name them."""
    choices = "; ".join(
        f"--box {box_text(person.box)} ({person.height_px:.0f} pixels tall)"
        for person in people_in_film.people
    )
    return (
        f"{len(people_in_film.people)} people are to be seen at frame {people_in_film.frame}. "
        f"Choose one, from left to right, with --frame {people_in_film.frame} and {choices}; or "
        "--everyone."
    )


def accepted_words(frames: Sequence[int]) -> str:
    """Say which drafts are keyframes now."""
    return f"Drafts accepted as approximate keyframes: {_listed(frames)}."


def undrafted_words(frames: Sequence[int]) -> str:
    """Say at which frames nobody was seen well enough; empty where there are none."""
    if not frames:
        return ""
    return f"The person was not seen well enough at {len(frames)} frames: {_listed(frames)}."


def flipped_words(runs: Sequence[FlippedDrafts]) -> str:
    """Say which drafts are wrong and become no keyframes therefore; empty where there are none."""
    if not runs:
        return ""
    named = "; ".join(flipped_place(run) for run in runs[:MOST_NAMED])
    more = f"; and {len(runs) - MOST_NAMED} more" if len(runs) > MOST_NAMED else ""
    return f"Drafts that are wrong, none of which becomes a keyframe unless posed: {named}{more}."


def flipped_place(run: FlippedDrafts) -> str:
    """ "left thigh, frames 16–23"."""
    first, last = run.first_frame, run.last_frame
    frames = f"frame {first}" if first == last else f"frames {first}–{last}"
    return f"{listed([readable(part) for part in run.parts])}, {frames}"


def another_person_words(frames: Sequence[int]) -> str:
    """Say from which frames on somebody else may be drafted; empty where there are none."""
    if not frames:
        return ""
    named = _listed(frames)
    return f"It may be another person from frame {named} on: look, and set a keyframe there."


def _listed(frames: Sequence[int]) -> str:
    named = ", ".join(map(str, frames[:MOST_NAMED]))
    more = f" and {len(frames) - MOST_NAMED} more" if len(frames) > MOST_NAMED else ""
    return f"{named}{more}"
