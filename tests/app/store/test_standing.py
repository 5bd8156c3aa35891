"""Standing on the floor, what is up, and drafts found anew: each one step, each said."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from keypose.app.editor.drafted import has_drafts_for_other_up
from keypose.app.jobs.find_up import FindUp, SeenLines
from keypose.app.jobs.learn import LearnDrafts
from keypose.app.jobs.lift import LiftDrafts
from keypose.app.jobs.stand import EachStood, StandOnFloor
from keypose.app.jobs.track import Track
from keypose.app.state.outcomes import FoundUp
from keypose.app.working import queue
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.geometry.up import UpEvidence, combined
from keypose.tracker.operations.solve_space import solved
from keypose.tracker.operations.stand import stand
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import Drafted
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.references import KeypointFile
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import Results
from tests.app.working.test_fitting import Worker
from tests.scenes import StoreDesk, at_desk, sample
from tests.tracker.operations.standing_cases import KEYS, results_of, session_of, walk, wandering
from tests.tracker.operations.standing_cases import lines as upright

LAST = 60
DRAFTED = Drafted(first_frame=0, last_frame=LAST, up_camera=(0.0, -1.0, 0.0))
KEYPOINTS = KeypointFile(file="keypoints-0123456789ab.npz", source="BlazePose", network="0")
SHOWN, UP = walk()
WHOLE = wandering(SHOWN.truth)
MOTION = Trajectory(0, WHOLE.Rs_parent_part[: LAST + 1], WHOLE.ps_camera_root[: LAST + 1])


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", Worker)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """The sample's film with somebody who strides."""
    path = sample(tmp_path)
    film = load_session(path).view.video
    given = session_of(SHOWN, WHOLE, video=film)
    keyframes = tuple(k for k in given.subject.keyframes if k.frame <= LAST)
    save_session(given.changed({"keyframes": keyframes}), path)
    return path


class Desk(StoreDesk):
    """A store with a tab, and what was tracked."""

    def track(self) -> None:
        self.know(results_of(self.doc, MOTION))

    def know(self, results: Results) -> None:
        """These are what the runner has by now."""
        self.store._set(edit=self.edit.with_results(results))

    def draft(self) -> None:
        """Every frame between the keyframes is drafted, for no up, and the second keyframe made of
        a draft; the third one was posed and softened by hand."""
        drafts = tuple(
            Keyframe.of(self.edit.skeleton, MOTION.pose(frame), frame, frame / 30).model_copy(
                update={"drafted": True}
            )
            for frame in range(1, 30)
        )
        keyframes = tuple(
            k.model_copy(update={"soft": True, "drafted": k.frame == KEYS[1]})
            if k.frame in KEYS[1:3]
            else k
            for k in self.doc.subject.keyframes
        )
        made = {"drafts": drafts, "keyframes": keyframes, "keypoints": KEYPOINTS,
                "drafted": Drafted(first_frame=0, last_frame=LAST)}  # fmt: skip
        self.store._set(edit=self.edit.with_doc(self.doc.changed(made)))

    @property
    def order(self) -> Any:
        return Worker.newest.fits[-1]


def standing(doc: Session, at: Desk) -> EachStood:
    """What standing finds, with lines that show what is up."""
    seen = SeenLines(upright(UP).evidence, upright(UP))
    ((body_id, fitting),) = at.order.fittings.items()
    return EachStood({body_id: stand(doc, fitting, seen.evidence)}, {}, seen)


@pytest.fixture
async def at(path: Path) -> AsyncIterator[Desk]:
    async with at_desk(path, Desk) as desk:
        yield desk


async def test_standing_is_one_step_that_undo_takes_back_whole(at: Desk) -> None:
    at.track()
    before = at.doc
    at.do({"do": "stand"})
    assert isinstance(at.order, StandOnFloor)
    Worker.newest.end(standing(before, at))
    doc = at.doc
    assert doc.subject.pins
    assert all(pin.floor for pin in doc.subject.pins)
    assert doc.world.floor_m is not None
    assert {k.soft for k in doc.subject.keyframes} == {"depth"}
    assert at.edit.history.past[-1].label == "stand on the floor"
    assert at.edit.history.total == 1
    at.do({"do": "undo"})
    assert at.doc == before


async def test_what_stands_is_there_when_the_session_is_opened_again_and_so_is_its_undo(
    path: Path,
) -> None:
    async with at_desk(path, Desk) as at:
        at.track()
        before = at.doc
        at.do({"do": "stand"})
        Worker.newest.end(standing(before, at))
        stood = at.doc
    async with at_desk(path, Desk) as at:
        assert at.doc == stood
        assert {k.soft for k in at.doc.subject.keyframes} == {"depth"}
        at.do({"do": "undo"})
        assert {k.soft for k in at.doc.subject.keyframes} == {False}
        assert not at.doc.subject.pins
        at.do({"do": "redo"})
        assert at.doc == stood


async def test_standing_again_changes_no_pin(at: Desk) -> None:
    at.track()
    for _ in range(2):
        at.do({"do": "stand"})
        Worker.newest.end(standing(at.doc, at))
    pins = at.doc.subject.pins
    at.do({"do": "undo"})
    assert at.doc.subject.pins == pins


async def test_soft_keyframes_are_the_same_after_it_so_that_drafts_learn_nothing(at: Desk) -> None:
    at.track()
    at.do({"do": "stand"})
    before = at.doc
    Worker.newest.end(standing(before, at))
    for one, other in zip(before.subject.keyframes, at.doc.subject.keyframes, strict=True):
        assert one.rotations_wxyz is other.rotations_wxyz


async def test_it_is_dropped_where_keyframes_change_meanwhile(at: Desk) -> None:
    at.track()
    at.do({"do": "stand"})
    at.do({"do": "delete_key", "frame": 30})
    assert not at.doc.subject.pins
    assert Worker.newest.cancelled


async def test_how_soles_lie_is_shown_beside_the_floor(at: Desk) -> None:
    at.track()
    assert at.section("floor")["soles"] == ""
    at.do({"do": "stand"})
    Worker.newest.end(standing(at.doc, at))
    results = at.edit.results
    for stretch in results.unsolved(at.doc):
        results = results.with_space(solved(at.doc, stretch))
    at.know(results)
    words = at.section("floor")["soles"]
    assert words.startswith("Soles within ")
    assert float(words.split()[2]) == abs(at.section("floor")["soles_off_cm"]) < 1.5


def lines(up: Array, *others: UpEvidence) -> FoundUp:
    """What was found in the film, with what disagrees."""
    seen = replace(upright(up), ends=np.array([[(9.0, 1.0), (9.0, 90.0)]]))
    return FoundUp(combined((seen.evidence, *others)), seen)


async def test_what_is_up_is_found_or_it_is_said_that_nothing_shows_it(at: Desk) -> None:
    at.do({"do": "find_up"})
    assert isinstance(at.order, FindUp)
    Worker.newest.end(FoundUp(None))
    assert at.doc.world.up_world is None
    assert at.section("up") is None
    at.do({"do": "find_up"})
    Worker.newest.end(lines(UP))
    np.testing.assert_allclose(at.doc.world.up_world, UP, atol=1e-5)
    assert at.section("camera")["up_origin"] == "found"
    assert at.edit.history.past[-1].label == "find the up direction"
    at.do({"do": "undo"})
    assert at.doc.world.up_world is None
    assert at.section("camera")["up_off_deg"] is None


async def test_up_by_a_motion_that_is_no_longer_that_is_not_taken(at: Desk) -> None:
    at.track()
    at.do({"do": "find_up"})
    order, before = at.order, at.doc
    assert isinstance(order, FindUp)
    pins = (Pin(part="left_foot", landmarks=("left_heel",), first_frame=3, last_frame=9),)
    keyframes = before.subject.keyframes[1:]
    for changes in ({"pins": pins}, {"keyframes": keyframes}, {"drafted": DRAFTED}):
        assert order.inputs(before.changed(changes)) != order.inputs(before), changes
    assert order.inputs(before.changed({"title": "Walk"})) == order.inputs(before)


@pytest.mark.parametrize("goes", ["level_camera", "close_up", "undo"])
async def test_the_lines_are_shown_until_the_next_edit_or_until_they_are_read(
    at: Desk, goes: str
) -> None:
    at.do({"do": "find_up"})
    Worker.newest.end(lines(UP))
    assert at.section("up")["lines"] == [[[9.0, 1.0], [9.0, 90.0]]]
    at.do({"do": goes})
    assert at.section("up") is None


@pytest.mark.parametrize(("sigma_deg", "is_sure"), [(0.9, True), (1.0, True), (1.2, False)])
async def test_up_counts_as_sure_only_where_twice_its_deviation_is_within_two_degrees(
    at: Desk, sigma_deg: float, is_sure: bool
) -> None:
    assert not at.section("camera")["up_is_sure"]
    at.do({"do": "find_up"})
    evidence = UpEvidence.of(UP, np.radians(sigma_deg), "lines")
    Worker.newest.end(FoundUp(combined((evidence,))))
    assert at.section("camera")["up_off_deg"] == np.ceil(2 * sigma_deg)
    assert at.section("camera")["up_is_sure"] == is_sure
    at.do({"do": "level_camera"})
    assert at.section("camera")["up_is_sure"]


async def test_where_ways_disagree_either_can_be_taken_in_one_step(at: Desk) -> None:
    stands = exp_rotation(np.array([np.radians(12.0), 0.0, 0.0])) @ UP
    at.do({"do": "find_up"})
    Worker.newest.end(lines(UP, UpEvidence.of(stands, np.radians(1.5), "person")))
    asked = at.section("up")
    assert "Upright lines say the camera looks down by 10° ± 1°, how the " in asked["words"]
    assert [each["source"] for each in asked["choices"]] == ["lines", "person"]
    before = at.doc
    taken = {name: asked["choices"][1][name] for name in ("up", "sigma_deg", "source")}
    at.do({"do": "take_up", **taken})
    np.testing.assert_allclose(at.doc.world.up_world, stands, atol=1e-5)
    assert at.doc.world.up_from == ("person", "set")
    assert at.doc.has_up_of_hand
    assert at.section("up") is None
    assert at.section("camera")["up_off_deg"] == 3
    assert not at.section("camera")["up_is_sure"]
    at.do({"do": "undo"})
    assert at.doc == before


@pytest.mark.parametrize(("is_pinned", "origin"), [(True, "feet"), (False, "drawn")])
async def test_up_by_feet_that_a_person_levelled_once_is_sure_and_theirs_as_long_as_they_are_pinned(
    at: Desk, is_pinned: bool, origin: str
) -> None:
    pin = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=3, last_frame=9)
    older = at.doc.changed(
        {"up_world": (0.0, -1.0, 0.0), "up_from": ("feet", "set"), "pins": (pin,) * is_pinned}
    )
    at.store._set(edit=at.edit.with_doc(older))
    shown = at.section("camera")
    assert (shown["up_origin"], shown["up_off_deg"], shown["up_is_sure"]) == (origin, None, True)


async def test_drafts_for_another_up_say_so_and_are_found_anew_with_what_nobody_posed(
    at: Desk,
) -> None:
    at.track()
    at.draft()
    at.track()
    assert at.section("camera")["lifts"] is None
    at.do({"do": "level_camera"})
    assert at.section("camera")["lifts"] == {"drafts": 29, "keyframes": 1, "segments": 2}
    at.do({"do": "lift"})
    assert isinstance(at.order, LiftDrafts)
    assert at.order.frames == frozenset((*range(1, 30), KEYS[1]))
    before = at.doc
    anew = {frame: WHOLE.pose(frame + 1) for frame in at.order.frames}
    Worker.newest.end(anew)
    both = zip(at.doc.subject.keyframes, before.subject.keyframes, strict=True)
    moved = {now.frame for now, was in both if now.root_m != was.root_m}
    assert moved == {KEYS[1]}
    assert all(draft.drafted for draft in at.doc.subject.drafts)
    assert at.section("camera")["lifts"] is None
    assert at.edit.history.past[-1].label == "draft anew"
    assert not Worker.newest.of(LearnDrafts)
    tracking = Worker.newest.of(Track)[-1]
    assert tracking.spans == [(0, 30), (30, 60)]


@pytest.mark.parametrize(("turned_deg", "is_other"), [(0.0, False), (1.5, False), (4.0, True)])
async def test_up_that_standing_turned_a_little_is_no_other_up_to_drafts(
    at: Desk, turned_deg: float, is_other: bool
) -> None:
    at.track()
    at.draft()
    drafted = at.doc.subject.drafted
    assert drafted is not None
    turned = np.radians(turned_deg)
    ups = {
        "drafted": drafted.model_copy(update={"up_camera": (0.0, -1.0, 0.0)}),
        "up_world": (0.0, float(-np.cos(turned)), float(np.sin(turned))),
    }
    assert has_drafts_for_other_up(at.doc.changed(ups)) == is_other


NOTHING_TO_LIFT: dict[str, dict[str, Any]] = {
    "all is posed": {"drafts": ()},
    "the keypoints were imported": {"keypoints": KEYPOINTS.model_copy(update={"network": ""})},
    "the keypoints are gone": {"keypoints": None},
}


@pytest.mark.parametrize("case", NOTHING_TO_LIFT)
async def test_what_cannot_be_found_anew_is_not_offered(at: Desk, case: str) -> None:
    at.draft()
    at.do({"do": "exact_key", "frame": KEYS[1]})
    at.do({"do": "level_camera"})
    assert at.section("camera")["lifts"] is not None
    at.store._set(edit=at.edit.with_doc(at.doc.changed(NOTHING_TO_LIFT[case])))
    assert at.section("camera")["lifts"] is None
    at.do({"do": "lift"})
    assert not Worker.newest.fits


async def test_drafts_that_are_as_up_has_them_are_not_found_anew(at: Desk) -> None:
    at.draft()
    at.do({"do": "lift"})
    assert not Worker.newest.fits


def raised(doc: Session, by_m: float) -> tuple[Session, Trajectory]:
    """A second body, posed and tracked as the first, 60 cm aside and so much higher."""
    shift = np.array([0.6, -by_m, 0.0])
    motion = Trajectory(0, MOTION.Rs_parent_part, MOTION.ps_camera_root + shift)
    skeleton = Skeleton.of(doc.subject.body)
    keyframes = tuple(
        Keyframe.of(skeleton, motion.pose(k.frame), k.frame, k.time_s)
        for k in doc.subject.keyframes
    )
    second = doc.subject.model_copy(update={"id": "body-2", "keyframes": keyframes})
    return doc.model_copy(update={"bodies": (*doc.bodies, second)}), motion


async def test_all_bodies_stand_on_one_floor_in_one_step(
    at: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    doc, motion = raised(at.doc, 0.04)
    at.store._set(edit=at.edit.with_doc(doc))
    results = results_of(doc, MOTION)
    for each in results_of(doc.about("body-2"), motion).by_key.values():
        results = results.with_result(each)
    at.know(results)
    at.do({"do": "stand"})
    seen = SeenLines(upright(UP).evidence, upright(UP))
    monkeypatch.setattr("keypose.app.jobs.stand.seen_lines", lambda *_: seen)
    nothing = SimpleNamespace(video=lambda *_: None)
    result = at.order.work(doc, SimpleNamespace(cache=nothing, cancelled=lambda: False))
    assert list(result.standing) == ["body", "body-2"]
    Worker.newest.end(result)
    stood = at.doc
    assert all(body.pins for body in stood.bodies)
    assert stood.world == result.standing["body"].session.world
    assert at.edit.history.total == 1
    at.do({"do": "undo"})
    assert at.doc == doc
