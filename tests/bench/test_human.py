"""The scripted person of the effort benchmark: what is counted, and what the hand can do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.human.clips import CARRIED_PX, Watched, carried, noisy, of_poses, sized
from bench.human.counting import SECONDS, SHARES, Effort, Ledger
from bench.human.desk import desk, ring_way
from bench.human.hand import LOOKS_RIGHT_PX, Hand, px
from bench.human.strategies import InSpace, Outcome
from bench.keeping import ROOT
from keypose.app.editor.drafted import keeps_proportions
from keypose.app.posing.gesture import Gesture
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.turning import pointer_angle
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session import Session
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.storage.files import load_session
from tests.rendering.scenes import camera


def done(*kinds: str, setup: int = 0, frames: int = 900) -> Effort:
    ledger = Ledger()
    for i, kind in enumerate(kinds):
        if i == setup:
            ledger.end_setup()
        ledger.note(kind, kind)  # type: ignore[arg-type]
    return ledger.effort(frames)


def test_looks_take_time_and_are_no_actions() -> None:
    work = done("click", "judged", "key", "drag", "judged")
    assert work.actions == 3
    assert work.count("judged") == 2
    assert work.seconds == pytest.approx(1.3 + 0.28 + 3.75 + 2 * 2.0)


def test_a_drag_takes_as_long_as_the_literature_says() -> None:
    assert 2.0 <= SECONDS["drag"] <= 4.0
    assert SECONDS["key"] < SECONDS["click"] < SECONDS["judged"] < SECONDS["drag"]


def test_what_is_done_once_a_clip_is_not_multiplied() -> None:
    work = done("click", "drag", "key", "key", setup=2, frames=900)
    assert work.scaled_actions() == pytest.approx(2 + 2 * 2)
    assert work.scaled_minutes() == pytest.approx((1.3 + 3.75 + 2 * 2 * 0.28) / 60)


def test_causes_are_told_by_the_time_they_take() -> None:
    causes = done("key", "key", "key", "drag").by_cause()
    assert [(why, count) for why, count, _ in causes] == [("drag", 1), ("key", 3)]


def test_work_is_divided_without_rest() -> None:
    ledger = Ledger()
    ledger.note("drag", "pull a hand", "keyframes")
    ledger.note("key", "K", "keyframes")
    ledger.end_first()
    ledger.note("drag", "pull a hand", "keyframes")
    ledger.note("drag", "pull a foot", "limbs")
    ledger.note("key", "play")
    ledger.note("judged", "judge a frame")
    work = ledger.effort(100)
    shares = {share: work.of_share(share) for share in SHARES}
    assert [actions for actions, _ in shares.values()] == [2, 1, 1, 1]
    assert sum(seconds for _, seconds in shares.values()) == pytest.approx(work.seconds)
    assert shares["looks"][1] == pytest.approx(0.28 + 2.0)


def test_a_body_that_is_sized_is_drafted_as_it_is() -> None:
    body = preset("adult_male")
    sessions = [
        Session.model_construct(bodies=(TrackedBody(body=each),)) for each in (body, sized(body))
    ]
    assert [keeps_proportions(session) for session in sessions] == [False, True]


def test_a_motion_is_right_only_if_median_and_worst_are() -> None:
    assert Outcome(5.0, 10.0).right
    assert not Outcome(5.1, 9.0).right
    assert not Outcome(1.0, 10.1).right


def test_what_a_person_sees_depends_on_person_and_frame_alone() -> None:
    joints = {f"joint {i}": (100.0, 50.0) for i in range(2000)}
    clip = Watched("x", None, Session.model_construct(), 0, 1, {0: joints, 1: joints}, {}, {})  # type: ignore[arg-type]
    one, again, other = noisy(clip, 2.0, 1), noisy(clip, 2.0, 1), noisy(clip, 2.0, 2)
    assert one.seen == again.seen
    assert one.seen != other.seen
    assert one.seen[0] != one.seen[1]
    off = np.array(list(one.seen[0].values())) - (100.0, 50.0)
    assert np.sqrt((off**2).sum(axis=1).mean()) == pytest.approx(2.0, rel=0.1)
    assert one.true == clip.seen


def test_marks_are_carried_along_the_rough_way_and_met_where_they_are() -> None:
    rough = np.column_stack([np.arange(21.0) ** 2, np.zeros(21)])
    uv = np.array([[3.0, 1.0], [405.0, 3.0]])
    assert carried([0, 20], uv, 0, rough) == pytest.approx(uv[0])
    assert carried([0, 20], uv, 20, rough) == pytest.approx(uv[1])
    assert carried([0, 20], uv, 10, rough) == pytest.approx((104.0, 2.0))


@pytest.mark.parametrize("axis", [(0.1, 0.0, 0.99), (0.0, 1.0, 0.0), (0.9, 0.2, 0.4)])
@pytest.mark.parametrize("angle", [0.3, -0.8])
def test_a_ring_is_dragged_by_the_angle_that_is_meant(
    axis: tuple[float, float, float], angle: float
) -> None:
    view, centre = PointerView.of(camera()), np.array([0.2, 0.1, 3.0])
    unit = np.array(axis) / px(np.array(axis))
    start, end = ring_way(view, centre, unit, angle)
    ring = {"kind": "ring", "part": "waist", "axis": "x"}
    given = {"view": "main", "handle": ring, "from": start.tolist(), "at": end.tolist()}
    gesture = Gesture.model_validate(given)
    assert pointer_angle(view, centre, unit, gesture) == pytest.approx(angle, abs=1e-6)


@pytest.fixture(scope="module")
def posed_by_hand() -> tuple[Effort, dict[str, float], list[str]]:
    """One frame of the rendered sample posed from nothing: what it took, how far off each joint is
    then, and what still looks wrong."""
    folder = ROOT / "sample_videos" / "person"
    bare = load_session(folder / "session.json").changed({"keyframes": ()})
    with np.load(folder / "truth.npz") as truth:
        poses = {0: Pose(truth["Rs_parent_part"][0], truth["ps_camera_root"][0])}
    clip = noisy(of_poses("sample", folder / "person.mp4", bare, poses), 2.0, 0)
    with desk(clip, TrackSettings()) as there:
        hand = Hand.of(there, 0)
        hand.correct()
        at = there.project(there.shown().pose)
        off = {name: px(np.subtract(uv, at[name])) for name, uv in clip.true[0].items()}
        return there.ledger.effort(1), off, hand.wrong()


def test_a_size_is_judged_by_the_picture_alone() -> None:
    folder = ROOT / "sample_videos" / "person"
    known = load_session(folder / "session.json")
    pose = known.subject.keyframes[0].pose(Skeleton.of(known.subject.body))
    farther = Pose(pose.Rs_parent_part, 1.1 * pose.p_camera_root)
    bare = known.changed({"keyframes": known.subject.keyframes[:1]})
    clip = of_poses(
        "sample", folder / "person.mp4", bare, {known.subject.keyframes[0].frame: farther}
    )
    with desk(clip, TrackSettings()) as there:
        hand = Hand.of(there, 0, by_picture=True)
        assert hand._too_large() == pytest.approx(np.log(1.1), abs=0.01)
        assert hand._too_close() == pytest.approx(np.log(1.1), abs=0.001)
    turned = replace(clip, poses={clip.first: Pose(pose.Rs_parent_part, pose.p_camera_root * 2)})
    with desk(turned, TrackSettings()) as there:
        assert Hand.of(there, 0, by_picture=True)._too_large() == pytest.approx(
            np.log(1.1), abs=0.01
        )


def test_marks_that_are_carried_on_are_believed_less() -> None:
    uv = {"knee": (100.0, 50.0)}
    clip = Watched(
        "x",
        None,
        Session.model_construct(),
        0,
        1,
        {0: uv, 1: uv},
        {},
        {},
        frozenset({0}),  # type: ignore[arg-type]
    )
    assert clip.slack_px(0) == 0.0
    assert clip.slack_px(1) == CARRIED_PX


def test_half_a_clip_is_a_clip() -> None:
    uv = {"knee": (100.0, 50.0)}
    clip = Watched("x", None, Session.model_construct(), 0, 9, dict.fromkeys(range(10), uv), {}, {})  # type: ignore[arg-type]
    half = noisy(clip, 2.0, 0).until(4)
    assert (half.frames, sorted(half.seen), sorted(half.true)) == (5, [*range(5)], [*range(5)])


def test_a_hand_poses_a_person_from_nothing(
    posed_by_hand: tuple[Effort, dict[str, float], list[str]],
) -> None:
    work, off, _ = posed_by_hand
    assert work.actions <= 30
    assert Outcome(float(np.median(list(off.values()))), max(off.values())).right


def test_what_looks_wrong_is_told_by_what_is_seen(
    posed_by_hand: tuple[Effort, dict[str, float], list[str]],
) -> None:
    _, off, wrong = posed_by_hand
    assert set(wrong) <= {name for name, far in off.items() if far > LOOKS_RIGHT_PX - 6.0}


def test_a_motion_is_right_in_space_only_if_joints_and_knees_are() -> None:
    assert InSpace(50.0, 10.0).right
    assert not InSpace(50.1, 3.0).right
    assert not InSpace(20.0, 10.1).right
