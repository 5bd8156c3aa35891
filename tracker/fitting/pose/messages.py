"""How a pose was changed, in one or two sentences for a person."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import listed, readable
from keypose.tracker.geometry.rotations import Array

LEAST_REPORTED_PX = 1.0
MOST = 3
UNDECIDED = 0.15
"""Share decided by the picture, below which a part practically stays as posed."""


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
    """Such as "Right forearm moved 6 px. Left hand is hidden and was left unchanged."."""
    sentences = [_moved(moves)]
    hidden = np.flatnonzero(moves.hidden)
    unclear = np.flatnonzero(moves.tracked & ~moves.hidden & (moves.decided < UNDECIDED))
    if len(hidden):
        are = "is" if len(hidden) == 1 else "are"
        sentences.append(_staying(moves, hidden, f"{are} hidden"))
    elif len(unclear):
        sentences.append(_staying(moves, unclear, "cannot be seen well enough"))
    return " ".join(sentences)


def _moved(moves: Moves) -> str:
    """The parts that moved most; what is only carried along is not named."""
    own = moves.tracked & ~moves.hidden & (moves.decided >= UNDECIDED)
    px = np.where(own, moves.moved_px, 0.0)
    most = [i for i in np.argsort(-px, kind="stable")[:MOST] if px[i] >= LEAST_REPORTED_PX]
    if not most:
        return "No part moved by more than a pixel."
    first, *others = most
    text = f"{readable(moves.names[first])} moved {moves.moved_px[first]:.0f} px"
    rest = (f", {readable(moves.names[i])} {moves.moved_px[i]:.0f} px" for i in others)
    return f"{_capital(text)}{''.join(rest)}."


def _staying(moves: Moves, which: NDArray[np.intp], why: str) -> str:
    """Say that some parts stay, and why."""
    names = [readable(moves.names[i]) for i in which[:MOST]]
    more = len(which) - len(names)
    if more:
        names.append(f"{more} more")
    were = "was" if len(which) == 1 else "were"
    return f"{_capital(listed(names))} {why} and {were} left unchanged."


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
