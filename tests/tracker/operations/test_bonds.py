"""Bonds: points of two bodies, or of one, that meet over a range of frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from keypose.app.words.bonds import keyed_apart_sentences
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.trajectory import joined
from keypose.tracker.errors import SessionError
from keypose.tracker.geometry.rotations import Array, rotation_from_euler
from keypose.tracker.operations.solve_space import solved
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.bonds import Bond, BondEnd
from keypose.tracker.storage.changes import apply_changes, changes
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import Results, load_all_results, save_all_results
from tests.app.results_cases import track
from tests.tracker import session_cases as cases
from tests.tracker.operations.space_cases import smooth

SKELETON = cases.SKELETON
TIP = cases.body().parts[cases.body().index("left_hand")].landmarks["tip"]
A, B = (BondEnd(body=each, part="left_hand", point_m=TIP) for each in ("body", "body-2"))
SHAKE = Bond(holder=A, held=B, first_frame=0, last_frame=8)


def tip(pose: Pose) -> Array:
    T = pose_transforms(SKELETON, pose)[SKELETON.body.index("left_hand")]
    return np.asarray(T[:3, :3] @ TIP + T[:3, 3])


def opposite(keyframe: Keyframe) -> Keyframe:
    """Somebody who stands on the other side of the hand, posed alike, the tips together."""
    pose = keyframe.pose(SKELETON)
    R, p = rotation_from_euler(0.0, np.pi * 0.6, 0.0), tip(pose)
    Rs = pose.Rs_parent_part.copy()
    Rs[0] = R @ Rs[0]
    there = Pose(Rs, p + R @ (pose.p_camera_root - p))
    return Keyframe.of(SKELETON, there, keyframe.frame, keyframe.time_s)


def shaking(*bonds: Bond) -> Session:
    """Two who have each other's hand at every keyframe, as somebody posed them."""
    doc = smooth()
    second = doc.subject.model_copy(
        update={"id": "body-2", "keyframes": tuple(map(opposite, doc.subject.keyframes))}
    )
    return doc.model_copy(update={"bodies": (doc.subject, second), "bonds": bonds})


def tracked(doc: Session, solve: bool = True) -> Results:
    """Both tracked, each bent in its own way between keyframes, and solved for in space."""
    results = Results()
    for body_id, bend in (("body", 0.1), ("body-2", 0.25)):
        for span in ((0, 4), (4, 8)):
            results = results.with_result(track(doc.about(body_id), *span, bend=bend))
    for body_id in ("body", "body-2") if solve else ():
        there = doc.about(body_id)
        for stretch in results.unsolved(there):
            results = results.with_space(solved(there, stretch))
    return results


def apart_m(doc: Session, results: Results) -> Array:
    """(9,) how far the two tips are from each other."""
    tips = []
    for body_id in ("body", "body-2"):
        fitting = results.fitting(doc.about(body_id))
        motion = joined([fitting[span].trajectory for span in sorted(fitting)])
        tips.append(np.array([tip(motion.pose(frame)) for frame in range(9)]))
    return np.asarray(np.linalg.norm(tips[0] - tips[1], axis=-1))


def test_two_hands_that_are_said_to_meet_do_and_each_gives_way() -> None:
    free, bound = shaking(), shaking(SHAKE)
    before, after = tracked(free), tracked(bound)
    assert apart_m(free, before).max() > 0.01
    assert apart_m(bound, after).max() < 0.001
    for body_id in ("body", "body-2"):
        motions = [
            results.fitting(doc.about(body_id))[0, 4].trajectory
            for doc, results in ((free, before), (bound, after))
        ]
        moved = [tip(motion.pose(2)) for motion in motions]
        assert np.linalg.norm(moved[0] - moved[1]) > 0.003


def test_what_is_held_alone_is_moved_where_that_was_asked() -> None:
    bond = SHAKE.model_copy(update={"moves": "held"})
    free, bound = shaking(), shaking(bond)
    before, after = tracked(free), tracked(bound)
    assert apart_m(bound, after).max() < 0.001
    first = [each.fitting(doc)[0, 4].trajectory for each, doc in ((before, free), (after, bound))]
    assert np.linalg.norm(tip(first[0].pose(2)) - tip(first[1].pose(2))) < 0.001


def test_beyond_its_frames_a_bond_holds_nothing_and_its_end_is_soft() -> None:
    bound = shaking(SHAKE.model_copy(update={"last_frame": 4}))
    apart = apart_m(bound, tracked(bound))
    assert apart[:3].max() < 0.002
    assert apart[6] > 0.03


def test_two_parts_of_one_body_meet_as_well() -> None:
    other = BondEnd(body="body", part="right_arm", point_m=(0.0, 0.0, 0.0))
    bond = Bond(holder=A, held=other, first_frame=1, last_frame=3, moves="holder")
    doc = smooth().model_copy(update={"bonds": (bond,)})
    results = Results().with_result(track(doc, 0, 4))
    for stretch in results.unsolved(doc):
        results = results.with_space(solved(doc, stretch))
    motion = results.fitting(doc)[0, 4].trajectory
    Ts = pose_transforms(SKELETON, motion.pose(2))
    arm = Ts[SKELETON.body.index("right_arm"), :3, 3]
    without = Results().with_result(track(smooth(), 0, 4)).fitting(smooth())[0, 4].trajectory
    assert np.linalg.norm(tip(motion.pose(2)) - arm) < np.linalg.norm(tip(without.pose(2)) - arm)


def with_keyframe_aside(session: Session, frame: int, **fields: object) -> Session:
    """The second person keyed 4 cm aside at a frame."""
    second = session.bodies[1]
    moved = [
        keyframe.model_copy(
            update={"root_m": (keyframe.root_m[0] + 0.04, *keyframe.root_m[1:]), **fields}
        )
        if keyframe.frame == frame
        else keyframe
        for keyframe in second.keyframes
    ]
    return session.with_body(second.model_copy(update={"keyframes": tuple(moved)}))


def test_keyframes_that_keep_what_should_meet_apart_are_said() -> None:
    assert keyed_apart_sentences(shaking(SHAKE)) == []
    apart = with_keyframe_aside(shaking(SHAKE), 4)
    assert keyed_apart_sentences(apart) == [
        "body:left_hand and body-2:left_hand are 4.0 cm apart at frame 4, where both are keyed: "
        "pose them together there."
    ]
    assert keyed_apart_sentences(with_keyframe_aside(shaking(SHAKE), 4, soft="depth")) == []
    later = SHAKE.model_copy(update={"first_frame": 5})
    assert keyed_apart_sentences(with_keyframe_aside(shaking(later), 4)) == []


def test_a_bond_to_a_body_that_is_not_tracked_there_waits_until_it_is() -> None:
    doc = shaking(SHAKE)
    alone = Results().with_result(track(doc, 0, 4))
    (stretch,) = alone.unsolved(doc)
    assert stretch.bonds == ()
    (joint, *_) = tracked(doc, solve=False).unsolved(doc)
    assert [bond.span for bond in joint.bonds] == [(0, 8)]


def test_bonds_are_saved_with_what_they_led_to_and_are_in_the_journal(tmp_path: Path) -> None:
    doc, path = shaking(SHAKE), tmp_path / "session.json"
    results = tracked(doc)
    save_session(save_all_results(doc, path, results), path)
    loaded = load_session(path)
    assert loaded.bonds == doc.bonds
    again, problem = load_all_results(loaded, path)
    assert problem == ""
    np.testing.assert_allclose(apart_m(loaded, again), apart_m(doc, results), atol=1e-6)
    assert apply_changes(shaking(), changes(shaking(), doc)) == doc


BAD = {
    "no body": ({"body": "body-9"}, "no body of the id 'body-9'"),
    "no part": ({"part": "tail"}, "'tail' is no part of the body"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bond_that_joins_what_is_not_there_is_refused_by_name(name: str, tmp_path: Path) -> None:
    change, words = BAD[name]
    bond = SHAKE.model_copy(update={"held": B.model_copy(update=change)})
    with pytest.raises(SessionError, match=words):
        save_session(shaking(bond), tmp_path / "session.json")


def test_a_part_cannot_hold_itself() -> None:
    with pytest.raises(ValueError, match="cannot hold itself"):
        Bond(holder=A, held=A, first_frame=0, last_frame=3)


def test_a_body_that_is_removed_takes_its_bonds_along() -> None:
    assert shaking(SHAKE).without_body("body-2").bonds == ()
