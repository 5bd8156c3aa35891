"""The person who plays the motion: what they see, where they stop, and when they are done."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from bench.human.counting import Kind, Ledger
from bench.human.hand import LOOKS_RIGHT_PX
from bench.human.watching import FIXATION, RUNS_ON, Watching
from keypose.tracker.geometry.rotations import Array

FRAMES = 40


@dataclass
class Played:
    """A motion of one joint, and the hand and the desk of who watches it. off_px: by frame."""

    off_px: dict[int, float]
    ledger: Ledger = field(default_factory=Ledger)
    script: list[str] = field(default_factory=list)
    stops: list[int] = field(default_factory=list)
    frame: int = 0
    slack: dict[int, float] = field(default_factory=dict)
    clip: Any = field(
        default_factory=lambda: SimpleNamespace(
            seen=dict.fromkeys(range(FRAMES)), unmeasured=frozenset(), first=0, last=FRAMES - 1
        )
    )

    @property
    def desk(self) -> Played:
        return self

    def off(self, frame: int) -> dict[str, Array]:
        return {"knee": np.array([self.off_px.get(frame, 0.0), 0.0])}

    def shown(self, frame: int) -> Any:
        return SimpleNamespace(pose=frame)

    def project(self, frame: int) -> dict[str, Array]:
        return {"knee": -self.off(frame)["knee"]}

    def act(self, kind: Kind, why: str, *messages: Any) -> None:
        self.ledger.note(kind, why)
        self.script.append(why)
        for message in messages:
            self.frame = message.frame

    def look(self, frame: int) -> None:
        self.frame = frame

    def judge(self) -> None:
        self.ledger.note("judged", "judge a frame")
        self.stops.append(self.frame)

    def wrong(self) -> list[str]:
        return ["knee"] if self.off_px.get(self.frame, 0.0) > LOOKS_RIGHT_PX else []

    def slack_px(self, frame: int) -> float:
        return self.slack.get(frame, 0.0)

    @property
    def watched(self) -> int:
        return self.ledger.effort(FRAMES).count("watched")


def watch(wrong: Mapping[int, float], mends: int = 0) -> Played:
    """Who corrects a frame corrects so many beside it, too."""
    played = Played(dict(wrong))

    def put_right(_: Any) -> None:
        played.act("drag", "put right")
        for frame in range(played.frame - mends, played.frame + mends + 1):
            played.off_px.pop(frame, None)

    Watching(played).until_right(put_right)  # type: ignore[arg-type]
    return played


def bump(first: int, *px: float) -> dict[int, float]:
    return dict(enumerate(px, first))


def test_a_motion_that_looks_right_is_watched_once() -> None:
    played = watch({})
    assert (played.watched, played.stops, played.script) == (FRAMES, [], ["play"])


def test_one_stops_where_it_is_worst() -> None:
    played = watch(bump(10, 8, 9, 14, 20, 14, 9, 8), mends=5)
    assert played.stops == [13]
    assert played.script.count("put right") == 1


def test_what_is_wrong_for_a_single_frame_is_not_seen() -> None:
    assert watch(bump(10, 15)).stops == []
    assert watch(bump(10, 15, 15)).stops != []


def test_who_stops_has_not_seen_more_than_a_second_of_it() -> None:
    played = watch(bump(5, *np.linspace(8.0, 20.0, 30)), mends=30)
    assert played.stops[0] <= 5 + RUNS_ON + FIXATION // 2


def test_what_did_not_change_is_not_watched_again() -> None:
    played = watch(bump(30, 12, 12, 12, 12, 12), mends=5)
    assert FRAMES < played.watched <= FRAMES + 15


def test_one_goes_on_from_where_one_stopped_and_then_back_to_what_changed() -> None:
    played = watch(bump(10, 12, 12, 12) | bump(30, 12, 12, 12), mends=3)
    assert len(played.stops) == 2
    gone = [i for i, why in enumerate(played.script) if why == "go where to play from"]
    assert gone
    assert min(gone) > played.script.index("put right", played.script.index("put right") + 1)


def test_a_motion_played_at_its_end_begins_anew_without_a_click() -> None:
    near = watch(bump(10, 12, 12, 12), mends=8)
    assert near.watched > FRAMES
    assert "go where to play from" not in near.script
    far = watch(bump(33, 12, 12, 12), mends=5)
    assert "go where to play from" in far.script


def test_a_click_on_the_timeline_stops_it_by_itself() -> None:
    script = watch(bump(10, 8, 9, 14, 20, 14, 9, 8), mends=5).script
    assert "go to the worst of it" in script
    assert "stop" not in script


def test_what_nothing_makes_better_is_left_and_the_rest_is_watched() -> None:
    played = Played(bump(10, 12, 12, 12))
    watching = Watching(played)  # type: ignore[arg-type]
    watching.until_right(lambda _: None)
    assert len(played.stops) == 1
    assert set(range(FRAMES)) == watching.seen.keys()


def test_marks_carried_on_to_the_frames_beside_a_marked_one_do_not_make_it_look_wrong() -> None:
    carried_on = {frame: 4.0 for frame in range(FRAMES) if frame % 5}
    played = Played(dict.fromkeys(range(FRAMES), LOOKS_RIGHT_PX + 2.0), slack=carried_on)
    Watching(played).until_right(lambda _: None)  # type: ignore[arg-type]
    assert played.stops == []
    played = Played(dict.fromkeys(range(FRAMES), LOOKS_RIGHT_PX + 2.0))
    Watching(played).until_right(lambda _: None)  # type: ignore[arg-type]
    assert played.stops != []


def test_what_still_looks_wrong_after_a_correction_was_tried_and_is_left() -> None:
    played = Played(bump(10, 12, 12, 12))

    def put_right(_: Any) -> None:
        played.act("drag", "put another joint right")

    Watching(played).until_right(put_right)  # type: ignore[arg-type]
    assert len(played.stops) == 1
