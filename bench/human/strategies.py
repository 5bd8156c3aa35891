"""Ways to get a whole clip right, each a small piece that may be replaced by another.

Every one works until the motion looks right to whoever works: every joint is at most 5 px off in
the median over all frames that are seen, and 10 px at worst.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from bench.human.desk import Desk
from bench.human.hand import TRUNK, Hand
from bench.human.watching import Watching
from keypose.app.document.defaults import Defaults
from keypose.app.editor.actions import Draft
from keypose.app.editor.keyframes import AddKey
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.update import Go, Switch
from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.settings import TrackSettings

MEDIAN_PX = 5.0
WORST_PX = 10.0
"""A motion is right when every joint is that near, in the median and at worst."""
OFF_MM = 50.0
KNEES_DEG = 10.0
"""A motion is right in space when joints are that near in the median, seen from the hips, and knees
are bent that nearly alike: what four cameras say of a joint is 15–25 mm off, and where makers put
the same joint differs by 30–40 mm."""
LIMB_JOINTS = tuple(
    f"{side}_{part}"
    for side in ("left", "right")
    for part in ("upper_arm", "forearm", "hand", "thigh", "shin", "foot")
)
GIVE_UP_FRAMES = 3
"""With a keyframe in so many frames, it is given up."""


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
    state = replace(desk.state, doc=desk.state.doc.changed({"drafts": ()}))
    return shown_pose(state if inside else desk.state, frame).pose


@dataclass(frozen=True)
class InSpace:
    """How right it is in space: the median of how far joints are off as seen from the hips, mm, and
    by how many degrees knees are bent more or less, in the mean."""

    off_mm: float
    knees_deg: float

    @property
    def right(self) -> bool:
        return self.off_mm <= OFF_MM and self.knees_deg <= KNEES_DEG


def in_space(desk: Desk) -> InSpace | None:
    """Of all frames that are worked on; None where nobody knows where joints were."""
    clip = desk.clip
    frames = [f for f in clip.p_true if clip.first <= f <= clip.last]
    if not frames:
        return None
    skeleton, off, knees = desk.state.skeleton, list[Array](), list[float]()
    names = joint_names(skeleton)
    for frame in frames:
        p = joint_positions(skeleton, pose_transforms(skeleton, motion_at(desk, frame)))
        ours, true = dict(zip(names, p, strict=True)), clip.p_true[frame]
        a, b = (np.stack([p[n] for n in LIMB_JOINTS]) - _hips(p) for p in (ours, true))
        off.append(np.linalg.norm(a - b, axis=-1))
        bent = zip(_knees_deg(ours), _knees_deg(true), strict=True)
        knees += [abs(one - other) for one, other in bent]
    return InSpace(1e3 * float(np.median(np.concatenate(off))), float(np.mean(knees)))


def _hips(p: Mapping[str, Array]) -> Array:
    return np.asarray((p["left_thigh"] + p["right_thigh"]) / 2)


def _knees_deg(p: Mapping[str, Array]) -> list[float]:
    """How far the left and the right knee are bent."""
    bent = []
    for side in ("left", "right"):
        thigh, shin = (
            p[f"{side}_{far}"] - p[f"{side}_{near}"]
            for near, far in (("thigh", "shin"), ("shin", "foot"))
        )
        cosine = thigh @ shin / (np.linalg.norm(thigh) * np.linalg.norm(shin))
        bent.append(float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))))
    return bent


# --- moves that all share


def go(desk: Desk, frame: int, why: str = "go to a frame") -> int:
    """A click on the timeline, at the nearest frame of which anything is seen; that frame."""
    near = min(desk.clip.seen, key=lambda f: (abs(f - frame), f))
    if near != desk.frame:
        desk.act("click", why, Go(frame=near))
    return near


def settle(hand: Hand) -> None:
    """Judge the present frame, correct it where it is wrong, and key it."""
    hand.desk.judge()
    if not hand.looks_right():
        hand.correct()
    key(hand.desk)


def key(desk: Desk) -> None:
    """K."""
    desk.act("key", "K", AddKey(frame=desk.frame))
    desk.ledger.end_first()


def live(desk: Desk) -> None:
    """Track at once whatever is posed."""
    desk.act("click", "switch Live on", Switch(do="live", on=True))


# --- without the page's advice


def by_intervals(hand: Hand) -> None:
    """Both ends, then the middle of whatever is longest unseen."""
    desk, clip = hand.desk, hand.desk.clip
    if desk.tracks:
        live(desk)
    for end in (clip.first, clip.last):
        go(desk, end)
        settle(hand)
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


def by_watching(hand: Hand) -> None:
    """A box, a draft, both ends as keyframes, and whatever looks wrong while the motion plays."""
    draft(hand.desk)
    ends(hand)
    live(hand.desk)
    Watching(hand).until_right(put_right)


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
    found = Draft(frame=frame, box=box, first=clip.first, last=clip.last)
    desk.act("key", "Enter: draft", found)
    desk.ledger.end_setup()


def ends(hand: Hand) -> None:
    """The first and the last frame are keyframes: only what lies between is tracked. Drafts are
    fitted already: F moves none of them."""
    desk = hand.desk
    for end in (desk.clip.first, desk.clip.last):
        if end not in desk.keys:
            go(desk, end, "go to the end of the clip")
            settle(hand)


LINEAR = Strategy("linear", TrackSettings(), by_intervals, tracks=False, drafts=False)
PAPER = Strategy("paper", TrackSettings(method="paper"), by_intervals, drafts=False)
WATCHED = Strategy("watched", Defaults().track_settings, by_watching, by_picture=True)
STRATEGIES = (LINEAR, PAPER, WATCHED)
