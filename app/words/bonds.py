"""Words for what bodies hold."""

from __future__ import annotations

from keypose.tracker.operations.bonds import MEET_M, keyed_apart
from keypose.tracker.session import Session
from keypose.tracker.session.bonds import BondEnd


def keyed_apart_sentences(session: Session) -> list[str]:
    """Such as "body:right_hand and racket:grip are 4.0 cm apart at frame 24, where both are keyed:
    pose them together there.", of each bond whose points keyframes keep apart."""
    sentences = []
    for bond in session.bonds:
        place = keyed_apart(session, bond)
        if place is not None and place[1] > MEET_M:
            frame, metres = place
            first, second = (_named(end) for end in bond.ends)
            sentences.append(
                f"{first} and {second} are {100 * metres:.1f} cm apart at frame {frame}, where "
                "both are keyed: pose them together there."
            )
    return sentences


def _named(end: BondEnd) -> str:
    return f"{end.body}:{end.part}"
