"""What has become of a pose, in one or two sentences for a person."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker.geometry.rotations import Array

WORTH_A_WORD_PX = 1.0
MOST = 3
UNDECIDED = 0.15
"""Share decided by the picture, below which a part stays as posed to all purposes."""


@dataclass(frozen=True, eq=False)
class Moves:
    """Of every part (P): its name, how far it moved in the picture, what share of its pose the
    picture decided, whether it is tracked, whether it is hidden."""

    names: Sequence[str]
    moved_px: Array
    decided: Array
    tracked: NDArray[np.bool_]
    hidden: NDArray[np.bool_]


def describe_moves(moves: Moves) -> str:
    """Such as "Right forearm moved 6 px. Left hand is hidden and stays as posed."."""
    sentences = [_moved(moves)]
    hidden = np.flatnonzero(moves.hidden)
    unclear = np.flatnonzero(moves.tracked & ~moves.hidden & (moves.decided < UNDECIDED))
    if len(hidden):
        sentences.append(_staying(moves, hidden, "hidden"))
    elif len(unclear):
        sentences.append(_staying(moves, unclear, "not told by the picture"))
    return " ".join(sentences)


def _moved(moves: Moves) -> str:
    """The parts that moved most; what is only carried along has no word of its own."""
    own = moves.tracked & ~moves.hidden & (moves.decided >= UNDECIDED)
    px = np.where(own, moves.moved_px, 0.0)
    most = [i for i in np.argsort(-px, kind="stable")[:MOST] if px[i] >= WORTH_A_WORD_PX]
    if not most:
        return "No part moved by more than a pixel."
    words = [f"{_plain_name(moves.names[i])} {moves.moved_px[i]:.0f} px" for i in most]
    words[0] = f"{_plain_name(moves.names[most[0]])} moved {moves.moved_px[most[0]]:.0f} px"
    return f"{_capital(', '.join(words))}."


def _staying(moves: Moves, which: NDArray[np.intp], why: str) -> str:
    """That some parts stay, and why."""
    names = [_plain_name(moves.names[i]) for i in which[:MOST]]
    more = len(which) - len(names)
    if more:
        names.append(f"{more} more")
    listed = names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
    verbs = ("is", "stays") if len(which) == 1 else ("are", "stay")
    return f"{_capital(listed)} {verbs[0]} {why} and {verbs[1]} as posed."


def _plain_name(name: str) -> str:
    return name.replace("_", " ")


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
