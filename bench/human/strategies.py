"""Ways to get a whole clip right, each a small piece that may be replaced by another.

Every one works until the motion looks right to whoever works: every joint is at most 5 px off in
the median over all frames that are seen, and 10 px at worst.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from bench.human.desk import Desk
from bench.human.hand import TRUNK, Hand, px
from bench.human.watching import Watching
from bench.needed import MEDIAN_PX, WORST_PX
from keypose.app.editor import actions as do
from keypose.app.editor.advice import NEXT_FRAMES
from keypose.app.editor.shown import shown_pose
from keypose.tracker.body.pose import Pose
from keypose.tracker.session.settings import ALL_CUES, TrackSettings

Choice: TypeAlias = Callable[[Desk, set[int]], int | None]
"""The frame to look at next, given those that were looked at; None where there is none."""
MANY_WRONG = 3
"""With so many joints wrong, somebody lets the pose be fitted before touching it."""
LOOK_EVERY = 8
"""Frames between two looks, when somebody goes through the whole clip."""
GIVE_UP_FRAMES = 3
"""With a keyframe in so many frames, it is given up."""
MOST_PLACES = 80
FITTED_FROM_PX = 40.0
"""A pose that is farther off than this is not one to let the computer fit."""


@dataclass(frozen=True)
class Strategy:
    """A way to work, what it tracks with, whether anything is tracked, whether it begins with a
    draft, which sizes the body as well (else it is sized already), and how sizes are judged, see
    `Hand`."""

    name: str
    settings: TrackSettings
    work: Callable[[Hand], None]
    tracks: bool = True
    drafts: bool = True
    by_picture: bool = False


@dataclass(frozen=True)
class Outcome:
    """How right it is: the worst joint's median, and the worst of all, px."""

    median: float
    worst: float

    @property
    def right(self) -> bool:
        return self.median <= MEDIAN_PX and self.worst <= WORST_PX


def outcome(desk: Desk) -> Outcome:
    """Of the motion as it would be exported, at all frames; marks that are carried on from others
    err themselves, and so much is forgiven there."""
    by_joint: dict[str, list[float]] = {}
    for frame, joints in desk.clip.true.items():
        at = desk.project(motion_at(desk, frame))
        slack = desk.clip.slack_px(frame)
        for name in joints.keys() - desk.clip.unmeasured:
            uv = joints[name]
            off = float(np.linalg.norm(np.subtract(uv, at[name])))
            by_joint.setdefault(name, []).append(max(off - slack, 0.0))
    medians = [float(np.median(px)) for px in by_joint.values()]
    return Outcome(max(medians), max(max(px) for px in by_joint.values()))


def motion_at(desk: Desk, frame: int) -> Pose:
    """The pose of the result: a keyframe, tracked, or between keyframes."""
    keyed = frame in desk.keys
    tracked = None if keyed else desk.state.tracked(frame)
    if tracked is not None:
        return tracked
    inside = desk.keys and desk.keys[0] <= frame <= desk.keys[-1]
    state = replace(desk.state, doc=desk.state.doc.model_copy(update={"drafts": ()}))
    return shown_pose(state if inside else desk.state, frame).pose


# --- moves that all share


def go(desk: Desk, frame: int, why: str = "go to a frame") -> int:
    """A click on the timeline, at the nearest frame of which anything is seen; that frame."""
    near = min(desk.clip.seen, key=lambda f: (abs(f - frame), f))
    if near != desk.frame:
        desk.act("click", why, do.Go(frame=near))
    return near


def go_next(desk: Desk, frame: int) -> int:
    """N, to the frame that the page names, or the nearest of which anything is seen."""
    free = [f for f in desk.clip.seen if f not in desk.keys or f == frame]
    near = min(free or desk.clip.seen, key=lambda f: (abs(f - frame), f))
    desk.act("key", "N", do.Go(frame=near))
    return near


def settle(hand: Hand, *, fit: bool) -> None:
    """Judge the present frame, correct it where it is wrong, and key it."""
    desk = hand.desk
    desk.judge()
    if not hand.looks_right():
        if fit and len(hand.wrong()) >= MANY_WRONG and not hand.wrong(FITTED_FROM_PX):
            desk.act("key", "F", do.FitHere())
            desk.judge()
        hand.correct()
    key(desk)


def key(desk: Desk) -> None:
    """K."""
    desk.act("key", "K", do.AddKey(frame=desk.frame))
    desk.ledger.end_first()


def live(desk: Desk) -> None:
    """Track at once whatever is posed."""
    desk.act("click", "switch Live on", do.Live(on=True))


# --- without the page's advice


def by_intervals(hand: Hand) -> None:
    """Both ends, then the middle of whatever is longest unseen."""
    desk, clip = hand.desk, hand.desk.clip
    if desk.tracks:
        live(desk)
    for end in (clip.first, clip.last):
        go(desk, end)
        settle(hand, fit=False)
    looked = {clip.first, clip.last}
    while not outcome(desk).right and len(desk.keys) < clip.frames / GIVE_UP_FRAMES:
        gaps = [g for g in pairwise(sorted(looked)) if any(g[0] < f < g[1] for f in clip.seen)]
        if not gaps:
            return
        first, last = max(gaps, key=lambda gap: gap[1] - gap[0])
        inside = [f for f in clip.seen if first < f < last]
        middle = min(inside, key=lambda f: (abs(2 * f - first - last), f))
        go(desk, middle)
        looked.add(middle)
        desk.judge()
        if not hand.looks_right():
            hand.correct()
            key(desk)


# --- with the page's advice


def before(hand: Hand) -> None:
    """Keyframes by hand about a second apart, then wherever the page asks for one."""
    desk, clip = hand.desk, hand.desk.clip
    live(desk)
    frames = list(range(clip.first, clip.last, NEXT_FRAMES))
    if clip.last - frames[-1] < NEXT_FRAMES // 2 and len(frames) > 1:
        frames.pop()
    for frame in (*frames, clip.last):
        go(desk, frame)
        settle(hand, fit=True)
    follow_advice(hand)


def now(hand: Hand) -> None:
    """A box and a draft, three of its places confirmed, then the review, each place put right where
    it is wrong: a limb alone, or all of the body."""
    confirm_draft(hand)
    live(hand.desk)
    review(hand)


def by_watching(hand: Hand) -> None:
    """A box, a draft, both ends as keyframes, and whatever looks wrong while the motion plays."""
    draft(hand.desk)
    ends(hand)
    live(hand.desk)
    Watching(hand).until_right(put_right)


def now_by_places(hand: Hand) -> None:
    """The same with every place of the draft confirmed first."""
    confirm_every_place(hand)
    live(hand.desk)
    review(hand)


def now_by_keyframes(hand: Hand) -> None:
    """The same with whole keyframes, wherever the page asks for one."""
    confirm_draft(hand)
    live(hand.desk)
    follow_advice(hand)


def confirm_draft(hand: Hand) -> None:
    """A box, a draft, and of its places the next one and both ends as keyframes: what lies between
    is seen better once it is tracked."""
    draft(hand.desk)
    confirm_next(hand)
    ends(hand)


def confirm_every_place(hand: Hand) -> None:
    """The same with all places of the draft."""
    draft(hand.desk)
    while hand.desk.to_confirm:
        confirm_next(hand)
    ends(hand)


def confirm_next(hand: Hand) -> None:
    """N, to the next place of the draft, and its pose as a keyframe."""
    desk = hand.desk
    ahead = [f for f in desk.to_confirm if f > desk.frame]
    go_next(desk, (ahead or desk.to_confirm)[0])
    settle(hand, fit=False)


def review(hand: Hand) -> None:
    """Shift R, and place after place until all is right; then whatever else is seen to be wrong."""
    desk, looks = hand.desk, _Looks()
    desk.act("key", "Shift R")
    for _ in range(MOST_PLACES):
        if outcome(desk).right or len(desk.keys) >= desk.clip.frames / GIVE_UP_FRAMES:
            return
        open_ = [place for place in desk.places if place.frame not in looks.right]
        if not open_:
            if not _look_through(hand, looks, alone=True):
                return
            continue
        place = open_[0]
        looks.right.add(place.frame)
        desk.look(place.frame)  # the review goes there by itself
        _use_tracked(desk)
        desk.judge()
        if hand.looks_right():
            desk.act("key", "Enter: accept", do.AcceptPlace(frame=place.frame, part=place.part))
        else:
            put_right(hand)


def put_right(hand: Hand) -> None:
    """Limbs alone where nothing else is wrong: dragged, they are keyed. Else all of the body."""
    desk, before = hand.desk, len(hand.desk.script)
    if desk.frame in desk.keys or any(name in TRUNK for name in hand.wrong()):
        hand.correct()
        if len(desk.script) > before:  # else there is nothing new to key
            key(desk)
    else:
        with desk.limbs_alone():
            hand.correct_limbs()


def draft(desk: Desk) -> None:
    """A box around the person, Enter."""
    clip = desk.clip
    frame, box = clip.box
    go(desk, frame)
    desk.act("drag", "draw the box")
    found = do.Draft(frame=frame, box=box, first=clip.first, last=clip.last)
    desk.act("key", "Enter: draft", found)
    desk.ledger.end_setup()


def ends(hand: Hand) -> None:
    """The first and the last frame are keyframes: only what lies between is tracked. Drafts are
    fitted already: F moves none of them."""
    desk = hand.desk
    for end in (desk.clip.first, desk.clip.last):
        if end not in desk.keys:
            go(desk, end, "go to the end of the clip")
            settle(hand, fit=False)


@dataclass
class _Looks:
    """Frames that were looked at and found right, with the keyframes there were."""

    right: set[int] = field(default_factory=set)
    through: bool = False


def follow_advice(hand: Hand) -> None:
    """N and what it asks for, until all is right."""
    desk, looks = hand.desk, _Looks()
    most = desk.clip.frames / GIVE_UP_FRAMES
    for _ in range(MOST_PLACES):
        if outcome(desk).right or len(desk.keys) >= most:
            return
        asked = desk.suggested
        if asked.frame is None or asked.frame in looks.right:
            if not _look_through(hand, looks):
                return
            continue
        frame = go_next(desk, asked.frame)
        _use_tracked(desk)
        if frame in looks.right:
            if not _look_through(hand, looks):
                return
            continue
        looks.right.add(asked.frame)
        looks.right.add(frame)
        settle(hand, fit=True)


# --- which frame next


def now_by(choose: Choice) -> Callable[[Hand], None]:
    """As `now`, with the frames to put right chosen in another way than by the review."""

    def work(hand: Hand) -> None:
        confirm_draft(hand)
        live(hand.desk)
        mend(hand, choose)

    return work


def mend(hand: Hand, choose: Choice) -> None:
    """Go where a rule says and put right what is wrong there, until all is right."""
    desk, looked = hand.desk, set[int]()
    most = desk.clip.frames / GIVE_UP_FRAMES
    for _ in range(MOST_PLACES):
        if outcome(desk).right or len(desk.keys) >= most:
            return
        frame = choose(desk, looked)
        if frame is None or frame in looked:
            if not _look_through(hand, _Looks(), alone=True):
                return
            continue
        looked |= {frame, go_next(desk, frame)}
        _use_tracked(desk)
        desk.judge()
        if not hand.looks_right():
            put_right(hand)


def by_advice(desk: Desk, looked: set[int]) -> int | None:
    """What N says."""
    return desk.suggested.frame


def by_length(desk: Desk, looked: set[int]) -> int | None:
    """The middle of the longest stretch in which nothing was looked at or posed."""
    known = looked | {*desk.keys, *(part.frame for part in desk.state.doc.part_keyframes)}
    first, last = max(pairwise(sorted(known)), key=lambda gap: gap[1] - gap[0])
    return (first + last) // 2 if last - first > 1 else None


def by_truth(desk: Desk, looked: set[int]) -> int | None:
    """Where a joint is farthest off, which nobody knows: no rule can do better by much."""
    free = [frame for frame in desk.clip.true if frame not in looked]
    return max(free, key=lambda frame: worst_px(desk, frame), default=None)


def worst_px(desk: Desk, frame: int) -> float:
    """How far off the worst joint of a frame is."""
    at, slack = desk.project(motion_at(desk, frame)), desk.clip.slack_px(frame)
    measured = desk.clip.true[frame].items()
    off = [px(uv - at[name]) for name, uv in measured if name not in desk.clip.unmeasured]
    return max(off, default=0.0) - slack


def _look_through(hand: Hand, looks: _Looks, alone: bool = False) -> bool:
    """Go through the clip, correct the first frame that looks wrong; whether there was one."""
    desk = hand.desk
    frames = sorted(desk.clip.seen)
    for frame in _every(frames, LOOK_EVERY) + frames[:: max(1, LOOK_EVERY // 2)]:
        desk.act("key", "look through the clip", do.Go(frame=frame))
        _use_tracked(desk)
        desk.judge()
        if hand.looks_right():
            continue
        before = len(desk.script)
        if alone:
            put_right(hand)
        else:
            hand.correct()
            if len(desk.script) > before:
                key(desk)
        if len(desk.script) > before:  # else nothing that a hand does brings it nearer
            return True
    return False


def _every(frames: Sequence[int], step: int) -> list[int]:
    """Frames at least so far apart."""
    found = list(frames[:1])
    for frame in frames:
        if frame - found[-1] >= step:
            found.append(frame)
    return found


def _use_tracked(desk: Desk) -> None:
    """Where a draft is shown instead of what was tracked, ask for that."""
    if desk.shown().source == "draft" and desk.state.tracked(desk.frame) is not None:
        desk.act("click", "use the tracked pose", do.TakeTracked())


LINEAR = Strategy("linear", TrackSettings(), by_intervals, tracks=False, drafts=False)
PAPER = Strategy("paper", TrackSettings(method="paper"), by_intervals, drafts=False)
BEFORE = Strategy("before", TrackSettings(), before, drafts=False)
KEYED = Strategy("whole keyframes", TrackSettings(cues=ALL_CUES, smooth=True), now_by_keyframes)
PLACES = Strategy("every place", TrackSettings(cues=ALL_CUES, smooth=True), now_by_places)
NOW = Strategy("now", TrackSettings(cues=ALL_CUES, smooth=True), now)
WATCHED = Strategy("watched", NOW.settings, by_watching, by_picture=True)
RULES = tuple(
    Strategy(f"now, {name}", NOW.settings, now_by(choose))
    for name, choose in (("N", by_advice), ("middle", by_length), ("truth", by_truth))
)
STRATEGIES = (LINEAR, PAPER, BEFORE, KEYED, PLACES, NOW, WATCHED, *RULES)
