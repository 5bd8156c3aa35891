"""The first keyframe of a clip of which nothing is known but its lens: with a box, and by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from keypose.app.editor import actions as do
from keypose.tracker.body.body import Body, preset
from keypose.tracker.session.settings import ALL_CUES, TrackSettings
from keypose.tracker.solver.body_points import BodyPoint
from tests.benchmarks.clips import place
from tests.benchmarks.human.clips import Watched
from tests.benchmarks.human.counting import Effort
from tests.benchmarks.human.desk import desk
from tests.benchmarks.human.hand import Hand, px
from tests.benchmarks.human.strategies import Outcome, draft, key


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
    with desk(unsized(clip), TrackSettings(cues=ALL_CUES, smooth=True)) as there:
        hand = Hand.of(there, seed)
        first.work(hand)
        (frame,) = there.keys
        at = there.project(there.shown(frame).pose)
        measured = there.clip.true[frame].keys() - there.clip.unmeasured
        seen = there.clip.true[frame]
        off = [px(np.subtract(seen[name], at[name])) for name in measured]
        return FirstKeyframe(there.ledger.effort(1), Outcome(float(np.median(off)), max(off)))


def unsized(clip: Watched) -> Watched:
    """The clip as it is opened: with the body of a preset."""
    body = preset("adult_female" if clip.name == "walk" else "adult_male")
    places = {name: _place(body, name) for name in clip.places}
    return replace(clip, session=clip.session.model_copy(update={"body": body}), places=places)


def _place(body: Body, name: str) -> BodyPoint:
    """Where on a body a joint lies."""
    if name in body.names:
        return ((body.index(name), (0.0, 0.0, 0.0)),)
    return place(body, {"head_top": "Head", "hips": "hip"}[name])


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
        desk.act("click", "go to a frame", do.Go(frame=frame))
    hand.correct()
    key(desk)


FIRSTS = (First("with a box", with_box, 15.0), First("by hand", by_hand, 25.0))
