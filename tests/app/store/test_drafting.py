"""Drafting a clip from the page: one job, one step of undo, and frames to confirm."""

from __future__ import annotations

import shutil
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.editor.drafted import flipped_drafts, proposed_frames
from keypose.app.jobs.draft import DraftClip, Drafted, progress_of
from keypose.app.jobs.job import Progress
from keypose.app.store import store
from keypose.app.working import queue
from keypose.tracker.body.body import preset
from keypose.tracker.body.modify import with_height
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass, interpolate
from keypose.tracker.fitting.draft import ClipDraft, DraftProgress, Proposal
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import FlippedDrafts, Reason
from keypose.tracker.session.verdict import GOOD
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import Results, segment_keys
from keypose.tracker.storage.sidecars import load_keypoints
from keypose.tracker.tracking.result import SegmentResult
from tests.app.working.test_fitting import Worker
from tests.scenes import SAMPLES, StoreDesk, at_desk, sample

BOX = [100.0, 100.0, 300.0, 400.0]
DRAFT = {"do": "draft", "frame": 10, "box": BOX}
BODY = preset("adult_male")
"""That of the session, without keyframes."""


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", Worker)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = sample(tmp_path)
    blank = {"keyframes": (), "drafts": (), "results": None, "body": BODY}
    save_session(load_session(path).changed(blank), path)
    return path


class Desk(StoreDesk):
    """A store with a tab and the worker's side of its jobs."""

    @property
    def order(self) -> DraftClip:
        order = Worker.newest.fits[-1]
        assert isinstance(order, DraftClip)
        return order

    def find(
        self,
        *frames: int,
        detected: tuple[int, int] | None = None,
        flipped: tuple[FlippedDrafts, ...] = (),
        last: Reason = "flip",
    ) -> None:
        """The draft ends with poses at these frames. detected: in those alone, once cancelled.
        flipped: those of which a limb is wrong.  last: why the last of them is to be confirmed."""
        pose = Pose.rest(Skeleton.of(BODY), (0.0, 0.0, 4.0))
        rows = np.full((5, len(JOINTS), 2), 7.0)
        keypoints = Keypoints(0, JOINTS, rows, np.ones(rows.shape[:2]))
        proposals = (Proposal(frames[0], "start"), Proposal(frames[-1], last, ("left_thigh",)))
        judged: Any = None
        draft = ClipDraft(BODY, dict.fromkeys(frames, pose), keypoints, proposals, judged, flipped)
        Worker.newest.end([Drafted(draft, "abc", detected)])

    def move_drafts(self, by_m: float) -> None:
        """All drafts to the right."""
        edit = self.edit
        moved = tuple(
            d.model_copy(update={"root_m": (d.root_m[0] + by_m, *d.root_m[1:])})
            for d in edit.doc.subject.drafts
        )
        self.store._set(edit=edit.with_doc(edit.doc.changed({"drafts": moved})))

    def track(self, first: int, last: int) -> None:
        """The segment between two keyframes is tracked."""
        edit = self.edit
        poses = {k.frame: k.pose(edit.skeleton) for k in edit.doc.subject.keyframes}
        key = segment_keys(edit.doc)[first, last]
        motion = interpolate(poses[first], poses[last], first, last)
        track = replace(SegmentResult.on_the_way(Pass("pass", motion, 1.0), key), verdict=GOOD)
        self.store._set(edit=edit.with_results(Results({key: track})))


@pytest.fixture
async def desk(path: Path) -> AsyncIterator[Desk]:
    async with at_desk(path, Desk) as made:
        yield made


async def test_a_draft_is_one_step_and_undo_is_exact(desk: Desk) -> None:
    before = desk.doc
    desk.do(DRAFT)
    assert desk.order.frames == (0, before.view.video.frame_count - 1)
    assert desk.order.proportions
    desk.find(3, 4, 5)
    assert [draft.frame for draft in desk.doc.subject.drafts] == [3, 4, 5]
    edit = desk.store.app_state.edit
    assert edit is not None
    assert edit.history.past[-1].label == "draft"
    desk.do({"do": "undo"})
    assert desk.doc == before
    assert desk.section("draft") is None
    desk.do({"do": "redo"})
    assert [draft.frame for draft in desk.doc.subject.drafts] == [3, 4, 5]


async def test_the_keypoints_of_a_draft_lie_beside_the_session(path: Path, desk: Desk) -> None:
    desk.do(DRAFT)
    desk.find(3)
    reference = desk.doc.view.keypoints
    assert reference is not None
    assert (reference.network, reference.seeds) == ("abc", (10,))
    assert load_keypoints(path.parent / reference.file).uv.max() == 7.0


async def test_a_film_just_opened_is_drafted_before_its_folder_is_there(tmp_path: Path) -> None:
    film = tmp_path / "films" / "person.mp4"
    film.parent.mkdir()
    shutil.copy(SAMPLES / "person" / "person.mp4", film)
    async with at_desk(film, Desk) as desk:
        assert not [place for place in film.parent.iterdir() if place.is_dir()]
        desk.do(DRAFT)
        desk.find(3, 4)
        assert [draft.frame for draft in desk.doc.subject.drafts] == [3, 4]
    (session,) = film.parent.glob("*/session.json")
    assert load_session(session).view.keypoints is not None


async def test_a_draft_that_is_wrong_becomes_a_keyframe_only_once_it_was_posed(desk: Desk) -> None:
    desk.do(DRAFT)
    wrong = FlippedDrafts(first_frame=3, last_frame=5, parts=("left_thigh",))
    desk.find(3, 4, 5, 9, flipped=(wrong,))
    assert proposed_frames(desk.doc) == (9,)
    assert flipped_drafts(desk.doc) == (wrong,)
    desk.do({"do": "go", "frame": 4}, {"do": "add_key", "frame": 4})
    assert desk.doc.subject.keyframes == ()
    desk.tab.acknowledge(10**9)
    assert any("left thigh, frames 3–5" in m.get("words", "") for m in await desk.tab.next())
    desk.do({"do": "angles", "part": "left_thigh", "x": -20}, {"do": "add_key", "frame": 4})
    assert [keyframe.frame for keyframe in desk.doc.subject.keyframes] == [4]
    assert [(r.first_frame, r.last_frame) for r in flipped_drafts(desk.doc)] == [(3, 3), (5, 5)]


async def test_frames_to_confirm_are_shown_until_they_are_keyframes(desk: Desk) -> None:
    assert desk.section("draft") is None
    desk.do({**DRAFT, "first": 2, "last": 12})
    desk.find(3, 8)
    shown = desk.section("draft")
    assert shown["latest"]
    assert shown["missing"] == [[2, 2], [4, 7], [9, 12]]
    assert (shown["first"], shown["last"], shown["drafted"]) == (2, 12, 2)
    assert shown["proposals"] == [
        {"frame": 3, "reason": "start", "parts": []},
        {"frame": 8, "reason": "flip", "parts": ["Left thigh"]},
    ]
    desk.do({"do": "go", "frame": 3}, {"do": "add_key", "frame": 3})
    assert [proposal["frame"] for proposal in desk.section("draft")["proposals"]] == [8]
    assert not desk.section("draft")["latest"]
    desk.do({"do": "undo"})
    assert desk.section("draft")["latest"]


async def test_a_draft_that_nobody_can_judge_is_proposed_no_more(desk: Desk) -> None:
    desk.do({**DRAFT, "first": 2, "last": 12})
    desk.find(3, 8)
    desk.do({"do": "cannot_tell", "frame": 3, "part": None})
    assert [proposal["frame"] for proposal in desk.section("draft")["proposals"]] == [8]
    desk.do({"do": "undo"})
    assert [proposal["frame"] for proposal in desk.section("draft")["proposals"]] == [3, 8]


@pytest.mark.parametrize(("moved_m", "asked"), [(0.05, [8]), (0.5, [3, 8])])
async def test_a_draft_is_asked_for_again_only_once_it_is_another_one(
    desk: Desk, moved_m: float, asked: list[int]
) -> None:
    desk.do({**DRAFT, "first": 2, "last": 12})
    desk.find(3, 8)
    desk.do({"do": "cannot_tell", "frame": 3, "part": None})
    desk.move_drafts(moved_m)
    assert [proposal["frame"] for proposal in desk.section("draft")["proposals"]] == asked


async def test_what_a_draft_found_is_there_after_a_restart(path: Path) -> None:
    found: list[Any] = []
    async with at_desk(path, Desk) as desk:
        desk.do({**DRAFT, "last": 12})
        desk.find(3, 8)
        found.append(desk.section("draft"))
    async with at_desk(path, Desk) as desk:
        assert desk.section("draft") == {**found[0], "latest": False}
        desk.do({"do": "undo"})  # of another day
        assert desk.section("draft") is None


async def test_drafting_some_frames_again_keeps_what_was_found_in_the_others(desk: Desk) -> None:
    desk.do({**DRAFT, "last": 12})
    desk.find(8, 9, 12)
    desk.do({"do": "draft", "frame": 3, "box": BOX, "last": 7})
    desk.find(2, 3, 4, 5, 6, 7)
    shown = desk.section("draft")
    assert shown["missing"] == [[0, 1], [10, 11]]
    assert (shown["first"], shown["last"], shown["drafted"]) == (0, 7, 6)
    assert [place["frame"] for place in shown["proposals"]] == [2, 7, 8, 12]
    assert desk.doc.view.keypoints is not None
    assert desk.doc.view.keypoints.seeds == (3, 10)
    desk.do({"do": "go", "frame": 10}, {"do": "add_key", "frame": 10})
    assert desk.section("draft")["missing"] == [[0, 1], [11, 11]]  # somebody has posed it


async def test_a_draft_is_of_what_was_known_to_be_up_when_it_began(desk: Desk) -> None:
    desk.do({"do": "draft", "frame": 3, "box": BOX, "last": 7})
    desk.do({"do": "level_camera"})
    desk.find(2, 3, 4)
    assert desk.doc.subject.drafted is not None
    assert desk.doc.subject.drafted.up_camera is None
    assert desk.section("camera")["lifts"]["drafts"] == 3
    desk.do({**DRAFT, "first": 8})
    desk.find(9, 10)
    assert desk.section("camera")["lifts"]["drafts"] == 5
    desk.do(DRAFT)
    desk.find(3, 4)
    assert desk.section("camera")["lifts"] is None


async def test_frames_that_are_tracked_lack_no_draft_and_show_what_was_tracked(desk: Desk) -> None:
    desk.do({"do": "add_key", "frame": 0}, {"do": "add_key", "frame": 6})
    desk.do({**DRAFT, "last": 12})
    desk.find(3, 4, 8, 12)
    desk.track(0, 6)
    shown = desk.section("draft")
    assert shown["missing"] == [[7, 7], [9, 11]]
    assert (shown["drafted"], shown["behind"]) == (4, 2)
    assert [place["frame"] for place in shown["proposals"]] == [12]  # and not 3
    assert [place["frame"] for place in desk.section("review")["places"]] == [12]
    assert desk.section("keys")["drafts"] == [8, 12]
    desk.do({"do": "delete_key", "frame": 6})
    assert desk.section("draft")["missing"] == [[1, 2], [5, 7], [9, 11]]
    assert desk.section("draft")["behind"] == 0
    assert desk.section("keys")["drafts"] == [3, 4, 8, 12]


async def test_the_progress_of_a_draft_is_shown_and_rises(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(store, "SECONDS_BETWEEN_PROGRESS", 0.0)
    async with at_desk(path, Desk) as desk:
        desk.do(DRAFT)
        shown = []
        for stage, done in (("keypoints", 5), ("keypoints", 20), ("poses", 0), ("poses", 20)):
            share, words = progress_of(DraftProgress(stage, done, 20))  # type: ignore[arg-type]
            Worker.newest.report(Progress(Worker.newest.number, share, words))
            job = desk.store.app_state.job
            assert job.kind == "draft"
            shown.append(job.percent)
        assert shown == sorted(shown)
        assert shown[-1] == pytest.approx(100)


async def test_a_draft_that_is_cancelled_or_fails_changes_nothing(desk: Desk) -> None:
    before = desk.doc
    desk.do(DRAFT)
    desk.do({"do": "cancel"})
    assert Worker.newest.cancelled
    desk.do(DRAFT)
    Worker.newest.fail("No person was found at frame 10.")
    assert desk.doc is before
    assert desk.store.app_state.job.state == "idle"


async def test_what_a_cancelled_draft_has_found_is_one_step_and_the_rest_is_drafted_later(
    desk: Desk,
) -> None:
    count = desk.doc.view.video.frame_count
    desk.do({**DRAFT, "first": 2}, {"do": "cancel"})
    desk.find(3, 4, 5, detected=(2, 20))
    shown = desk.section("draft")
    assert shown["rest"] == [[21, count - 1]]
    assert (shown["drafted"], shown["missing"][0]) == (3, [2, 2])
    assert shown["missing"][-1] == [6, 20]
    desk.do({"do": "draft_rest"})
    assert (desk.order.frame, desk.order.box) == (10, tuple(BOX))
    assert (desk.order.frames, desk.order.proportions) == ((10, count - 1), False)
    before = {draft.frame: draft for draft in desk.doc.subject.drafts}
    desk.find(*range(10, 30), detected=(10, 40))
    assert [draft.frame for draft in desk.doc.subject.drafts] == [3, 4, 5, *range(21, 30)]
    assert all(
        draft == before[draft.frame] for draft in desk.doc.subject.drafts if draft.frame < 21
    )
    assert desk.section("draft")["rest"] == [[41, count - 1]]
    desk.do({"do": "draft_rest"})
    desk.find(*range(10, count))
    assert desk.section("draft")["rest"] == []
    desk.do({"do": "draft_rest"})
    assert desk.section("draft")["rest"] == []
    desk.do({"do": "undo"}, {"do": "undo"}, {"do": "undo"})
    assert desk.section("draft") is None


async def test_a_draft_in_two_goes_has_one_first_and_one_last_frame(desk: Desk) -> None:
    count = desk.doc.view.video.frame_count
    desk.do(DRAFT, {"do": "cancel"})
    desk.find(*range(21), detected=(0, 20), last="end")
    desk.do({"do": "draft_rest"})
    desk.find(*range(10, count), last="end")
    places = [(each["frame"], each["reason"]) for each in desk.section("draft")["proposals"]]
    assert places == [(0, "start"), (count - 1, "end")]


async def test_a_draft_of_other_frames_leaves_what_remains(desk: Desk) -> None:
    desk.do(DRAFT)
    desk.find(3, detected=(0, 20))
    desk.do({"do": "draft", "frame": 30, "box": BOX, "first": 21, "last": 40})
    desk.find(30)
    assert desk.section("draft")["rest"][0][0] == 41


async def test_a_draft_of_a_body_that_was_changed_meanwhile_is_left(desk: Desk) -> None:
    desk.do(DRAFT, {"do": "height", "cm": 190})
    changed = desk.doc
    desk.find(3)
    assert desk.doc is changed


async def test_a_height_that_is_known_stays_and_the_proportions_are_still_found(desk: Desk) -> None:
    desk.do({"do": "height", "cm": 171.5}, {"do": "height", "cm": 190}, DRAFT)
    sent = Session.model_validate_json(desk.order.session)
    assert sent.subject.body == with_height(BODY, 1.9), "what --height writes"
    assert desk.order.proportions
    desk.do({"do": "joint", "part": "head", "y": 30}, DRAFT)
    assert not desk.order.proportions  # somebody sized it


@pytest.mark.parametrize(
    "wrong",
    [
        {"box": [5000, 100, 5100, 200]},
        {"box": [100, 100, 100, 100]},
        {"frame": 99999},
        {"frame": 10, "first": 20},
        {"frame": 10, "last": 5},
        {"frame": 10, "last": 99999},
    ],
)
async def test_what_cannot_be_drafted_is_refused_before_the_work(
    desk: Desk, wrong: dict[str, Any]
) -> None:
    desk.do({**DRAFT, **wrong})
    assert not Worker.newest.fits


async def test_keyframes_and_drafts_of_other_frames_stay(desk: Desk) -> None:
    desk.do({**DRAFT, "last": 12})
    desk.find(3, 8)
    desk.do({"do": "go", "frame": 3}, {"do": "add_key", "frame": 3})
    (keyframe,) = desk.doc.subject.keyframes
    desk.do({"do": "draft", "frame": 2, "box": BOX, "last": 6})
    assert not desk.order.proportions  # a keyframe is posed with this body
    desk.find(2, 3, 4)
    assert desk.doc.subject.keyframes == (keyframe,)
    assert [draft.frame for draft in desk.doc.subject.drafts] == [2, 4, 8]
