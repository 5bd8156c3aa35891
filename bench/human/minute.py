"""A minute of a hand on a session that is tracked, where the page leads.

The person goes through the places of the review, the worst first; then to where N goes, which asks
for a keyframe; and where neither asks for anything, to the keyframes that nobody has posed. There
they judge the frame, and correct what looks wrong: limbs alone where nothing else does, or the
whole body. What would end beyond their time is not begun.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from bench.human.clips import Watched
from bench.human.counting import Effort, seconds_of
from bench.human.desk import Desk, desk_of
from bench.human.hand import Hand
from bench.human.strategies import go, put_right
from keypose.app.editor.advice import next_step
from keypose.tracker.review.places import review_of
from keypose.tracker.review.segments import JudgedSegments
from keypose.tracker.session import Session
from keypose.tracker.storage.files import save_session

SECONDS = 60.0


@dataclass(frozen=True)
class Worked:
    """What was done. offered: frames that the page led to; looked: all that were gone to; wrong: of
    these, those that were corrected; keyframes: of the body and of limbs that are new or posed."""

    effort: Effort
    offered: int
    looked: int
    wrong: int
    keyframes: int


def worked(clip: Watched, path: Path, seed: int, seconds: float = SECONDS) -> Worked:
    """One person's work on a saved session, which is saved again, not tracked anew.

    clip: as they see it, of that session.
    """
    with desk_of(clip, path) as there:
        hand = Hand.of(there, seed, by_picture=True)
        known, gone = _keyed(there.state.doc), dict[int, bool]()
        offered = 0
        while (spot := _next(there, gone)) is not None:
            before, acts = there.state, len(there.ledger.acts)
            corrected = _visited(hand, spot)
            if seconds_of(there.ledger.acts) > seconds:
                there.state = before
                del there.ledger.acts[acts:]
                break
            gone[spot.frame] = corrected
            offered += spot.offered
        after = there.state.doc
        save_session(after.changed({"results": clip.session.subject.results}), path)
        done = there.ledger.effort(clip.frames)
        return Worked(done, offered, len(gone), sum(gone.values()), _keyed(after) - known)


@dataclass(frozen=True)
class _Spot:
    """A frame to go to, and whether the page led there, by its review or by N."""

    frame: int
    in_review: bool = False
    offered: bool = False


def _next(desk: Desk, gone: Collection[int]) -> _Spot | None:
    """Where to go next; None where everything was looked at."""
    doc, results = desk.state.doc, desk.state.results
    for place in review_of(doc, results).places:
        if place.frame not in gone:
            return _Spot(place.frame, in_review=True, offered=True)
    known = JudgedSegments.of(doc, results)
    suggested = next_step(desk.keys, doc, results.fitting(doc), known).frame
    if suggested is not None and suggested not in gone:
        return _Spot(suggested, offered=True)
    left = [k.frame for k in doc.subject.keyframes if k.drafted and k.frame not in gone]
    return _Spot(left[0]) if left else None


def _visited(hand: Hand, spot: _Spot) -> bool:
    """Go there, judge, and correct; whether anything was corrected."""
    desk = hand.desk
    go(desk, spot.frame, "go to a frame")
    desk.judge()
    before = len(desk.script)
    if not hand.looks_right() or desk.frame in desk.keys:
        put_right(hand)
    corrected = len(desk.script) > before
    if spot.in_review and not corrected:
        desk.act("key", "Enter: accept the place")
    return corrected


def _keyed(session: Session) -> int:
    """How many keyframes there are, of the whole body and of limbs, that somebody posed."""
    posed = [keyframe for keyframe in session.subject.keyframes if not keyframe.drafted]
    return len(posed) + len(session.subject.part_keyframes)
