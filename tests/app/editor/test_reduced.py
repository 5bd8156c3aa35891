"""A session's motion reduced: what a person posed stays, and little else changes."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from keypose.app.document.open import with_own_motion
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.motion import motion_between
from keypose.app.editor.reduced import Reducible, reduced_session, reducible, with_reduction
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate, joined
from keypose.tracker.errors import KeyposeError
from keypose.tracker.reduction.reduce import reduce_motion
from keypose.tracker.reduction.result import Reduction, Tolerance
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.storage.fingerprints import segment_keys
from keypose.tracker.storage.sidecars import (
    load_first_motion,
    save_own_motion,
)
from tests.app import surface_cases
from tests.app.editor.desk import SAMPLE, after, desk

TRUTH = np.load(SAMPLE.with_name("truth.npz"))
MOTION = Trajectory(0, TRUTH["Rs_parent_part"], TRUTH["ps_camera_root"])
LAST = MOTION.last_frame


def drafted(state: EditorState, frames: range = range(LAST + 1)) -> EditorState:
    """The sample with the true motion as drafts that were found in the film."""
    skeleton, keyed = state.skeleton, set(state.keys)
    drafts = tuple(
        Keyframe.of(skeleton, MOTION.pose(n), n, n / 30).model_copy(update={"drafted": True})
        for n in frames
        if n not in keyed
    )
    return state.with_doc(state.doc.changed({"drafts": drafts}))


def reduced(doc: Session, found: Reducible, metres: float = 0.05) -> Reduction:
    skeleton = Skeleton.of(doc.subject.body)
    given = found.motion, Tolerance(metres), found.required, found.parts
    return reduce_motion(skeleton, doc.view.camera, *given)


def shown(state: EditorState) -> Trajectory:
    """What the page shows of all frames."""
    poses = [shown_pose(state, frame).pose for frame in range(LAST + 1)]
    Rs = np.stack([pose.Rs_parent_part for pose in poses])
    return Trajectory(0, Rs, np.stack([pose.p_camera_root for pose in poses]))


def interpolated(doc: Session) -> Trajectory:
    """What is shown of a motion that is not tracked."""
    skeleton = Skeleton.of(doc.subject.body)
    poses = [(k.frame, k.pose(skeleton)) for k in doc.subject.keyframes]
    return joined([interpolate(p, q, a, b) for (a, p), (b, q) in pairwise(poses)])


def test_drafts_become_keyframes_from_which_interpolation_is_within_the_tolerance() -> None:
    state = drafted(desk())
    found = reducible(state.doc, {}, None)
    assert (found.source, found.required) == ("drafts", (0, 24, 48, 72))
    frames = reduced(state.doc, found).frames
    doc = reduced_session(state.doc, found, frames, state.times_s, None)
    assert tuple(k.frame for k in doc.subject.keyframes) == frames
    assert doc.subject.drafts == ()
    assert [k.time_s for k in doc.subject.keyframes] == [state.times_s[n] for n in frames]
    skeleton = state.skeleton
    away = interpolated(doc).joints(skeleton) - found.motion.joints(skeleton)
    assert np.linalg.norm(away, axis=-1).max() <= 0.05 + 1e-9


def test_keyframes_that_a_person_posed_stay_unless_they_may_go() -> None:
    state = drafted(
        after(desk(), {"do": "go", "frame": 24}, {"do": "angles", "part": "head", "y": 60})
    )
    found = reducible(state.doc, {}, None)
    doc = reduced_session(state.doc, found, reduced(state.doc, found).frames, state.times_s, None)
    before = {k.frame: k for k in state.doc.subject.keyframes}
    assert {k.frame: k for k in doc.subject.keyframes if k.frame in before} == before

    found = reducible(state.doc, {}, None, replacing=True)
    assert found.required == ()
    few = reduced(state.doc, found, 1.0).frames
    doc = reduced_session(state.doc, found, few, state.times_s, None, replacing=True)
    assert [k.frame for k in doc.subject.keyframes] == [0, 72]


def test_a_draft_that_a_person_posed_stays_a_draft() -> None:
    state = after(
        drafted(desk()), {"do": "go", "frame": 11}, {"do": "angles", "part": "head", "y": 9}
    )
    found = reducible(state.doc, {}, None)
    doc = reduced_session(state.doc, found, reduced(state.doc, found).frames, state.times_s, None)
    assert [draft.frame for draft in doc.subject.drafts] == [11]


def test_a_reduction_is_one_step_of_undo(tmp_path: Path) -> None:
    state = drafted(desk())
    found = reducible(state.doc, {}, None)
    frames = reduced(state.doc, found).frames
    own = save_own_motion(state.doc, tmp_path / "session.json", found.motion)
    done = with_reduction(state, found, frames, own, replacing=False)
    assert done.history.past[-1].label == "reduce to keyframes"
    assert after(done, {"do": "undo"}).doc == state.doc


def test_a_corrected_keyframe_moves_its_two_stretches_and_nothing_else(tmp_path: Path) -> None:
    state = drafted(desk())
    found = reducible(state.doc, {}, None)
    frames = reduced(state.doc, found).frames
    own = save_own_motion(state.doc, tmp_path / "session.json", found.motion)
    done = with_reduction(state, found, frames, own, replacing=False)
    done = with_own_motion(done, tmp_path / "session.json")
    at = 4
    turned = {"do": "angles", "part": "right_forearm", "x": -70, "free": True}
    corrected = after(done, {"do": "go", "frame": frames[at]}, turned)
    moved = np.arange(frames[at - 1] + 1, frames[at + 1])
    before, now = shown(done), shown(corrected)
    same = np.setdiff1d(np.arange(LAST + 1), moved)
    for name in ("Rs_parent_part", "ps_camera_root"):
        assert getattr(before, name)[same].tobytes() == getattr(now, name)[same].tobytes()
    assert np.abs(before.Rs_parent_part[moved] - now.Rs_parent_part[moved]).max() > 0.01
    # and those alone have to be tracked anew
    keys = segment_keys(done.doc), segment_keys(corrected.doc)
    changed = [span for span in keys[0] if keys[0][span] != keys[1][span]]
    assert changed == [(frames[at - 1], frames[at]), (frames[at], frames[at + 1])]


def test_with_few_keyframes_the_motion_shown_is_still_what_it_was(tmp_path: Path) -> None:
    state, path = drafted(desk()), tmp_path / "session.json"
    found = reducible(state.doc, {}, None, replacing=True)
    frames = reduced(state.doc, found, 0.6).frames
    assert len(frames) <= 1 + LAST // 20 + 1
    own = save_own_motion(state.doc, path, found.motion)
    done = with_own_motion(with_reduction(state, found, frames, own, replacing=True), path)
    now = shown(done)
    np.testing.assert_allclose(now.Rs_parent_part, found.motion.Rs_parent_part, atol=1e-9)
    np.testing.assert_allclose(now.ps_camera_root, found.motion.ps_camera_root, atol=1e-9)
    known = motion_between(done, 0, LAST)
    np.testing.assert_allclose(
        known.Ts_world_part, found.motion.transforms(done.skeleton), atol=1e-9
    )


def test_the_motion_is_kept_and_only_segments_within_it_start_from_it(tmp_path: Path) -> None:
    state, path = drafted(desk(), range(20, 51)), tmp_path / "session.json"
    found = reducible(state.doc, {}, None, frames=(24, 48))
    frames = reduced(state.doc, found).frames
    assert (frames[0], frames[-1]) == (24, 48)
    own = save_own_motion(state.doc, path, found.motion)
    doc = reduced_session(state.doc, found, frames, state.times_s, own)
    assert [(run.first_frame, run.last_frame) for run in own.own] == [(24, 48)]
    kept = load_first_motion(doc, tmp_path)
    assert kept is not None
    assert kept.Rs_parent_part.tobytes() == found.motion.Rs_parent_part.tobytes()
    before, now = segment_keys(state.doc), segment_keys(doc)
    assert now[0, 24] == before[0, 24]
    assert now[48, 72] == before[48, 72]
    bare = segment_keys(doc.changed({"first_motion": None}))
    assert all((now[span] != bare[span]) == (span[0] >= 24 and span[1] <= 48) for span in now)
    assert [d.frame for d in doc.subject.drafts] == [20, 21, 22, 23, 49, 50]


def test_what_was_kept_of_other_frames_stays_with_gaps_between(tmp_path: Path) -> None:
    doc, path = desk().doc, tmp_path / "session.json"

    def part(first: int, last: int) -> Trajectory:
        rows = slice(first, last + 1)
        return Trajectory(first, MOTION.Rs_parent_part[rows], MOTION.ps_camera_root[rows])

    doc = doc.changed({"first_motion": save_own_motion(doc, path, part(40, 60))})
    early = (
        {run.digest for run in doc.subject.first_motion.own} if doc.subject.first_motion else set()
    )
    doc = doc.changed({"first_motion": save_own_motion(doc, path, part(2, 9))})
    assert doc.subject.first_motion is not None
    runs = doc.subject.first_motion.own
    assert [(run.first_frame, run.last_frame) for run in runs] == [(2, 9), (40, 60)]
    assert runs[1].digest in early
    kept = load_first_motion(doc, tmp_path)
    assert kept is not None
    assert np.isnan(kept.ps_camera_root[9 - 2 + 1 : 40 - 2]).all()
    assert reducible(doc, {}, kept, frames=(41, 59)).source == "imported"


def test_a_limb_is_keyed_alone_between_the_keyframes() -> None:
    state = drafted(desk())
    found = reducible(state.doc, {}, None, limbs=["left_forearm"])
    doc = reduced_session(
        state.doc, found, reduced(state.doc, found, 0.02).frames, state.times_s, None
    )
    assert doc.subject.keyframes == state.doc.subject.keyframes
    assert doc.subject.part_keyframes
    assert {each.parts for each in doc.subject.part_keyframes} == {
        ("left_upper_arm", "left_forearm", "left_hand")
    }
    assert not {each.frame for each in doc.subject.part_keyframes} & {0, 24, 48, 72}
    assert (
        Session.model_validate_json(doc.model_dump_json()).subject.part_keyframes
        == doc.subject.part_keyframes
    )


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"frames": (5, 90)}, "The video has frames 0 to 72"),
        ({"frames": (9, 9)}, "the first before the last"),
        ({"source": "tracked"}, "Nothing is tracked as the keyframes are posed now"),
        ({"source": "imported"}, "No motion has been imported"),
        ({"limbs": ["waist"]}, "Press K to key all of it"),
        ({"limbs": ["tail"]}, "The body has no part 'tail'"),
    ],
)
def test_what_cannot_be_reduced_is_said_in_a_sentence(given: dict[str, object], words: str) -> None:
    with pytest.raises(KeyposeError, match=words):
        reducible(drafted(desk()).doc, {}, None, **given)  # type: ignore[arg-type]


def test_without_a_motion_there_is_nothing_to_reduce() -> None:
    with pytest.raises(
        ActionRefused, match="There is no motion to reduce: track, draft or import one"
    ):
        reducible(desk().doc, {}, None)
    one = drafted(desk(keyframes=False), range(30, 31))
    with pytest.raises(ActionRefused, match="no motion to reduce in these frames"):
        reducible(one.doc, {}, None, frames=(20, 40))
    with pytest.raises(ActionRefused, match="Only the motion of a video"):
        reducible(surface_cases.session(), {}, None)


def test_an_imported_motion_is_laid_on_the_keyframes_before_it_is_reduced() -> None:
    state = desk()
    moved = replace(MOTION, ps_camera_root=MOTION.ps_camera_root + np.array([0.1, 0.0, 0.2]))
    found = reducible(state.doc, {}, moved)
    assert found.source == "imported"
    skeleton = state.skeleton
    for keyframe in state.doc.subject.keyframes:
        pose, own = found.motion.pose(keyframe.frame), keyframe.pose(skeleton)
        assert isinstance(pose, Pose)
        np.testing.assert_allclose(pose.p_camera_root, own.p_camera_root, atol=1e-9)
    steps = np.linalg.norm(np.diff(found.motion.ps_camera_root, axis=0), axis=1)
    assert steps.max() < 0.1  # no jump at any keyframe
