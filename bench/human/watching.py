"""A person who plays the motion, stops where it looks wrong, and is done when nothing does.

They watch the whole of it once, going on from where they stopped, and then what their corrections
changed. While it plays a joint is seen to be wrong if it is so over a fixation, three frames; what
is wrong is let run on for at most a second, to see where it is worst, and that frame is gone to,
judged and corrected; what still looks wrong there was tried, and is left. They do not know how far
off anything is: who sees nothing wrong stops, right or not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from bench.human.counting import SECONDS
from bench.human.desk import Desk
from bench.human.hand import LOOKS_RIGHT_PX, Hand, px
from keypose.app.editor.update import Go
from keypose.tracker.geometry.rotations import Array

FIXATION = 3
"""Frames over which a joint is seen to be wrong."""
RUNS_ON = 15
"""Frames that are watched at most after something is seen to be wrong."""
CHANGED_PX = 3.0
"""What moved by less since it was watched is not watched again."""
MOST_STOPS = 60


@dataclass
class Watching:
    """What was watched, and where everything was then; and where joints were left as they are."""

    hand: Hand
    seen: dict[int, dict[str, Array]] = field(default_factory=dict)
    left: dict[str, set[int]] = field(default_factory=dict)

    @property
    def desk(self) -> Desk:
        return self.hand.desk

    def until_right(self, put_right: Callable[[Hand], None]) -> None:
        """Watch and correct until nothing looks wrong."""
        for _ in range(MOST_STOPS):
            found = self._next_wrong()
            if found is None:
                return
            frame, joint = found
            self._stop_at(frame)
            before, wrong = len(self.desk.script), self.hand.wrong()
            if not wrong:  # it is not, looked at closely
                self._leave([joint], frame, FIXATION)
                continue
            put_right(self.hand)
            if len(self.desk.script) == before:  # nothing that a hand does brings it nearer
                self._leave([joint, *wrong], frame, RUNS_ON)
            else:  # nor what still looks wrong beside
                self._leave(self.hand.wrong(), frame, FIXATION)

    def _leave(self, joints: Sequence[str], frame: int, frames: int) -> None:
        for joint in joints:
            about = range(frame - frames, frame + frames + 1)
            self.left.setdefault(joint, set()).update(about)

    def _next_wrong(self) -> tuple[int, str] | None:
        """Play what is new or changed; the first joint that is seen to be wrong, and the frame at
        which it is worst."""
        for first, last in self._stretches():
            begin = self._begin_at(first)
            self.desk.act("key", "play")
            found = self._played(begin, last)
            if found is not None:
                return found
        return None

    def _begin_at(self, first: int) -> int:
        """Where playing begins so that what is new from a frame on is seen, gone to where it must
        be: played at its end a motion begins anew."""
        desk, begin = self.desk, self.desk.clip.first
        at_end = desk.frame == desk.clip.last
        if at_end and (first - begin) * SECONDS["watched"] < SECONDS["click"]:
            return begin
        if desk.frame != first:
            desk.act("click", "go where to play from", Go(frame=first))
        return first

    def _played(self, first: int, last: int) -> tuple[int, str] | None:
        """Frames one after the other, and soon after something is wrong no further."""
        worst: tuple[float, int, str] | None = None
        stop = last
        for frame in range(first, last + 1):
            if frame > stop:
                break
            self.desk.ledger.note("watched", "watch it play")
            off, joint = self._sticks_out(frame)
            if joint is not None:
                stop = min(stop, frame + RUNS_ON) if worst is None else stop
                worst = max(worst or (0.0, 0, ""), (off, frame, joint))
            elif worst is not None:
                break
            else:
                self.seen[frame] = self._joints(frame)
        self.desk.look(frame)
        return None if worst is None else worst[1:]

    def _stop_at(self, frame: int) -> None:
        """A click on the timeline stops what plays."""
        if self.desk.frame == frame:
            self.desk.act("key", "stop")
        else:
            self.desk.act("click", "go to the worst of it", Go(frame=frame))
        self.desk.judge()

    # --- what is seen

    def _stretches(self) -> Iterator[tuple[int, int]]:
        """Runs of frames that were not watched as they are now: on from the present frame, and then
        what was changed before it."""
        while new := [frame for frame in sorted(self.desk.clip.seen) if self._is_new(frame)]:
            ahead = [frame for frame in new if frame >= self.desk.frame] or new
            apart = (i for i, f in enumerate(ahead) if f - ahead[0] > i + FIXATION)
            yield ahead[0], ahead[next(apart, len(ahead)) - 1]

    def _is_new(self, frame: int) -> bool:
        before, now = self.seen.get(frame), self._joints(frame)
        return before is None or max(px(now[n] - before[n]) for n in now) > CHANGED_PX

    def _joints(self, frame: int) -> dict[str, Array]:
        return self.desk.project(self.desk.shown(frame).pose)

    def _sticks_out(self, frame: int) -> tuple[float, str | None]:
        """By how much the joint is off that is worst over the frames about this one; None where
        that is not seen, or was left as it is."""
        clip = self.desk.clip
        about = range(frame - FIXATION // 2, frame + FIXATION // 2 + 1)
        off = [self.desk.off(f) for f in about if f in clip.seen]
        names = {name for each in off for name in each} - clip.unmeasured
        looked_at = [n for n in sorted(names) if frame not in self.left.get(n, ())]
        ways = {n: np.mean([each[n] for each in off if n in each], axis=0) for n in looked_at}
        worst = max(ways, key=lambda n: px(ways[n]), default=None)
        slack_px = float(np.mean([self.hand.slack_px(f) for f in about if f in clip.seen] or [0]))
        if worst is None or px(ways[worst]) <= LOOKS_RIGHT_PX + slack_px:
            return 0.0, None
        return px(ways[worst]), worst
