"""The first keyframe of a clip of which nothing is known but its lens: with a box, and by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bench.human.clips import Watched
from bench.human.counting import Effort
from bench.human.desk import desk
from bench.human.hand import Hand, px
from bench.human.strategies import Outcome, draft, key
from keypose.app.document.defaults import Defaults
from keypose.app.editor.update import Go


@dataclass(frozen=True)
class First:
    """A way to the first keyframe, and the most actions that it should take."""

    name: str
    work: Callable[[Hand], None]
    most: float


@dataclass(frozen=True)
class FirstKeyframe:
    """What it took, and how right it is."""

    effort: Effort
    outcome: Outcome


def first_keyframe(clip: Watched, first: First, seed: int) -> FirstKeyframe:
    """The first keyframe with the body of a preset, which nobody has sized."""
    with desk(clip.unsized(), Defaults().track_settings) as there:
        hand = Hand.of(there, seed)
        first.work(hand)
        (frame,) = there.keys
        at = there.project(there.shown(frame).pose)
        measured = there.clip.true[frame].keys() - there.clip.unmeasured
        seen = there.clip.true[frame]
        off = [px(np.subtract(seen[name], at[name])) for name in measured]
        return FirstKeyframe(there.ledger.effort(1), Outcome(float(np.median(off)), max(off)))


def with_box(hand: Hand) -> None:
    """The lens confirmed, a box, the draft looked at and corrected, K."""
    desk = hand.desk
    desk.act("click", "keep the lens")
    draft(desk)
    desk.judge()
    hand.correct()
    key(desk)


def by_hand(hand: Hand) -> None:
    """The lens confirmed, then the guide's steps."""
    desk = hand.desk
    desk.act("click", "keep the lens")
    desk.act("click", "pose by hand")
    frame, _ = desk.clip.box
    if desk.frame != frame:
        desk.act("click", "go to a frame", Go(frame=frame))
    hand.correct()
    key(desk)


FIRSTS = (First("with a box", with_box, 15.0), First("by hand", by_hand, 25.0))
