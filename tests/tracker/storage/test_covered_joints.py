"""What another person lies over at a keyframe is not compared with a detector's keypoints."""

from __future__ import annotations

import pytest

from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.annotations import KeypointCorrection
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.storage.covered_joints import covered_joints
from keypose.tracker.storage.fingerprints import segment_keys
from tests.tracker import session_cases as cases

ADULT = preset("adult_female")


def keyframe(body: Body, frame: int, x_m: float, z_m: float) -> Keyframe:
    skeleton = Skeleton.of(body)
    return Keyframe.of(skeleton, Pose.rest(skeleton, (x_m, 0.0, z_m)), frame, frame / 30)


def beside(x_m: float, z_m: float, body: Body = ADULT, frames: tuple[int, ...] = (0, 8)) -> Session:
    """Somebody four metres away, and a body so far to the right of them; both stand still."""
    doc = cases.session().changed(
        {"body": ADULT, "keyframes": tuple(keyframe(ADULT, frame, 0.0, 4.0) for frame in (0, 8))}
    )
    posed = tuple(keyframe(body, frame, x_m, z_m) for frame in frames)
    second = TrackedBody(id="body-2", body=body, keyframes=posed)
    doc = doc.model_copy(update={"bodies": (doc.subject, second)})
    return doc.changed({"settings": doc.settings.model_copy(update={"cues": ("keypoints",)})})


def covered(doc: Session) -> set[tuple[int, str]]:
    joints = covered_joints(doc, doc.subject.keyframes)
    assert all(each.uv is None for each in joints)
    assert list(joints) == sorted(joints, key=lambda each: (each.frame, each.joint))
    return {(each.frame, each.joint) for each in joints}


@pytest.mark.parametrize(("x_m", "side"), [(0.35, "left"), (-0.35, "right")])
@pytest.mark.parametrize("z_m", [3.8, 4.2], ids=["before", "behind"])
def test_whoever_stands_beside_covers_the_arm_on_that_side_before_or_behind_it(
    x_m: float, side: str, z_m: float
) -> None:
    joints = covered(beside(x_m, z_m))
    arm = {f"{side}_{joint}" for joint in ("shoulder", "elbow", "wrist")}
    assert {(frame, joint) for frame in (0, 8) for joint in arm} <= joints
    assert {joint.partition("_")[0] for _, joint in joints} == {side}


@pytest.mark.parametrize(
    "doc",
    [
        beside(3.0, 4.0),
        beside(0.0, -4.0),
        beside(0.0, 3.8, preset("box")),
        beside(0.0, 3.8, frames=(3,)),
        cases.session(),
    ],
    ids=["far beside", "behind the camera", "a thing", "posed elsewhere alone", "alone"],
)
def test_nothing_is_covered_by(doc: Session) -> None:
    assert covered(doc) == set()


def test_between_its_keyframes_another_body_is_where_even_motion_leads() -> None:
    doc = beside(0.0, 3.8)
    ways = tuple(keyframe(ADULT, frame, x, 3.8) for frame, x in ((0, -2.0), (4, 0.0), (8, 2.0)))
    passing = doc.with_body(doc.bodies[1].model_copy(update={"keyframes": ways}))
    assert covered(passing) == set()
    ends = tuple(keyframe(ADULT, frame, x, 3.8) for frame, x in ((0, -2.0), (8, 2.0)))
    mid = passing.changed({"keyframes": tuple(keyframe(ADULT, n, 0.0, 4.0) for n in (0, 4, 8))})
    for other in (ways, ends):
        meeting = mid.with_body(mid.bodies[1].model_copy(update={"keyframes": other}))
        assert {frame for frame, _ in covered(meeting)} == {4}


def test_what_a_person_said_of_a_joint_counts() -> None:
    doc = beside(0.0, 3.8)
    said = KeypointCorrection(frame=0, joint="left_wrist", uv=(20.0, 20.0))
    assert (0, "left_wrist") in covered(doc)
    assert (0, "left_wrist") not in covered(doc.changed({"keypoint_corrections": (said,)}))


@pytest.mark.parametrize(("x_m", "outdates"), [(0.35, True), (3.0, False)])
def test_a_motion_is_outdated_where_other_joints_are_covered(x_m: float, outdates: bool) -> None:
    doc, apart = beside(x_m, 6.0), beside(4.0, 6.0)
    assert (segment_keys(doc) != segment_keys(apart)) is outdates
