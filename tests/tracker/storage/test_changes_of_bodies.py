"""The journal holds which bodies a session has, and which of them is posed."""

from __future__ import annotations

from typing import Any

import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import KeypointCorrection
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.storage.changes import apply_changes, changes
from tests.tracker import session_cases as cases

CORRECTION = KeypointCorrection(frame=3, joint="left_wrist", uv=(40.0, 30.0))


def of_two() -> Session:
    """The session's body with a keypoint set right, and one that nobody posed yet."""
    doc = cases.session().changed({"keypoint_corrections": (CORRECTION,)})
    added = TrackedBody(id="body-2", body=preset("box"))
    return doc.model_copy(update={"bodies": (doc.subject, added)})


def _another(doc: Session) -> Session:
    added = TrackedBody(id="body-3", body=preset("cylinder"))
    return doc.model_copy(update={"bodies": (*doc.bodies, added)}).about("body-3")


def _called(doc: Session) -> Session:
    return doc.with_body(doc.bodies[1].model_copy(update={"called": "Anna"}))


JOURNALED = {
    "the other one is posed": lambda doc: doc.about("body-2"),
    "added, and posed": _another,
    "removed": lambda doc: doc.model_copy(update={"bodies": doc.bodies[:1]}),
    "one beside it is called": _called,
    "another one is posed, and edited": lambda doc: doc.about("body-2").changed(
        {"called": "Anna", "keypoint_corrections": (CORRECTION,)}
    ),
    "one is called, and its neighbour has a keyframe less": lambda doc: _called(doc).changed(
        {"keyframes": doc.subject.keyframes[1:]}
    ),
}


@pytest.mark.parametrize("name", JOURNALED)
def test_what_the_journal_holds_of_an_edit_of_bodies_makes_it_again_both_ways(name: str) -> None:
    doc = of_two()
    edited = JOURNALED[name](doc)
    assert edited != doc
    assert apply_changes(doc, changes(doc, edited)) == edited
    assert apply_changes(edited, changes(edited, doc)) == doc


def test_to_pose_another_body_and_back_leaves_a_session_as_it_was() -> None:
    doc = of_two()
    there = doc.about("body-2")
    assert there.subject.id == "body-2"
    assert there.view.keypoint_corrections == ()
    assert there.about("body") == doc
    assert list(changes(doc, there)) == ["posed"]


BAD = {"set": [], "ids": ["body-9"], "posed": "body-9"}


@pytest.mark.parametrize("change", [{"bodies": []}, {"bodies": BAD}, {"posed": "body-9"}])
def test_a_journal_that_names_no_body_of_the_session_is_refused(change: Any) -> None:
    with pytest.raises(ValueError, match="bod"):
        apply_changes(cases.session(), change)
