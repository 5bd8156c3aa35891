"""A reduction at the page: previewed, asked again, applied as one step, or left without a trace."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest

from keypose.app.editor.shown import shown_pose
from keypose.app.jobs.job import Finished, Progress, Report
from keypose.app.jobs.reduce import ReduceMotion
from keypose.app.working import queue
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.reduction.result import Tolerance
from keypose.tracker.session import Keyframe
from keypose.tracker.storage.files import load_session, save_session
from tests.app.jobs.job_cases import NUMBER, reported
from tests.app.working.test_fitting import Desk, Worker, desk
from tests.page.test_page_shapes import declared, differences
from tests.scenes import at_desk, sample

__all__ = ["desk"]
REDUCE = {"do": "reduce", "cm": 6.0}


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", Worker)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """The sample with its true motion drafted between the keyframes."""
    path = sample(tmp_path)
    session, truth = load_session(path), np.load(path.with_name("truth.npz"))
    skeleton, keyed = (
        Skeleton.of(session.subject.body),
        {k.frame for k in session.subject.keyframes},
    )
    poses = zip(truth["Rs_parent_part"], truth["ps_camera_root"], strict=True)
    drafts = [Keyframe.of(skeleton, Pose(*pose), n, n / 30) for n, pose in enumerate(poses)]
    found = [d.model_copy(update={"drafted": True}) for d in drafts if d.frame not in keyed]
    save_session(session.changed({"drafts": tuple(found)}), path)
    return path


def worked(desk: Desk, cancelled: bool = False) -> list[Report]:
    """The newest order done as the worker process does it; what that reports."""
    stop = Event()
    if cancelled:
        stop.set()
    return reported(desk.worker.fits[-1], None, stop)


def answered(desk: Desk) -> Any:
    """The newest order is done, and what the page is told then."""
    for report in worked(desk):
        desk.worker.report(replace(report, job=desk.worker.number))
    return desk.section("reduction")


async def test_its_keyframes_are_shown_applied_as_one_step_and_undone(path: Path) -> None:
    async with at_desk(path, Desk) as desk:
        before = desk.edit.doc
        desk.do(REDUCE)
        shown = desk.section("reduction")
        assert (shown["busy"], shown["frames"], shown["source"]) == (True, [], "drafts")
        desk.do({"do": "apply_reduction"})
        assert await desk.words() == ["The keyframes are not known yet. Wait a moment."]
        shown = answered(desk)
        assert shown["frames"][0] == 0
        assert shown["kept"] == 4
        assert 0 < shown["off_cm"] <= 6
        assert list(differences(shown, "Reduction", declared(), "reduction")) == []
        assert desk.edit.doc is before
        desk.do({**REDUCE, "cm": 30.0, "stroke": "a"})
        assert desk.section("reduction")["frames"] == shown["frames"]  # until the others are known
        coarse = answered(desk)
        assert len(coarse["frames"]) < len(shown["frames"])
        desk.do({"do": "apply_reduction"})
        assert desk.section("reduction") is None
        assert desk.section("keys")["frames"] == coarse["frames"]
        assert desk.section("keys")["drafts"] == []
        assert desk.section("undo")["undo"] == "reduce to keyframes"
        assert desk.edit.own_motion is not None
        desk.do({"do": "undo"})
        assert desk.edit.doc is before
        assert desk.edit.own_motion is None
        desk.do({"do": "redo"})
        assert desk.edit.own_motion is not None
    assert load_session(path).subject.first_motion is not None


async def test_one_keyframe_in_so_many_frames_leaves_the_motion_as_it_is_between(
    desk: Desk,
) -> None:
    before = [shown_pose(desk.edit, frame).pose for frame in range(73)]
    desk.do({"do": "reduce", "every": 36, "replacing": True})
    shown = answered(desk)
    assert (shown["goal"], shown["cm"], shown["every"]) == (36, None, 36.0)
    assert len(shown["frames"]) == 3
    assert shown["off_cm"] > 2  # were they interpolated alone
    assert shown["off_px"] is None
    assert list(differences(shown, "Reduction", declared(), "reduction")) == []
    desk.do({"do": "apply_reduction"})
    for frame, pose in enumerate(before):
        now = shown_pose(desk.edit, frame).pose
        np.testing.assert_allclose(now.Rs_parent_part, pose.Rs_parent_part, atol=1e-9)
        np.testing.assert_allclose(now.p_camera_root, pose.p_camera_root, atol=1e-9)


async def test_edits_wait_for_the_answer_and_what_is_discarded_leaves_nothing_behind(
    path: Path, desk: Desk
) -> None:
    before = desk.edit.doc
    desk.do(REDUCE)
    answered(desk)
    desk.do({"do": "angles", "part": "head", "x": 9}, {"do": "undo"}, {"do": "go", "frame": 7})
    assert await desk.words() == ["Apply or discard the keyframes of the reduction first."] * 2
    assert desk.edit.frame == 7
    desk.do({"do": "discard_reduction"})
    assert desk.section("reduction") is None
    assert desk.edit.doc is before
    assert not list(path.parent.glob("first-*"))
    desk.do({"do": "discard_reduction"})
    assert await desk.words() == ["There are no keyframes of a reduction to answer."]


async def test_a_reduction_that_is_cancelled_or_fails_is_not_waited_for(desk: Desk) -> None:
    desk.do(REDUCE)
    assert worked(desk, cancelled=True) == [Finished(NUMBER, cancelled=True)]
    desk.do({"do": "cancel"})
    assert desk.section("reduction") is None
    desk.do(REDUCE)
    desk.worker.report(Progress(desk.worker.number, 30 / 73))
    assert desk.store._queue.state.percent == pytest.approx(41, abs=1)  # told now and then
    desk.worker.fail("It failed.")
    assert desk.section("reduction") is None
    assert await desk.words() == ["It failed."]


async def test_what_cannot_be_reduced_is_refused_and_what_was_shown_stays(desk: Desk) -> None:
    desk.do({"do": "reduce"}, {**REDUCE, "every": 9})
    assert all("a tolerance is needed" in words for words in await desk.words())
    desk.do({"do": "reduce"}, {**REDUCE, "first": 70, "last": 99})
    words = await desk.words()
    assert "a tolerance is needed" in words[0]
    assert "The video has frames 0 to 72" in words[1]
    assert desk.section("reduction") is None
    desk.do(REDUCE)
    shown = answered(desk)
    desk.do({**REDUCE, "limbs": ["waist"]})
    assert "Press K to key all of it" in (await desk.words())[0]
    assert desk.section("reduction") == shown


async def test_the_order_holds_the_motion_and_the_reports_its_progress(desk: Desk) -> None:
    desk.do({**REDUCE, "px": 9.0, "first": 10, "last": 50})
    (order,) = desk.worker.fits
    assert isinstance(order, ReduceMotion)
    assert (order.found.motion.first_frame, order.found.motion.last_frame) == (10, 50)
    assert isinstance(order.goal, Tolerance)
    assert (order.goal.metres, order.goal.pixels) == (0.06, 9.0)
    *progress, last = worked(desk)
    assert isinstance(last, Finished)
    assert {10, 24, 48, 50} <= set(last.result.frames)
    counts = [report.share for report in progress if isinstance(report, Progress)]
    assert counts == sorted(counts)
    steps = np.array(counts) * 41  # of as many frames
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    assert 0 < steps[0] < steps[-1] <= 41
    assert len(set(counts)) == len(counts)


BODY_EDITS = {
    "movable shoulders": {"do": "clavicles", "on": True},
    "a part added": {"do": "add_part", "parent": "head", "name": "hat"},
    "a part deleted": {"do": "delete_part", "part": "left_hand"},
    "a part renamed": {"do": "rename_part", "part": "head", "name": "skull"},
    "the first part renamed": {"do": "rename_part", "part": "waist", "name": "hips"},
    "another body": {"do": "preset", "name": "dog"},
    "no body left": {"do": "preset", "name": "box"},
}


@pytest.mark.parametrize("change", BODY_EDITS)
async def test_a_motion_that_was_reduced_follows_the_body_and_undo_leads_back(
    desk: Desk, change: str
) -> None:
    desk.do({"do": "reduce", "every": 36, "replacing": True})
    answered(desk)
    desk.do({"do": "apply_reduction"}, {"do": "go", "frame": 20}, {"do": "select", "part": "head"})
    before = shown_pose(desk.edit)
    desk.do({"do": "delete_key", "frame": 99}, BODY_EDITS[change])
    all_sections_made(desk)
    now = shown_pose(desk.edit)
    assert now.source == "between"
    np.testing.assert_allclose(now.pose.p_camera_root, before.pose.p_camera_root, atol=1e-9)
    assert len(now.pose.Rs_parent_part) == len(desk.edit.doc.subject.body.parts)
    desk.do({"do": "undo"})
    all_sections_made(desk)
    np.testing.assert_array_equal(
        shown_pose(desk.edit).pose.Rs_parent_part, before.pose.Rs_parent_part
    )
    desk.do({"do": "redo"}, {"do": "track", "what": "all"}, REDUCE)
    answered(desk)
    desk.do({"do": "apply_reduction"})
    all_sections_made(desk)


def all_sections_made(desk: Desk) -> None:
    """Every part of the page can be sent."""
    desk.store._publish()
    assert desk.store._sections.failed == {}
