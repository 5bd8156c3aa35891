"""What a person does, counted, and the time it takes them.

Times are those of the keystroke-level model (Card, Moran and Newell, "The keystroke-level model for
user performance time with interactive systems", CACM 23(7), 1980): K 0.28 s a key for somebody who
types 40 words a minute, P 1.1 s to point at a target, M 1.35 s to decide what comes next; and B
0.1 s to press or release a button (Kieras, "Using the keystroke-level model to estimate execution
times", 2001). So a click takes P + 2 B. A drag of a handle is decided on, pointed at, pressed,
carried and released, M + 2 P + 2 B, which agrees with the 2–4 s that animators take. A frame is
judged in 2 s: one decision and the looks at head, hands and feet that it rests on. What the
computer takes is not counted: tracking goes on while the person does.

A motion is watched at 15 frames a second, a film of 30 at half its speed: a fixation lasts 0.2 to
0.3 s (Rayner, "Eye movements in reading and information processing: 20 years of research",
Psychological Bulletin 124(3), 1998), three or four frames then, and what sticks out of its
surroundings is found at a glance, however much there is around it (Treisman and Gelade, "A
feature-integration theory of attention", Cognitive Psychology 12(1), 1980).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Literal, TypeAlias, get_args

Kind: TypeAlias = Literal["click", "key", "drag", "judged", "watched"]
KINDS: Final[tuple[Kind, ...]] = get_args(Kind)
KEY_S = 0.28
POINT_S = 1.1
BUTTON_S = 0.1
DECIDE_S = 1.35
JUDGE_S = 2.0
WATCHED_S = 1 / 15
"""A frame of a motion that is played."""
LOOKED: Final = ("judged", "watched")
"""What is no action: to look."""
Share: TypeAlias = Literal["begin", "keyframes", "limbs", "looks"]
SHARES: Final[tuple[Share, ...]] = get_args(Share)
"""What work consists of: all up to the first keyframe, and what is chosen once; posing at further
keyframes; correcting single limbs between them; playing, going to frames and judging them."""
SECONDS: Final[dict[Kind, float]] = {
    "click": POINT_S + 2 * BUTTON_S,
    "key": KEY_S,
    "drag": DECIDE_S + 2 * POINT_S + 2 * BUTTON_S,
    "judged": JUDGE_S,
    "watched": WATCHED_S,
}
LONG_FRAMES = 1800
"""Of a minute at 30 frames a second: what efforts are told for."""


@dataclass(frozen=True)
class Act:
    """One thing that a person does. why: what for, in a word, to find where effort goes."""

    kind: Kind
    why: str
    share: Share = "looks"


@dataclass(frozen=True)
class Effort:
    """What was done for so many frames of a clip; the first `setup` of it once a clip, however long
    that is. first: up to the first keyframe, from which all drafts learn."""

    acts: tuple[Act, ...]
    frames: int
    setup: int = 0
    first: int = 0

    @property
    def actions(self) -> int:
        """Clicks, keys and drags; to look is none."""
        return sum(act.kind not in LOOKED for act in self.acts)

    @property
    def seconds(self) -> float:
        return seconds_of(self.acts)

    def count(self, kind: Kind) -> int:
        return sum(act.kind == kind for act in self.acts)

    def scaled_actions(self) -> float:
        """Actions for `LONG_FRAMES`: what is done once, and the rest as often as frames ask."""
        once = Effort(self.acts[: self.setup], self.frames).actions
        return once + (self.actions - once) * LONG_FRAMES / self.frames

    def scaled_minutes(self) -> float:
        """Minutes of work for `LONG_FRAMES`, in the same way."""
        once = seconds_of(self.acts[: self.setup])
        return (once + (self.seconds - once) * LONG_FRAMES / self.frames) / 60

    @property
    def first_seconds(self) -> float:
        """Until the first keyframe stands."""
        return seconds_of(self.acts[: self.first])

    @property
    def seconds_a_frame(self) -> float:
        """After that, for each frame of the clip."""
        return (self.seconds - self.first_seconds) / self.frames

    def of_share(self, share: Share) -> tuple[int, float]:
        """Actions and seconds of one share of the work."""
        own = Effort(tuple(act for act in self.acts if act.share == share), self.frames)
        return own.actions, own.seconds

    def by_cause(self) -> list[tuple[str, int, float]]:
        """What for, how many acts and how many seconds, the most seconds first."""
        counts = Counter(act.why for act in self.acts)
        spent = {why: seconds_of([a for a in self.acts if a.why == why]) for why in counts}
        return sorted(((w, counts[w], spent[w]) for w in counts), key=lambda row: -row[2])


def seconds_of(acts: Sequence[Act]) -> float:
    """How long a person takes."""
    return sum(SECONDS[act.kind] for act in acts)


@dataclass
class Ledger:
    """Everything done so far."""

    acts: list[Act] = field(default_factory=list)
    setup: int = 0
    first: int = 0

    def note(self, kind: Kind, why: str, share: Share = "looks") -> None:
        """Before the first keyframe stands all work is its beginning."""
        self.acts.append(Act(kind, why, share if self.first else "begin"))

    def end_setup(self) -> None:
        """What was done until now is done once for a clip."""
        self.setup = len(self.acts)

    def end_first(self) -> None:
        """The first keyframe stands."""
        self.first = self.first or len(self.acts)

    def effort(self, frames: int) -> Effort:
        return Effort(tuple(self.acts), frames, self.setup, self.first)
