"""A fit is taken over once, as one step, only where it began from still stands; tracking waits."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.document.library import Library
from keypose.app.jobs.fit import Fit
from keypose.app.jobs.fit_pose import FitPose, FoundPose
from keypose.app.jobs.fit_sizes import FitSizes
from keypose.app.jobs.job import Failed, Finished
from keypose.app.jobs.track import Track
from keypose.app.posing import with_height
from keypose.app.store.store import Store
from keypose.app.working import queue
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass
from keypose.tracker.fitting.sizes import Proposal, SizesFitted
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.results import Results, segment_keys
from keypose.tracker.tracking.result import SegmentResult
from tests.app.store.test_store import _track
from tests.scenes import IdleWorker, StoreDesk, at_desk

FIT = {"do": "fit_here"}
SIZES = {"do": "fit_sizes"}
TURN = {"do": "angles", "part": "left_forearm", "x": -30}
WORDS = "Left forearm moved 6 px."


class Worker(IdleWorker):
    """Takes orders and reports what the test says."""

    @property
    def fits(self) -> list[Fit]:
        return self.of(Fit)

    @property
    def tracked(self) -> list[tuple[tuple[int, int], ...]]:
        return [tuple(job.spans) for job in self.of(Track)]

    @property
    def stages(self) -> list[Sequence[str]]:
        return [job.stages for job in self.of(Track)]

    @property
    def number(self) -> int:
        """Of the newest fit."""
        return max(n for n, job in enumerate(self.jobs, 1) if isinstance(job, Fit))

    def end(self, result: Any) -> None:
        """The newest fit ends with this."""
        self.report(Finished(self.number, result))

    def fail(self, words: str) -> None:
        """The newest fit fails."""
        self.report(Failed(self.number, words))

    def find(self, metres: float = 0.02, found: bool = True) -> None:
        """The newest fit ends with the body moved so far to the side."""
        job = self.fits[-1]
        if isinstance(job, FitPose):
            moved = job.pose.p_camera_root + np.array([metres if found else 0.0, 0, 0])
            self.end(FoundPose(Pose(job.pose.Rs_parent_part, moved), found, WORDS))
        else:
            doc = Session.model_validate_json(job.session)
            alone, with_poses = (_proposed(doc, turned) for turned in (False, True))
            self.end(SizesFitted(WORDS, 6.2, alone, with_poses, ("neck",)))


def _proposed(doc: Session, turned: bool) -> Proposal:
    """A taller body; `turned`: with the limbs of keyframe 24 turned as well."""
    poses = {k.frame: k.pose(Skeleton.of(doc.subject.body)) for k in doc.subject.keyframes}
    turns = {}
    if turned:
        Rs, shin = poses[24].Rs_parent_part.copy(), doc.subject.body.index("left_shin")
        Rs[shin] = Rs[shin] @ exp_rotation([np.radians(3.0), 0.0, 0.0])
        poses[24] = Pose(Rs, poses[24].p_camera_root)
        turns = {24: (("left_shin", 3.0),)}
    changes = (("shin", "length", 40.0, 42.0),)
    error = 4.1 if turned else 5.0
    return Proposal(
        with_height(doc.subject.body, 190), doc.view.camera, poses, changes, error, turns
    )


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", Worker)


class Desk(StoreDesk):
    """A store with a tab, at frame 24, which has a keyframe."""

    def __init__(self, store: Store) -> None:
        super().__init__(store)
        self.do({"do": "go", "frame": 24})

    @property
    def worker(self) -> Worker:
        return Worker.newest

    @property
    def x_m(self) -> float:
        """Where keyframe 24 has the body."""
        return next(k for k in self.edit.doc.subject.keyframes if k.frame == 24).root_m[0]

    async def words(self) -> list[str]:
        """What the tab was noted or refused since it was asked last."""
        self.tab.acknowledge(10**9)
        return [m["words"] for m in await self.tab.next() if "words" in m]


@pytest.fixture
async def desk(path: Path) -> AsyncIterator[Desk]:
    async with at_desk(path, Desk) as made:
        yield made


async def test_a_fitted_keyframe_is_saved_and_one_undo_takes_it_back(path: Path) -> None:
    was = load_session(path).subject.keyframes[1].root_m[0]
    async with at_desk(path, Desk) as desk:
        before = desk.edit.doc
        desk.do(FIT)
        assert desk.section("job")["title"] == "Fitting frame 24"
        desk.worker.find()
        assert desk.section("job")["state"] == "idle"
        assert desk.section("undo")["undo"] == "fit the pose"
        desk.do({"do": "undo"})
        assert desk.edit.doc is before
        desk.do({"do": "redo"})
    assert load_session(path).subject.keyframes[1].root_m[0] == pytest.approx(was + 0.02)


async def test_the_order_carries_the_pose_that_stands_there_and_the_document_as_it_is(
    desk: Desk,
) -> None:
    desk.do({"do": "go", "frame": 10}, {"do": "root", "x": 0.5}, FIT)
    (order,) = desk.worker.fits
    assert isinstance(order, FitPose)
    assert order.frame == 10
    assert order.pose.p_camera_root[0] == pytest.approx(0.5)
    assert (
        Session.model_validate_json(order.session).subject.keyframes
        == desk.edit.doc.subject.keyframes
    )
    assert Path(order.video_path).name == "person.mp4"
    desk.worker.find()
    assert desk.section("keys")["drafts"] == [10]


async def test_only_what_tracking_has_finished_is_evidence(desk: Desk) -> None:
    doc = desk.edit.doc
    key = segment_keys(doc)[0, 24]
    done = _track(doc, 0, 24, key)
    passing = SegmentResult.on_the_way(Pass("pass", done.trajectory, 1.0), key)
    desk.do({"do": "go", "frame": 20})
    for track, near in ((passing, 0), (done, 13)):
        desk.store.know(Results({key: track}))
        desk.do(FIT)
        order = desk.worker.fits[-1]
        assert isinstance(order, FitPose)
        assert len(order.tracked) == near
        assert (20 in order.tracked) == (near > 0)  # tells what was led through this pose
        desk.do({"do": "cancel"})


async def test_what_the_fit_did_is_reported_until_the_next_edit(desk: Desk) -> None:
    desk.do(FIT)
    assert desk.section("fit") is None
    desk.worker.find()
    assert desk.section("fit")["words"] == WORDS
    assert desk.section("fit")["frame"] == 24
    desk.do({"do": "go", "frame": 30}, {"do": "go", "frame": 24})
    assert desk.section("fit") is not None
    desk.do(TURN)
    assert desk.section("fit") is None


async def test_what_the_fit_did_can_be_closed_and_the_fit_stays(desk: Desk) -> None:
    was = desk.x_m
    desk.do(FIT)
    desk.worker.find()
    desk.do({"do": "close_fit"})
    assert desk.section("fit") is None
    assert desk.x_m == pytest.approx(was + 0.02)


async def test_looking_back_shows_the_pose_before_and_changes_nothing(desk: Desk) -> None:
    before = desk.section("pose")
    desk.do(FIT)
    desk.worker.find()
    after, doc = desk.section("pose"), desk.edit.doc
    assert after["root"] != before["root"]
    desk.do({"do": "look_before", "on": True})
    assert desk.section("pose")["root"] == before["root"]
    assert desk.section("fit")["looking_back"]
    desk.do({"do": "look_before", "on": False})
    assert desk.section("pose") == after
    assert desk.edit.doc is doc


async def test_a_tab_that_leaves_while_it_looks_back_leaves_the_others_with_what_is(
    desk: Desk,
) -> None:
    desk.do(FIT)
    desk.worker.find()
    after = desk.section("pose")
    other = desk.store.join()
    desk.do({"do": "look_before", "on": True}, tab=other)
    desk.store.leave(other)
    assert desk.section("pose") == after


async def test_a_drag_that_begins_while_one_looks_back_goes_on_from_what_was_fitted(
    desk: Desk,
) -> None:
    was = desk.x_m
    desk.do(FIT)
    desk.worker.find()
    desk.do({"do": "look_before", "on": True}, TURN)
    assert desk.section("fit") is None
    assert desk.x_m == pytest.approx(was + 0.02)


async def test_asked_for_twice_it_is_done_once(desk: Desk) -> None:
    desk.do(FIT, FIT)
    assert len(desk.worker.fits) == 1
    desk.do({"do": "go", "frame": 48}, FIT)
    assert [order.frame for order in desk.worker.fits] == [24, 48]  # type: ignore[attr-defined]


async def test_a_pose_that_is_edited_meanwhile_stays_as_it_was_edited(desk: Desk) -> None:
    before = desk.worker.cancelled
    desk.do(FIT, {**TURN, "stroke": "drag"})
    assert desk.worker.cancelled == before + 1
    assert desk.section("job")["state"] == "idle"
    desk.worker.find()  # too late
    desk.do({"do": "end_stroke", "stroke": "drag"})
    assert desk.section("undo")["undo"] == "turn left forearm"
    assert await desk.words() == ["Fit cancelled because the pose changed."]


async def test_a_drag_of_something_else_is_not_torn_out_of_the_hand(desk: Desk) -> None:
    was = desk.x_m
    other = {"do": "key_angle", "frame": 48, "part": "head", "axis": "x", "stroke": "curve"}
    desk.do(FIT, {**other, "deg": 3})
    desk.worker.find()
    assert desk.x_m == was
    desk.do({**other, "deg": 9}, {"do": "end_stroke", "stroke": "curve"})
    assert desk.x_m == pytest.approx(was + 0.02)
    desk.do({"do": "undo"})
    assert desk.x_m == was
    assert desk.section("undo")["undo"] == "turn head"


async def test_a_body_that_is_changed_meanwhile_makes_the_fit_void(desk: Desk) -> None:
    was = desk.x_m
    desk.do(FIT, {"do": "height", "cm": 150})
    desk.worker.find()
    assert desk.x_m == was


async def test_a_fit_that_is_cancelled_does_nothing_and_can_be_asked_for_again(desk: Desk) -> None:
    doc = desk.edit.doc
    desk.do(FIT, {"do": "cancel"})
    assert desk.section("job")["state"] == "idle"
    desk.worker.find()
    assert desk.edit.doc is doc
    assert await desk.words() == []
    desk.do(FIT)
    desk.worker.find()
    assert desk.edit.doc is not doc


async def test_where_the_picture_shows_nothing_it_is_said_and_nothing_is_to_undo(
    desk: Desk,
) -> None:
    doc = desk.edit.doc
    desk.do(FIT)
    desk.worker.find(found=False)
    assert desk.edit.doc is doc
    assert desk.section("fit") is None
    assert await desk.words() == [WORDS]


async def test_a_failed_fit_is_reported_and_the_next_one_works(desk: Desk) -> None:
    desk.do(FIT)
    desk.worker.fail("The video is gone.")
    assert desk.section("job")["state"] == "idle"
    assert await desk.words() == ["The video is gone."]
    desk.do(FIT)
    desk.worker.find()
    assert desk.section("fit") is not None


async def test_tracking_waits_for_the_fit_and_goes_on_after_it(desk: Desk) -> None:
    desk.do({"do": "track", "what": "all"}, FIT)
    assert desk.section("job")["words"] == "tracking continues after it"
    assert {s["state"] for s in desk.section("segments")} == {"waiting"}
    assert len(desk.worker.tracked) == 1
    desk.worker.find()
    assert desk.worker.tracked[1] == ((0, 24), (24, 48), (48, 72))
    assert desk.section("job")["state"] == "running"


async def test_tracking_goes_on_after_a_fit_that_was_cancelled(desk: Desk) -> None:
    desk.do({"do": "track", "what": "all"}, FIT)
    before = desk.worker.cancelled
    desk.do({"do": "cancel"})
    assert len(desk.worker.tracked) == 2
    assert desk.worker.cancelled == before + 1, "the fit, and not what goes on after it"
    desk.do({"do": "cancel"})
    assert len(desk.worker.tracked) == 2


async def test_what_waits_for_a_fit_waits_for_the_one_that_replaces_it(desk: Desk) -> None:
    desk.do({"do": "track", "what": "all"}, FIT, {"do": "fit_sizes"})
    assert desk.section("job")["words"] == "tracking continues after it"
    assert len(desk.worker.tracked) == 1


async def test_tracking_that_is_asked_for_during_a_fit_comes_after_it(desk: Desk) -> None:
    desk.do(FIT, {"do": "track", "what": "all"})
    assert desk.worker.tracked == []
    desk.worker.find()
    assert desk.worker.tracked == [((0, 24), (24, 48), (48, 72))]


async def test_with_live_on_the_segments_beside_a_fitted_keyframe_are_tracked_anew(
    desk: Desk,
) -> None:
    desk.do({"do": "live", "on": True}, FIT)
    desk.worker.find()
    assert desk.worker.tracked == [((0, 24), (24, 48))]
    assert desk.worker.stages == [("preview", "full")]


async def test_with_live_off_nothing_is_tracked_after_a_fit(desk: Desk) -> None:
    desk.do(FIT)
    desk.worker.find()
    assert desk.worker.tracked == []


async def test_a_session_that_is_closed_during_a_fit_stays_as_it_was(path: Path) -> None:
    before = load_session(path).subject.keyframes
    async with at_desk(path, Desk) as desk:
        desk.do(FIT)
        await desk.store.close_session()
        desk.worker.find()
        assert desk.store.app_state.edit is None
        await desk.store.open(path)
        desk.worker.find()
        assert desk.section("fit") is None
    assert load_session(path).subject.keyframes == before


async def test_new_sizes_are_only_shown_until_they_are_applied(desk: Desk) -> None:
    before, tall = desk.edit.doc, desk.section("body")["height_cm"]
    desk.do({**SIZES, "focal": True})
    (order,) = desk.worker.fits
    assert isinstance(order, FitSizes)
    assert order.focal
    assert desk.section("job")["title"] == "Fitting the sizes"
    desk.worker.find()
    assert desk.edit.doc is before
    assert desk.section("body")["height_cm"] == pytest.approx(190)
    reported = desk.section("sizes_preview")
    assert reported["error"] == {"before": 6.2, "after": 5.0}
    assert reported["changes"] == [
        {"part": "Shin", "what": "length", "pair": True, "before": 40.0, "after": 42.0}
    ]
    assert reported["height"] == {"before": pytest.approx(tall), "after": pytest.approx(190)}
    assert reported["unseen"] == ["Neck"]
    before_sizes, sizes = (desk.section(name) for name in ("before", "solids"))
    assert before_sizes["T"].keys() == before_sizes["solids"].keys() == sizes.keys()
    assert before_sizes["solids"]["left_shin"] != sizes["left_shin"]
    desk.do({"do": "look_before", "on": True})
    assert desk.section("before") is None
    assert desk.section("body")["height_cm"] == pytest.approx(tall)
    desk.do({"do": "look_before", "on": False}, {"do": "apply_sizes"})
    assert desk.section("sizes_preview") is None
    assert desk.section("body")["height_cm"] == pytest.approx(190)
    assert desk.section("undo")["undo"] == "fit the sizes"
    assert _turns(before) == _turns(desk.edit.doc)
    desk.do({"do": "undo"})
    assert desk.edit.doc is before


def _turns(doc: Session) -> Any:
    return [keyframe.rotations_wxyz for keyframe in doc.subject.keyframes]


async def test_poses_change_with_the_sizes_only_where_that_is_accepted(desk: Desk) -> None:
    before = desk.edit.doc
    desk.do(SIZES)
    desk.worker.find()
    reported = desk.section("sizes_preview")
    assert (reported["poses"], reported["choice"]) == (False, True)
    assert reported["turns"] == [{"frame": 24, "parts": [{"part": "Left shin", "deg": 3.0}]}]
    desk.do({"do": "preview_poses", "on": True})
    assert desk.section("sizes_preview")["error"]["after"] == 4.1
    desk.do({"do": "apply_sizes"})
    changed = [a != b for a, b in zip(_turns(before), _turns(desk.edit.doc), strict=True)]
    assert changed == [False, True, False, False]


async def test_new_sizes_that_are_discarded_leave_nothing_behind(desk: Desk) -> None:
    before, tall = desk.edit.doc, desk.section("body")["height_cm"]
    desk.do(SIZES)
    desk.worker.find()
    desk.do({"do": "discard_sizes"})
    assert desk.edit.doc is before
    assert desk.section("body")["height_cm"] == pytest.approx(tall)
    assert desk.section("undo")["undo"] is None
    desk.do({"do": "apply_sizes"})
    assert await desk.words() == ["There are no new sizes to answer."]


async def test_edits_wait_for_the_answer_to_new_sizes_and_frames_may_be_stepped(desk: Desk) -> None:
    before = desk.edit.doc
    desk.do(SIZES)
    desk.worker.find()
    for message in (TURN, {"do": "undo"}, {"do": "track"}, FIT):
        desk.do(message)
    assert await desk.words() == 4 * ["Apply or discard the new sizes first."]
    assert desk.edit.doc is before
    desk.do({"do": "go", "frame": 48})
    assert desk.section("view")["frame"] == 48
    assert desk.section("body")["height_cm"] == pytest.approx(190)


async def test_where_no_sizes_fit_better_it_is_said_and_nothing_waits(desk: Desk) -> None:
    doc = desk.edit.doc
    desk.do(SIZES)
    desk.worker.end(SizesFitted(WORDS))
    assert desk.edit.doc is doc
    assert desk.section("sizes_preview") is None
    assert await desk.words() == [WORDS]


async def test_a_pose_that_is_kept_as_a_keyframe_meanwhile_is_fitted_all_the_same(
    desk: Desk,
) -> None:
    desk.do(
        {"do": "go", "frame": 10}, {"do": "root", "x": 0.5}, FIT, {"do": "add_key", "frame": 10}
    )
    desk.worker.find()
    keyframe = next(k for k in desk.edit.doc.subject.keyframes if k.frame == 10)
    assert keyframe.root_m[0] == pytest.approx(0.52)
    assert await desk.words() == []


async def test_a_keyframe_that_is_edited_meanwhile_makes_fitted_sizes_void(desk: Desk) -> None:
    desk.do(SIZES, {"do": "delete_key", "frame": 72})
    desk.worker.find()
    assert desk.edit.keys == (0, 24, 48)
    assert await desk.words() == ["Fit cancelled because the sizes changed."]


async def test_what_cannot_be_fitted_is_refused_in_a_sentence(desk: Desk) -> None:
    desk.do(*({"do": "delete_key", "frame": frame} for frame in desk.edit.keys), FIT, SIZES)
    assert desk.worker.fits == []
    here, sizes = await desk.words()
    assert "Pose the body roughly first" in here
    assert "Needs 2 keyframes that show the body from different sides" in sizes
    await desk.store.close_session()
    desk.do(FIT)
    assert await desk.words() == ["Open a video first."]


async def test_a_session_of_another_keypose_is_not_fitted(path: Path, desk: Desk) -> None:
    folder = path.parent.parent
    other = Store(asyncio.get_running_loop(), lambda *_: None, Library(folder / "more", [folder]))
    await other.open(path)
    reader = Desk(other)
    reader.do(FIT)
    assert reader.worker.fits == []
    assert (await reader.words())[-1].startswith("Read only")
    await other.stop()
