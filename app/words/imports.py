"""Word what was odd about an imported file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from keypose.tracker.errors import listed, readable
from keypose.tracker.formats.text import Note, Oddity

SHOWN: Final = 4
"""Parts in a sentence."""


def note_words(notes: Sequence[Note]) -> list[str]:
    """One sentence for each note, with what to do."""
    return [_WORDS[note.oddity](*note.values) for note in notes]


def _rows(said: str, found: int) -> str:
    return f"The file says it has {said} frames and has {found}; all {found} were read."


def _markers(said: str, found: int) -> str:
    return f"The file says it has {said} markers and names {found}."


def _beyond(count: int, last: int) -> str:
    some = "1 frame" if count == 1 else f"{count} frames"
    return f"Left out {some} outside the video, whose last frame is {last}."


def _undetermined(*parts: str) -> str:
    shown = [readable(part) for part in parts[:SHOWN]]
    more = [f"{len(parts) - SHOWN} more"] if len(parts) > SHOWN else []
    return (
        f"Nothing in the file says how {listed([*shown, *more])} move: name the places of more "
        "joints, or pose these parts yourself."
    )


def _unplaced(*parts: str) -> str:
    shown = listed([readable(part) for part in parts[:SHOWN]])
    return f"Nothing in the file says where {shown} begin, so how these limbs bend is a guess."


def _proportions(*bones: tuple[str, float]) -> str:
    shown = listed([f"{readable(part)} × {ratio:.2g}" for part, ratio in bones[:SHOWN]])
    return (
        f"Its proportions are not the body's ({shown}): check what its joints were taken for, or "
        "the body's sizes."
    )


def _poor(rms_cm: float) -> str:
    return (
        f"The joint error of {rms_cm:.1f} cm is well above the usual 2–5 cm: check what the "
        "joints were taken for, the unit, and the start frame."
    )


def _lying(angle: float) -> str:
    return (
        f"The body is tilted by {angle:.0f}° from upright: if it should stand, choose another "
        "world (z up or y up)."
    )


_WORDS: Final[dict[Oddity, Callable[..., str]]] = {
    "row count": _rows,
    "marker count": _markers,
    "frames beyond": _beyond,
    "row per frame": lambda: (
        "The file has no times: each row is taken for a frame of the video. Give its rate if not."
    ),
    "z up at rest": lambda: "Read with z up, as its rest pose shows.",
    "undetermined parts": _undetermined,
    "unplaced joints": _unplaced,
    "proportions": _proportions,
    "poor fit": _poor,
    "flat": lambda: (
        "All joints lie in one plane, so the file does not know depth: use it for the picture only."
    ),
    "lying": _lying,
    "starts at": lambda frame: (
        f"Taken to start at frame {frame}, where it meets the keyframes: choose start frame 0 if "
        "it begins with the video."
    ),
    "far from keyframes": lambda cm: (
        f"Its joints lie {cm:.0f} cm from the keyframes: check the frame at which it starts, or "
        "whether it is this motion."
    ),
}
