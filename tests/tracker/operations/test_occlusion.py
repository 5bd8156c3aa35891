"""A body that passes before another one hides it: there the film says nothing of who is behind."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from keypose.tracker.operations.occlusion import ignored_regions
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.storage.fingerprints import segment_keys
from tests.tracker import session_cases as cases

SKELETON = cases.SKELETON
WALKS_M = 2.4


def walking(z_m: float, way: int, frames: tuple[int, ...] = (0, 8)) -> tuple[Keyframe, ...]:
    """Across the picture at a depth, to the right or to the left."""
    pose = cases.pose(0.0)
    keyframes = []
    for frame in frames:
        x = way * WALKS_M * (frame / 8 - 0.5)
        there = pose.__class__(pose.Rs_parent_part, np.array([x, 0.0, z_m]))
        keyframes.append(Keyframe.of(SKELETON, there, frame, frame / 30))
    return tuple(keyframes)


def crossing(z_m: float, way: int = -1) -> Session:
    """Somebody three metres away walks to the right, and another at this depth."""
    doc = cases.session().changed({"keyframes": walking(3.0, 1)})
    second = doc.subject.model_copy(update={"id": "body-2", "keyframes": walking(z_m, way)})
    return doc.model_copy(update={"bodies": (doc.subject, second)})


def covered(doc: Session, frame: int) -> np.ndarray:
    picture = np.zeros((cases.HEIGHT, cases.WIDTH), np.uint8)
    for mask in ignored_regions(doc):
        if mask.first_frame <= frame <= mask.last_frame:
            cv2.fillPoly(picture, [np.round(np.array(mask.polygon)).astype(np.int32)], 255)
    return picture > 0


def test_who_passes_before_hides_who_is_behind_where_they_meet_and_not_the_reverse() -> None:
    doc = crossing(2.0)
    assert covered(doc, 4)[24, 32]
    assert not covered(doc, 0).any()
    assert not covered(doc.about("body-2"), 4).any()


def test_regions_that_a_person_drew_are_ignored_as_well() -> None:
    doc = cases.session()
    assert ignored_regions(doc) == doc.view.ignore_masks


def test_what_is_before_and_beside_is_no_region_of_who_is_far_from_it() -> None:
    doc = crossing(2.0)
    aside = [
        keyframe.model_copy(update={"root_m": (3.0, 0.0, 2.0)})
        for keyframe in doc.bodies[1].keyframes
    ]
    doc = doc.with_body(doc.bodies[1].model_copy(update={"keyframes": tuple(aside)}))
    assert ignored_regions(doc) == doc.view.ignore_masks


def moved(doc: Session, body_id: str, z_m: float) -> Session:
    body = next(body for body in doc.bodies if body.id == body_id)
    return doc.with_body(body.model_copy(update={"keyframes": walking(z_m, -1)}))


@pytest.mark.parametrize(("z_m", "outdates"), [(2.0, True), (4.5, False)])
def test_a_motion_is_outdated_by_another_pose_of_who_may_hide_it_alone(
    z_m: float, outdates: bool
) -> None:
    doc = crossing(z_m)
    again = moved(doc, "body-2", z_m + 0.1)
    assert (segment_keys(doc) != segment_keys(again)) is outdates


def test_a_body_alone_has_the_keys_that_it_had() -> None:
    doc = crossing(2.0)
    alone = doc.model_copy(update={"bodies": doc.bodies[:1]})
    far = moved(doc, "body-2", 9.0)
    assert segment_keys(far) == segment_keys(alone)
    assert segment_keys(doc) != segment_keys(alone)
