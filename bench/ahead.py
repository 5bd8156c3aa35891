"""Real people followed from one keyframe: how far it carries, and whether it stops where it should.

The keyframe is posed on marks alone, see `keyed.py`. Reported are the marked joints that are more
than 12 px off some frames away, whether trusted there or not; how far the body was followed until
it was not trusted any more; and the joints that are off before that frame and beyond it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from bench.clips import Clip, clip
from bench.keeping import Absent
from bench.keyed import Keyed, keyed
from bench.table import Expected, Report
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.keypoints.stretch import Stretch
from keypose.tracker.session.annotations import Direction
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.tracking.ahead.follow import LONGEST, follow_ahead, followed_ways
from keypose.tracker.tracking.ahead.line import Line
from keypose.tracker.tracking.cues.sources import DetectedKeypoints
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video

FAR_PX, MOST_FAR = 12.0, 8.0
"""A joint farther off is wrong; so many per cent of them may be, before the stop."""
AWAY, NEAR = (15, 30), 5
"""So many frames from the keyframe, at the marked frame that is nearest, within so many."""


@dataclass(frozen=True)
class Start:
    """keyframes: those that the body is sized on; `frame` is one of them."""

    clip: str
    keyframes: tuple[int, ...]
    frame: int
    direction: Direction
    held_out: bool = False

    @property
    def size(self) -> float:
        """How many times larger than the other films: its pixels count by so much less."""
        return 2.0 if self.clip == "camera4" else 1.0


_PERSON, _WALK, _ARMS = (0, 30, 60, 90), (30, 50, 70, 90), (20, 40, 60)
STARTS = (
    Start("person", _PERSON, 0, "forward"),
    Start("person", _PERSON, 30, "forward"),
    Start("person", _PERSON, 60, "backward"),
    Start("person", _PERSON, 90, "backward"),
    Start("walk", _WALK, 30, "forward"),
    Start("walk", _WALK, 50, "forward"),
    Start("walk", _WALK, 70, "backward"),
    Start("walk", _WALK, 90, "backward"),
    Start("arms", _ARMS, 20, "forward"),
    Start("arms", _ARMS, 40, "forward"),
    Start("arms", _ARMS, 60, "backward"),
    Start("camera4", _PERSON, 0, "forward", held_out=True),
    Start("camera4", _PERSON, 30, "forward", held_out=True),
    Start("camera4", _PERSON, 60, "backward", held_out=True),
    Start("camera4", _PERSON, 90, "backward", held_out=True),
)
WAYS = {
    "brightness": TrackSettings(cues=("brightness",)),
    "keypoints": TrackSettings(cues=("brightness", "keypoints")),
}


class _Seen(dict[str, Stretch]):
    """What the network saw, looked at once."""

    def put(self, key: str, stretch: Stretch) -> None:
        self[key] = stretch


_SEEN = _Seen()


@dataclass
class _Sum:
    """Joints that are far off, and all: by frames away, before the stop, and beyond it."""

    away: dict[int, list[bool]] = field(default_factory=dict)
    before: list[bool] = field(default_factory=list)
    beyond: list[bool] = field(default_factory=list)
    carried: list[int] = field(default_factory=list)


def ahead(report: Report) -> None:
    """The whole group."""
    report.note(f"joints more than {FAR_PX:.0f} px off, of those marked; posed at one frame alone")
    columns = ("way", "at 15", "at 30", "carried", "stop", "last mark", "before", "beyond")
    table = report.table("followed from one keyframe", *columns, wide=("stop",))
    sums = {way: _Sum() for way in WAYS}
    for start in STARTS:
        if start.held_out != report.options.held_out:
            continue
        name = f"{start.clip} {start.frame} {start.direction}"
        try:
            shown = clip(start.clip)
        except Absent as absent:
            report.note(f"{name} left out: {absent} is not here")
            continue
        for way, settings in WAYS.items():
            table.row(name, way, *_measured(shown, start, settings, sums[way]))
    for way, total in sums.items():
        if total.carried:
            at = [_of(total.away.get(n, [])) for n in AWAY]
            mean = f"{np.mean(total.carried):.0f} of {LONGEST}"
            cells = (*at, mean, "–", "–", _share(total.before), _share(total.beyond))
            far = 100 * float(np.mean(total.before)) if total.before else 0.0
            table.row("all", way, *cells, expected=[Expected("before", far, MOST_FAR, "%")])


def _measured(shown: Clip, start: Start, settings: TrackSettings, total: _Sum) -> list[str]:
    hand = keyed(shown, start.keyframes)
    line = Line(start.frame, start.direction)
    with Video.open(shown.video) as video:
        source = DetectedKeypoints(video, shown.camera, shown.name, _SEEN)
        posed = {start.frame: hand.poses[start.frame]}
        tracker = Tracker(video, shown.camera, hand.skeleton, posed, keypoints=source, fewest=1)
        count = video.info.frame_count
        steps = min(LONGEST, start.frame if line.sign < 0 else count - 1 - start.frame)
        found = follow_ahead(tracker, *(line.frame, line.direction), settings, lambda motion: None)
        whole = line.motion(followed_ways(tracker, line, steps, settings)[0].motion)
    carried = abs(found.to_frame - start.frame)
    off, kept = (_off(shown, hand, motion, start) for motion in (whole, found.motion))
    cells = []
    for away in AWAY:
        at = min(off, key=lambda step: (abs(step - away), step))
        far = [px > FAR_PX for px in off[at].values()] if abs(at - away) <= NEAR else []
        total.away.setdefault(away, []).extend(far)
        cells.append(_of(far))
    before = [px > FAR_PX for marks in kept.values() for px in marks.values()]
    beyond = [px > FAR_PX for step, marks in off.items() if step > carried for px in marks.values()]
    total.before += before
    total.beyond += beyond
    total.carried.append(carried)
    last = f"{np.mean(list(kept[max(kept)].values())):.1f} at {max(kept)}" if kept else "–"
    stop = " ".join(filter(None, (found.stop.cause, found.stop.part, found.stop.behind)))
    return [*cells, str(carried), stop, last, _of(before), _of(beyond)]


def _off(
    shown: Clip, hand: Keyed, motion: Trajectory, start: Start
) -> Mapping[int, Mapping[str, float]]:
    """Pixels by joint of every marked frame, by how far it is from the keyframe."""
    reference = shown.reference(hand.skeleton.body)
    points, found = BodyPoints(hand.skeleton, reference.places), {}
    for frame, known in zip(reference.frames.tolist(), reference.positions, strict=True):
        if motion.first_frame <= frame <= motion.last_frame and frame != start.frame:
            p = points.at(motion.transforms(hand.skeleton)[frame - motion.first_frame])
            away = np.linalg.norm(shown.camera.project(p) - known, axis=-1) / start.size
            named = zip(reference.names, away.tolist(), strict=True)
            found[abs(frame - start.frame)] = {name: px for name, px in named if np.isfinite(px)}
    return found


def _of(far: list[bool]) -> str:
    return f"{sum(far)}/{len(far)}" if far else "–"


def _share(far: list[bool]) -> str:
    return f"{100 * np.mean(far):.1f} %" if far else "–"
